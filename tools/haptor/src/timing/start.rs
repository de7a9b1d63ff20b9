//! Where histories begin: orientations and places of the probe in which one, some and as many parts as can be meet the object, found by the core's own
//! detection.

use fastrand::Rng;
use haptor_contact::geometry::deepest::{deepest, part_pose};
use haptor_contact::{ObjectShape, Pose, ProbeFrame, ProbePart, Quat, Vec3, World};

/// Depth at which parts are counted \[m\]: what a finger presses into rubber.
pub const PRESSED: f32 = 1.0e-3;

/// Orientations that are tried beside the scene's own.
const ORIENTATIONS: usize = 24;

/// Small turns tried to bring down one part more.
const TILTS: usize = 48;

/// Halvings of the bracket of first touch: from a metre to a micrometre.
const HALVINGS: usize = 20;

/// Farthest the probe is lifted in search of a place without contact \[m\].
const HIGHEST: f32 = 100.0;

/// Where a descent begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The probe's rotation.
    pub rotation: Quat,
    /// Its place across \[m\].
    pub across: [f32; 2],
    /// Height at which the first part touches \[m\].
    pub touch: f32,
    /// Parts that touch [`PRESSED`] below that.
    pub parts: usize,
    /// 1 where the probe comes from above, -1 from below.
    pub side: f32,
}

impl Start {
    /// Pose at a depth beyond first touch \[m\]; negative is before it.
    pub fn pose(&self, depth: f32) -> Pose<World, ProbeFrame> {
        Pose::new(Vec3::new(self.across[0], self.across[1], self.touch - self.side * depth), self.rotation)
    }
}

/// Probe and object to look at.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// The object.
    pub object: &'a ObjectShape<'a>,
    /// The probe's parts.
    pub parts: &'a [ProbePart<'a>],
}

impl Pair<'_> {
    fn touching(&self, x_wp: &Pose<World, ProbeFrame>) -> usize {
        let touches = |part: &&ProbePart<'_>| deepest(self.object, part, &part_pose(part, x_wp)).gap.distance < 0.0;
        self.parts.iter().filter(touches).count()
    }

    /// A start from above, unless nothing is met on the way down.
    fn descend(&self, rotation: Quat, across: [f32; 2]) -> Option<Start> {
        self.approach(rotation, across, 1.0)
    }

    /// The probe as the scene has it, from below, its first part at the middle of the object's base; `None` where nothing is met on the way up.
    pub fn below(&self) -> Option<Start> {
        let part = self.parts.first()?.position;
        self.approach(Quat::IDENTITY, [-part.x, -part.y], -1.0)
    }

    /// Lengths along the way count from the object's base, towards the side that the probe comes from.
    fn approach(&self, rotation: Quat, across: [f32; 2], side: f32) -> Option<Start> {
        let at = |way: f32| Pose::new(Vec3::new(across[0], across[1], side * way), rotation);
        let mut before = self.object.height() + 0.01;
        while self.touching(&at(before)) > 0 {
            before *= 2.0;
            if before > HIGHEST {
                return None;
            }
        }
        // in steps, so that nothing is passed through
        let step = 0.02 * self.object.height().max(0.05);
        let mut beyond = before;
        while self.touching(&at(beyond)) == 0 {
            (before, beyond) = (beyond, beyond - step);
            if beyond < -self.object.height() - 1.0 {
                return None;
            }
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + beyond);
            if self.touching(&at(middle)) > 0 {
                beyond = middle;
            } else {
                before = middle;
            }
        }
        let start = Start { rotation, across, touch: side * beyond, parts: 0, side };
        Some(Start { parts: self.touching(&start.pose(PRESSED)), ..start })
    }

    /// Turned and shifted a little, as long as that brings more parts down.
    fn climb(&self, start: Start, rng: &mut Rng) -> Start {
        let mut best = start;
        for _ in 0..TILTS {
            let size = 10.0_f32.powf(-3.0 * rng.f32());
            let turn = Quat::from_scaled_axis(size * direction(rng));
            if let Some(found) = self.descend((turn * best.rotation).normalize(), best.across)
                && found.parts > best.parts
            {
                best = found;
            }
        }
        best
    }

    /// Starts of as many different numbers of parts as are found, fewest first; the scene's own orientation goes before others with the same number.
    pub fn starts(&self, rng: &mut Rng) -> Vec<Start> {
        let mut found: Vec<Start> = self.descend(Quat::IDENTITY, [0.0; 2]).into_iter().collect();
        let span = 0.4 * self.object.height().min(0.2);
        for _ in 0..ORIENTATIONS {
            let rotation = Quat::from_scaled_axis(core::f32::consts::PI * rng.f32() * direction(rng));
            found.extend(self.descend(rotation, [span * signed(rng), span * signed(rng)]));
        }
        if self.parts.len() > 1 {
            let climbed: Vec<_> = found.iter().map(|start| self.climb(*start, rng)).collect();
            found.extend(climbed);
        }
        let mut starts: Vec<Start> = Vec::new();
        for start in found {
            if start.parts > 0 && starts.iter().all(|other| other.parts != start.parts) {
                starts.push(start);
            }
        }
        starts.sort_by_key(|start| start.parts);
        starts
    }
}

/// A number from -1 to 1.
pub fn signed(rng: &mut Rng) -> f32 {
    2.0 * rng.f32() - 1.0
}

/// A direction, any as likely as any other but for the corners of a cube.
pub fn direction(rng: &mut Rng) -> Vec3 {
    Vec3::new(signed(rng), signed(rng), signed(rng)).normalize_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_contact::ProbeShape;

    #[test]
    fn two_legs_are_brought_down_one_by_one_and_together() {
        let leg = |x| ProbePart { position: Vec3::new(x, 0.0, 0.0), ..ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 }) };
        let parts = [leg(-0.02), leg(0.02)];
        let pair = Pair { object: &ObjectShape::HalfSpace, parts: &parts };
        let starts = pair.starts(&mut Rng::with_seed(1));
        assert_eq!(starts.iter().map(|start| start.parts).collect::<Vec<_>>(), [1, 2]);
        assert!((starts[1].touch - 0.01).abs() < 1.0e-5, "{starts:?}");
    }
}

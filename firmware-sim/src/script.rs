//! What the hand wants: motions as lists of way points.
//!
//! A way point is a place, an angle about z, and the time to get there; between two the hand follows the polynomial of fifth
//! degree that begins and ends at rest without acceleration (Flash & Hogan's minimum-jerk path, which human reaching follows).
//! All in `d`: +z up, the probe [`CLEARANCE`] above the object at the origin. Every script begins and ends there, so it can be
//! repeated. Depths are where the hand **wants** to be; it gives way, see [`crate::plant`].

use glam::{Quat, Vec3};

/// Gap between probe and object at the start of every script \[m\]: seen by eye, crossed within half a second.
pub const CLEARANCE: f32 = 5e-3;

/// Share of a device's largest force with which a script presses: leaves room for friction at a coefficient of 0.75.
pub const PRESS_SHARE: f32 = 0.8;

/// Way points of a script at most.
pub const MAX_WAY_POINTS: usize = 16;

/// The names of the scripts, as on the command line.
pub const NAMES: [&str; 7] = ["hold", "press", "twist", "slide", "lift", "press-twist-slide", "two-legs"];

/// Where the hand wants to be, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Position `p_dh` \[m\].
    pub position: Vec3,
    /// Rotation `q_dh`.
    pub rotation: Quat,
    /// Velocity of the position \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity, in `d` \[rad/s\].
    pub spin: Vec3,
}

/// One way point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayPoint {
    /// Time to get there from the one before \[s\].
    pub seconds: f32,
    /// Position \[m\].
    pub position: Vec3,
    /// Angle about z \[rad\].
    pub angle: f32,
}

/// How far a script goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// How far below the object's top the hand wants to be \[m\].
    pub depth: f32,
    /// How far it turns \[rad\].
    pub angle: f32,
    /// How far it slides, along x \[m\].
    pub slide: f32,
}

impl Reach {
    /// The usual reach with a hand of `stiffness` \[N/m\] on a device of `max_force` \[N\].
    ///
    /// The depth presses with [`PRESS_SHARE`] of the force once the hand's spring has given way. 0.5 rad and 10 mm take a ball of
    /// 20 mm radius on soft rubber well into slip.
    #[must_use]
    pub fn usual(stiffness: f32, max_force: f32) -> Self {
        Self { depth: PRESS_SHARE * max_force / stiffness, angle: 0.5, slide: 10e-3 }
    }
}

/// A motion of the hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    points: heapless::Vec<WayPoint, MAX_WAY_POINTS>,
    repeat: bool,
}

impl Script {
    /// The script of that name; `repeat` begins it anew at its end, otherwise the hand rests there.
    #[must_use]
    pub fn by_name(name: &str, reach: &Reach, repeat: bool) -> Option<Self> {
        let mut draft = Draft::new(reach);
        match name {
            "hold" => draft.wait(1.0),
            "press" => draft.press().wait(0.5).lift(),
            "twist" => draft.press().twist(1.0).twist(-1.0).twist(0.0).lift(),
            "slide" => draft.press().slide(1.0).slide(-1.0).slide(0.0).lift(),
            "lift" => draft.press().lift_slowly(),
            "press-twist-slide" => draft.press().twist(1.0).slide(1.0).lift().go_home(),
            // both legs must stay on the object: less angle, no slide
            "two-legs" => draft.press().twist(0.3).twist(-0.3).twist(0.0).lift(),
            _ => return None,
        };
        Some(Self { points: draft.points, repeat })
    }

    /// Time from begin to end \[us\].
    #[must_use]
    pub fn length_us(&self) -> u64 {
        self.points.iter().map(|p| micros(p.seconds)).sum()
    }

    /// Whether it begins anew at its end.
    #[must_use]
    pub const fn repeats(&self) -> bool {
        self.repeat
    }

    /// What the hand wants `t_us` after the script began.
    #[must_use]
    pub fn target(&self, t_us: u64) -> Target {
        let length = self.length_us().max(1);
        let mut left = if self.repeat { t_us % length } else { t_us };
        let mut from = HOME;
        for to in &self.points {
            let span = micros(to.seconds);
            if left < span {
                return between(&from, to, left as f32 / span as f32);
            }
            left -= span;
            from = *to;
        }
        between(&from, &from, 0.0)
    }
}

const HOME: WayPoint = WayPoint { seconds: 0.0, position: Vec3::ZERO, angle: 0.0 };

fn micros(seconds: f32) -> u64 {
    (f64::from(seconds) * 1e6 + 0.5) as u64
}

/// On the way from one point to the next; `s` from 0 to 1.
fn between(from: &WayPoint, to: &WayPoint, s: f32) -> Target {
    let share = s * s * s * (10.0 + s * (6.0 * s - 15.0));
    let slope = 30.0 * s * s * (1.0 - s) * (1.0 - s);
    let rate = if to.seconds > 0.0 { slope / to.seconds } else { 0.0 };
    let way = to.position - from.position;
    let turn = to.angle - from.angle;
    Target {
        position: from.position + way * share,
        rotation: Quat::from_rotation_z(from.angle + turn * share),
        velocity: way * rate,
        spin: Vec3::Z * (turn * rate),
    }
}

/// A script being written: each step moves on from where the last one ended.
struct Draft {
    reach: Reach,
    points: heapless::Vec<WayPoint, MAX_WAY_POINTS>,
    at: WayPoint,
}

impl Draft {
    fn new(reach: &Reach) -> Self {
        Self { reach: *reach, points: heapless::Vec::new(), at: HOME }
    }

    fn go(&mut self, seconds: f32, position: Vec3, angle: f32) -> &mut Self {
        self.at = WayPoint { seconds, position, angle };
        let fits = self.points.push(self.at).is_ok();
        debug_assert!(fits, "a script has more than {MAX_WAY_POINTS} way points");
        self
    }

    fn wait(&mut self, seconds: f32) -> &mut Self {
        self.go(seconds, self.at.position, self.at.angle)
    }

    /// Down to just touching, then into the object, then steady.
    fn press(&mut self) -> &mut Self {
        let touching = Vec3::new(0.0, 0.0, -CLEARANCE);
        let pressed = Vec3::new(0.0, 0.0, -CLEARANCE - self.reach.depth);
        self.go(0.5, touching, 0.0).go(0.5, pressed, 0.0).wait(0.2)
    }

    /// To a share of the angle, then steady.
    fn twist(&mut self, share: f32) -> &mut Self {
        let angle = share * self.reach.angle;
        self.go(0.8, self.at.position, angle).wait(0.1)
    }

    /// To a share of the way, then steady.
    fn slide(&mut self, share: f32) -> &mut Self {
        let x = share * self.reach.slide;
        let to = Vec3::new(x, self.at.position.y, self.at.position.z);
        self.go(0.8, to, self.at.angle).wait(0.1)
    }

    /// Up to the clearance.
    fn lift(&mut self) -> &mut Self {
        let up = Vec3::new(self.at.position.x, self.at.position.y, 0.0);
        self.go(0.5, up, self.at.angle).wait(0.1)
    }

    /// Up at a fifth of the speed, to see contact break.
    fn lift_slowly(&mut self) -> &mut Self {
        let up = Vec3::new(self.at.position.x, self.at.position.y, 0.0);
        self.go(2.5, up, self.at.angle).wait(0.1)
    }

    /// Back to where it began.
    fn go_home(&mut self) -> &mut Self {
        self.go(0.4, Vec3::ZERO, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> impl Iterator<Item = (&'static str, Script)> {
        let reach = Reach::usual(2000.0, 8.5);
        NAMES.into_iter().map(move |name| (name, Script::by_name(name, &reach, true).unwrap()))
    }

    #[test]
    fn every_name_is_a_script_that_returns_to_where_it_began() {
        for (name, script) in all() {
            let once = Script { repeat: false, ..script.clone() };
            let end = once.target(script.length_us());
            assert_eq!(end.position, Vec3::ZERO, "{name}");
            assert!(end.rotation.angle_between(Quat::IDENTITY) < 1e-6, "{name}");
            assert_eq!(end, once.target(u64::MAX), "{name} rests at its end");
        }
        assert_eq!(Script::by_name("dance", &Reach::usual(1.0, 1.0), true), None);
    }

    #[test]
    fn position_velocity_and_acceleration_have_no_jumps() {
        // over two rounds, so that the seam is in it
        for (name, script) in all() {
            let dt = 1e-3;
            let mut before = script.target(0);
            let mut speed_before = Vec3::ZERO;
            for ms in 1..2 * script.length_us() / 1000 {
                let now = script.target(1000 * ms);
                let mean = (now.velocity + before.velocity) * 0.5;
                let step = (now.position - before.position - mean * dt).length();
                assert!(step < 1e-7, "{name} at {ms} ms: position jumps by {step} m");
                let speed_step = (now.velocity - speed_before).length();
                assert!(speed_step < 1e-3, "{name} at {ms} ms: {speed_step} m/s");
                let spin_step = (now.spin - before.spin).length();
                assert!(spin_step < 2e-2, "{name} at {ms} ms: {spin_step} rad/s");
                before = now;
                speed_before = now.velocity;
            }
        }
    }

    #[test]
    fn press_goes_down_by_clearance_and_depth_and_no_further() {
        for max_force in [8.5, 12.0, 3.3] {
            let reach = Reach::usual(2000.0, max_force);
            for name in NAMES {
                let script = Script::by_name(name, &reach, false).unwrap();
                let lowest = (0..script.length_us() / 1000).map(|ms| script.target(1000 * ms).position.z).fold(0.0, f32::min);
                let expected = if name == "hold" { 0.0 } else { -CLEARANCE - reach.depth };
                assert!((lowest - expected).abs() < 1e-7, "{name}: {lowest}");
            }
        }
    }
}

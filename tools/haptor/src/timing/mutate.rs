//! What the search varies: a first pose and the motion of every tick after it. Changes are small or large, of one stretch of ticks, and never leave what the core
//! believes.

use fastrand::Rng;
use haptor_contact::{Pose, ProbeFrame, Quat, Vec3, World};

use super::history::{self, History, Motion};
use super::start::{PRESSED, Start, direction, signed};

/// Ticks of a history that the search makes: ten births, and as many ticks again twice over for what follows them.
pub const TICKS: usize = 32;

/// Exponents of ways in a tick, 10^x m, and of turns, 10^x rad: from what no sensor sees to what no hand does.
const WAYS: (f32, f32) = (-7.0, -2.0);
const TURNS: (f32, f32) = (-5.0, -0.3);

/// Exponents of depths of the first pose, 10^x m.
const DEPTHS: (f32, f32) = (-5.0, -2.0);

/// One candidate.
#[derive(Clone, Debug)]
pub struct Genome {
    /// Pose of the first tick.
    pub first: Pose<World, ProbeFrame>,
    /// Motion into each tick after it.
    pub motions: Vec<Motion>,
}

/// 10 to a power between two.
fn size(rng: &mut Rng, (low, high): (f32, f32)) -> f32 {
    10.0_f32.powf(low + (high - low) * rng.f32())
}

/// One motion of the kinds a hand makes: press, slide, twist, roll, several, or none.
fn motion(rng: &mut Rng) -> Motion {
    let (way, turn) = (size(rng, WAYS) * signed(rng).signum(), size(rng, TURNS) * signed(rng).signum());
    let across = Vec3::new(signed(rng), signed(rng), 0.0).normalize_or(Vec3::X);
    match rng.usize(..7) {
        0 => Motion { way: way * Vec3::Z, ..Motion::default() },
        1 => Motion { way: way * across, ..Motion::default() },
        2 => Motion { turn: turn * Vec3::Z, ..Motion::default() },
        3 => Motion { turn: turn * across, ..Motion::default() },
        4 => Motion { way: way * across, turn: turn * Vec3::Z },
        5 => Motion { way: way * direction(rng), turn: turn * direction(rng) },
        _ => Motion::default(),
    }
}

/// A stretch of a history.
fn stretch(rng: &mut Rng, ticks: usize) -> core::ops::Range<usize> {
    let from = rng.usize(..ticks);
    from..(from + 1 + rng.usize(..ticks.min(12))).min(ticks)
}

impl Genome {
    /// The last ticks of a history up to the one that is `at`.
    pub fn of(history: &History, at: usize) -> Self {
        let from = (at + 1).saturating_sub(TICKS);
        let poses = &history.poses[from..(from + TICKS).min(history.poses.len())];
        let between = |pair: &[Pose<World, ProbeFrame>]| Motion {
            way: pair[1].position - pair[0].position,
            turn: (pair[1].rotation * pair[0].rotation.conjugate()).to_scaled_axis(),
        };
        Self { first: poses[0], motions: poses.windows(2).map(between).collect() }
    }

    /// A new one at one of the starts: pressed, then led about.
    pub fn fresh(starts: &[Start], rng: &mut Rng) -> Self {
        // as many parts as can be every other time
        let start = if rng.bool() { starts.last() } else { starts.get(rng.usize(..starts.len().max(1))) };
        let depth = if rng.u8(..4) == 0 { -PRESSED } else { size(rng, DEPTHS) };
        let first = start.map_or(Pose::IDENTITY, |start| start.pose(depth));
        let mut motions = vec![Motion::default(); TICKS - 1];
        for _ in 0..1 + rng.usize(..4) {
            lead(&mut motions, rng);
        }
        Self { first, motions }
    }

    /// One or two changes away from this one; `other` may lend a stretch.
    pub fn changed(&self, other: &Self, rng: &mut Rng) -> Self {
        let mut next = self.clone();
        for _ in 0..1 + rng.usize(..2) {
            match rng.usize(..8) {
                0 | 1 => lead(&mut next.motions, rng),
                2 => next.scale(rng),
                3 => next.alternate(rng),
                4 => next.turn_back(rng),
                5 => next.take(other, rng),
                6 => next.first.position += size(rng, WAYS) * direction(rng),
                _ => {
                    let turn = Quat::from_scaled_axis(size(rng, TURNS) * direction(rng));
                    next.first.rotation = (turn * next.first.rotation).normalize();
                }
            }
        }
        next
    }

    /// Its poses as a history.
    pub fn history(&self, dt: f32) -> History {
        let poses = history::poses(self.first, &self.motions, dt);
        History { name: "search".to_owned(), poses, tunings: Vec::new() }
    }

    fn scale(&mut self, rng: &mut Rng) {
        let by = size(rng, (-0.7, 0.7));
        let stretch = stretch(rng, self.motions.len());
        self.motions[stretch].iter_mut().for_each(|motion| (motion.way, motion.turn) = (by * motion.way, by * motion.turn));
    }

    /// There and back from tick to tick: sticks and slips all over.
    fn alternate(&mut self, rng: &mut Rng) {
        let (motion, stretch) = (motion(rng), stretch(rng, self.motions.len()));
        let back = Motion { way: -motion.way, turn: -motion.turn };
        for (k, into) in self.motions[stretch].iter_mut().enumerate() {
            *into = if k % 2 == 0 { motion } else { back };
        }
    }

    fn turn_back(&mut self, rng: &mut Rng) {
        let stretch = stretch(rng, self.motions.len());
        self.motions[stretch].iter_mut().for_each(|motion| (motion.way, motion.turn) = (-motion.way, -motion.turn));
    }

    /// From a tick on as the other.
    fn take(&mut self, other: &Self, rng: &mut Rng) {
        let stretch = stretch(rng, self.motions.len().min(other.motions.len()));
        self.motions[stretch.clone()].copy_from_slice(&other.motions[stretch]);
    }
}

/// One stretch led by one motion.
fn lead(motions: &mut [Motion], rng: &mut Rng) {
    let (motion, stretch) = (motion(rng), stretch(rng, motions.len()));
    motions[stretch].fill(motion);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_histories() {
        let start = Start { rotation: Quat::IDENTITY, across: [0.0; 2], touch: 0.02, parts: 1, side: 1.0 };
        let make = |seed| {
            let mut rng = Rng::with_seed(seed);
            let one = Genome::fresh(&[start], &mut rng);
            let other = Genome::fresh(&[start], &mut rng);
            (0..50).fold(one, |genome, _| genome.changed(&other, &mut rng)).history(1.0e-3)
        };
        assert_eq!(make(7), make(7));
        assert_ne!(make(7), make(8));
        assert_eq!(make(7).poses.len(), TICKS);
    }

    #[test]
    fn a_history_becomes_a_candidate_that_ends_at_its_dearest_tick() {
        let start = Start { rotation: Quat::IDENTITY, across: [0.0; 2], touch: 0.02, parts: 1, side: 1.0 };
        let poses: Vec<_> = (0..100).map(|k| start.pose(1.0e-5 * k as f32)).collect();
        let genome = Genome::of(&History { name: String::new(), poses: poses.clone(), tunings: Vec::new() }, 80);
        let back = genome.history(1.0e-3);
        assert_eq!(back.poses[0], poses[81 - TICKS]);
        assert!((back.poses[TICKS - 1].position - poses[80].position).length() < 1.0e-6);
    }
}

//! The motions that a trade is measured on, made from the scene: pressed to a depth, then twisted, turned back, and led on paths that turn while they twist.
//!
//! Shifts and angles are told in the contact's own units ([`Units`](super::truth::Units)): one unit is what a contact that sticks would need to reach full slip. The shapes of
//! the mixed paths are the reference's own (`haptor_reference::paths`).

use haptor_reference::paths::named;

/// Which figures a motion gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Torque under a steady twist.
    Twist,
    /// Torque where a twist turns back.
    Reversal,
    /// Force and torque where both change at once.
    Mixed,
}

impl Kind {
    /// In words, after which the surface is looked at.
    pub fn name(self) -> &'static str {
        match self {
            Self::Twist => "the twist",
            Self::Reversal => "the reversals",
            Self::Mixed => "a mixed motion",
        }
    }
}

/// A motion from the pressed state on.
#[derive(Clone, Copy)]
pub struct Motion {
    /// What it measures.
    pub kind: Kind,
    at: fn(f64) -> [f64; 3],
}

impl Motion {
    /// Shift along x and y and angle at progress `t`, 0 to 1.
    pub fn at(&self, t: f64) -> [f64; 3] {
        (self.at)(t)
    }
}

/// Samples of a motion that are compared.
pub const SAMPLES: usize = 100;

/// Time of a motion \[s\]: at the lowest rate two ticks fall between two samples.
pub const SECONDS: f64 = 0.4;

/// Ticks in which the core presses before a motion, and samples of the press that are compared.
pub const PRESS_SAMPLES: usize = 10;

/// All motions.
pub const MOTIONS: [Motion; 4] = [
    Motion { kind: Kind::Twist, at: |t| [0.0, 0.0, 4.0 * t] },
    Motion { kind: Kind::Reversal, at: |t| [0.0, 0.0, back_and_forth(t)] },
    Motion { kind: Kind::Mixed, at: |t| on_path("circle_one_twist", t) },
    Motion { kind: Kind::Mixed, at: |t| on_path("wander_one", t) },
];

/// Out to 2, back to -2, out to 1.
fn back_and_forth(t: f64) -> f64 {
    let way = 9.0 * t;
    if way < 2.0 {
        way
    } else if way < 6.0 {
        4.0 - way
    } else {
        way - 8.0
    }
}

fn on_path(name: &str, t: f64) -> [f64; 3] {
    named(name).map_or([0.0; 3], |path| (path.at)(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_start_at_rest_and_go_somewhere() {
        for motion in MOTIONS {
            assert!(motion.at(0.0).iter().all(|c| c.abs() < 1e-12), "{:?}", motion.kind);
            let far = (1..=SAMPLES).map(|i| motion.at(i as f64 / SAMPLES as f64)[2].abs()).fold(0.0, f64::max);
            assert!(far >= 1.0, "{:?}: {far}", motion.kind);
        }
        assert_eq!([2.0, 6.0, 9.0].map(|way| back_and_forth(way / 9.0)), [2.0, -2.0, 1.0]);
    }
}

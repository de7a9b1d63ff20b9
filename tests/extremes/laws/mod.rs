//! What must hold in every case: the laws, their bounds, and the one entry that checks a case against a law.

mod energy;
mod frames;
mod place;
mod pressing;
mod rest;
mod wander;

use haptor_contact::{Invalid, Tier};

use super::cases::Case;
use super::rig::{Seen, index};

/// A law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Anything goes: see `wander.rs`.
    Wander,
    /// The same on a virtual coupling.
    Coupled,
    /// No energy out of closed cycles.
    Cycle,
    /// Units do not matter.
    Units,
    /// A quarter turn of the world does not matter.
    Turned,
    /// A place on the half space does not matter.
    Moved,
    /// What sticks comes back.
    Stick,
    /// Deeper is not lighter.
    Deeper,
    /// Small motions change little.
    Continuous,
    /// Time does not matter to the contact.
    Times,
    /// Poses that come several times over matter little.
    Repeated,
    /// Holding still holds.
    Hold,
}

/// Every law, in the order of the tables.
pub const LAWS: [Law; 12] = [
    Law::Wander,
    Law::Coupled,
    Law::Cycle,
    Law::Units,
    Law::Turned,
    Law::Moved,
    Law::Stick,
    Law::Deeper,
    Law::Continuous,
    Law::Times,
    Law::Repeated,
    Law::Hold,
];

/// Place of a law in [`LAWS`].
pub fn place_of(law: Law) -> usize {
    LAWS.iter().position(|&other| other == law).unwrap_or(0)
}

impl Law {
    /// Its name in tables and files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wander => "wander",
            Self::Coupled => "coupled",
            Self::Cycle => "cycle",
            Self::Units => "units",
            Self::Turned => "turned",
            Self::Moved => "moved",
            Self::Stick => "stick",
            Self::Deeper => "deeper",
            Self::Continuous => "continuous",
            Self::Times => "times",
            Self::Repeated => "repeated",
            Self::Hold => "hold",
        }
    }

    /// Largest figure that keeps the law, by tier.
    pub fn bound(self, tier: Tier) -> f64 {
        BOUNDS[place_of(self)][index(tier)]
    }
}

/// Bounds of the laws for the tiers point, paper, bristle, influence, green; the reasons stand in the document (`words.rs`).
const BOUNDS: [[f64; 5]; 12] = [
    [1.0e-3; 5],
    [1.0e-3; 5],
    [1.0e-2; 5],
    [1.0e-3; 5],
    [2.0e-2, UNBOUND, 2.0e-2, 2.0e-2, 2.0e-2],
    [1.0e-2; 5],
    [5.0e-2; 5],
    [1.0e-3; 5],
    [5.0e-2; 5],
    [0.0; 5],
    [2.0e-2, UNBOUND, 2.0e-2, 2.0e-2, 2.0e-2],
    [0.0; 5],
];

/// Tier `paper` has thresholds of its own (an axis that does or does not pierce the region, a region that slides or does not): what is on one side of them is not what is on the other.
const UNBOUND: f64 = f64::INFINITY;

/// What a case said about a law.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// What was seen of all its scenes together.
    pub seen: Seen,
    /// The law's figure; `None` where the case did not come to measure it: no contact, or ticks that warned of themselves.
    pub figure: Option<f64>,
    /// Construction refused the scene.
    pub refused: Option<Invalid>,
}

impl Outcome {
    /// Adds what was seen of one scene.
    fn add(&mut self, seen: &Seen) {
        let own = &mut self.seen;
        own.steps += seen.steps;
        own.touching += seen.touching;
        own.warned += seen.warned;
        own.refused += seen.refused;
        own.excess = own.excess.max(seen.excess);
        own.fault = own.fault.take().or_else(|| seen.fault.clone());
        own.digest.take(seen.digest.0 as u32);
        own.digest.take((seen.digest.0 >> 32) as u32);
    }

    /// Keeps the larger figure. What is not a number is the worst there is.
    fn figure(&mut self, figure: f64) {
        let figure = if figure.is_nan() { f64::INFINITY } else { figure };
        self.figure = Some(self.figure.map_or(figure, |other| other.max(figure)));
    }
}

/// Checks a case against a law.
pub fn check(law: Law, case: &Case) -> Outcome {
    let mut outcome = Outcome::default();
    let done = match law {
        Law::Wander => wander::wander(case, &mut outcome),
        Law::Coupled => wander::coupled(case, &mut outcome),
        Law::Cycle => energy::cycle(case, &mut outcome),
        Law::Units => frames::units(case, &mut outcome),
        Law::Turned => frames::turned(case, &mut outcome),
        Law::Moved => frames::moved(case, &mut outcome),
        Law::Stick => energy::stick(case, &mut outcome),
        Law::Deeper => pressing::deeper(case, &mut outcome),
        Law::Continuous => pressing::continuous(case, &mut outcome),
        Law::Times => rest::times(case, &mut outcome),
        Law::Repeated => rest::repeated(case, &mut outcome),
        Law::Hold => rest::hold(case, &mut outcome),
    };
    if let Err(invalid) = done {
        outcome.refused = Some(invalid);
    }
    outcome
}

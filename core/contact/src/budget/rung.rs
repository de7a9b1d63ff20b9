//! The rungs of the ladder: from what the parameters ask for down to what costs least.

use crate::limits::MIN_SAMPLES;
use crate::params::Tier;
use crate::tier::influence::Layout;

/// How finely a tick computes what friction holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rung {
    /// Fidelity.
    pub tier: Tier,
    /// Samples per region for `paper` and `bristle`, cells of a fresh contact for `influence` and `green`; of no meaning for `point`.
    pub samples: u16,
    /// Sweeps of tiers `influence` and `green`; of no meaning for the others.
    pub sweeps: u8,
}

/// Rungs below the highest at most: coarse cells, five halvings of [`MAX_SWEEPS`](crate::MAX_SWEEPS), three numbers of bristles, `point`. Bounds the loops that go down.
pub const MAX_STEPS: u8 = 10;

/// Bristles of the first rung below the cells: the default of a scene.
const BRISTLES: u16 = 64;

/// Cells of the coarse grid.
const COARSE: u16 = Layout::COARSE.cells as u16;

impl Rung {
    /// The next that costs less: coarse cells, half the sweeps, bristles, half of them, closed forms. Tier `paper` keeps its equations and only halves its
    /// samples. `None` on the lowest.
    #[must_use]
    pub const fn lower(self) -> Option<Self> {
        let Self { tier, samples, sweeps } = self;
        match tier {
            Tier::Point => None,
            Tier::Influence | Tier::Green if samples > COARSE => Some(Self { samples: COARSE, ..self }),
            Tier::Influence | Tier::Green if sweeps > 1 => Some(Self { sweeps: sweeps / 2, ..self }),
            Tier::Influence | Tier::Green => Some(Self { tier: Tier::Bristle, samples: BRISTLES, sweeps }),
            Tier::Paper | Tier::Bristle if samples > MIN_SAMPLES as u16 => Some(Self { samples: halved(samples), ..self }),
            Tier::Bristle => Some(Self { tier: Tier::Point, ..self }),
            Tier::Paper => None,
        }
    }

    /// Steps from this rung down to the lowest.
    pub(crate) fn steps_down(self) -> u8 {
        let mut rung = self;
        for steps in 0..MAX_STEPS {
            let Some(lower) = rung.lower() else { return steps };
            rung = lower;
        }
        MAX_STEPS
    }

    /// The rung so many steps below this one, or the lowest.
    pub(crate) fn below(self, steps: u8) -> Self {
        let mut rung = self;
        for _ in 0..steps.min(MAX_STEPS) {
            let Some(lower) = rung.lower() else { break };
            rung = lower;
        }
        rung
    }
}

/// The power of two at or below half: 64, 32, 16 whatever the scene's own number.
const fn halved(samples: u16) -> u16 {
    let half = (samples - 1).ilog2();
    1 << half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_goes_down_to_its_lowest_within_the_bound() {
        use Tier::{Bristle, Green, Influence, Paper, Point};
        /// The first rungs, and tier and samples of the lowest where it is not among them.
        type Row = (&'static [(Tier, u16, u8)], Option<(Tier, u16)>);
        let ladders: [Row; 5] = [
            (
                &[
                    (Influence, 112, 4),
                    (Influence, 52, 4),
                    (Influence, 52, 2),
                    (Influence, 52, 1),
                    (Bristle, 64, 1),
                    (Bristle, 32, 1),
                ],
                Some((Point, 16)),
            ),
            (&[(Green, 52, 32), (Green, 52, 16), (Green, 52, 8)], Some((Point, 16))),
            (&[(Bristle, 256, 4), (Bristle, 128, 4), (Bristle, 64, 4), (Bristle, 32, 4), (Bristle, 16, 4), (Point, 16, 4)], None),
            (&[(Bristle, 20, 1), (Bristle, 16, 1), (Point, 16, 1)], None),
            (&[(Paper, 1000, 1), (Paper, 512, 1), (Paper, 256, 1)], Some((Paper, 16))),
        ];
        for (first, last) in ladders {
            let mut rung = Rung { tier: first[0].0, samples: first[0].1, sweeps: first[0].2 };
            let top = rung;
            for (steps, &(tier, samples, sweeps)) in first.iter().enumerate() {
                assert_eq!((rung.tier, rung.samples, rung.sweeps), (tier, samples, sweeps), "{first:?}");
                assert_eq!(top.below(steps as u8), rung);
                rung = rung.lower().unwrap_or(rung);
            }
            let lowest = top.below(top.steps_down());
            assert_eq!(lowest.lower(), None, "{first:?}");
            assert!(last.is_none_or(|last| last == (lowest.tier, lowest.samples)), "{first:?}: {lowest:?}");
        }
    }
}

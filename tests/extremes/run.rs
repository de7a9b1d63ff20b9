//! Many cases on two threads, tallied by law and tier.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::cases::Case;
use super::laws::{LAWS, Law, Outcome, check, place_of};
use super::rig::{Digest, index};

/// Cases of a round; after each round the steps are counted, so that the end does not depend on which thread was faster.
const ROUND: u64 = 1536;

/// Faults that are kept with their words; all are counted.
const KEPT: usize = 16;

/// What all cases of a law and a tier said.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Cases.
    pub cases: u64,
    /// Ticks.
    pub steps: u64,
    /// Ticks with contact.
    pub touching: u64,
    /// Cases that came to measure the law's figure.
    pub measured: u64,
    /// Scenes that construction refused.
    pub refused: u64,
    /// Figures above the bound.
    pub above: u64,
    /// Largest figure, and the seed of its case.
    pub worst: Option<(f64, u64)>,
}

/// Something that must never be.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Law and seed that make it again.
    pub law: Law,
    /// See `law`.
    pub seed: u64,
    /// What it is.
    pub what: String,
}

/// What a run said.
#[derive(Clone, Debug, Default)]
pub struct Tallies {
    /// By law, then by tier.
    pub laws: [[Tally; 5]; LAWS.len()],
    /// Faults there were.
    pub faulty: u64,
    /// The first of them.
    pub faults: Vec<Fault>,
    /// Poses that were refused, and ticks that warned of themselves.
    pub refused_poses: u64,
    /// See `refused_poses`.
    pub warned: u64,
    /// Hash over the bits of every output in the order of the cases.
    pub digest: Digest,
}

impl Tallies {
    /// Ticks of all cases.
    pub fn steps(&self) -> u64 {
        self.laws.as_flattened().iter().map(|tally| tally.steps).sum()
    }

    /// Cases of all laws.
    pub fn cases(&self) -> u64 {
        self.laws.as_flattened().iter().map(|tally| tally.cases).sum()
    }

    fn take(&mut self, law: Law, case: &Case, outcome: &Outcome) {
        let tier = case.twin.params.tier;
        let tally = &mut self.laws[place_of(law)][index(tier)];
        tally.cases += 1;
        tally.steps += outcome.seen.steps;
        tally.touching += outcome.seen.touching;
        tally.refused += u64::from(outcome.refused.is_some());
        if let Some(figure) = outcome.figure {
            tally.measured += 1;
            tally.above += u64::from(figure > law.bound(tier));
            if tally.worst.is_none_or(|(worst, _)| figure > worst) {
                tally.worst = Some((figure, case.seed));
            }
        }
        self.warned += outcome.seen.warned;
        self.refused_poses += outcome.seen.refused;
        self.digest.take(outcome.seen.digest.0 as u32);
        if let Some(what) = &outcome.seen.fault {
            self.fail(Fault { law, seed: case.seed, what: what.clone() });
        }
    }

    fn fail(&mut self, fault: Fault) {
        self.faulty += 1;
        if self.faults.len() < KEPT {
            self.faults.push(fault);
        }
    }

    fn join(&mut self, other: Self) {
        for (own, more) in self.laws.as_flattened_mut().iter_mut().zip(other.laws.as_flattened()) {
            own.cases += more.cases;
            own.steps += more.steps;
            own.touching += more.touching;
            own.measured += more.measured;
            own.refused += more.refused;
            own.above += more.above;
            own.worst = match (own.worst, more.worst) {
                (Some(a), Some(b)) => Some(if b.0 > a.0 { b } else { a }),
                (a, b) => a.or(b),
            };
        }
        self.faulty += other.faulty;
        let room = KEPT.saturating_sub(self.faults.len());
        self.faults.extend(other.faults.into_iter().take(room));
        self.refused_poses += other.refused_poses;
        self.warned += other.warned;
        self.digest.take(other.digest.0 as u32);
        self.digest.take((other.digest.0 >> 32) as u32);
    }
}

/// The seed of case `i` of a run (Steele, Lea and Flood's mixing of a counter).
pub fn seed_of(run: u64, i: u64) -> u64 {
    let mut z = run.wrapping_add((i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The law that case `i` of a run is for.
pub fn law_of(i: u64) -> Law {
    LAWS[(i % LAWS.len() as u64) as usize]
}

/// Checks one case, a panic being a fault like any other.
pub fn judge(law: Law, seed: u64) -> (Case, Outcome) {
    let case = Case::new(seed);
    let outcome = catch_unwind(AssertUnwindSafe(|| check(law, &case))).unwrap_or_else(|_| {
        let mut outcome = Outcome::default();
        outcome.seen.fault = Some("panicked".to_owned());
        outcome
    });
    (case, outcome)
}

fn batch(run: u64, cases: impl Iterator<Item = u64>) -> Tallies {
    let mut tallies = Tallies::default();
    for i in cases {
        let (case, outcome) = judge(law_of(i), seed_of(run, i));
        tallies.take(law_of(i), &case, &outcome);
    }
    tallies
}

/// The first `cases` cases of a run.
pub fn some(run: u64, cases: u64) -> Tallies {
    batch(run, 0..cases)
}

/// Cases until there were `steps` ticks, on two threads. `progress` is told the ticks so far.
///
/// # Panics
/// When a thread cannot be joined.
pub fn all(run: u64, steps: u64, mut progress: impl FnMut(u64)) -> Tallies {
    let mut tallies = Tallies::default();
    let mut first = 0;
    while tallies.steps() < steps {
        // laws take turns: both threads get some of each
        let half = |thread: u64| (first..first + ROUND).filter(move |i| i / LAWS.len() as u64 % 2 == thread);
        let (a, b) = std::thread::scope(|scope| {
            let other = scope.spawn(|| batch(run, half(1)));
            (batch(run, half(0)), other.join().expect("a batch does not panic"))
        });
        tallies.join(a);
        tallies.join(b);
        first += ROUND;
        progress(tallies.steps());
    }
    tallies
}

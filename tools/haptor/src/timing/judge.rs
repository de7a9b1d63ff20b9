//! What histories cost, tick by tick: played by the engine into recordings, run by the measuring program, as many at a time as there are CPUs.

use std::thread;

use haptor_wire::{Record, Tuning};

use super::cover::Cover;
use super::history::History;
use super::measure::Measure;
use crate::failure::Failure;
use crate::session::offline;

/// A scene that histories are played on.
#[derive(Debug)]
pub struct Judge<'a> {
    /// The baked scene's file.
    pub scene: &'a [u8],
    /// Ticks a second.
    pub rate_hz: u32,
    /// What runs them.
    pub measure: &'a Measure,
    /// What was exercised so far.
    pub cover: Cover,
}

/// The dearest tick of a history.
#[derive(Clone, Debug)]
pub struct Dearest {
    /// The history.
    pub history: History,
    /// The tick, from 0.
    pub tick: usize,
    /// Its cost.
    pub cost: u64,
}

impl Judge<'_> {
    /// Length of a tick \[s\].
    pub fn dt(&self) -> f32 {
        (1.0 / f64::from(self.rate_hz)) as f32
    }

    /// A recording of histories at a level, and what they exercised.
    ///
    /// # Errors
    /// [`Failure::Problem`] when the scene refuses the level.
    pub fn recording(&self, level: &Tuning, histories: &[History]) -> Result<(Vec<u8>, Cover), Failure> {
        let (mut records, mut first, mut cover) = (Vec::new(), 0, Cover::default());
        for history in histories {
            records.extend(history.records(level, first));
            first += history.poses.len() as u64;
        }
        let mut lengths = histories.iter().map(|history| history.poses.len());
        let mut left = 0;
        let file = offline::answer(self.scene, self.rate_hz, records.into_iter().map(Ok), |tick, engine| {
            if left == 0 {
                cover.rest();
                left = lengths.next().unwrap_or(usize::MAX);
            }
            left -= 1;
            cover.tick(tick, engine);
        });
        Ok((file.map_err(Failure::problem)?, cover))
    }

    /// Regions in each tick of a history.
    ///
    /// # Errors
    /// As [`Self::recording`].
    pub fn regions(&self, level: &Tuning, history: &History) -> Result<Vec<u8>, Failure> {
        let (mut regions, records) = (Vec::new(), history.records(level, 0).into_iter().map(Ok));
        offline::answer(self.scene, self.rate_hz, records, |tick, _| regions.push(tick.regions)).map_err(Failure::problem)?;
        Ok(regions)
    }

    /// What the level's engine is made of and no tick.
    ///
    /// # Errors
    /// As [`Self::recording`].
    pub fn empty(&self, level: &Tuning) -> Result<Vec<u8>, Failure> {
        let records = offline::begin(level).into_iter().map(Ok::<Record<'static>, String>);
        offline::answer(self.scene, self.rate_hz, records, |_, _| ()).map_err(Failure::problem)
    }

    /// Cost of every tick of every history.
    ///
    /// # Errors
    /// [`Failure::Problem`] when the measuring program fails.
    pub fn costs(&mut self, level: &Tuning, histories: &[History]) -> Result<Vec<Vec<u64>>, Failure> {
        let workers = thread::available_parallelism().map_or(1, usize::from).min(histories.len()).max(1);
        // times are taken one after the other: neighbours would disturb them
        let workers = if self.measure.counter().is_some() { workers } else { 1 };
        let shares: Vec<&[History]> = histories.chunks(histories.len().div_ceil(workers).max(1)).collect();
        let this = &*self;
        let done: Vec<Result<_, Failure>> = thread::scope(|scope| {
            let started: Vec<_> =
                shares.iter().enumerate().map(|(slot, share)| scope.spawn(move || this.share(level, share, slot))).collect();
            let failed = || Err(Failure::problem("a thread of the search ended by a panic; please report it"));
            started.into_iter().map(|thread| thread.join().unwrap_or_else(|_| failed())).collect()
        });
        let mut all = Vec::new();
        for share in done {
            let (costs, cover) = share?;
            self.cover.add(&cover);
            all.extend(costs);
        }
        Ok(all)
    }

    fn share(&self, level: &Tuning, histories: &[History], slot: usize) -> Result<(Vec<Vec<u64>>, Cover), Failure> {
        let (recording, cover) = self.recording(level, histories)?;
        let costs = self.measure.costs(&recording, slot)?;
        let mut rest = costs.as_slice();
        let take = |history: &History| {
            let (own, others) = rest.split_at(history.poses.len().min(rest.len()));
            rest = others;
            own.to_vec()
        };
        Ok((histories.iter().map(take).collect(), cover))
    }
}

/// The dearest tick of costs; the first of several.
pub fn dearest(costs: &[u64]) -> (usize, u64) {
    costs.iter().copied().enumerate().fold((0, 0), |best, (tick, cost)| if cost > best.1 { (tick, cost) } else { best })
}

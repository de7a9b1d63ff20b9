//! The search for the dearest tick: hill climbing over histories, with an elite that lends and restarts where it stays on a hill.

use std::time::{Duration, Instant};

use fastrand::Rng;
use haptor_wire::Tuning;
use indicatif::ProgressBar;

use super::history::History;
use super::judge::{Dearest, Judge, dearest};
use super::mutate::Genome;
use super::start::Start;
use crate::failure::Failure;

/// Candidates of a generation: some for each CPU, few enough that the next ones learn from them.
const GENERATION: usize = 8;

/// Candidates that are kept to be changed further.
const ELITE: usize = 4;

/// Generations without a dearer tick after which the elite is given up.
const PATIENCE: u32 = 6;

/// How long it goes on.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Time.
    pub time: Duration,
    /// Generations; with this the same seed finds the same.
    pub generations: Option<u32>,
}

/// How far it came.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effort {
    /// Generations.
    pub generations: u32,
    /// Histories tried.
    pub histories: u64,
    /// Restarts.
    pub restarts: u32,
}

/// A candidate and the cost of its dearest tick.
type Kept = (u64, Genome);

/// Searches at a level from what is known; yields the dearest found, if it is dearer than nothing at all, and the effort.
///
/// # Errors
/// As [`Judge::costs`].
pub fn search(
    judge: &mut Judge<'_>,
    level: &Tuning,
    starts: &[Start],
    known: &[Dearest],
    (limits, rng, bar): (Limits, &mut Rng, &ProgressBar),
) -> Result<(Option<Dearest>, Effort), Failure> {
    let (began, mut effort, mut best) = (Instant::now(), Effort::default(), None::<Dearest>);
    let mut elite: Vec<Kept> = known.iter().map(|dearest| (0, Genome::of(&dearest.history, dearest.tick))).take(ELITE).collect();
    let (mut summit, mut since) = (0, 0);
    while !starts.is_empty() && goes_on(&limits, began, effort.generations) {
        bar.set_position((began.elapsed().as_millis() as u64).min(bar.length().unwrap_or(0)));
        let genomes = offspring(&elite, starts, effort.generations == 0, rng);
        let histories: Vec<History> = genomes.iter().map(|genome| genome.history(judge.dt())).collect();
        let costs = judge.costs(level, &histories)?;
        effort.generations += 1;
        effort.histories += histories.len() as u64;
        for ((genome, history), costs) in genomes.into_iter().zip(histories).zip(&costs) {
            let (tick, cost) = dearest(costs);
            if best.as_ref().is_none_or(|best| cost > best.cost) {
                best = Some(Dearest { history, tick, cost });
                bar.set_message(format!("{cost}"));
            }
            elite.push((cost, genome));
        }
        elite.sort_by_key(|(cost, _)| std::cmp::Reverse(*cost));
        elite.truncate(ELITE);
        let top = elite.first().map_or(0, |(cost, _)| *cost);
        (summit, since) = if top > summit { (top, 0) } else { (summit, since + 1) };
        if since >= PATIENCE {
            elite.clear();
            (summit, since, effort.restarts) = (0, 0, effort.restarts + 1);
        }
    }
    Ok((best, effort))
}

fn goes_on(limits: &Limits, began: Instant, generations: u32) -> bool {
    match limits.generations {
        Some(most) => generations < most,
        None => began.elapsed() < limits.time,
    }
}

/// The next candidates: known ones first as they are, then changes of the elite and, one in four, fresh ones.
fn offspring(elite: &[Kept], starts: &[Start], first: bool, rng: &mut Rng) -> Vec<Genome> {
    let mut genomes: Vec<Genome> = if first { elite.iter().map(|(_, genome)| genome.clone()).collect() } else { Vec::new() };
    while genomes.len() < GENERATION {
        let fresh = elite.is_empty() || rng.u8(..4) == 0;
        genomes.push(if fresh {
            Genome::fresh(starts, rng)
        } else {
            let (one, other) = (&elite[rng.usize(..elite.len())].1, &elite[rng.usize(..elite.len())].1);
            one.changed(other, rng)
        });
    }
    genomes
}

//! Cost per unit of work, by differences: the same history once more with more samples, more cells, more sweeps; per region by a straight line through ticks.

use haptor_wire::{Tier, Tuning};

use super::judge::{Dearest, Judge};
use crate::failure::Failure;

/// Cost of one more of something.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Of what.
    pub what: &'static str,
    /// Instructions, or nanoseconds.
    pub cost: f64,
    /// How it was found.
    pub how: String,
}

/// Samples of a bristle patch and of the paper's for the difference; cells there are 52 and 112 of.
const SAMPLES: [u16; 2] = [64, 128];
const CELLS: [u16; 2] = [52, 112];
const SWEEPS: [u8; 2] = [4, 8];

/// Units of a level at its dearest tick, which has so many regions; without a work budget, which would take back what is added.
///
/// # Errors
/// As [`Judge::costs`].
pub fn of(judge: &mut Judge<'_>, level: &Tuning, dearest: &Dearest, regions: usize) -> Result<Vec<Unit>, Failure> {
    let mut units = Vec::new();
    if regions == 0 {
        return Ok(units);
    }
    let free = if level.work.is_some() { ", no budget" } else { "" };
    let level = &Tuning { work: None, ..*level };
    let samples = |samples| Tuning { samples, ..*level };
    let mut between = |what, [less, more]: [Tuning; 2], steps: usize, how: String| -> Result<(), Failure> {
        let history = std::slice::from_ref(&dearest.history);
        let at = |costs: Vec<Vec<u64>>| costs.first().and_then(|ticks| ticks.get(dearest.tick)).map_or(0.0, |&cost| cost as f64);
        let (less, more) = (at(judge.costs(&less, history)?), at(judge.costs(&more, history)?));
        units.push(Unit { what, cost: (more - less) / (steps * regions) as f64, how });
        Ok(())
    };
    let to = |list: [u16; 2]| format!("{} to {}, {regions} regions{free}", list[0], list[1]);
    match level.tier {
        Tier::Point => {}
        Tier::Paper | Tier::Bristle => {
            between("sample of a region", SAMPLES.map(samples), usize::from(SAMPLES[1] - SAMPLES[0]), to(SAMPLES))?;
        }
        Tier::Influence | Tier::Green => {
            between("cell of a region", CELLS.map(samples), usize::from(CELLS[1] - CELLS[0]), to(CELLS))?;
            let sweeps = SWEEPS.map(|sweeps| Tuning { sweeps, ..*level });
            let steps = usize::from(SWEEPS[1] - SWEEPS[0]);
            between("sweep of a region", sweeps, steps, format!("{} to {}, {regions} regions{free}", SWEEPS[0], SWEEPS[1]))?;
        }
    }
    Ok(units)
}

/// Points of the surface for the difference: a square of 8 and one of 64 a side.
const POINTS: [u16; 2] = [64, 4096];

/// Cost of one more vertex of the surface after the dearest tick, which has so many regions. `None` where nothing counts instructions.
///
/// # Errors
/// As [`Judge::costs`].
pub fn vertex(judge: &Judge<'_>, level: &Tuning, dearest: &Dearest, regions: usize) -> Result<Option<Unit>, Failure> {
    let (recording, _) = judge.recording(level, &[dearest.history.until(dearest.tick)])?;
    let [few, many] = POINTS.map(|points| judge.measure.surface(&recording, points));
    let between = |(few, many): (u64, u64)| Unit {
        what: "vertex of the surface",
        cost: (many as f64 - few as f64) / f64::from(POINTS[1] - POINTS[0]),
        how: format!("{} to {} on 0.1 m around the deepest contact, {regions} regions", POINTS[0], POINTS[1]),
    };
    Ok(few?.zip(many?).map(between))
}

/// Cost of one more region: the slope of a straight line through the ticks with at least one, (regions, cost). `None` where all have as many.
pub fn region(ticks: &[(u8, u64)]) -> Option<Unit> {
    let touching: Vec<(f64, f64)> =
        ticks.iter().filter(|(regions, _)| *regions > 0).map(|&(regions, cost)| (f64::from(regions), cost as f64)).collect();
    let count = touching.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| touching.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|tick| tick.0), mean(|tick| tick.1));
    let spread: f64 = touching.iter().map(|tick| (tick.0 - x) * (tick.0 - x)).sum();
    let together: f64 = touching.iter().map(|tick| (tick.0 - x) * (tick.1 - y)).sum();
    (spread > 0.0).then(|| Unit {
        what: "region",
        cost: together / spread,
        how: format!("straight line through {} ticks of the fixed motions", touching.len()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found() {
        let ticks: Vec<_> = (0..=10_u8).map(|k| (k, if k == 0 { 7 } else { 100 + 30 * u64::from(k) })).collect();
        assert!((region(&ticks).unwrap().cost - 30.0).abs() < 1.0e-9);
        assert_eq!(region(&[(2, 5), (2, 9)]), None);
    }
}

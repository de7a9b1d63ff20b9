//! One measured case as a line. Every program of the comparison in `tests/bench/peers` prints the same fields, so that the lines of all of them make one table.

use std::time::Duration;

use serde::Serialize;

use super::clock::Spent;

/// One measured case; times in microseconds. A quantile is the time of a call that was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// The program.
    pub peer: String,
    /// Its version.
    pub version: String,
    /// The scene.
    pub scene: String,
    /// How it is computed.
    pub case: String,
    /// Calls counted.
    pub n: usize,
    /// Wall time, middle.
    pub median_us: f64,
    /// Wall time that 99 of 100 calls stay within.
    pub p99_us: f64,
    /// Longest wall time.
    pub max_us: f64,
    /// CPU time of the thread, middle.
    pub cpu_median_us: f64,
    /// CPU time that 99 of 100 calls stay within.
    pub cpu_p99_us: f64,
    /// Longest CPU time.
    pub cpu_max_us: f64,
}

impl Line {
    /// The line of so many calls.
    pub fn new(peer: &str, version: &str, scene: &str, case: &str, spent: &[Spent]) -> Self {
        let [median_us, p99_us, max_us] = quantiles(spent.iter().map(|took| took.wall));
        let [cpu_median_us, cpu_p99_us, cpu_max_us] = quantiles(spent.iter().map(|took| took.cpu));
        let [peer, version, scene, case] = [peer, version, scene, case].map(str::to_owned);
        Self { peer, version, scene, case, n: spent.len(), median_us, p99_us, max_us, cpu_median_us, cpu_p99_us, cpu_max_us }
    }
}

/// Middle, 99 of 100 and longest \[us\].
pub fn quantiles(times: impl Iterator<Item = Duration>) -> [f64; 3] {
    let mut times: Vec<_> = times.collect();
    times.sort_unstable();
    let us = |share: f64| {
        let rank = (share * times.len() as f64).ceil() as usize;
        times.get(rank.max(1) - 1).map_or(0.0, |time| time.as_nanos() as f64 / 1.0e3)
    };
    [us(0.5), us(0.99), us(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_times_that_were() {
        let times = |n: u64| (1..=n).rev().map(Duration::from_micros);
        assert_eq!(quantiles(times(200)), [100.0, 198.0, 200.0]);
        assert_eq!(quantiles(times(1)), [1.0; 3]);
        assert_eq!(quantiles(times(0)), [0.0; 3]);
    }
}

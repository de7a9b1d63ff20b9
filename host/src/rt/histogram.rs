//! Durations counted in bins that are all there from the start, so that recording one is an increment.
//!
//! The bins are those of HdrHistogram (hdrhistogram.org): as wide as a fixed share of the value. Three of these say how a session
//! went: wake-up, step and round trip.

use haptor_wire::Quantiles;
use hdrhistogram::Histogram;

/// Longest duration told apart \[ns\]. What takes four seconds or more is counted in the last bin; `max` is exact up to u32.
const LONGEST_NS: u64 = 4_000_000_000;

/// Digits kept: a bin is 1 % of its value wide, finer than two runs on one machine agree.
const DIGITS: u8 = 2;

/// Durations of one kind over a session.
#[derive(Debug)]
pub struct Durations {
    bins: Histogram<u64>,
    max_ns: u64,
}

impl Default for Durations {
    fn default() -> Self {
        Self::new()
    }
}

impl Durations {
    /// Empty, with all its memory.
    #[must_use]
    pub fn new() -> Self {
        let bins = Histogram::new_with_bounds(1, LONGEST_NS, DIGITS).expect("the bounds are constants that the crate accepts");
        Self { bins, max_ns: 0 }
    }

    /// Counts one duration. Allocates nothing.
    pub fn record_ns(&mut self, ns: u64) {
        self.bins.saturating_record(ns);
        self.max_ns = self.max_ns.max(ns);
    }

    /// Durations counted.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.bins.len()
    }

    /// What was counted: upper edge of each bin \[ns\], and how many, in order; empty bins are left out. The last edge is no more than the
    /// largest seen.
    pub fn bins(&self) -> impl Iterator<Item = (u64, u64)> {
        let bins = self.bins.iter_recorded();
        bins.map(|bin| (bin.value_iterated_to().min(self.max_ns), bin.count_since_last_iteration()))
    }

    /// Quantiles \[ns\]: upper edges of bins, but no more than the largest seen, which is exact. All 0 when nothing was counted.
    #[must_use]
    pub fn quantiles(&self) -> Quantiles {
        let at = |share: f64| to_u32(self.bins.value_at_quantile(share).min(self.max_ns));
        Quantiles { p50: at(0.5), p99: at(0.99), p999: at(0.999), p9999: at(0.9999), max: to_u32(self.max_ns) }
    }
}

fn to_u32(ns: u64) -> u32 {
    u32::try_from(ns).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_a_ramp() {
        let mut durations = Durations::new();
        assert_eq!(durations.quantiles(), Quantiles::default());
        (1..=10_000).for_each(|us| durations.record_ns(us * 1000));
        let q = durations.quantiles();
        for (got, exact) in [(q.p50, 5.0e6), (q.p99, 9.9e6), (q.p999, 9.99e6), (q.p9999, 9.999e6)] {
            let error = f64::from(got) / exact - 1.0;
            assert!((0.0..=0.01).contains(&error), "{got} for {exact}");
        }
        assert_eq!((q.max, durations.count()), (10_000_000, 10_000));
        let bins: Vec<_> = durations.bins().collect();
        assert_eq!((bins.iter().map(|bin| bin.1).sum::<u64>(), bins.last().unwrap().0), (10_000, 10_000_000));
        assert!(bins.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn what_is_too_long_is_counted_in_the_last_bin() {
        let mut durations = Durations::new();
        durations.record_ns(u64::MAX);
        assert_eq!((durations.count(), durations.quantiles().max), (1, u32::MAX));
        assert!(u64::from(durations.quantiles().p50) <= LONGEST_NS * 101 / 100);
    }
}

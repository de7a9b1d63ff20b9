//! Durations by bins: of the host's histograms, of cyclictest's, and of several together.

use std::collections::BTreeMap;

use serde_json::{Value, json};

/// Durations of one kind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spread {
    /// How many, by the upper edge of their bin \[ns\].
    bins: BTreeMap<u64, u64>,
}

impl Spread {
    /// Nothing counted.
    pub const EMPTY: Self = Self { bins: BTreeMap::new() };

    /// Counts `count` durations of up to `upto_ns`.
    pub fn add(&mut self, upto_ns: u64, count: u64) {
        if count > 0 {
            *self.bins.entry(upto_ns).or_default() += count;
        }
    }

    /// Counts all of another one.
    pub fn merge(&mut self, other: &Self) {
        other.bins.iter().for_each(|(&upto_ns, &count)| self.add(upto_ns, count));
    }

    /// How many were counted.
    pub fn count(&self) -> u64 {
        self.bins.values().sum()
    }

    /// The smallest edge that a share of all does not pass \[ns\]; 0 when nothing was counted.
    pub fn quantile_ns(&self, share: f64) -> u64 {
        let wanted = (share * self.count() as f64).ceil() as u64;
        let mut seen = 0;
        let found = self.bins.iter().find(|(_, count)| {
            seen += **count;
            seen >= wanted
        });
        found.map_or(0, |(&upto_ns, _)| upto_ns)
    }

    /// The largest \[ns\]; 0 when nothing was counted.
    pub fn max_ns(&self) -> u64 {
        self.bins.last_key_value().map_or(0, |(&upto_ns, _)| upto_ns)
    }

    /// Bins in order: upper edge \[ns\], count.
    pub fn bins(&self) -> impl Iterator<Item = (u64, u64)> {
        self.bins.iter().map(|(&upto_ns, &count)| (upto_ns, count))
    }

    /// p50, p99, p99.9, p99.99 and the largest \[ns\].
    pub fn figures(&self) -> [u64; 5] {
        let at = |share| self.quantile_ns(share);
        [at(0.5), at(0.99), at(0.999), at(0.9999), self.max_ns()]
    }

    /// The same for programs.
    pub fn value(&self) -> Value {
        let [p50, p99, p999, p9999, max] = self.figures();
        json!({ "cycles": self.count(), "p50_ns": p50, "p99_ns": p99, "p99_9_ns": p999, "p99_99_ns": p9999, "max_ns": max })
    }

    /// The rows of the host's file of times that are about `what`.
    pub fn of_times(table: &str, what: &str) -> Self {
        let mut spread = Self::default();
        for line in table.lines().skip(1) {
            let mut fields = line.split(',');
            if fields.next() == Some(what)
                && let (Some(upto_ns), Some(count)) = (number(fields.next()), number(fields.next()))
            {
                spread.add(upto_ns, count);
            }
        }
        spread
    }
}

fn number(text: Option<&str>) -> Option<u64> {
    text?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_edges_of_bins() {
        let mut spread = Spread::default();
        assert_eq!((spread.count(), spread.figures()), (0, [0; 5]));
        spread.add(10, 9_998);
        spread.add(70, 1);
        spread.add(500, 0);
        let mut more = Spread::default();
        more.add(90, 1);
        spread.merge(&more);
        assert_eq!((spread.count(), spread.figures()), (10_000, [10, 10, 10, 70, 90]));
    }

    #[test]
    fn the_host_s_file_is_read_by_kind() {
        let table = "what,upto_ns,count\nwake_up,100,3\nstep,50,2\nwake_up,200,1\n";
        let wake = Spread::of_times(table, "wake_up");
        assert_eq!((wake.count(), wake.max_ns()), (4, 200));
        assert_eq!(Spread::of_times(table, "round_trip").count(), 0);
    }
}

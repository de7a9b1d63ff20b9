//! How late a thread of normal priority wakes from a thousand sleeps a second.

use std::thread;
use std::time::{Duration, Instant};

use super::{Finding, Mark};
use crate::progress;
use crate::trial::{SHARE_FAIL, SHARE_WARN};

/// Length of a tick \[ns\].
const PERIOD_NS: u64 = 1_000_000;

/// Ticks of the test: two seconds.
const TICKS: u64 = 2_000;

/// Lateness that 999 of 1,000 wake-ups should stay below \[ns\]: half a tick, the rest is for the work.
const GOOD_NS: u64 = 500_000;

/// The finding of the timer test.
pub fn check() -> Finding {
    let mut late = Lateness::default();
    let bar = progress::bar(TICKS, "timing");
    let start = Instant::now();
    for tick in 1..=TICKS {
        let due = start + Duration::from_nanos(PERIOD_NS * tick);
        thread::sleep(due.saturating_duration_since(Instant::now()));
        late.add(Instant::now().saturating_duration_since(due));
        if tick % 500 == 0 {
            bar.set_position(tick);
        }
    }
    bar.finish_and_clear();
    judge(&late)
}

fn judge(late: &Lateness) -> Finding {
    let us = |ns: u64| ns as f64 / 1.0e3;
    let share = late.share();
    let found = format!(
        "wake-up late by p50 {:.0} / p99.9 {:.0} / max {:.0} us, {:.2} % within the tick ({} s, normal priority)",
        us(late.quantile(0.5)),
        us(late.quantile(0.999)),
        us(late.max),
        100.0 * share,
        late.count * PERIOD_NS / 1_000_000_000,
    );
    if share < SHARE_FAIL {
        return Finding::bad("timer", Mark::Fail, found, "close other programs; on a virtual machine give it whole cores");
    }
    if share < SHARE_WARN || late.quantile(0.999) > GOOD_NS {
        let advice = "close other programs, use the performance governor; with real-time priority the host does better";
        return Finding::bad("timer", Mark::Warn, found, advice);
    }
    Finding::ok("timer", found)
}

/// Width of a bin \[ns\]: finer than anyone asks.
const BIN_NS: u64 = 1_000;

/// Bins: up to 10 ms; what is later is in the last one.
const BINS: usize = 10_000;

/// A histogram of lateness.
struct Lateness {
    bins: Vec<u64>,
    count: u64,
    within: u64,
    max: u64,
}

impl Default for Lateness {
    fn default() -> Self {
        Self { bins: vec![0; BINS], count: 0, within: 0, max: 0 }
    }
}

impl Lateness {
    fn add(&mut self, late: Duration) {
        let ns = u64::try_from(late.as_nanos()).unwrap_or(u64::MAX);
        let bin = (ns / BIN_NS).min(BINS as u64 - 1);
        self.bins[bin as usize] += 1;
        self.count += 1;
        self.within += u64::from(ns < PERIOD_NS);
        self.max = self.max.max(ns);
    }

    fn share(&self) -> f64 {
        self.within as f64 / self.count.max(1) as f64
    }

    /// Upper edge of the bin that holds the quantile \[ns\].
    fn quantile(&self, share: f64) -> u64 {
        let wanted = (share * self.count as f64).ceil() as u64;
        let mut seen = 0;
        let bin = self.bins.iter().position(|count| {
            seen += count;
            seen >= wanted
        });
        (bin.unwrap_or(0) as u64 + 1) * BIN_NS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lateness(parts: &[(u64, u64)]) -> Lateness {
        let mut late = Lateness::default();
        for &(count, us) in parts {
            (0..count).for_each(|_| late.add(Duration::from_micros(us)));
        }
        late
    }

    #[test]
    fn a_machine_is_judged_by_its_share_and_its_tail() {
        let table = [
            (lateness(&[(1000, 60)]), Mark::Ok),
            (lateness(&[(990, 60), (10, 800)]), Mark::Warn),
            (lateness(&[(930, 60), (70, 5000)]), Mark::Warn),
            (lateness(&[(800, 60), (200, 5000)]), Mark::Fail),
        ];
        for (late, expected) in table {
            assert_eq!(judge(&late).mark, expected, "{}", judge(&late).found);
        }
    }
}

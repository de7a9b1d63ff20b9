//! What each right of the real-time policy buys on this machine: sessions under load with all of them, without each in turn, and without any, round after round so that
//! whatever else the machine does meets every one alike.

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};

use super::session::{Trial, run};
use super::spread::Spread;
use super::{helper, load, us};
use crate::failure::Failure;
use crate::progress;

/// Ticks a second \[Hz\].
const RATE_HZ: u32 = 1000;

/// Rounds: each way of running meets the machine so many times.
const ROUNDS: u64 = 3;

/// Ways of running: name in the tables, rights left out as the host spells them. The first is what the others are compared with.
const WAYS: [(&str, &[&str]); 6] = [
    ("all", &[]),
    ("without SCHED_FIFO", &["fifo"]),
    ("without locked memory", &["lock"]),
    ("without a CPU of its own", &["pin"]),
    ("without holding off deep sleep", &["awake"]),
    ("without any", &["fifo", "lock", "pin", "awake"]),
];

/// One way of running.
#[derive(Clone, Debug)]
struct Row {
    name: &'static str,
    wake: Spread,
    ticks: [u64; 2],
}

/// All ways.
#[derive(Clone, Debug)]
pub struct Gains {
    rows: Vec<Row>,
    seconds: u64,
}

/// Runs every way for so many seconds in all.
///
/// # Errors
/// A program that is missing or fails, or an interrupt.
pub fn gains(model: &Path, work: &Path, load_on: usize, seconds: u64, stop: &AtomicBool) -> Result<Gains, Failure> {
    helper::need(&[helper::STRESS_NG])?;
    let part_s = seconds.div_ceil(ROUNDS);
    let bar = progress::bar(ROUNDS * WAYS.len() as u64, "trying rights");
    let mut rows: Vec<_> = WAYS.iter().map(|&(name, _)| Row { name, wake: Spread::EMPTY, ticks: [0; 2] }).collect();
    for _ in 0..ROUNDS {
        for (row, (_, without)) in rows.iter_mut().zip(WAYS) {
            let _load = load::start(load_on, part_s)?;
            let more: Vec<_> = without.iter().flat_map(|right| ["--without".to_owned(), (*right).to_owned()]).collect();
            let (device, serve) = (None, "pty");
            let trial =
                Trial { model, work, device, serve, rate_hz: RATE_HZ, seconds: part_s, more: &more, record: true, viewer: false };
            let (ran, ()) = run(&trial, stop, || Ok(()))?;
            row.wake.merge(&ran.wake);
            row.ticks[0] += ran.summary.ticks;
            row.ticks[1] += ran.summary.in_time;
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(Gains { rows, seconds: part_s * ROUNDS })
}

impl Row {
    fn share(&self) -> f64 {
        self.ticks[1] as f64 / self.ticks[0].max(1) as f64
    }

    /// Of p99.9 to that of another.
    fn ratio(&self, all: &Self) -> f64 {
        self.wake.quantile_ns(0.999) as f64 / all.wake.quantile_ns(0.999).max(1) as f64
    }
}

impl Gains {
    /// The table.
    pub fn table(&self) -> String {
        let mut text = format!(
            "wake-up latency [us] at {RATE_HZ} Hz with rights left out, {} s each in {ROUNDS} rounds; load: {}\n",
            self.seconds,
            load::WORDS
        );
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "{:<32}{:>10}{:>10}{:>10}{:>10}{:>10}{:>12}{:>10}",
            "", "p50", "p99", "p99.9", "p99.99", "max", "p99.9/all", "in time"
        );
        for row in &self.rows {
            let figures: String = row.wake.figures().iter().map(|&ns| format!("{:>10.1}", us(ns))).collect();
            let (name, ratio) = (row.name, row.ratio(&self.rows[0]));
            let _ = writeln!(text, "{name:<32}{figures}{ratio:>12.2}{:>8.2} %", 100.0 * row.share());
        }
        text
    }

    /// The same for programs.
    pub fn value(&self) -> Value {
        let rows = self.rows.iter().map(|row| {
            json!({ "way": row.name, "wake_up": row.wake.value(), "ratio_p99_9": row.ratio(&self.rows[0]), "in_time": row.share() })
        });
        json!({ "rate_hz": RATE_HZ, "seconds": self.seconds, "rounds": ROUNDS, "load": load::WORDS, "ways": rows.collect::<Vec<_>>() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_compared_with_all_rights() {
        let row = |name, us: u64| {
            let mut wake = Spread::default();
            wake.add(us * 1000, 100);
            Row { name, wake, ticks: [100, 95] }
        };
        let gains = Gains { rows: vec![row("all", 20), row("without any", 500)], seconds: 6 };
        let table = gains.table();
        assert!(table.contains("6 s each in 3 rounds") && table.contains("25.00   95.00 %"), "{table}");
        assert_eq!(gains.value()["ways"][1]["ratio_p99_9"], 25.0);
    }
}

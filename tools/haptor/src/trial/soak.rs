//! The soak: the host's real-time thread and cyclictest side by side on a CPU each, then swapped, so that neither has the better CPU; with nothing else to do, under
//! load, and with a viewer that wants every tick. What counts is the ratio within a condition: both met the same machine at the same time.
//!
//! Told as OSADL tells its farm (<https://www.osadl.org/Latency-plots.latency-plots.0.html>): cycles, load, the largest; quantiles beside it.

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};

use super::session::{Ran, Trial, run};
use super::spread::Spread;
use super::{SHARE_FAIL, cyclictest, helper, load, us, verdict};
use crate::failure::Failure;
use crate::plot::{self, Curve};
use crate::progress;

/// Ticks a second \[Hz\].
const RATE_HZ: u32 = 1000;

/// What happens beside the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// Nothing of ours.
    Idle,
    /// Load.
    Load,
    /// A viewer that wants everything.
    Viewer,
}

impl Condition {
    const ALL: [Self; 3] = [Self::Idle, Self::Load, Self::Viewer];

    /// Word in the tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Load => "load",
            Self::Viewer => "viewer",
        }
    }
}

/// What is soaked.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// The baked scene.
    pub model: &'a Path,
    /// A folder for what sessions write.
    pub work: &'a Path,
    /// A device as the host spells it; without one, a simulated one.
    pub device: Option<&'a str>,
    /// Length of everything \[s\].
    pub seconds: u64,
    /// The two CPUs.
    pub cpus: [usize; 2],
    /// Load runs on so many CPUs.
    pub load_on: usize,
}

/// Shortest part \[s\]: below it p99.9 is a guess.
pub const PART_MIN_S: u64 = 2;

/// One condition, both halves together.
#[derive(Clone, Debug)]
pub struct Row {
    /// Which.
    pub condition: Condition,
    /// The host's real-time thread.
    pub ours: Spread,
    /// cyclictest.
    pub theirs: Spread,
    /// Ticks, and those in time.
    ticks: [u64; 2],
    /// Every session had the rights of the real-time policy.
    real_time: bool,
}

impl Row {
    const fn new(condition: Condition) -> Self {
        Self { condition, ours: Spread::EMPTY, theirs: Spread::EMPTY, ticks: [0; 2], real_time: true }
    }

    fn take(&mut self, ran: &Ran, theirs: &Spread) {
        self.ours.merge(&ran.wake);
        self.theirs.merge(theirs);
        self.ticks[0] += ran.summary.ticks;
        self.ticks[1] += ran.summary.in_time;
        self.real_time &= ran.summary.rt.fifo;
    }

    /// Share of ticks in time.
    fn share(&self) -> f64 {
        self.ticks[1] as f64 / self.ticks[0].max(1) as f64
    }

    /// Ours to theirs at p99.99 and at the largest.
    fn ratios(&self) -> [f64; 2] {
        let ([.., a, b], [.., c, d]) = (self.ours.figures(), self.theirs.figures());
        [a as f64 / c.max(1) as f64, b as f64 / d.max(1) as f64]
    }
}

/// The whole soak.
#[derive(Clone, Debug)]
pub struct Soak {
    rows: Vec<Row>,
    part_s: u64,
    cpus: [usize; 2],
}

/// Runs it; `real_time` = cyclictest may have the class that the host's thread gets.
///
/// # Errors
/// A program that is missing or fails, or an interrupt.
pub fn soak(plan: &Plan<'_>, real_time: bool, stop: &AtomicBool) -> Result<Soak, Failure> {
    helper::need(&[helper::CYCLICTEST, helper::STRESS_NG])?;
    let parts = 2 * Condition::ALL.len() as u64;
    let part_s = (plan.seconds / parts).max(PART_MIN_S);
    let bar = progress::bar(parts, "soaking");
    let mut rows = Vec::new();
    for condition in Condition::ALL {
        let mut row = Row::new(condition);
        for [ours, theirs] in [plan.cpus, [plan.cpus[1], plan.cpus[0]]] {
            let (ran, spread) = part(plan, condition, [ours, theirs], part_s, real_time, stop)?;
            row.take(&ran, &spread);
            bar.inc(1);
        }
        rows.push(row);
    }
    bar.finish_and_clear();
    Ok(Soak { rows, part_s, cpus: plan.cpus })
}

fn part(
    plan: &Plan<'_>,
    condition: Condition,
    [ours, theirs]: [usize; 2],
    seconds: u64,
    real_time: bool,
    stop: &AtomicBool,
) -> Result<(Ran, Spread), Failure> {
    let _load = (condition == Condition::Load).then(|| load::start(plan.load_on, seconds)).transpose()?;
    let trial = Trial {
        model: plan.model,
        work: plan.work,
        device: plan.device,
        serve: "pty",
        rate_hz: RATE_HZ,
        seconds,
        more: &["--cpu".to_owned(), ours.to_string()],
        record: false,
        viewer: condition == Condition::Viewer,
    };
    run(&trial, stop, || cyclictest::run(theirs, 1_000_000 / RATE_HZ, seconds, real_time, stop))
}

impl Soak {
    /// The tables.
    pub fn table(&self) -> String {
        let mut text = String::new();
        let [a, b] = self.cpus;
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "wake-up latency [us] at {RATE_HZ} Hz on CPUs {a} and {b}, each half of the time; {} s a condition; load: {}",
            2 * self.part_s,
            load::WORDS
        );
        let _ = writeln!(
            text,
            "{:<8}{:<18}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}",
            "", "", "cycles", "p50", "p99", "p99.9", "p99.99", "max"
        );
        for row in &self.rows {
            for (who, spread) in [("haptor-host", &row.ours), ("cyclictest", &row.theirs)] {
                let figures: String = spread.figures().iter().map(|&ns| format!("{:>10.1}", us(ns))).collect();
                let _ = writeln!(text, "{:<8}{who:<18}{:>10}{figures}", row.condition.name(), spread.count());
            }
            let [tail, max] = row.ratios();
            let class = if row.real_time { "" } else { ", without the real-time class" };
            let _ = writeln!(
                text,
                "{:<8}{:<18}{:>50.2}{max:>10.2}   in time {:.3} %: {}{class}",
                row.condition.name(),
                "ratio",
                tail,
                100.0 * row.share(),
                verdict(row.share())
            );
        }
        text
    }

    /// The same for programs.
    pub fn value(&self) -> Value {
        let rows = self.rows.iter().map(|row| {
            let [tail, max] = row.ratios();
            json!({ "condition": row.condition.name(), "haptor_host": row.ours.value(), "cyclictest": row.theirs.value(),
                    "ratio_p99_99": tail, "ratio_max": max, "in_time": row.share(), "verdict": verdict(row.share()),
                    "real_time_class": row.real_time })
        });
        json!({ "rate_hz": RATE_HZ, "cpus": self.cpus, "seconds_a_condition": 2 * self.part_s, "load": load::WORDS,
                "conditions": rows.collect::<Vec<_>>() })
    }

    /// What keeps the machine from being good enough, if anything does.
    pub fn problem(&self) -> Option<String> {
        let worst = self.rows.iter().min_by(|a, b| a.share().total_cmp(&b.share()))?;
        (worst.share() < SHARE_FAIL).then(|| {
            format!(
                "{:.2} % of the ticks were in time ({}); at least 90 % must be",
                100.0 * worst.share(),
                worst.condition.name()
            )
        })
    }

    /// Draws the latencies, a panel a condition, both axes by powers of ten.
    ///
    /// # Errors
    /// When the picture cannot be drawn or written.
    pub fn draw(&self, path: &Path) -> anyhow::Result<()> {
        let power = |value: u64, unit: f64| (value.max(1) as f64 / unit).log10();
        let curve = |name, spread: &Spread| {
            let points = spread.bins().map(|(upto_ns, count)| (power(upto_ns, 1.0e3), power(count, 1.0)));
            Curve { name, points: points.collect() }
        };
        let panel = |row: &Row| {
            let label = match row.condition {
                Condition::Idle => "idle: cycles, log10",
                Condition::Load => "load: cycles, log10",
                Condition::Viewer => "viewer: cycles, log10",
            };
            (label, vec![curve("haptor-host", &row.ours), curve("cyclictest", &row.theirs)])
        };
        let panels: Vec<_> = self.rows.iter().map(panel).collect();
        plot::draw_panels_over("wake-up latency, log10 [us]", path, "Wake-up latency", &panels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(condition: Condition, in_time: u64) -> Row {
        let mut row = Row::new(condition);
        row.ours.add(30_000, 10);
        row.theirs.add(15_000, 10);
        row.ticks = [1000, in_time];
        row
    }

    #[test]
    fn the_table_has_both_and_their_ratio_and_the_worst_condition_judges() {
        let mut soak = Soak { rows: vec![row(Condition::Idle, 1000), row(Condition::Load, 930)], part_s: 5, cpus: [1, 0] };
        let table = soak.table();
        for part in
            ["10 s a condition", "idle    haptor-host", "idle    cyclictest", "2.00      2.00   in time 93.000 %: doubtful"]
        {
            assert!(table.contains(part), "{part} missing in\n{table}");
        }
        assert_eq!(soak.problem(), None);
        soak.rows[1].ticks[1] = 899;
        assert!(soak.problem().unwrap().contains("89.90 % of the ticks were in time (load)"));
        assert_eq!(soak.value()["conditions"][0]["ratio_max"], 2.0);
    }
}

//! Which rates a machine holds for a scene: short sessions with the simulated device at 1, 2, 4 and 8 kHz over each of its links, and what comes near the period
//! first.

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};

use super::session::{Ran, Trial, run};
use super::{SHARE_WARN, us, verdict};
use crate::failure::Failure;
use crate::progress;

/// The rates tried \[Hz\]; 8 kHz is the most that the host takes, the micro-frames of high-speed USB.
const RATES_HZ: [u32; 4] = [1000, 2000, 4000, 8000];

/// The links tried: the simulated device as an ordinary process behind a pseudo-terminal and a socket.
const LINKS: [&str; 2] = ["pty", "tcp:127.0.0.1:0"];

/// Share of the period that wake-up and step may take up at p99.9: the rest is the link's, and the other one's.
const HALF: f64 = 0.5;

/// Periods that a command may take to come back at the median: it leaves behind one report, is felt with the next, and told with the one after.
const TRIP_PERIODS: f64 = 2.5;

/// Times a second that the simulated device may be too late to catch up.
const STILLS_A_SECOND: f64 = 2.0;

/// One session.
#[derive(Clone, Debug)]
pub struct Row {
    link: &'static str,
    rate_hz: u32,
    seconds: u64,
    ran: Ran,
}

impl Row {
    fn period_ns(&self) -> f64 {
        1.0e9 / f64::from(self.rate_hz)
    }

    /// The rate holds: enough ticks in time, no fault, every record written.
    fn holds(&self) -> bool {
        let summary = &self.ran.summary;
        self.ran.share() >= SHARE_WARN && summary.fault.is_none() && summary.recorder_dropped == 0
    }

    /// What takes the largest part of what it may take, and how many times that.
    fn limit(&self) -> (&'static str, f64) {
        let (period_ns, ran) = (self.period_ns(), &self.ran);
        let parts = [
            ("wake-up latency of this machine", ran.wake.quantile_ns(0.999) as f64 / (HALF * period_ns)),
            ("step of the core", ran.step.quantile_ns(0.999) as f64 / (HALF * period_ns)),
            ("round trip over the link", ran.round_trip.quantile_ns(0.5) as f64 / (TRIP_PERIODS * period_ns)),
            ("simulated device, an ordinary process", ran.stood_still as f64 / (STILLS_A_SECOND * self.seconds as f64)),
            ("recorder", if ran.summary.recorder_dropped > 0 { f64::INFINITY } else { 0.0 }),
        ];
        parts.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }
}

/// All sessions.
#[derive(Clone, Debug)]
pub struct Rates {
    scene: String,
    rows: Vec<Row>,
}

/// Runs a session of so many seconds at each rate and link; `scene` names it with its tier.
///
/// # Errors
/// A program that is missing or fails, or an interrupt.
pub fn rates(scene: String, model: &Path, work: &Path, seconds: u64, stop: &AtomicBool) -> Result<Rates, Failure> {
    let bar = progress::bar((RATES_HZ.len() * LINKS.len()) as u64, "trying rates");
    let mut rows = Vec::new();
    for rate_hz in RATES_HZ {
        for serve in LINKS {
            let (device, more) = (None, &[][..]);
            let trial = Trial { model, work, device, serve, rate_hz, seconds, more, record: true, viewer: false };
            let (ran, ()) = run(&trial, stop, || Ok(()))?;
            let link = serve.split(':').next().unwrap_or(serve);
            rows.push(Row { link, rate_hz, seconds, ran });
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(Rates { scene, rows })
}

impl Rates {
    /// Highest rate of a link up to which all hold, and what limits the first that does not, or would come first.
    fn highest(&self, link: &str) -> (u32, &'static str) {
        let rows: Vec<_> = self.rows.iter().filter(|row| row.link == link).collect();
        let held = rows.iter().take_while(|row| row.holds()).count();
        let limit = rows.get(held).or(rows.last()).map_or("", |row| row.limit().0);
        (held.checked_sub(1).map_or(0, |last| rows[last].rate_hz), limit)
    }

    fn links(&self) -> impl Iterator<Item = &'static str> {
        LINKS.iter().map(|serve| serve.split(':').next().unwrap_or(serve))
    }

    /// The tables.
    pub fn table(&self) -> String {
        let seconds = self.rows.first().map_or(0, |row| row.seconds);
        let mut text = format!("{}; {seconds} s a session, simulated device, recording on; times at p99.9 [us]\n", self.scene);
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "{:<6}{:>8}{:>10}{:>10}{:>10}{:>12}{:>8}{:>10}  verdict; nearest to its limit",
            "link", "rate", "in time", "wake-up", "step", "round trip", "lost", "dropped"
        );
        for row in &self.rows {
            let Row { link, rate_hz, ran, .. } = row;
            let at = |spread: &super::spread::Spread| us(spread.quantile_ns(0.999));
            let fault = ran.summary.fault.map_or(String::new(), |fault| format!(", fault: {}", fault.name()));
            let (limit, times) = row.limit();
            let _ = writeln!(
                text,
                "{link:<6}{rate_hz:>8}{:>8.2} %{:>10.1}{:>10.1}{:>12.1}{:>8}{:>10}  {}{fault}; {limit}: {times:.2} of it",
                100.0 * ran.share(),
                at(&ran.wake),
                at(&ran.step),
                at(&ran.round_trip),
                ran.summary.lost,
                ran.summary.recorder_dropped,
                verdict(ran.share()),
            );
        }
        for link in self.links() {
            let (rate_hz, limit) = self.highest(link);
            let held = if rate_hz == 0 { "none of these rates".to_owned() } else { format!("{rate_hz} Hz") };
            let _ = writeln!(text, "{link}: this machine holds {held}; the limit is the {limit}");
        }
        text
    }

    /// The same for programs.
    pub fn value(&self) -> Value {
        let rows = self.rows.iter().map(|row| {
            let (limit, times) = row.limit();
            json!({ "link": row.link, "rate_hz": row.rate_hz, "seconds": row.seconds, "in_time": row.ran.share(), "holds": row.holds(),
                    "wake_up": row.ran.wake.value(), "step": row.ran.step.value(), "round_trip": row.ran.round_trip.value(),
                    "lost": row.ran.summary.lost, "recorder_dropped": row.ran.summary.recorder_dropped,
                    "device_stood_still": row.ran.stood_still, "fault": row.ran.summary.fault.map(haptor_wire::HostFault::name),
                    "nearest_limit": limit, "of_it": if times.is_finite() { json!(times) } else { Value::Null } })
        });
        let highest = self.links().map(|link| {
            let (rate_hz, limit) = self.highest(link);
            json!({ "link": link, "rate_hz": rate_hz, "limit": limit })
        });
        json!({ "scene": self.scene, "sessions": rows.collect::<Vec<_>>(), "highest": highest.collect::<Vec<_>>() })
    }

    /// What keeps the machine from being good enough, if anything does.
    pub fn problem(&self) -> Option<String> {
        let none = self.links().all(|link| self.highest(link).0 == 0);
        none.then(|| format!("not even {} Hz holds; run `haptor doctor`", RATES_HZ[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::spread::Spread;
    use haptor_wire::Summary;

    fn row(rate_hz: u32, in_time: u64, step_us: u64) -> Row {
        let spread = |us: u64| {
            let mut spread = Spread::default();
            spread.add(us * 1000, 100);
            spread
        };
        let summary = Summary { ticks: 1000, in_time, ..Summary::default() };
        let ran = Ran { summary, wake: spread(30), step: spread(step_us), round_trip: spread(200), stood_still: 0 };
        Row { link: "pty", rate_hz, seconds: 1, ran }
    }

    #[test]
    fn the_highest_rate_is_the_last_of_those_that_hold_and_the_next_says_why() {
        let table = [
            (vec![row(1000, 1000, 3), row(2000, 990, 200), row(4000, 100, 200)], (2000, "step of the core")),
            (vec![row(1000, 900, 3), row(2000, 990, 3)], (0, "round trip over the link")),
            (vec![row(8000, 1000, 3)], (8000, "round trip over the link")),
        ];
        for (rows, expected) in table {
            let rates = Rates { scene: "s, tier bristle".to_owned(), rows };
            assert_eq!(rates.highest("pty"), expected);
            assert_eq!(rates.problem().is_some(), expected.0 == 0);
            assert!(rates.table().contains(expected.1), "{}", rates.table());
        }
    }

    #[test]
    fn a_record_that_was_dropped_is_a_limit() {
        let mut dropped = row(1000, 1000, 3);
        dropped.ran.summary.recorder_dropped = 1;
        assert!(!dropped.holds());
        assert_eq!(dropped.limit().0, "recorder");
    }
}

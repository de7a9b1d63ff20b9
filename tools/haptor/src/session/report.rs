//! What a session comes to: the table that `demo` prints, and whether it was good.

use std::fmt::Write;

use haptor_wire::{FaultRecord, HostFault, Quantiles, Summary, TickRecord};

use super::recording::Recording;

/// Share of ticks in time below which a session is warned about (libfranka's mark).
const SHARE_WARN: f64 = 0.95;

/// Share of ticks in time below which a session has failed (libfranka's mark).
const SHARE_FAIL: f64 = 0.90;

/// A session in figures.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// The host's own, or what the recording gives when the host did not end in order.
    pub summary: Summary,
    /// The first fault that latched.
    pub fault: Option<HostFault>,
    /// When that was, if it was recorded.
    pub first: Option<FaultRecord>,
    /// Faults recorded after it.
    pub later: usize,
    /// The host ended in order and said so.
    pub complete: bool,
}

impl Figures {
    /// Figures from the host's last word, else from the recording.
    pub fn new(said: Option<Summary>, recording: &Recording) -> Self {
        let complete = said.or(recording.summary);
        let summary = complete.unwrap_or_else(|| from_ticks(&recording.ticks));
        Self {
            summary,
            fault: summary.fault.or(recording.fault()),
            first: recording.faults.first().copied(),
            later: recording.faults.len().saturating_sub(1),
            complete: complete.is_some(),
        }
    }

    /// Share of ticks in time, 0 to 1.
    pub fn share(&self) -> f64 {
        if self.summary.ticks == 0 { 0.0 } else { self.summary.in_time as f64 / self.summary.ticks as f64 }
    }

    /// Why the session was no good; `None` when it was good.
    pub fn verdict(&self) -> Option<String> {
        if let Some(fault) = self.fault {
            return Some(format!("a fault was latched: {}", fault.name()));
        }
        if !self.complete {
            return Some("the host did not end in order".to_owned());
        }
        if self.share() < SHARE_FAIL {
            let share = 100.0 * self.share();
            return Some(format!("{share:.2} % of the ticks were in time, at least 90 % must be; run `haptor doctor`"));
        }
        None
    }

    /// A good session with something to be said about it.
    pub fn warning(&self) -> Option<String> {
        let share = self.share();
        (share < SHARE_WARN)
            .then(|| format!("{:.2} % of the ticks were in time, 95 % are wanted; run `haptor doctor`", 100.0 * share))
    }

    fn ticks(&self) -> String {
        let s = &self.summary;
        if !self.complete {
            return format!("{} recorded (how many were in time is {UNKNOWN})", s.ticks);
        }
        format!("{} ({:.3} % in time, {} late)", s.ticks, 100.0 * self.share(), s.late)
    }

    /// The fault in words, when it latched and how long the wrench took to be zero.
    fn told_fault(&self) -> String {
        let (Some(fault), Some(first)) = (self.fault, self.first) else {
            return self.fault.map_or("none", HostFault::name).to_owned();
        };
        let zero = match first.after_ticks {
            0 => "at once".to_owned(),
            ticks => format!("{ticks} ticks after the last pose"),
        };
        let more = if self.later > 0 { format!("; {} more later", self.later) } else { String::new() };
        format!("{} in tick {}, wrench zero {zero}{more}", fault.name(), first.tick)
    }

    /// The table, one line per figure.
    pub fn table(&self) -> String {
        let s = &self.summary;
        let lost = format!(
            "{} lost, {} rejected, {} out of order, {} not recorded",
            s.lost, s.rejected, s.out_of_order, s.recorder_dropped
        );
        let rows = [
            ("ticks", self.ticks()),
            ("peak force", format!("{:.3} N", s.peak_force)),
            ("peak torque", format!("{:.5} N m", s.peak_torque)),
            ("step p50 / p99.9 / max", microseconds(&s.step_ns)),
            ("wake-up p50 / p99.9 / max", microseconds(&s.wake_ns)),
            ("round trip p50 / p99.9 / max", microseconds(&s.round_trip_ns)),
            ("messages", lost),
            ("real-time policy", if self.complete { policy(s) } else { UNKNOWN.to_owned() }),
            ("fault", self.told_fault()),
        ];
        rows.iter().fold(String::new(), |mut table, (name, value)| {
            // writing to a string cannot fail
            let _ = writeln!(table, "{name:<30}{value}");
            table
        })
    }
}

/// What stands where only the host could have told.
const UNKNOWN: &str = "unknown, the host did not end in order";

fn microseconds(ns: &Quantiles) -> String {
    let us = |ns: u32| f64::from(ns) / 1.0e3;
    format!("{:.1} / {:.1} / {:.1} us", us(ns.p50), us(ns.p999), us(ns.max))
}

fn policy(summary: &Summary) -> String {
    let rt = summary.rt;
    let parts = [(rt.fifo, "SCHED_FIFO"), (rt.locked, "memory locked"), (rt.pinned, "pinned"), (rt.dma_latency, "no deep sleep")];
    let had: Vec<_> = parts.iter().filter(|(had, _)| *had).map(|(_, name)| *name).collect();
    if had.is_empty() { "none granted".to_owned() } else { had.join(", ") }
}

/// What the ticks of an unfinished recording give; what they cannot give is zero.
fn from_ticks(ticks: &[TickRecord]) -> Summary {
    let count = ticks.len() as u64;
    let magnitude = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
    let felt = || ticks.iter().filter(|tick| tick.was_felt());
    Summary {
        ticks: count,
        in_time: count,
        peak_force: felt().map(|tick| magnitude(tick.contact_force)).fold(0.0, f32::max),
        peak_torque: felt().map(|tick| magnitude(tick.contact_torque)).fold(0.0, f32::max),
        step_ns: quantiles(ticks.iter().map(|tick| tick.step_ns).collect()),
        wake_ns: quantiles(ticks.iter().map(|tick| tick.wake_ns).collect()),
        round_trip_ns: quantiles(ticks.iter().map(|tick| tick.round_trip_ns).filter(|&ns| ns > 0).collect()),
        ..Summary::default()
    }
}

fn quantiles(mut values: Vec<u32>) -> Quantiles {
    values.sort_unstable();
    let at = |share: f64| {
        let index = (share * values.len() as f64).ceil() as usize;
        values.get(index.saturating_sub(1)).copied().unwrap_or(0)
    };
    Quantiles { p50: at(0.5), p99: at(0.99), p999: at(0.999), p9999: at(0.9999), max: at(1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(in_time: u64, fault: Option<HostFault>, complete: bool) -> Figures {
        let summary = Summary { ticks: 1000, in_time, ..Summary::default() };
        Figures { summary, fault, first: None, later: 0, complete }
    }

    #[test]
    fn a_session_is_good_when_in_time_and_without_fault() {
        let table = [
            (figures(1000, None, true), None, None),
            (figures(940, None, true), None, Some("95 % are wanted")),
            (figures(899, None, true), Some("90 % must be"), Some("95 % are wanted")),
            (figures(1000, Some(HostFault::LinkLost), true), Some("link lost"), None),
            (figures(1000, None, false), Some("did not end in order"), None),
        ];
        for (figures, verdict, warning) in table {
            let holds = |said: Option<String>, part: Option<&str>| match (said, part) {
                (Some(said), Some(part)) => said.contains(part),
                (said, part) => said.is_none() && part.is_none(),
            };
            assert!(holds(figures.verdict(), verdict), "{figures:?}");
            assert!(holds(figures.warning(), warning), "{figures:?}");
        }
    }

    #[test]
    fn a_fault_is_told_with_its_tick() {
        let fault = |cause, after_ticks, later| Figures {
            first: Some(FaultRecord { cause, tick: 7, after_ticks }),
            later,
            ..figures(1000, Some(cause), true)
        };
        let table = [
            (figures(1000, None, true), "none"),
            (fault(HostFault::LinkLost, 0, 0), "link lost in tick 7, wrench zero at once"),
            (fault(HostFault::Stale, 40, 2), "pose stale in tick 7, wrench zero 40 ticks after the last pose; 2 more later"),
        ];
        for (figures, told) in table {
            assert_eq!(figures.told_fault(), told);
        }
    }

    #[test]
    fn peaks_of_an_unfinished_recording_are_those_that_were_felt() {
        let tick = |force, flags| TickRecord { contact_force: [0.0, 0.0, force], flags, ..TickRecord::default() };
        let ticks = [tick(2.0, 0), tick(5.0, haptor_wire::flags::LATE), tick(40.0, haptor_wire::flags::CLOSED)];
        assert_eq!(from_ticks(&ticks).peak_force, 5.0);
    }

    #[test]
    fn quantiles_of_few_values_are_among_them() {
        let found = quantiles((1..=1000).rev().collect());
        assert_eq!((found.p50, found.p999, found.max), (500, 999, 1000));
        assert_eq!(quantiles(vec![7]).p50, 7);
        assert_eq!(quantiles(vec![]).max, 0);
    }
}

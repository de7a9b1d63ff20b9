//! The thread that tells people and programs how it goes.
//!
//! `--status frames`: frames of the tool link on standard output, as they happen, the summary last. `--status text`: a table on
//! standard output at the end. Faults are said on standard error at once, either way. A reader that goes away ends the telling,
//! not the session.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use haptor_wire::frame::{encode_stream, stream_bound};
use haptor_wire::{FaultRecord, FromHost, Quantiles, RtReport, Summary};
use rtrb::Consumer;

use crate::config::StatusFormat;
use crate::rt::budget::{Verdict, verdict};

/// Time between two looks for news: a fault is told while a hand still wonders.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Tells until the summary, or until nobody can send one any more.
pub fn run(format: StatusFormat, rate_hz: u32, mut news: Consumer<FromHost>, end: &Receiver<Summary>) {
    let mut out = Out { format, listening: true };
    loop {
        let ending = end.recv_timeout(LOOK_EVERY);
        while let Ok(message) = news.pop() {
            if let FromHost::Fault(fault) = &message {
                complain(fault);
            }
            out.frame(&message);
        }
        match ending {
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
            Ok(summary) => return out.end(&summary, rate_hz),
        }
    }
}

fn complain(fault: &FaultRecord) {
    let FaultRecord { cause, tick, after_ticks } = fault;
    // nobody may be left to hear it
    let _ = writeln!(io::stderr(), "haptor-host: fault: {} in tick {tick}; wrench zero after {after_ticks} ticks", cause.name());
}

struct Out {
    format: StatusFormat,
    listening: bool,
}

impl Out {
    fn frame(&mut self, message: &FromHost) {
        if self.format == StatusFormat::Frames {
            let mut frame = [0; stream_bound(FromHost::MAX_ENCODED)];
            // the buffer has the longest message's bound
            let length = encode_stream(message, &mut frame).unwrap_or(0);
            self.write(&frame[..length]);
        }
    }

    fn end(&mut self, summary: &Summary, rate_hz: u32) {
        match self.format {
            StatusFormat::Frames => self.frame(&FromHost::Summary(*summary)),
            StatusFormat::Text => self.write(table(summary, rate_hz).as_bytes()),
        }
    }

    fn write(&mut self, bytes: &[u8]) {
        let mut stdout = io::stdout().lock();
        self.listening = self.listening && stdout.write_all(bytes).and_then(|()| stdout.flush()).is_ok();
    }
}

/// The session as a table for people.
#[must_use]
pub fn table(summary: &Summary, rate_hz: u32) -> String {
    let s = summary;
    let share = if s.ticks == 0 { 1.0 } else { s.in_time as f64 / s.ticks as f64 };
    let judged = match verdict(share) {
        Verdict::Good => "",
        Verdict::Warn => "  (below 95 %: this machine is barely good enough)",
        Verdict::Refuse => "  (below 90 %: this machine is not good enough)",
    };
    let mut text = String::new();
    let mut row = |name: &str, value: std::fmt::Arguments<'_>| {
        // writing to a string cannot fail
        let _ = writeln!(text, "{name:<16} {value}");
    };
    row("session", format_args!("{:.3} s, {} ticks at {rate_hz} Hz", s.ticks as f64 / f64::from(rate_hz), s.ticks));
    row("in time", format_args!("{:.2} %, {} late{judged}", 100.0 * share, s.late));
    row("poses", format_args!("{} lost, {} out of order, {} frames rejected", s.lost, s.out_of_order, s.rejected));
    row("recorder", format_args!("{} dropped", s.recorder_dropped));
    row("peak contact", format_args!("{:.3} N, {:.4} N m", s.peak_force, s.peak_torque));
    row("", format_args!("{:>9} {:>9} {:>9} {:>9} {:>9}", "p50", "p99", "p99.9", "p99.99", "max"));
    for (name, figures) in [("step [us]", &s.step_ns), ("wake-up [us]", &s.wake_ns), ("round trip [us]", &s.round_trip_ns)] {
        row(name, format_args!("{}", quantiles_us(figures)));
    }
    row("real time", format_args!("{}", rights(&s.rt)));
    row("fault", format_args!("{}", s.fault.map_or("none", |fault| fault.name())));
    text
}

fn quantiles_us(q: &Quantiles) -> String {
    let us = |ns: u32| f64::from(ns) / 1000.0;
    format!("{:>9.1} {:>9.1} {:>9.1} {:>9.1} {:>9.1}", us(q.p50), us(q.p99), us(q.p999), us(q.p9999), us(q.max))
}

fn rights(rt: &RtReport) -> String {
    let say = |granted, what| format!("{what} {}", if granted { "yes" } else { "no" });
    [
        say(rt.fifo, "SCHED_FIFO"),
        say(rt.locked, "locked memory"),
        say(rt.pinned, "own CPU"),
        say(rt.dma_latency, "CPU sleep held off"),
    ]
    .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_wire::HostFault;

    #[test]
    fn the_table_says_what_matters() {
        let summary = Summary {
            ticks: 1000,
            in_time: 880,
            late: 120,
            peak_force: 7.25,
            step_ns: Quantiles { p50: 3_100, p99: 4_000, p999: 5_000, p9999: 6_000, max: 7_500 },
            rt: RtReport { fifo: true, ..RtReport::default() },
            fault: Some(HostFault::LinkLost),
            ..Summary::default()
        };
        let text = table(&summary, 1000);
        for part in [
            "1.000 s, 1000 ticks",
            "88.00 %, 120 late",
            "not good enough",
            "7.250 N",
            "3.1",
            "7.5",
            "SCHED_FIFO yes",
            "own CPU no",
            "link lost",
        ] {
            assert!(text.contains(part), "{part} missing in\n{text}");
        }
    }
}

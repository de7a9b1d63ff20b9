//! `haptor view ADDR --text`: a running host in lines of text, two a second.

use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use haptor_wire::{Refusal, Snapshot, Subscription, Summary, ToViewer, flags};

use crate::client::{Address, News, Viewer, address};
use crate::failure::{Failure, Outcome};
use crate::output::unwritten;
use crate::programs;

/// Lines a second.
const LINES_PER_S: u32 = 2;

/// How often Ctrl-C is looked for.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Follows a host until its session ends, the time is over, or Ctrl-C.
///
/// # Errors
/// [`Failure::Problem`] when there is no host, it refuses, or a fault is latched at the end; [`Failure::BadInput`] for a token that is none.
pub fn watch(host: &Address, token_file: Option<&Path>, seconds: Option<f64>) -> Outcome {
    let token = address::token(token_file)?;
    let mut viewer = Viewer::connect(host.clone(), token).map_err(|error| Failure::problem(error.to_string()))?;
    let interrupted = programs::note_interrupts()?;
    let rate_hz = viewer.connection().map_or(1000, |connection| connection.welcome().rate_hz);
    viewer.subscribe(Subscription { every: (rate_hz / LINES_PER_S).max(1), surface: 0, statistics_ms: 0 });
    let until = seconds.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let mut fault = None;
    while !interrupted.load(std::sync::atomic::Ordering::Relaxed) && until.is_none_or(|until| Instant::now() < until) {
        match viewer.next(LOOK_EVERY).map_err(|error| Failure::problem(error.to_string()))? {
            None => {}
            Some(News::Lost(why)) => print(&format!("{why}; trying again"))?,
            Some(News::Connected) => print("connected again")?,
            Some(News::Message(ToViewer::End(summary))) => return concluded(&summary),
            Some(News::Message(message)) => {
                if let ToViewer::Snapshot(snapshot) = &message {
                    fault = snapshot.fault;
                }
                told(&message).map_or(Ok(()), |line| print(&line))?;
            }
        }
    }
    fault.map_or(Ok(()), |fault| Err(Failure::problem(format!("a fault is latched: {}", fault.name()))))
}

fn concluded(summary: &Summary) -> Outcome {
    print(&format!("the session has ended after {} ticks", summary.ticks))?;
    summary.fault.map_or(Ok(()), |fault| Err(Failure::problem(format!("a fault was latched: {}", fault.name()))))
}

/// What is worth a line.
fn told(message: &ToViewer) -> Option<String> {
    match message {
        ToViewer::Snapshot(snapshot) => Some(line(snapshot)),
        ToViewer::Event(event) => Some(format!("tick {}: {}", event.tick, event.what.name())),
        ToViewer::Fault(fault) => Some(format!("tick {}: FAULT: {}", fault.tick, fault.cause.name())),
        ToViewer::Scene(scene) => Some(format!("scene {:016x}, {} bytes", scene.digest, scene.length)),
        ToViewer::Refused(Refusal { why, .. }) => Some(why.name().to_owned()),
        _ => None,
    }
}

/// A snapshot in one line.
fn line(s: &Snapshot) -> String {
    let length = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
    let regions = s.patches.iter().map(|patch| patch.region).max().map_or(0, |last| last + 1);
    let fault = s.fault.map_or(String::new(), |fault| format!("  FAULT: {}", fault.name()));
    let said: Vec<&str> =
        flags::NAMES.iter().enumerate().filter(|(i, _)| s.flags & 1 << (24 + i) != 0).map(|(_, name)| *name).collect();
    let said = if said.is_empty() { String::new() } else { format!("  ({})", said.join(", ")) };
    format!(
        "tick {:>8}  F {:7.3} N  T {:8.4} N m  depth {:6.3} mm  regions {regions}  {}  output {}  device {}  in time {:5.1} %{said}{fault}",
        s.tick,
        length(s.contact_force),
        length(s.contact_torque),
        1000.0 * s.depth,
        s.tier.name(),
        s.output.name(),
        s.mode.name(),
        f64::from(s.in_time_permille) / 10.0,
    )
}

/// One line at once; a reader that went away ends the command.
fn print(line: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}").and_then(|()| out.flush()).map_err(|error| unwritten(&error))
}

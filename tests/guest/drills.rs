//! The drills: what is done to a session in which the hand presses, and what must come of it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use haptor_host::rt::stale::{FADE_TICKS, HOLD_TICKS};
use haptor_wire::HostFault;

use crate::judge::{Seen, black_box_of, fault};
use crate::programs::{Host, Sim, said};
use crate::recording::{Recording, length};

/// When the drill begins, in ticks of the host's session, which begins with the first report in force mode: the hand has come to rest in the object.
const AT_TICK: u64 = 1_100;

/// Length of a drilled session \[s\]: the hand comes out at 2.0 s and presses anew from 2.8 s on.
const SECONDS: f64 = 3.6;

/// When what a process holds is looked at before and after the drill [s after the host's start]; connecting takes up to half a second.
const BEFORE_S: f64 = 1.0;
const AFTER_S: f64 = 2.4;

/// Memory by which a host may grow during a drill \[kB\]: the writer of the black box touches its buffers for the first time.
const GROWTH_KB: u64 = 256;

/// Ticks within which the wrench is zero after what the device or the kernel says itself: the drill falls between two reports, the message is a
/// tick on its way, and the device looks once a millisecond.
const AT_ONCE: u64 = 4;

/// Ticks within which it is zero when nothing usable comes any more: hold and fade, and the same as above.
const STALE: u64 = (HOLD_TICKS + FADE_TICKS) as u64 + 3;

/// What must come of a drill.
#[derive(Clone, Copy)]
enum Expected {
    /// One of these faults, the wrench zero within so many ticks, forces back by the rule.
    Fault(&'static [HostFault], u64),
    /// The same, and the session ends.
    End(&'static [HostFault], u64),
    /// No fault; so many reports were lost, repeated or out of order, or frames rejected.
    Nothing { bruised: bool },
}

use Expected::{End, Fault, Nothing};
use HostFault::{DeviceOverSpeed, DeviceRestarted, Garbage, LinkLost, NonFinite, Stale};

/// Name in the table, arguments of the simulated device, what must come of it.
const DRILLS: [(&str, &str, Expected); 20] = [
    ("unplugged for 0.3 s", "unplug@1.1:300ms", Fault(&[LinkLost], AT_ONCE)),
    ("device reset: off the bus for 0.3 s, firmware anew", "reboot@1.1:300ms", Fault(&[LinkLost], AT_ONCE)),
    ("firmware anew, the link stays", "restart@1.1", Fault(&[DeviceRestarted], AT_ONCE)),
    ("endpoints halted once", "halt@1.1:1ms", Fault(&[LinkLost], AT_ONCE)),
    ("endpoints halted for 50 ms", "halt@1.1:50ms", Fault(&[LinkLost], AT_ONCE)),
    ("silent both ways for 50 ms", "stall@1.1:50ms", Fault(&[Stale], STALE)),
    ("every packet dropped for 50 ms", "drop@1.1:50ms", Fault(&[Stale], STALE)),
    ("every packet dropped for 3 ms", "drop@1.1:3ms", Nothing { bruised: true }),
    ("one bit of every packet turned for 50 ms", "corrupt@1.1:50ms", Fault(&[Garbage], STALE)),
    ("one bit of every packet turned for 3 ms", "corrupt@1.1:3ms", Nothing { bruised: true }),
    ("random bytes for 50 ms", "garbage@1.1:50ms", Fault(&[Garbage], STALE)),
    ("every packet twice for 50 ms", "duplicate@1.1:50ms", Nothing { bruised: true }),
    ("every other packet overtaken for 50 ms", "reorder@1.1:50ms", Nothing { bruised: true }),
    ("every packet 3 ms late for 50 ms", "delay@1.1:50ms", Nothing { bruised: false }),
    ("position not a number for 50 ms", "nan@1.1:50ms", Fault(&[NonFinite], STALE)),
    ("the same report for 50 ms", "freeze@1.1:50ms", Fault(&[Stale], STALE)),
    ("the same pose under new numbers for 50 ms", "stuck@1.1:50ms", Fault(&[Stale], STALE)),
    ("over-speed: the handle flies off at 2 m/s", "kick@1.1", Fault(&[DeviceOverSpeed], AT_ONCE)),
    ("firmware anew in another version", "version@1.1", End(&[DeviceRestarted], AT_ONCE)),
    ("a device that renders no torque", "", Nothing { bruised: false }),
];

/// Runs all of them.
pub fn run(model: &Path) {
    for (name, drill, expected) in DRILLS {
        report(name, one(model, drill, expected));
    }
}

/// Prints a row, or what went wrong in its place.
pub fn report(name: &str, row: Result<String>) {
    match row {
        Ok(row) => println!("@drill|{name}|{row}"),
        Err(error) => println!("@failed|{name}: {error:#}"),
    }
}

/// One drill; its row: fault, detected after, zero after, recovered after.
fn one(model: &Path, drill: &str, expected: Expected) -> Result<String> {
    let torqueless = ["--script", "press", "--preset", "omega6"];
    let faulty = ["--script", "press", "--fault", drill];
    let sim = Sim::start(if drill.is_empty() { &torqueless } else { &faulty })?;
    let file = PathBuf::from("/tmp/drill.haptor");
    let mut host = Host::start(model, "usb:G1", SECONDS, &file)?;
    let lives_on = !matches!(expected, End(..));
    host.run_for(BEFORE_S)?;
    let (before, sim_before) = (host.account()?, sim.files()?);
    if lives_on {
        host.run_for(AFTER_S - BEFORE_S)?;
        let (after, sim_after) = (host.account()?, sim.files()?);
        ensure!((after.files, sim_after) == (before.files, sim_before), "files are left open: {before:?}, {after:?}");
        ensure!(after.memory_kb <= before.memory_kb + GROWTH_KB, "memory grows: {before:?}, {after:?}");
    }
    let code = host.end()?;
    let recording = Recording::read(&file)?;
    let row = judge(&recording, &file, code, expected);
    row.with_context(|| format!("{:?}, the host said {}", recording.faults, said(&file)))
}

fn judge(recording: &Recording, file: &Path, code: i32, expected: Expected) -> Result<String> {
    let (names, within, ends) = match expected {
        Nothing { bruised } => return unharmed(recording, code, bruised),
        Fault(names, within) => (names, within, false),
        End(names, within) => (names, within, true),
    };
    let seen = fault(recording, AT_TICK)?;
    ensure!(names.contains(&seen.fault.cause), "{:?} is none of {names:?}", seen.fault.cause);
    ensure!(seen.detected <= within && seen.zero <= within, "{seen:?}, {within} ticks are allowed");
    ensure!(code == 1, "the host ended with {code}");
    ensure!(ends || seen.recovered.is_some(), "forces did not come back: {seen:?}");
    if ends {
        ensure!(said(file).contains("version"), "the host does not say why it ended");
    }
    black_box_of(file, &seen.fault)?;
    Ok(row(&seen, ends))
}

fn row(seen: &Seen, ends: bool) -> String {
    let recovered = match seen.recovered {
        Some(ticks) => format!("after {:.1} s, the hand out", ticks as f64 * 1e-3),
        None if ends => "no: the session ends, the versions named".to_owned(),
        None => "no".to_owned(),
    };
    format!("{}|{}|{}|{recovered}", seen.fault.cause.name(), seen.detected, seen.zero)
}

/// No fault, forces to the end; and the counts show that something happened.
fn unharmed(recording: &Recording, code: i32, bruised: bool) -> Result<String> {
    let summary = recording.summary.context("the recording has no end")?;
    ensure!(summary.fault.is_none() && code == 0, "{:?}, ended with {code}", summary.fault);
    let held = recording.ticks.iter().filter(|tick| tick.flags & haptor_wire::flags::HELD != 0).count();
    let bruises = summary.lost + summary.out_of_order + summary.rejected;
    ensure!(!bruised || bruises > 0, "nothing happened");
    ensure!(recording.ticks.iter().any(|tick| length(tick.force) > 3.0), "the hand did not press");
    let counts =
        format!("{} lost, {} out of order, {} rejected, {held} held", summary.lost, summary.out_of_order, summary.rejected);
    Ok(format!("none: {counts}|-|-|never stopped"))
}

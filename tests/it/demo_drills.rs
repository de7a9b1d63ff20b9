//! `haptor demo` and `haptor run` when something goes wrong for real: processes killed, stopped and restarted, noise on the link.
//! Whatever happens, the wrench is zero from the fault on, the fault is named, nothing hangs, nothing is left running, and the
//! recording up to then reads.
//!
//! Time is no part of what is judged: a test waits until the recording shows what it waits for, and [`served::PATIENCE`] only ends one that
//! hangs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{MutexGuard, OnceLock};

use haptor_host::rt::flags;
use haptor_host::rt::stale::SMALL_FORCE;
use haptor_wire::recording::RecordReader;
use haptor_wire::{FaultRecord, HostFault, Record, Summary, TickRecord};

use crate::cli::{built, root};
use crate::host_rig::length;
use crate::served::{self, alone, patiently};

/// A two-second session into the folder of the test.
const DEMO: [&str; 5] = ["demo", "--seconds", "2", "-o", "."];

/// Sessions begun at most when the machine is so busy that one ends in a fault before anything was done to it.
const ATTEMPTS: u32 = 20;

/// Ticks of a drilled session that the machine alone is to blame for; the drills are in tick 1000.
const BEFORE_THE_DRILL: u64 = 990;

/// The variable that marks the processes of one test; children inherit it.
const MARK: &str = "HAPTOR_TEST_MARK";

/// Force at which the hand is taken to press \[N\].
const PRESSING: f32 = 3.0;

/// The tool, with the programs it starts built beside it.
fn tool() -> &'static Path {
    static TOOL: OnceLock<PathBuf> = OnceLock::new();
    TOOL.get_or_init(|| {
        built("haptor-host");
        built("haptor-firmware-sim");
        built("haptor")
    })
}

/// One run of the tool in a folder of its own.
struct Run {
    folder: tempfile::TempDir,
    child: Option<Child>,
    mark: String,
    _alone: MutexGuard<'static, ()>,
}

impl Run {
    fn start(args: &[&str]) -> Self {
        let tool = tool();
        let alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let mark = folder.path().display().to_string();
        let mut command = Command::new(tool);
        command.args(args).current_dir(folder.path()).env(MARK, &mark);
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        Self { folder, child: Some(child), mark, _alone: alone }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// What is recorded so far.
    fn recording(&self) -> Recording {
        Recording::read(&fs::read(self.file("session.haptor")).unwrap_or_default())
    }

    /// Waits until the recording shows it.
    fn until(&self, what: &str, done: impl Fn(&Recording) -> bool) {
        patiently(what, || done(&self.recording()));
    }

    /// Starts until one session gets as far as pressing without a fault of the machine's own.
    fn pressing(args: &[&str]) -> Self {
        for _ in 0..ATTEMPTS {
            let run = Self::start(args);
            run.until("the hand presses, or a fault", |so_far| so_far.presses() || !so_far.faults.is_empty());
            if run.recording().faults.is_empty() {
                return run;
            }
        }
        panic!("no session of {ATTEMPTS} got as far as pressing: this machine is far too busy");
    }

    /// Processes of this run.
    fn processes(&self) -> Vec<(u32, String)> {
        let wanted = format!("{MARK}={}", self.mark);
        let entries = fs::read_dir("/proc").unwrap().filter_map(Result::ok);
        let ids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
        let marked = |id: &u32| {
            let environment = fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
            environment.split(|&byte| byte == 0).any(|variable| variable == wanted.as_bytes())
        };
        let name = |id: u32| (id, fs::read_to_string(format!("/proc/{id}/comm")).unwrap_or_default().trim().to_owned());
        ids.filter(marked).map(name).collect()
    }

    /// Sends a signal to the process whose name begins so.
    fn signal(&self, name: &str, signal: &str) {
        let processes = self.processes();
        let (id, _) = processes.iter().find(|(_, comm)| comm.starts_with(name)).unwrap_or_else(|| panic!("{processes:?}"));
        served::signal(*id, signal);
    }

    /// Sends a signal to the tool itself.
    fn signal_tool(&self, signal: &str) {
        served::signal(self.child.as_ref().expect("it runs").id(), signal);
    }

    /// Waits for the tool's end, and for that of everything it started.
    fn end(&mut self) -> Output {
        let mut child = self.child.take().expect("ends once");
        patiently("the tool ends", || child.try_wait().unwrap().is_some());
        let output = child.wait_with_output().unwrap();
        patiently("nothing is left running", || self.processes().is_empty());
        output
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// A recording as far as it reads.
#[derive(Debug, Default)]
struct Recording {
    ticks: Vec<TickRecord>,
    faults: Vec<FaultRecord>,
    summary: Option<Summary>,
    damaged: usize,
}

impl Recording {
    fn read(file: &[u8]) -> Self {
        let mut all = Self::default();
        for record in RecordReader::new(&mut file.to_vec()) {
            match record {
                Ok(Record::Tick(tick)) => all.ticks.push(tick),
                Ok(Record::Fault(fault)) => all.faults.push(fault),
                Ok(Record::End(summary)) => all.summary = Some(summary),
                Ok(_) => {}
                Err(_) => all.damaged += 1,
            }
        }
        all
    }

    fn presses(&self) -> bool {
        self.ticks.last().is_some_and(|tick| length(tick.force) > PRESSING)
    }

    /// The wrench was there before the fault, zero from the fault's tick on, and came back, if at all, from next to nothing.
    fn is_zero_from_the_fault_on(&self) {
        let fault = self.faults[0];
        let at = self.ticks.iter().position(|tick| tick.tick == fault.tick).expect("the fault's tick is recorded");
        assert!(self.ticks[..at].iter().any(|tick| length(tick.force) > PRESSING), "the hand pressed before");
        let closed: Vec<_> = self.ticks[at..].iter().take_while(|tick| tick.flags & flags::CLOSED != 0).collect();
        assert!(!closed.is_empty(), "{fault:?}");
        for tick in &closed {
            assert_eq!((tick.force, tick.torque), ([0.0; 3], [0.0; 3]), "tick {}", tick.tick);
        }
        if let Some(opened) = self.ticks.get(at + closed.len()) {
            assert!(length(opened.contact_force) < SMALL_FORCE, "opened at {} N", length(opened.contact_force));
        }
        // held, then only falling
        let stale: Vec<f32> =
            self.ticks[..at].iter().rev().take_while(|t| t.flags & flags::HELD != 0).map(|t| length(t.force)).collect();
        assert!(stale.windows(2).all(|pair| pair[0] <= pair[1]), "backwards in time: {stale:?}");
    }
}

/// The tool told of a fault by one of these names, with everything written.
fn ended_with(run: &mut Run, names: &[HostFault]) -> Recording {
    let output = run.end();
    let (said, complained) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(1), "{said}{complained}");
    let recording = run.recording();
    let fault = recording.faults.first().expect("a fault is recorded").cause;
    assert!(names.contains(&fault), "{fault:?} is none of {names:?}");
    assert!(complained.contains(&format!("a fault was latched: {}", fault.name())), "{complained}");
    assert!(said.lines().any(|line| line.starts_with("fault ") && line.contains(fault.name())), "{said}");
    recording.is_zero_from_the_fault_on();
    assert_eq!(recording.damaged, 0);
    for picture in ["force.png", "torque.png"] {
        assert_eq!(fs::read(run.file(picture)).unwrap()[..8], *b"\x89PNG\r\n\x1a\n", "{picture}");
    }
    let rows = fs::read_to_string(run.file("wrench.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + recording.ticks.len(), "wrench.csv has every tick");
    let last = rows.lines().nth(1 + recording.ticks.iter().position(|t| t.tick == recording.faults[0].tick).unwrap()).unwrap();
    assert!(last.split(',').skip(13).take(6).all(|sent| sent == "0" || sent == "-0"), "{last}");
    let black_box = Recording::read(&fs::read(run.file("session.haptor.blackbox")).unwrap());
    assert_eq!((black_box.damaged, black_box.faults.as_slice()), (0, &recording.faults[..1]));
    recording
}

#[test]
fn a_killed_device_is_a_lost_link() {
    let mut run = Run::pressing(&DEMO);
    run.signal("haptor-firmware", "KILL");
    let recording = ended_with(&mut run, &[HostFault::LinkLost]);
    assert!(recording.summary.is_some());
    let (after, fault) = (recording.ticks.last().unwrap(), recording.faults[0]);
    assert!(after.tick > fault.tick && after.flags & flags::CLOSED != 0, "it stays at zero to the end");
}

#[test]
fn a_stopped_device_is_a_stale_pose() {
    let mut run = Run::pressing(&DEMO);
    run.signal("haptor-firmware", "STOP");
    run.until("the fault is named", |so_far| !so_far.faults.is_empty());
    run.signal("haptor-firmware", "CONT");
    ended_with(&mut run, &[HostFault::Stale]);
}

#[test]
fn every_drill_is_named_and_ends_at_zero() {
    let table: [(&str, &[HostFault]); 5] = [
        ("die@1", &[HostFault::LinkLost]),
        // the device's own watchdog may come first where the host was late to look
        ("stall@1:50ms", &[HostFault::Stale, HostFault::DeviceWatchdog]),
        ("garbage@1:200ms", &[HostFault::Garbage]),
        ("restart@1", &[HostFault::DeviceRestarted]),
        ("kick@1", &[HostFault::DeviceOverSpeed]),
    ];
    for (drill, names) in table {
        ended_with(&mut drilled(drill), names);
    }
}

/// A session with a drill, over but for its verdict, in which nothing else came first.
fn drilled(drill: &str) -> Run {
    for _ in 0..ATTEMPTS {
        let run = Run::start(&[&DEMO[..], &["--drill", drill]].concat());
        run.until("the session is over", |so_far| so_far.summary.is_some());
        if run.recording().faults.first().is_none_or(|fault| fault.tick > BEFORE_THE_DRILL) {
            return run;
        }
    }
    panic!("no session of {ATTEMPTS} got as far as its drill: this machine is far too busy");
}

#[test]
fn a_killed_host_leaves_a_recording_that_reads_up_to_then() {
    let mut run = Run::pressing(&DEMO);
    run.signal("haptor-host", "KILL");
    let output = run.end();
    let complained = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(complained.contains("haptor-host ended without a summary"), "{complained}");
    let recording = run.recording();
    assert!(recording.damaged <= 1 && recording.ticks.iter().any(|tick| length(tick.force) > PRESSING));
    let rows = fs::read_to_string(run.file("wrench.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + recording.ticks.len());
}

#[test]
fn when_the_tool_is_killed_host_and_device_end_too() {
    let scene = root().join("tests/scenes/cube-twist.toml");
    let scene = scene.to_str().unwrap();
    let demo = ["demo", "--seconds", "600", "-o", "."];
    let run = ["run", scene, "--device", "sim", "--rt", "ignore", "--record", "session.haptor"];
    for args in [&demo[..], &run] {
        let mut run = Run::pressing(args);
        assert_eq!(run.processes().len(), 3, "{:?}", run.processes());
        run.child.as_mut().unwrap().kill().unwrap();
        let output = run.end();
        assert_eq!(output.status.code(), None, "killed");
        let recording = run.recording();
        assert_eq!((recording.damaged, recording.summary.is_some()), (0, true), "the host ended in order");
    }
}

#[test]
fn ctrl_c_ends_a_session_in_order_with_what_there_is() {
    let mut run = Run::pressing(&["demo", "--seconds", "600", "-o", "."]);
    run.signal_tool("INT");
    let output = run.end();
    let complained = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(complained.contains("interrupted; the results are those up to then"), "{complained}");
    assert!(run.recording().summary.is_some());
    assert!(run.file("force.png").is_file());
}

#[test]
fn a_drill_that_is_none_or_comes_too_late_is_refused_before_anything_is_written() {
    for (drill, part) in
        [("flood@1", "garbage, stall, die, restart, kick"), ("die@1:50ms", "takes no length"), ("die@2", "the session lasts 2 s")]
    {
        let mut run = Run::start(&[&DEMO[..], &["--drill", drill]].concat());
        let output = run.end();
        let complained = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{complained}");
        assert!(complained.contains(part), "{complained}");
        assert_eq!(fs::read_dir(run.folder.path()).unwrap().count(), 0);
    }
}

//! In the steady loop the real-time thread asks the system for nothing but its clock and its link: no lock, no memory, no file, no text. Seen from outside, by
//! strace on the released way of starting the programs, with a viewer looking on and a recording being made; and by the kernel's own counts of that thread, page
//! faults and times it gave its CPU away.
//!
//! USB has the same proof in a guest with a USB bus of its own: `cargo xtask guest --latency`.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;

use haptor_wire::{FromViewer, RestBegin, RestPoints, ToViewer};

use crate::cli::built;
use crate::served::{alone, host_command, model, patiently, signal};
use crate::viewer::TestViewer;

/// The thread that the promise is about, and one about which nothing is promised.
const REAL_TIME: &str = "real-time";
const RECORDER: &str = "recorder";

/// System calls of the clock and of a link that is a descriptor; the last is how the kernel goes on with one of them after a tracer has attached.
const CLOCK: &str = "clock_nanosleep";
const LINK: [&str; 3] = ["ppoll", "read", "write"];
const RESUMED: &str = "restart_syscall";

/// Ticks before anything is looked at: handshake, first contact, first surface for the viewer.
const SETTLED: u64 = 1_500;

/// Ticks looked at.
const LOOKED_AT: u64 = 1_000;

/// Lines of strace looked at: some five hundred ticks, however many a traced thread on a busy machine sleeps through.
const CALLS: usize = 2_000;

/// Times a tick that the thread may give its CPU away: it sleeps until the tick is due, and waits for a pose.
const SLEEPS_A_TICK: u64 = 2;

/// A session with everything on.
struct Session {
    device: Child,
    host: Child,
    viewer: TestViewer,
    folder: tempfile::TempDir,
}

impl Session {
    fn start(serve: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut device = Command::new(built("haptor-firmware-sim"))
            .args(["--serve", serve, "--watchdog-ms", "2000"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let place = first_after("serving ", device.stdout.take().unwrap());
        let (kind, at) = place.split_once(' ').unwrap();
        let address = if kind == "pty" { format!("serial:{at}") } else { format!("{kind}:{at}") };
        // patient: a traced thread is late, and what is looked at is the loop and not a fault
        let record = folder.path().join("session.haptor");
        let args = ["--hold", "100", "--fade", "100", "--viewer", "127.0.0.1:0", "--record", record.to_str().unwrap()];
        let mut command = host_command(&model(folder.path()), &address, &args);
        let mut host = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let entrance = first_after("viewers come in at ", host.stderr.take().unwrap());
        let viewer = TestViewer::connect(&entrance.parse().unwrap()).enter();
        Self { device, host, viewer, folder }
    }

    /// The viewer wants to see every tick, and the surface with it.
    fn look_at_everything(&mut self) {
        self.viewer.say(&FromViewer::RestBegin(RestBegin { count: 100 }));
        let points = (0..100).map(|k| [0.0, 0.0, 1.0e-3 * k as f32]).collect();
        self.viewer.say(&FromViewer::RestPoints(RestPoints { offset: 0, points }));
        self.viewer.subscribe(1, 1, 10);
    }

    /// A tick that has been: the newest that the viewer has heard of.
    fn tick(&mut self) -> u64 {
        self.viewer.heard.clear();
        self.viewer.wait_for("a snapshot", |message| match message {
            ToViewer::Snapshot(snapshot) => Some(snapshot.tick),
            _ => None,
        })
    }

    fn until_tick(&mut self, tick: u64) {
        while self.tick() < tick {}
    }

    /// Folder of the kernel's files on a thread of the host.
    fn thread(&self, name: &str) -> PathBuf {
        let tasks = fs::read_dir(format!("/proc/{}/task", self.host.id())).unwrap();
        let named = |task: &PathBuf| fs::read_to_string(task.join("comm")).is_ok_and(|comm| comm.trim() == name);
        tasks.flatten().map(|task| task.path()).find(named).unwrap_or_else(|| panic!("no thread {name}"))
    }

    /// Some thousand system calls of a thread, as strace prints them, descriptors with what they lead to.
    fn trace(&mut self, name: &str) -> String {
        let task = self.thread(name);
        let out = self.folder.path().join(name);
        let mut strace = Command::new("strace")
            .args(["-y", "-v", "-s", "0", "-p", task.file_name().unwrap().to_str().unwrap(), "-o"])
            .arg(&out)
            .stderr(Stdio::null())
            .spawn()
            .expect("strace can be started (Debian's package strace)");
        patiently("strace has seen enough", || {
            self.tick();
            fs::read_to_string(&out).is_ok_and(|lines| lines.lines().count() > CALLS)
        });
        signal(strace.id(), "INT");
        patiently("strace lets go", || strace.try_wait().unwrap().is_some());
        fs::read_to_string(out).unwrap()
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        for child in [&mut self.host, &mut self.device] {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// What follows `mark` in the first line that begins or goes on so; the rest is read and dropped.
fn first_after(mark: &'static str, pipe: impl std::io::Read + Send + 'static) -> String {
    let mut lines = BufReader::new(pipe).lines().map_while(Result::ok);
    let found = lines.by_ref().find_map(|line| line.split_once(mark).map(|(_, rest)| rest.trim().to_owned()));
    thread::spawn(move || lines.for_each(drop));
    found.unwrap_or_else(|| panic!("a program ended without saying `{mark}`"))
}

/// Calls by name: how many, and what they were asked of (the first argument).
fn calls(trace: &str) -> BTreeMap<&str, (u64, Vec<&str>)> {
    let mut calls = BTreeMap::<&str, (u64, Vec<&str>)>::new();
    for line in trace.lines() {
        let Some((name, rest)) = line.split_once('(').filter(|(name, _)| !name.contains(' ')) else { continue };
        let of = rest.split([',', ')']).next().unwrap_or(rest);
        let (count, asked) = calls.entry(name).or_default();
        *count += 1;
        if !asked.contains(&of) {
            asked.push(of);
        }
    }
    calls
}

/// Minor and major page faults of a thread (proc(5), fields 10 and 12 of `stat`; the second is the name in brackets).
fn page_faults(task: &Path) -> [u64; 2] {
    let stat = fs::read_to_string(task.join("stat")).unwrap();
    let fields: Vec<_> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    [fields[10 - 3], fields[12 - 3]].map(|field| field.parse().unwrap())
}

/// Times a thread has given its CPU away by itself.
fn gave_way(task: &Path) -> u64 {
    let status = fs::read_to_string(task.join("status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("voluntary_ctxt_switches:")).unwrap();
    line.trim().parse().unwrap()
}

/// One session on one kind of link.
fn is_steady(serve: &str) {
    let mut session = Session::start(serve);
    session.look_at_everything();
    session.until_tick(SETTLED);
    let task = session.thread(REAL_TIME);

    // a snapshot before and one after: no more ticks than between them can have been counted
    let first = session.tick();
    let (faults, switches) = (page_faults(&task), gave_way(&task));
    session.until_tick(first + LOOKED_AT);
    let (faults_then, switches_then) = (page_faults(&task), gave_way(&task));
    let ticks = session.tick() - first;
    assert_eq!(faults_then, faults, "{serve}: page faults, minor and major, in {ticks} ticks");
    let switches = switches_then - switches;
    assert!((1..=SLEEPS_A_TICK * ticks).contains(&switches), "{serve}: {switches} in {ticks} ticks");

    let trace = session.trace(REAL_TIME);
    let calls = calls(&trace);
    let strangers: Vec<_> = calls.keys().filter(|name| !(LINK.contains(name) || [CLOCK, RESUMED].contains(name))).collect();
    assert!(strangers.is_empty(), "{serve}: {strangers:?} in\n{calls:?}");
    assert!([CLOCK, "write"].iter().all(|name| calls[name].0 as usize > CALLS / 10), "{serve}: {calls:?}");
    // no other file, and not standard error: one descriptor, read and written
    let link = if serve == "pty" { "</dev/pts/" } else { "<socket:" };
    let (read, written) = (&calls["read"].1, &calls["write"].1);
    assert!(read == written && read.len() == 1 && read[0].contains(link), "{serve}: {calls:?}");
    assert!(calls["ppoll"].1.iter().all(|of| of.contains(read[0])), "{serve}: {calls:?}");
}

#[test]
fn the_steady_loop_asks_for_clock_and_link_alone() {
    let _alone = alone();
    for serve in ["pty", "tcp:127.0.0.1:0"] {
        is_steady(serve);
    }
}

/// The same look at a thread that writes files and waits for its queues sees that: what the test above does not find is not there.
#[test]
fn a_thread_that_does_more_is_seen_to() {
    let _alone = alone();
    let mut session = Session::start("pty");
    session.look_at_everything();
    session.until_tick(SETTLED);
    let trace = session.trace(RECORDER);
    let calls = calls(&trace);
    assert!(calls.contains_key("futex"), "{calls:?}");
    assert!(calls["write"].1.iter().any(|of| of.contains("session.haptor")), "{calls:?}");
}

//! The host's real-time thread beside cyclictest in the guest, and the system calls of that thread on USB.
//!
//! Time here is a count of instructions: a latency says what the kernel and the programs run between a timer's end and the thread, not how long a machine takes for it.
//! What is proven is logic: the thread has the class that goes before a hog of ordinary class on the same, only CPU; it wakes by the same path as cyclictest's; it asks
//! the system for nothing but clock and link.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use haptor_wire::Quantiles;

use crate::programs::{Host, Sim, task};
use crate::recording::Recording;
use crate::spread::Spread;

/// Latencies that cyclictest tells apart \[us\].
const BINS: u32 = 5_000;

/// Priority of the host's real-time thread.
const PRIORITY: u32 = 80;

/// System calls of the clock and of libusb's link; the last is how the kernel goes on with one of them after a tracer has attached.
const ALLOWED: [&str; 7] = ["clock_nanosleep", "ioctl", "poll", "ppoll", "read", "write", "restart_syscall"];

/// Calls looked at, and time given to see them.
const CALLS: usize = 2_000;
const PATIENCE_S: u32 = 60;

/// When cyclictest begins: until then the host's thread locks memory and shakes hands, for tens of milliseconds.
const SETTLED_S: f64 = 1.0;

/// How much longer the session lasts than cyclictest \[s\].
const LONGER_S: f64 = 2.0 + SETTLED_S;

/// Runs all of it.
pub fn run(model: &Path, seconds: f64) {
    for (condition, hog) in [("nothing else", false), ("a hog of ordinary class", true)] {
        if let Err(error) = beside(model, condition, hog, seconds) {
            println!("@failed|latency, {condition}: {error:#}");
        }
    }
    if let Err(error) = calls(model) {
        println!("@failed|system calls on USB: {error:#}");
    }
}

/// A child that is killed with its value.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Both on the one CPU of the guest, under the same priority.
fn beside(model: &Path, condition: &str, hog: bool, seconds: f64) -> Result<()> {
    let _sim = Sim::start(&["--script", "press-twist-slide"])?;
    let file = PathBuf::from("/tmp/latency.haptor");
    // by the clock: paced by the device a tick begins with a report and there is no wake-up to compare
    let mut host = Host::start(model, "usb:G1 --pace clock", seconds + LONGER_S, &file)?;
    host.run_for(SETTLED_S)?;
    let hog = hog.then(|| Command::new("/bin/sh").args(["-c", "while :; do :; done"]).spawn()).transpose()?.map(Killed);
    let (priority, bins, duration) = (PRIORITY.to_string(), BINS.to_string(), (seconds.ceil() as u64).to_string());
    let args = ["-q", "-t1", "-m", "-i", "1000", "-p", &priority, "-h", &bins, "-D", &duration];
    let said = Command::new("/bin/cyclictest").args(args).output()?;
    drop(hog);
    let code = host.end()?;
    let theirs = Spread::of_cyclictest(&String::from_utf8_lossy(&said.stdout));
    ensure!(theirs.count() > 0, "cyclictest: {}", String::from_utf8_lossy(&said.stderr));
    let summary = Recording::read(&file)?.summary.context("the recording has no end")?;
    let Quantiles { p50, p99, p999, p9999, max } = summary.wake_ns;
    tell(condition, "haptor-host", summary.ticks, [p50, p99, p999, p9999, max].map(u64::from));
    tell(condition, "cyclictest", theirs.count(), theirs.figures());
    ensure!(code == 0 && summary.rt.fifo, "ended with {code}, {:?}, {:?}", summary.fault, summary.rt);
    Ok(())
}

fn tell(condition: &str, who: &str, cycles: u64, figures_ns: [u64; 5]) {
    let figures = figures_ns.map(|ns| format!("{:.1}", ns as f64 * 1e-3)).join("|");
    println!("@latency|{condition}|{who}|{cycles}|{figures}");
}

/// System calls of the real-time thread in a session on USB, by strace.
fn calls(model: &Path) -> Result<()> {
    let _sim = Sim::start(&["--script", "press-twist-slide"])?;
    let file = PathBuf::from("/tmp/traced.haptor");
    let mut host = Host::start(model, "usb:G1 --hold 100 --fade 100", f64::from(PATIENCE_S), &file)?;
    host.run_for(1.0)?;
    let task = task(host.id(), "real-time")?;
    let out = PathBuf::from("/tmp/calls");
    let id = task.file_name().context("a thread's number")?.to_string_lossy().into_owned();
    let mut strace = Command::new("/bin/strace");
    strace.args(["-s", "0", "-p", &id, "-o"]).arg(&out).stderr(Stdio::null());
    let strace = Killed(strace.spawn()?);
    let mut seen = String::new();
    for _ in 0..10 * PATIENCE_S {
        seen = fs::read_to_string(&out).unwrap_or_default();
        if seen.lines().count() > CALLS {
            break;
        }
        thread::sleep(Duration::from_millis(100));
    }
    drop(strace);
    host.kill()?;
    let mut calls = BTreeMap::<&str, u64>::new();
    for (name, _) in seen.lines().filter_map(|line| line.split_once('(')) {
        *calls.entry(name).or_default() += 1;
    }
    let told: Vec<_> = calls.iter().map(|(name, count)| format!("{name} {count}")).collect();
    println!("@calls|{}", told.join(", "));
    match calls.keys().find(|name| !ALLOWED.contains(name)) {
        Some(stranger) => bail!("{stranger} is none of clock and link"),
        None if seen.lines().count() > CALLS => Ok(()),
        None => bail!("only {} calls were seen", seen.lines().count()),
    }
}

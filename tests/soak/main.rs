//! A soak: the real host and the simulated device in real time over a cable that drops, damages, repeats, delays and stands still, and a
//! device that restarts, all by a seed; at the end the books of both must add up to the frame.
//!
//! ```text
//!  haptor-host ── pty ── relay with a ledger ── pty ── haptor-firmware-sim
//! ```
//! `cargo run --release -p haptor-tests --bin soak -- --minutes 60 --seed 1`. Exit 0 when every row adds up and nothing grew, 1 when not, 2 when it
//! could not be run. How many ticks were in time is told and not judged.
#![forbid(unsafe_code)]

#[path = "../support/ball.rs"]
mod ball;
mod books;
mod programs;
mod relay;
mod watch;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use programs::Programs;
use relay::Relay;
use watch::Watch;

/// Anything that keeps a soak from being run.
type Failure = Box<dyn std::error::Error>;

/// Between two looks at the processes.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// How long the line must be silent for everything on it to have been read [turns of the relay, 1 ms]: a second and a half, more than the second
/// after which a device without a host falls silent.
const SILENT_TURNS: u32 = 1_500;

/// Turns in which that must come about: a minute, for a machine however busy.
const PATIENT_TURNS: u32 = 60_000;

fn main() -> ExitCode {
    let Some((minutes, seed)) = arguments(&std::env::args().skip(1).collect::<Vec<_>>()) else {
        eprintln!("usage: soak --minutes N --seed S   (N above 0.5)");
        return ExitCode::from(2);
    };
    match soak(minutes, seed) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("soak: {error}");
            ExitCode::from(2)
        }
    }
}

fn arguments(words: &[String]) -> Option<(f64, u64)> {
    let [m, minutes, s, seed] = words else { return None };
    let minutes = minutes.parse().ok().filter(|minutes: &f64| (0.5..=100_000.0).contains(minutes))?;
    (m == "--minutes" && s == "--seed").then_some((minutes, seed.parse().ok()?))
}

/// Runs it; true when everything adds up.
fn soak(minutes: f64, seed: u64) -> Result<bool, Failure> {
    let length = Duration::from_secs_f64(60.0 * minutes);
    let (mut programs, device_path) = Programs::device(seed, length)?;
    let mut relay = Relay::new(&device_path, seed)?;
    programs.start_host(relay.host_path())?;
    let mut watches = [Watch::new("haptor-host", programs.host_id()?), Watch::new("haptor-firmware-sim", programs.device_id())];
    run(&mut relay, &mut programs, &mut watches, length)?;
    let host = wind_up(&mut relay, &mut programs)?;
    let device = programs.end_device()?;
    let rows = books::rows(&relay, &host, &device);
    Ok(books::print(&rows, &watches.map(|watch| watch.verdict()), &host, &device, &relay, programs.restarts))
}

/// The time of faults.
fn run(relay: &mut Relay, programs: &mut Programs, watches: &mut [Watch], length: Duration) -> Result<(), Failure> {
    let begin = Instant::now();
    let mut look = LOOK_EVERY;
    while begin.elapsed() < length {
        relay.turn()?;
        if begin.elapsed() >= look {
            look += LOOK_EVERY;
            programs.both_run()?;
            watches.iter_mut().for_each(|watch| watch.look(begin.elapsed().as_secs_f64()));
        }
    }
    Ok(())
}

/// Ends the faults, lets everything that is on the way arrive, ends the host; its summary. Nothing goes to the host after it has read its
/// last, and the host says good-bye to the device.
fn wind_up(relay: &mut Relay, programs: &mut Programs) -> Result<haptor_wire::Summary, Failure> {
    relay.mischief = false;
    relay.release();
    relay.silent = true;
    until_silent(relay, |relay, _| Ok(relay.unread_by_host()? == 0))?;
    programs.stop_host()?;
    until_silent(relay, |_, came| Ok(came == 0))?;
    programs.host_summary()
}

/// Turns until something has been so for long enough.
fn until_silent(relay: &mut Relay, is_so: impl Fn(&Relay, u64) -> Result<bool, Failure>) -> Result<(), Failure> {
    let mut silent = 0;
    for _ in 0..PATIENT_TURNS {
        let begin = Instant::now();
        let came = relay.turn()?;
        silent = if is_so(relay, came)? { silent + 1 } else { 0 };
        if silent >= SILENT_TURNS {
            return Ok(());
        }
        std::thread::sleep(Duration::from_millis(1).saturating_sub(begin.elapsed()));
    }
    Err("the line never came to rest".into())
}

//! One session of the host for a trial, with whatever shall happen beside it.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;
use haptor_wire::{FromHost, Subscription, Summary, viewer::NO_TOKEN};

use super::interrupted;
use super::spread::Spread;
use crate::client::{Address, Viewer};
use crate::failure::Failure;
use crate::output::unwritten;
use crate::session::device::SimulatedDevice;
use crate::session::host::{Host, Plan};

/// How often an interrupt is looked for.
const LOOK: Duration = Duration::from_millis(20);

/// How much longer than asked a host may take: start-up, handshake, its end, on a machine under load.
const LONGER: Duration = Duration::from_secs(30);

/// How much longer the simulated device serves \[s\]: the host must be the one that ends the session.
const DEVICE_LONGER: f64 = 60.0;

/// Milliseconds without an answer until the simulated device brakes. Trials ask about times: a device that is an ordinary process must not end them.
const WATCHDOG_MS: u32 = 500;

/// Hold and fade \[ticks at 1 kHz\], for the same reason the longest.
const PATIENCE: (u32, u32) = (100, 100);

/// Points of the surface that a viewer of a trial wants to see, as many as a window does.
const WATCHED: u16 = 1_000;

/// The motion of the simulated hand.
const SCRIPT: &str = "press-twist-slide";

/// What is tried.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// The baked scene.
    pub model: &'a Path,
    /// A folder for what the session writes.
    pub work: &'a Path,
    /// A device as the host spells it; without one, a simulated one serves at `serve`.
    pub device: Option<&'a str>,
    /// Where the simulated device serves: `pty`, `tcp:ADDRESS`.
    pub serve: &'a str,
    /// Ticks a second \[Hz\].
    pub rate_hz: u32,
    /// Length \[s\].
    pub seconds: u64,
    /// Further arguments of the host.
    pub more: &'a [String],
    /// Make a recording.
    pub record: bool,
    /// Somebody looks on, at everything.
    pub viewer: bool,
}

/// How it went.
#[derive(Clone, Debug)]
pub struct Ran {
    /// The host's own words.
    pub summary: Summary,
    /// Wake-up latency.
    pub wake: Spread,
    /// Time of a step of the core.
    pub step: Spread,
    /// From a command to its echo.
    pub round_trip: Spread,
    /// Times that the simulated device was too late to catch up, when one was used.
    pub stood_still: u64,
}

impl Ran {
    fn new(summary: Summary, times: &str, stood_still: u64) -> Self {
        let of = |what| Spread::of_times(times, what);
        Self { summary, wake: of("wake_up"), step: of("step"), round_trip: of("round_trip"), stood_still }
    }

    /// Share of ticks in time.
    pub fn share(&self) -> f64 {
        self.summary.in_time as f64 / self.summary.ticks.max(1) as f64
    }
}

/// Runs a session, and `beside` it from when the device renders; both are over when this returns.
///
/// # Errors
/// Whatever kept it from running to its end; what `beside` fails with.
pub fn run<T>(trial: &Trial<'_>, stop: &AtomicBool, beside: impl FnOnce() -> Result<T, Failure>) -> Result<(Ran, T), Failure> {
    let (times, record, view) = (trial.work.join("times.csv"), trial.work.join("trial.haptor"), trial.work.join("view"));
    let simulated = simulated(trial)?;
    let address = simulated.as_ref().map_or(trial.device.unwrap_or_default(), |device| &device.address);
    let viewers = format!("unix:{}", view.display());
    let more = [&["--times".to_owned(), times.display().to_string()], trial.more].concat();
    let mut host = Host::start(&Plan {
        model: trial.model,
        device: address,
        rate_hz: trial.rate_hz,
        seconds: trial.seconds as f64,
        record: trial.record.then_some(record.as_path()),
        viewers: trial.viewer.then_some(&viewers),
        hold_fade: PATIENCE,
        more: &more,
    })?;
    await_hello(&mut host, stop)?;
    let over = AtomicBool::new(false);
    let (result, summary) = thread::scope(|scope| {
        if trial.viewer {
            scope.spawn(|| look_on(&viewers, &over));
        }
        let result = beside();
        let summary = result.is_ok().then(|| await_summary(&mut host, trial, stop));
        over.store(true, Ordering::Relaxed);
        (result, summary)
    });
    let result = result?;
    let summary = summary.context("the host was not listened to")??;
    // the file of times is written last
    host.child.wait(LONGER);
    let table = fs::read_to_string(&times).map_err(|error| unwritten(&error))?;
    // a recording of a trial is made to be made
    let _ = fs::remove_file(&record);
    let stood_still = simulated.map_or(0, SimulatedDevice::stood_still);
    Ok((Ran::new(summary, &table, stood_still), result))
}

fn simulated(trial: &Trial<'_>) -> Result<Option<SimulatedDevice>, Failure> {
    if trial.device.is_some() {
        return Ok(None);
    }
    let watchdog = ["--watchdog-ms".to_owned(), WATCHDOG_MS.to_string()];
    let seconds = trial.seconds as f64 + DEVICE_LONGER;
    SimulatedDevice::serve(trial.serve, crate::config::PRESET, SCRIPT, seconds, &watchdog).map(Some)
}

fn await_hello(host: &mut Host, stop: &AtomicBool) -> Result<(), Failure> {
    let is_hello = |message: &FromHost| matches!(message, FromHost::Hello(_)).then_some(());
    await_message(host, Instant::now() + LONGER, stop, is_hello)
}

fn await_summary(host: &mut Host, trial: &Trial<'_>, stop: &AtomicBool) -> Result<Summary, Failure> {
    let until = Instant::now() + Duration::from_secs(trial.seconds) + LONGER;
    await_message(host, until, stop, |message| match message {
        FromHost::Summary(summary) => Some(*summary),
        _ => None,
    })
}

fn await_message<T>(
    host: &mut Host,
    until: Instant,
    stop: &AtomicBool,
    pick: impl Fn(&FromHost) -> Option<T>,
) -> Result<T, Failure> {
    loop {
        if stop.load(Ordering::Relaxed) {
            host.child.release();
            return Err(interrupted());
        }
        match host.messages.recv_timeout(LOOK) {
            Ok(message) => {
                if let Some(found) = pick(&message) {
                    return Ok(found);
                }
            }
            Err(RecvTimeoutError::Timeout) if Instant::now() < until => {}
            Err(why) => {
                // its last words come with its end
                host.child.wait(LOOK);
                let how = if why == RecvTimeoutError::Timeout { "hangs" } else { "ended before its session" };
                return Err(Failure::problem(format!("haptor-host {how}{}", host.child.last_words())));
            }
        }
    }
}

/// Looks at every tick and the surface, as fast as it comes; what comes is dropped.
fn look_on(address: &str, over: &AtomicBool) {
    let Some(mut viewer) = address.parse::<Address>().ok().and_then(|address| Viewer::connect(address, NO_TOKEN).ok()) else {
        return;
    };
    let points = (0..WATCHED).map(|k| [0.0, 0.0, 1.0e-4 * f32::from(k)]).collect();
    // a host that takes no points still shows ticks
    let _ = viewer.watch_points(points);
    viewer.subscribe(Subscription { every: 1, surface: 1, statistics_ms: 100 });
    while !over.load(Ordering::Relaxed) && viewer.next(LOOK).is_ok() {}
}

//! A run: its threads, the queues between them, and how they end.
//!
//! ```text
//!  signals, stdin ──stop─► real-time thread ──records, black boxes──► recorder thread ──► files
//!                             ▲        │    └──news──────────────────► status thread ──► stdout, stderr
//!                             ├─ links ─┴── dead links ──► reopening thread
//!                             └─ looks, orders ──► viewers' thread ──► sockets    ([`crate::viewer`], when asked for)
//! ```
//! The real-time thread ends first: by its ticks, by a signal, with standard input if told so, or because the device speaks another version. Its summary ends the others.

use std::fs;
use std::io::{Read, Write, stderr, stdin};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, Scope, ScopedJoinHandle};

use haptor_wire::{Summary, VersionMismatch};

use crate::config::{Config, StatusFormat};
use crate::error::HostError;
use crate::link::{AnyLink, open};
use crate::recorder::origin::Origin;
use crate::recorder::{Recorder, Sources, Written};
use crate::rt::account::Account;
use crate::rt::blackbox::black_box;
use crate::rt::budget::{Verdict, verdict};
use crate::rt::clock::Monotonic;
use crate::rt::control::Control;
use crate::rt::desk::Desk;
use crate::rt::line::{Exchange, Line, exchange};
use crate::rt::parts::Settings;
use crate::rt::policy;
use crate::viewer::entrance::Entrance;
use crate::viewer::figures::SharedFigures;
use crate::{reopen, status, viewer, work};
use haptor_engine::{Scene, SceneError};

/// How a run went.
#[derive(Debug)]
pub struct Outcome {
    /// In figures.
    pub summary: Summary,
    /// The versions, when the device speaks another.
    pub mismatch: Option<VersionMismatch>,
    /// What became of the files.
    pub written: Written,
}

impl Outcome {
    /// True when no fault was latched, enough ticks were in time, and the files are whole.
    #[must_use]
    pub fn is_good(&self) -> bool {
        let share = if self.summary.ticks == 0 { 0.0 } else { self.summary.in_time as f64 / self.summary.ticks as f64 };
        self.summary.fault.is_none() && self.written.error.is_none() && verdict(share) != Verdict::Refuse
    }
}

/// What the real-time thread leaves.
struct Ran {
    summary: Summary,
    mismatch: Option<VersionMismatch>,
    /// Every duration, when asked for.
    times: Option<String>,
}

/// Runs a session to its end.
///
/// # Errors
/// [`HostError`] when it could not begin: bad scene, no device, no rights under `--rt enforce`, no file.
pub fn run(config: &Config) -> Result<Outcome, HostError> {
    let (scene, file) = read_scene(config)?;
    let link = open(&config.device)?;
    let guests = Entrance::open(config)?;
    let stop = stop_on_signals()?;
    if config.until_stdin_closes {
        stop_with_stdin(Arc::clone(&stop))?;
    }
    thread::scope(|scope| supervise(scope, config, &scene, link, Origin::new(config.rate_hz, file), guests, &stop))
}

fn read_scene(config: &Config) -> Result<(Scene, Arc<[u8]>), HostError> {
    let path = &config.model;
    let bytes = fs::read(path).map_err(|reason| HostError::File { doing: "read the baked scene", path: path.clone(), reason })?;
    let bad = |reason: SceneError| HostError::Scene { path: path.clone(), reason };
    Ok((Scene::read(&bytes).map_err(bad)?, bytes.into()))
}

/// A flag that Ctrl-C, SIGTERM or a closed terminal sets. Called before any other thread starts: they inherit the blocked signals.
fn stop_on_signals() -> Result<Arc<AtomicBool>, HostError> {
    policy::block_ending_signals();
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let wait = move || flag.fetch_or(policy::wait_for_ending_signal(), Ordering::Relaxed);
    // not joined: it waits for ever when no signal comes
    thread::Builder::new().name("signals".into()).spawn(wait).map_err(|reason| HostError::Thread { name: "signals", reason })?;
    Ok(stop)
}

/// Sets the flag when standard input closes; what comes before is dropped.
fn stop_with_stdin(stop: Arc<AtomicBool>) -> Result<(), HostError> {
    let watch = move || {
        let mut dropped = [0; 256];
        while matches!(stdin().read(&mut dropped), Ok(n) if n > 0) {}
        stop.store(true, Ordering::Relaxed);
    };
    // not joined: it waits for ever when standard input outlives the session
    thread::Builder::new()
        .name("stdin".into())
        .spawn(watch)
        .map(drop)
        .map_err(|reason| HostError::Thread { name: "stdin", reason })
}

/// Starts the threads, waits for the real-time thread, and ends the others with its summary. Files are created once the real-time
/// thread has its rights, so that a start that is refused touches none.
fn supervise<'scope>(
    scope: &'scope Scope<'scope, '_>,
    config: &'scope Config,
    scene: &'scope Scene,
    link: AnyLink,
    origin: Origin,
    (entrance, desk): (Option<Entrance>, Desk),
    stop: &'scope AtomicBool,
) -> Result<Outcome, HostError> {
    let (links, opener) = exchange();
    let (black_box, dumps) = black_box(config.rate_hz);
    let (account, readers) = Account::new(black_box, config.rate_hz);
    let (news, sources) = (readers.news, Sources { records: readers.records, dumps, rest_wanted: readers.rest_wanted });
    let ((tell_recorder, recorder_end), (tell_status, status_end)) = (mpsc::channel(), mpsc::channel());
    let ((tell_viewers, viewers_end), (ready, is_ready)) = (mpsc::channel(), mpsc::channel());
    start(scope, "reopen", move || reopen::run(opener, &config.device))?;
    let status = start(scope, "status", move || status::run(config.status, config.rate_hz, news, &status_end))?;
    let real_time = start(scope, "real-time", move || real_time(config, scene, (link, links), account, desk, &ready, stop))?;
    if is_ready.recv().is_err() {
        // it ended before it was ready: it says why
        join("real-time", real_time)??;
        return Err(HostError::Panicked { name: "real-time" });
    }
    let attended = attend(scope, config, scene, origin, entrance, sources, (recorder_end, viewers_end));
    stop.fetch_or(attended.is_err(), Ordering::Relaxed);
    let ran = join("real-time", real_time)??;
    let told = Told { recorder: tell_recorder, status: tell_status, viewers: tell_viewers };
    conclude(config, ran, &told, attended, status)
}

/// Threads that are there once the real-time thread has its rights.
struct Attendants<'scope> {
    recorder: ScopedJoinHandle<'scope, Written>,
    /// When asked for.
    viewers: Option<ScopedJoinHandle<'scope, ()>>,
}

/// Creates the files and starts the threads that fill them and that serve viewers.
fn attend<'scope>(
    scope: &'scope Scope<'scope, '_>,
    config: &Config,
    scene: &Scene,
    origin: Origin,
    entrance: Option<Entrance>,
    sources: Sources,
    (recorder_end, viewers_end): (Receiver<Summary>, Receiver<Summary>),
) -> Result<Attendants<'scope>, HostError> {
    let figures = SharedFigures::default();
    let (recorder, orders) = Recorder::create(origin.clone(), config.record.clone(), config.black_box.clone())?;
    let recorder = recorder.with_figures(figures.clone());
    let session = viewer::entrance::Session {
        scene: scene.clone(),
        budget: config.budget,
        origin,
        recorder: orders,
        figures,
        end: viewers_end,
    };
    let recorder = start(scope, "recorder", move || recorder.run(sources, &recorder_end))?;
    let viewers = entrance.map(|entrance| entrance.serve(scope, session)).transpose()?;
    Ok(Attendants { recorder, viewers })
}

/// Where the threads wait for the session's summary.
struct Told {
    recorder: Sender<Summary>,
    status: Sender<Summary>,
    viewers: Sender<Summary>,
}

/// Ends the threads with the summary of the real-time thread, and writes the durations when asked for.
fn conclude(
    config: &Config,
    Ran { summary, mismatch, times }: Ran,
    told: &Told,
    attended: Result<Attendants<'_>, HostError>,
    status: ScopedJoinHandle<'_, ()>,
) -> Result<Outcome, HostError> {
    // a thread that is gone has said why; it does not change how the session went
    let _ = told.recorder.send(summary);
    let _ = told.status.send(summary);
    let attendants = attended?;
    let written = join("recorder", attendants.recorder)?;
    // viewers get the recording's end with their last bytes
    let _ = told.viewers.send(summary);
    attendants.viewers.map_or(Ok(()), |viewers| join("viewers", viewers))?;
    join("status", status)?;
    if let (Some(path), Some(times)) = (&config.times, times) {
        write_times(path, &times)?;
    }
    Ok(Outcome { summary, mismatch, written })
}

/// The real-time thread: everything is made, then rights are asked for, then the loop runs.
fn real_time(
    config: &Config,
    scene: &Scene,
    (link, links): (AnyLink, Exchange),
    account: Account,
    desk: Desk,
    ready: &Sender<()>,
    stop: &AtomicBool,
) -> Result<Ran, HostError> {
    let mut engine = scene.engine().map_err(|reason| HostError::Scene { path: config.model.clone(), reason })?;
    let line = Line::new(link, links);
    let obtained = policy::apply(config.rt, config.cpu, &config.without)?;
    let budget = work::find(config.budget, scene, config.rate_hz, &Monotonic);
    let budget = budget.map_err(|reason| HostError::Scene { path: config.model.clone(), reason })?;
    engine.limit(budget.limit);
    if let (Some(measured), StatusFormat::Text) = (budget.measured, config.status) {
        // nobody need be left to hear it
        let _ = writeln!(stderr(), "haptor-host: {measured}");
    }
    let settings = Settings {
        rate_hz: config.rate_hz,
        follow: config.follow,
        ticks: config.ticks,
        stale: config.stale,
        rt: obtained.report,
    };
    let mut control = Control::new(settings, Monotonic, line, engine, account, desk);
    // a supervisor that is gone will not be served better by stopping here
    let _ = ready.send(());
    control.run(stop);
    let times = config.times.as_ref().map(|_| control.times());
    Ok(Ran { summary: control.summary(obtained.report), mismatch: control.mismatch(), times })
}

/// Writes the durations so that the file appears complete or not at all.
fn write_times(path: &Path, times: &str) -> Result<(), HostError> {
    let mut part = path.to_owned().into_os_string();
    part.push(".part");
    let written = fs::write(&part, times).and_then(|()| fs::rename(&part, path));
    written.map_err(|reason| HostError::File { doing: "write the times", path: path.to_owned(), reason })
}

/// Starts a thread of a session.
pub(crate) fn start<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    name: &'static str,
    body: impl FnOnce() -> T + Send + 'scope,
) -> Result<ScopedJoinHandle<'scope, T>, HostError> {
    thread::Builder::new().name(name.into()).spawn_scoped(scope, body).map_err(|reason| HostError::Thread { name, reason })
}

fn join<T>(name: &'static str, thread: ScopedJoinHandle<'_, T>) -> Result<T, HostError> {
    thread.join().map_err(|_| HostError::Panicked { name })
}

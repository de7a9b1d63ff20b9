//! `haptor demo`: simulated device, real-time host and core for some seconds, over a pseudo-terminal, then figures, plots and the
//! recording.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use haptor_wire::{FromHost, Progress, Summary, TickRecord};
use indicatif::ProgressBar;

use super::bake::bake;
use crate::config;
use crate::failure::{Failure, Outcome};
use crate::output::{Output, say, unwritten};
use crate::plot::{self, Curve};
use crate::programs;
use crate::progress;
use crate::scene;
use crate::session::device::SimulatedDevice;
use crate::session::drill::{self, Drill};
use crate::session::host::{Host, Plan};
use crate::session::recording::Recording;
use crate::session::report::Figures;
use crate::session::table;
use crate::window;

/// Runs a simulated device, the real-time host and the core for some seconds and shows what was felt.
///
/// The folder gets wrench.csv, force.png, torque.png and session.haptor (the recording). Exit 0 only if at least 90 % of the
/// ticks were in time and no fault was latched; Ctrl-C ends it early, with what was felt up to then.
///
/// With a drill something goes wrong on purpose: the wrench goes to zero, the fault is named, the exit code is 1. Forces come back,
/// where the device does, once the hand has come out of the object.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor demo --seconds 5 -o my-demo\n\
                        With a fault: haptor demo --seconds 5 --drill stall@2:50ms")]
pub struct Args {
    /// Length of the session [s], 1 to 3600
    #[arg(long, default_value_t = 8.0, allow_negative_numbers = true, value_parser = seconds)]
    seconds: f64,
    /// Scene file; a steel ball on a rubber cube when not given
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Device to simulate
    #[arg(long, default_value = config::PRESET, value_parser = config::PRESETS)]
    preset: String,
    /// Ticks per second [Hz], 100 to 8000
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(100..=8000))]
    rate: u32,
    /// Something that goes wrong T seconds into the session: die@T (the device is gone), stall@T[:50ms] (nothing goes over the
    /// link), garbage@T[:50ms] (random bytes), restart@T (the device starts anew), kick@T (somebody bumps into the hand). May be
    /// repeated
    #[arg(long = "drill", value_name = "KIND@T[:LENGTH]", value_parser = drill::parse)]
    drills: Vec<Drill>,
    /// Show the session in the window; it closes with the session
    #[arg(long)]
    view: bool,
    /// Folder for the results
    #[arg(short, value_name = "DIR", default_value = "haptor-demo")]
    output: PathBuf,
}

/// The motion that the simulated hand makes.
const SCRIPT: &str = "press-twist-slide";

/// What the host writes beside the recording when a fault latches: its last thousand ticks.
const BLACK_BOX: &str = "session.haptor.blackbox";

/// How much longer the device serves than the session lasts \[s\]: the host must be the one that ends it.
const DEVICE_LONGER: f64 = 10.0;

/// How much longer than asked the host may take before it counts as hanging: start-up, hello, last flush on a loaded machine.
const HOST_LONGER: Duration = Duration::from_secs(15);

/// How often Ctrl-C is looked for: a person does not notice.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// How long the host may take from its summary, or from the end of its output, to its end.
const FAREWELL: Duration = Duration::from_secs(5);

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    if args.view {
        window::check()?;
    }
    if let Some(late) = args.drills.iter().find(|drill| drill.at_s >= args.seconds) {
        let what =
            format!("--drill {}: the session lasts {} s; choose an earlier time or more --seconds", late.text, args.seconds);
        return Err(Failure::bad_input(what));
    }
    let scene = scene::load_or_default(args.scene.as_deref())?;
    let name = args.scene.as_deref().map_or("cube-twist".into(), Path::to_string_lossy);
    let folder = Folder::create(&args.output)?;
    let work = tempfile::tempdir().map_err(|error| unwritten(&error))?;
    let model = work.path().join("scene.model");
    bake(&scene, &name, &model)?;
    let session = play(args, &model, &folder.session)?;
    let recording = Recording::read(&folder.session).unwrap_or_default();
    folder.fill(&recording)?;
    conclude(args, &session, &recording, &folder)
}

/// Where the results go.
struct Folder {
    path: PathBuf,
    session: PathBuf,
}

impl Folder {
    /// Makes the folder and takes away what an earlier run left in it, so that nothing old passes for new.
    fn create(path: &Path) -> Result<Self, Failure> {
        let unusable = |error| Failure::bad_input(format!("{}: cannot be a folder for the results: {error}", path.display()));
        fs::create_dir_all(path).map_err(unusable)?;
        for name in ["wrench.csv", "force.png", "torque.png", "session.haptor", BLACK_BOX] {
            match fs::remove_file(path.join(name)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(unusable(error)),
                _ => {}
            }
        }
        Ok(Self { path: path.to_owned(), session: path.join("session.haptor") })
    }

    /// Writes table and plots of whatever was recorded.
    fn fill(&self, recording: &Recording) -> Outcome {
        let mut csv = Output::create(Some(&self.path.join("wrench.csv")))?;
        table::write(&recording.ticks, &mut csv).map_err(|error| unwritten(&error))?;
        csv.finish()?;
        let force = curves(&recording.ticks, |tick| tick.contact_force, ["|F|", "Fx", "Fy", "Fz"]);
        plot::draw(&self.path.join("force.png"), "Contact force on the probe", "force [N]", &force)?;
        let torque = curves(&recording.ticks, |tick| tick.contact_torque, ["|T|", "Tx", "Ty", "Tz"]);
        plot::draw(&self.path.join("torque.png"), "Contact torque on the probe", "torque [N m]", &torque)?;
        Ok(())
    }
}

/// What the host said before it ended.
struct Session {
    summary: Option<Summary>,
    /// Why the session is no good though the host may not know, with the programs' last words.
    trouble: Option<String>,
    /// Ctrl-C ended it.
    interrupted: bool,
}

/// Runs device and host; both are gone when this returns.
fn play(args: &Args, model: &Path, record: &Path) -> Result<Session, Failure> {
    let interrupted = programs::note_interrupts()?;
    let device = SimulatedDevice::start(&args.preset, SCRIPT, args.seconds + DEVICE_LONGER, &args.drills)?;
    let viewers = args.view.then(|| format!("unix:{}", model.with_file_name("view").display()));
    let plan = Plan {
        model,
        device: &device.address,
        rate_hz: args.rate,
        seconds: args.seconds,
        record: Some(record),
        viewers: viewers.as_deref(),
        hold_fade: Plan::PATIENCE,
        more: &[],
    };
    let mut host = Host::start(&plan)?;
    let _window = viewers.as_deref().map(|address| window::beside(address, "demo")).transpose()?;
    let heard = listen(&mut host, args, &interrupted);
    let ended = host.child.wait(FAREWELL);
    let words = || format!("{}{}", host.child.last_words(), device.child.last_words());
    let trouble = match (&heard, ended) {
        (Heard::Hanging, _) | (_, None) => Some(format!("haptor-host hangs and was killed{}", words())),
        (Heard::Closed, Some(status)) => Some(format!("haptor-host ended without a summary ({status}){}", words())),
        (Heard::Summary(_), _) => None,
    };
    let summary = if let Heard::Summary(summary) = heard { Some(*summary) } else { None };
    Ok(Session { summary, trouble, interrupted: interrupted.load(Ordering::Relaxed) })
}

/// How the host's messages ended.
enum Heard {
    Summary(Box<Summary>),
    Closed,
    Hanging,
}

/// Follows the host's messages to the last one.
fn listen(host: &mut Host, args: &Args, interrupted: &AtomicBool) -> Heard {
    let ticks = (args.seconds * f64::from(args.rate)) as u64;
    let bar = progress::bar(ticks, "running");
    let until = Instant::now() + Duration::from_secs_f64(args.seconds) + HOST_LONGER;
    let heard = loop {
        if interrupted.load(Ordering::Relaxed) {
            host.child.release();
        }
        let left = until.saturating_duration_since(Instant::now());
        match host.messages.recv_timeout(left.min(LOOK_EVERY)) {
            Ok(FromHost::Summary(summary)) => break Heard::Summary(Box::new(summary)),
            Ok(FromHost::Progress(now)) => show(&bar, &now),
            Ok(FromHost::Hello(_) | FromHost::Fault(_)) => {}
            Err(RecvTimeoutError::Timeout) if left > LOOK_EVERY => {}
            Err(RecvTimeoutError::Timeout) => break Heard::Hanging,
            Err(RecvTimeoutError::Disconnected) => break Heard::Closed,
        }
    };
    bar.finish_and_clear();
    heard
}

fn show(bar: &ProgressBar, now: &Progress) {
    let ([.., fz], [.., tz]) = (now.force, now.torque);
    let fault = now.fault.map_or(String::new(), |fault| format!("  FAULT: {}", fault.name()));
    bar.set_position(now.tick);
    bar.set_message(format!("Fz {fz:7.2} N  Tz {tz:8.4} N m  regions {}{fault}", now.regions));
}

/// Magnitude and components over time.
fn curves(ticks: &[TickRecord], of: fn(&TickRecord) -> [f32; 3], names: [&'static str; 4]) -> Vec<Curve> {
    let values = ticks.iter().map(|tick| {
        let [x, y, z] = of(tick).map(f64::from);
        (tick.t_us as f64 / 1.0e6, [(x * x + y * y + z * z).sqrt(), x, y, z])
    });
    let values: Vec<_> = values.collect();
    let points = |row: usize| values.iter().map(|&(t, rows)| (t, rows[row])).collect();
    let curve = |(row, name)| Curve { name, points: points(row) };
    names.into_iter().enumerate().map(curve).collect()
}

/// Prints the table and says whether the session was good.
fn conclude(args: &Args, session: &Session, recording: &Recording, folder: &Folder) -> Outcome {
    let figures = Figures::new(session.summary, recording);
    say(figures.table().trim_end());
    for drill in &args.drills {
        say(format_args!("{:<30}{}", "drill", drill.text));
    }
    say(format_args!("{:<30}{} (wrench.csv, force.png, torque.png, session.haptor)", "results", folder.path.display()));
    if folder.path.join(BLACK_BOX).is_file() {
        say(format_args!("{:<30}the last ticks before the fault are in {BLACK_BOX}", "black box"));
    }
    let interrupted = session.interrupted.then(|| "interrupted; the results are those up to then".to_owned());
    match (&session.trouble, figures.verdict().or(interrupted)) {
        (Some(trouble), Some(verdict)) => Err(Failure::problem(format!("{verdict}; {trouble}"))),
        (Some(trouble), None) => Err(Failure::problem(trouble)),
        (None, Some(verdict)) => Err(Failure::problem(verdict)),
        (None, None) if recording.ticks.is_empty() => Err(Failure::problem("nothing was recorded")),
        (None, None) => {
            figures.warning().iter().for_each(|warning| eprintln!("warning: {warning}"));
            Ok(())
        }
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (1.0..=3600.0).contains(&value) => Ok(value),
        _ => Err("allowed is a number, 1 to 3600 s".to_owned()),
    }
}

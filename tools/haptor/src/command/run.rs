//! `haptor run`: bakes a scene and starts the real-time host with it; the host's own words pass through.

use std::path::{Path, PathBuf};
use std::process::Command;

use haptor_engine::work::budget;
use haptor_wire::WorkBudget;
use haptor_wire::viewer::DEFAULT_ADDRESS;

use super::bake::bake;
use crate::client::Address;
use crate::config::{self, Config};
use crate::failure::{Failure, Outcome};
use crate::output::unwritten;
use crate::programs::{self, Child};
use crate::scene::Scene;
use crate::session::device::SimulatedDevice;
use crate::session::host::patience;
use crate::window;

/// Starts the real-time host with a scene, on a simulated or a real device.
///
/// A table of figures is printed at the end; a fault is told at once. Exit 0 only if at least 90 % of the ticks were in time and no
/// fault was latched. Ctrl-C ends the session in order.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor run tests/scenes/cube-twist.toml --device serial:/dev/ttyACM0 --rt enforce\n\
                        Without a device: haptor run tests/scenes/cube-twist.toml --device sim --rt ignore --seconds 5")]
pub struct Args {
    #[command(flatten)]
    session: Session,
    /// Recording to write
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Show the session in the window; it closes with the session
    #[arg(long)]
    view: bool,
}

/// A session with a device.
#[derive(Debug, clap::Args)]
pub struct Session {
    /// Scene file (TOML)
    pub scene: PathBuf,
    /// sim (a simulated device), usb, usb:SERIAL, usb-bulk[:SERIAL], serial:PORT, serial:NUMBER or tcp:HOST:PORT; `haptor devices` lists what is there
    /// [default: that of
    /// `haptor config`]
    #[arg(long, value_parser = device)]
    device: Option<String>,
    /// Ticks per second [Hz], 100 to 8000 [default: that of `haptor config`, or 1000]
    #[arg(long, value_parser = clap::value_parser!(u32).range(100..=8000))]
    pub rate: Option<u32>,
    /// enforce: refuse to start without real-time rights, saying what to do; ignore: take what is granted [default: that of `haptor
    /// config`, or enforce]
    #[arg(long, value_parser = ["enforce", "ignore"])]
    rt: Option<String>,
    /// What `--device sim` simulates [default: that of `haptor config`, or premium15]
    #[arg(long, value_parser = config::PRESETS)]
    preset: Option<String>,
    /// Work a tick may spend before tier and samples are lowered, in this scene and in those that viewers bring: auto measures this machine for each, off sets no
    /// limit, scene leaves it to each, or instructions, 10000 to 1000000000
    #[arg(long, value_name = "scene|auto|off|N", value_parser = budget, default_value_t = WorkBudget::Scene)]
    budget: WorkBudget,
    /// Length of the session [s]; until Ctrl-C when not given
    #[arg(long, allow_negative_numbers = true, value_parser = seconds)]
    seconds: Option<f64>,
    /// Let viewers in (`haptor view`, `haptor tell`) at HOST:PORT or unix:PATH; without an address at 127.0.0.1:21278
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = DEFAULT_ADDRESS)]
    viewer: Option<Address>,
    /// File with the token that viewers must know; HAPTOR_TOKEN of the environment when not given
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
}

impl Session {
    /// File with the token that viewers must know.
    pub fn token_file(&self) -> Option<&Path> {
        self.token_file.as_deref()
    }

    /// Length \[s\].
    pub const fn seconds(&self) -> Option<f64> {
        self.seconds
    }
}

/// How long a simulated device serves when no length is given \[s\]: some eleven days, what it takes at most.
const LONGEST_S: f64 = 999_990.0;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    if args.view {
        window::check()?;
    }
    start(&args.session, args.record.as_deref(), args.view)
}

/// Runs a session to its end, recorded and shown where asked.
pub fn start(args: &Session, record: Option<&Path>, view: bool) -> Outcome {
    let chosen = Chosen::new(args, Config::load()?)?;
    let scene = Scene::load(&args.scene)?;
    let work = tempfile::tempdir().map_err(|error| unwritten(&error))?;
    let model = work.path().join("scene.model");
    bake(&scene, &args.scene.display().to_string(), &model)?;
    let simulated = simulated(&chosen, args.seconds)?;
    let device = simulated.as_ref().map_or(chosen.device.clone(), |device| device.address.clone());
    let mut command = Command::new(programs::find(programs::HOST)?);
    command.arg(&model).args(["--device", &device, "--rate", &chosen.rate.to_string(), "--rt", &chosen.rt]).arg(programs::TIED);
    if simulated.is_some() {
        command.args(patience(chosen.rate));
    }
    if let Some(seconds) = args.seconds {
        command.args(["--seconds", &seconds.to_string()]);
    }
    command.args(["--budget", &args.budget.to_string()]);
    if let Some(record) = record {
        command.arg("--record").arg(record);
    }
    let own = view.then(|| format!("unix:{}", work.path().join("view").display()));
    let viewers = args.viewer.as_ref().map(ToString::to_string).or(own);
    if let Some(address) = &viewers {
        command.args(["--viewer", address]);
    }
    if let (Some(_), Some(file)) = (&args.viewer, &args.token_file) {
        command.arg("--token-file").arg(file);
    }
    let interrupted = programs::note_interrupts()?;
    let mut host = Child::attached(&mut command)?;
    let title = args.scene.display().to_string();
    let _window = viewers.filter(|_| view).map(|address| window::beside(&address, &title)).transpose()?;
    let status = host.wait_for_end(&interrupted);
    match status.code() {
        Some(0) => Ok(()),
        Some(1) => Err(Failure::problem("the session failed; haptor-host says why above")),
        Some(2) => Err(Failure::bad_input("haptor-host refused what it was given")),
        _ => Err(Failure::problem(format!("haptor-host ended with {status}"))),
    }
}

/// What holds: the command line, then the configuration, then the defaults.
struct Chosen {
    device: String,
    rate: u32,
    rt: String,
    preset: String,
}

impl Chosen {
    fn new(args: &Session, config: Config) -> Result<Self, Failure> {
        let device = args.device.clone().or(config.device).ok_or_else(|| {
            Failure::bad_input(
                "no device: give --device (`haptor devices` lists what is there), or name one in the file of `haptor config`",
            )
        })?;
        Ok(Self {
            device,
            rate: args.rate.or(config.rate).unwrap_or(config::RATE),
            rt: args.rt.clone().or(config.rt).unwrap_or_else(|| config::RT.to_owned()),
            preset: args.preset.clone().or(config.preset).unwrap_or_else(|| config::PRESET.to_owned()),
        })
    }
}

fn simulated(chosen: &Chosen, seconds: Option<f64>) -> Result<Option<SimulatedDevice>, Failure> {
    if chosen.device != "sim" {
        return Ok(None);
    }
    let seconds = seconds.unwrap_or(LONGEST_S) + 10.0;
    SimulatedDevice::start(&chosen.preset, "press-twist-slide", seconds, &[]).map(Some)
}

/// The host checks it fully; what it calls a device and this program another does not reach it.
pub fn device(text: &str) -> Result<String, String> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    match (kind, rest.is_empty()) {
        ("sim", true) | ("usb" | "usb-bulk", _) | ("serial" | "tcp", false) => Ok(text.to_owned()),
        _ => Err("allowed is sim, usb, usb:SERIAL, usb-bulk[:SERIAL], serial:PORT, serial:NUMBER or tcp:HOST:PORT".to_owned()),
    }
}

pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= LONGEST_S => Ok(value),
        _ => Err("allowed is a number above 0, up to 999990 s".to_owned()),
    }
}

//! `haptor run`: bakes a scene and starts the real-time host with it; the host's own words pass through.

use std::path::PathBuf;
use std::process::Command;

use super::bake::bake;
use crate::failure::{Failure, Outcome};
use crate::output::unwritten;
use crate::programs::{self, Child};
use crate::scene::Scene;
use crate::session::device::SimulatedDevice;
use crate::session::host::PATIENCE;

/// Starts the real-time host with a scene, on a simulated or a real device.
///
/// A table of figures is printed at the end; a fault is told at once. Exit 0 only if at least 90 % of the ticks were in time and no
/// fault was latched. Ctrl-C ends the session in order.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor run tests/scenes/cube-twist.toml --device serial:/dev/ttyACM0 --rt enforce\n\
                        Without a device: haptor run tests/scenes/cube-twist.toml --device sim --rt ignore --seconds 5")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// sim (a simulated device), usb, usb:SERIAL, serial:PORT or tcp:HOST:PORT; `haptor devices` lists what is there
    #[arg(long, value_parser = device)]
    device: String,
    /// Ticks per second [Hz], 100 to 8000
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(100..=8000))]
    rate: u32,
    /// enforce: refuse to start without real-time rights, saying what to do; ignore: take what is granted
    #[arg(long, default_value = "enforce", value_parser = ["enforce", "ignore"])]
    rt: String,
    /// Length of the session [s]; until Ctrl-C when not given
    #[arg(long, allow_negative_numbers = true, value_parser = seconds)]
    seconds: Option<f64>,
    /// Recording to write
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

/// What a simulated device is: the smallest that renders torque.
const PRESET: &str = "premium15";

/// How long a simulated device serves when no length is given \[s\]: some eleven days, what it takes at most.
const LONGEST_S: f64 = 999_990.0;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let scene = Scene::load(&args.scene)?;
    let work = tempfile::tempdir().map_err(|error| unwritten(&error))?;
    let model = work.path().join("scene.model");
    bake(&scene, &args.scene.display().to_string(), &model)?;
    let simulated = simulated(args)?;
    let device = simulated.as_ref().map_or(args.device.clone(), |device| format!("serial:{}", device.port));
    let mut command = Command::new(programs::find(programs::HOST)?);
    command.arg(&model).args(["--device", &device, "--rate", &args.rate.to_string(), "--rt", &args.rt]).arg(programs::TIED);
    if simulated.is_some() {
        command.args(PATIENCE);
    }
    if let Some(seconds) = args.seconds {
        command.args(["--seconds", &seconds.to_string()]);
    }
    if let Some(record) = &args.record {
        command.arg("--record").arg(record);
    }
    let interrupted = programs::note_interrupts()?;
    let status = Child::attached(&mut command)?.wait_for_end(&interrupted);
    match status.code() {
        Some(0) => Ok(()),
        Some(1) => Err(Failure::problem("the session failed; haptor-host says why above")),
        Some(2) => Err(Failure::bad_input("haptor-host refused what it was given")),
        _ => Err(Failure::problem(format!("haptor-host ended with {status}"))),
    }
}

fn simulated(args: &Args) -> Result<Option<SimulatedDevice>, Failure> {
    if args.device != "sim" {
        return Ok(None);
    }
    let seconds = args.seconds.unwrap_or(LONGEST_S) + 10.0;
    SimulatedDevice::start(PRESET, "press-twist-slide", seconds, &[]).map(Some)
}

/// The host checks it fully; what it calls a device and this program another does not reach it.
fn device(text: &str) -> Result<String, String> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    match (kind, rest.is_empty()) {
        ("sim", true) | ("usb", _) | ("serial" | "tcp", false) => Ok(text.to_owned()),
        _ => Err("allowed is sim, usb, usb:SERIAL, serial:PORT or tcp:HOST:PORT".to_owned()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= LONGEST_S => Ok(value),
        _ => Err("allowed is a number above 0, up to 999990 s".to_owned()),
    }
}

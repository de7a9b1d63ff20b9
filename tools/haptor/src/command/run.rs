//! `haptor run`: bakes a scene and starts the real-time host with it; the host's own words pass through.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Context;

use super::bake::bake;
use crate::failure::{Failure, Outcome};
use crate::output::unwritten;
use crate::programs;
use crate::scene::Scene;
use crate::session::device::SimulatedDevice;

/// Starts the real-time host with a scene, on a simulated or a real device.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor run tests/scenes/cube-twist.toml --device serial:/dev/ttyACM0 --rt enforce")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// sim, usb[:SERIAL] or serial:PORT
    #[arg(long)]
    device: String,
    /// Ticks per second [Hz]
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(10..=8000))]
    rate: u32,
    /// enforce: refuse to start without real-time rights, saying what to do; ignore: take what is granted
    #[arg(long, default_value = "enforce", value_parser = ["enforce", "ignore"])]
    rt: String,
    /// Length of the session [s]; until the device goes when not given
    #[arg(long)]
    seconds: Option<u32>,
    /// Recording to write
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

/// What a simulated device is: the smallest that renders torque.
const PRESET: &str = "premium15";

/// How long a simulated device serves when no length is given \[s\]: a day.
const A_DAY: f64 = 86_400.0;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let scene = Scene::load(&args.scene)?;
    let work = tempfile::tempdir().map_err(|error| unwritten(&error))?;
    let model = work.path().join("scene.model");
    bake(&scene, &args.scene.display().to_string(), &model)?;
    let simulated = simulated(args)?;
    let device = simulated.as_ref().map_or(args.device.clone(), |device| format!("serial:{}", device.port));
    let mut command = Command::new(programs::find(programs::HOST)?);
    command.arg(&model).args(["--device", &device, "--rate", &args.rate.to_string(), "--rt", &args.rt]);
    if let Some(seconds) = args.seconds {
        command.args(["--seconds", &seconds.to_string()]);
    }
    if let Some(record) = &args.record {
        command.arg("--record").arg(record);
    }
    let status = command.status().context("haptor-host cannot be started")?;
    match status.code() {
        Some(0) => Ok(()),
        Some(2) => Err(Failure::bad_input("haptor-host refused what it was given")),
        _ => Err(Failure::problem(format!("haptor-host ended with {status}"))),
    }
}

fn simulated(args: &Args) -> Result<Option<SimulatedDevice>, Failure> {
    if args.device != "sim" {
        return Ok(None);
    }
    let seconds = args.seconds.map_or(A_DAY, |seconds| f64::from(seconds) + 10.0);
    SimulatedDevice::start(PRESET, "press-twist-slide", seconds).map(Some)
}

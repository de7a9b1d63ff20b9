//! `haptor trajectory`: trajectory files of scripted motions, to evaluate or to compare.

use std::io::Write;
use std::path::PathBuf;

use crate::failure::Outcome;
use crate::motion::{self, CLEARANCE, Move, minimum_jerk};
use crate::output::{Output, unwritten};
use crate::scene::{self, Scene};
use crate::trajectory::HEADER;

/// Writes the trajectory of a scripted motion as CSV.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor trajectory press-twist-slide -o cube-twist.csv")]
pub struct Args {
    #[command(subcommand)]
    motion: Motion,
}

#[derive(Debug, clap::Subcommand)]
enum Motion {
    PressTwistSlide(PressTwistSlide),
    Moves(Moves),
}

/// Press onto the middle of the object's top, twist about z, slide along x, lift.
///
/// Each move starts and ends at rest (minimum jerk); between two moves the probe is held for a tenth of a second.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: haptor trajectory press-twist-slide --depth 0.001 --angle 0.5 --slide 0.01 --rate 250 -o FILE.csv"
)]
struct PressTwistSlide {
    /// Scene file whose probe and object give the height of first touch; cube-twist when not given
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Depth of the press [m]
    #[arg(long, default_value_t = 0.001, allow_negative_numbers = true, value_parser = positive)]
    depth: f64,
    /// Angle of the twist [rad]
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true, value_parser = finite)]
    angle: f64,
    /// Distance of the slide [m]
    #[arg(long, default_value_t = 0.01, allow_negative_numbers = true, value_parser = finite)]
    slide: f64,
    /// Rows per second [Hz]
    #[arg(long, default_value_t = 250.0, value_parser = rate)]
    rate: f64,
    /// Trajectory file; standard output when not given
    #[arg(short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// One move after the other, each from rest to rest (minimum jerk) to the value given: press=M below first touch, twist=RAD about z
/// through the mass centre, slide=M or slide=M,M along x and y, hold, lift; each with @SECONDS (0.2 when not given).
///
/// The probe starts 1 mm above first touch; first touch is found where the probe's own parts meet the object.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: haptor trajectory moves --scene tests/scenes/mallet.toml press=0.001 twist=0.3 twist=-0.3@0.4 lift"
)]
struct Moves {
    /// Scene file whose probe and object give the height of first touch; cube-twist when not given
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Rows per second [Hz]
    #[arg(long, default_value_t = 1000.0, value_parser = rate)]
    rate: f64,
    /// Trajectory file; standard output when not given
    #[arg(short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The moves, NAME[=VALUE][@SECONDS]
    #[arg(required = true, value_name = "MOVE")]
    moves: Vec<Move>,
}

/// Length of each move \[s\]: press, twist, slide, lift; a hand's pace.
const MOVES: [f64; 4] = [0.4, 0.8, 0.8, 0.4];

/// Rest after each move \[s\].
const HOLD: f64 = 0.1;

/// Largest rate \[Hz\]: the finest time step the core is meant for.
const MAX_RATE: f64 = 1.0e6;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let (scene, file) = match &args.motion {
        Motion::PressTwistSlide(motion) => (&motion.scene, &motion.output),
        Motion::Moves(motion) => (&motion.scene, &motion.output),
    };
    let scene = scene::load_or_default(scene.as_deref())?;
    let mut output = Output::create(file.as_deref())?;
    let written = match &args.motion {
        Motion::PressTwistSlide(motion) => write(motion, &scene, &mut output),
        Motion::Moves(motion) => write_moves(motion, &scene, &mut output),
    };
    written.map_err(|error| unwritten(&error))?;
    output.finish()
}

fn write_moves(motion: &Moves, scene: &Scene, out: &mut impl Write) -> std::io::Result<()> {
    writeln!(out, "{}", HEADER.join(","))?;
    let touch = f64::from(motion::first_touch(&scene.object.shape, &scene.probe.parts, scene.touch_height()));
    let ticks = (motion::seconds(&motion.moves) * motion.rate).round() as u64;
    for tick in 0..=ticks {
        let t = tick as f64 / motion.rate;
        let place = motion::place(&motion.moves, t);
        // f32 is what the core reads: shorter text, the same pose
        let ([x, y], z) = (place.shift.map(|shift| shift as f32), (touch - place.depth) as f32);
        let (qw, qz) = ((place.angle / 2.0).cos() as f32, (place.angle / 2.0).sin() as f32);
        writeln!(out, "{t},{x},{y},{z},{qw},0,0,{qz}")?;
    }
    Ok(())
}

fn write(motion: &PressTwistSlide, scene: &Scene, out: &mut impl Write) -> std::io::Result<()> {
    writeln!(out, "{}", HEADER.join(","))?;
    let touch = f64::from(scene.touch_height());
    let seconds: f64 = MOVES.iter().map(|length| length + HOLD).sum();
    let ticks = (seconds * motion.rate).round() as u64;
    for tick in 0..=ticks {
        let t = tick as f64 / motion.rate;
        let (x, height, angle) = place(motion, t);
        // f32 is what the core reads: shorter text, the same pose
        let (x, z) = (x as f32, (touch + height) as f32);
        let (qw, qz) = ((angle / 2.0).cos() as f32, (angle / 2.0).sin() as f32);
        writeln!(out, "{t},{x},0,{z},{qw},0,0,{qz}")?;
    }
    Ok(())
}

/// Shift along x \[m\], height above first touch \[m\] and angle about z \[rad\] at time t \[s\].
fn place(motion: &PressTwistSlide, t: f64) -> (f64, f64, f64) {
    let mut start = 0.0;
    let done = MOVES.map(|length| {
        let share = minimum_jerk((t - start) / length);
        start += length + HOLD;
        share
    });
    let [press, twist, slide, lift] = done;
    let travel = CLEARANCE + motion.depth;
    (motion.slide * slide, CLEARANCE - travel * press + travel * lift, motion.angle * twist)
}

fn finite(text: &str) -> Result<f64, String> {
    bounded(text, -1.0e3..=1.0e3, "-1e3 to 1e3")
}

fn positive(text: &str) -> Result<f64, String> {
    bounded(text, 1.0e-9..=1.0, "1e-9 to 1 m")
}

fn rate(text: &str) -> Result<f64, String> {
    bounded(text, 1.0..=MAX_RATE, "1 to 1e6 Hz")
}

fn bounded(text: &str, range: std::ops::RangeInclusive<f64>, allowed: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("not a number; allowed is {allowed}"))?;
    if range.contains(&value) { Ok(value) } else { Err(format!("allowed is {allowed}")) }
}

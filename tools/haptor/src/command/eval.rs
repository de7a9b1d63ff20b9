//! `haptor eval`: the core over a trajectory, one row per tick. Everything is read and checked before anything is written.

use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

use haptor_contact::{Invalid, Output as TickOutput, ParamsSpec, Tier};

use crate::failure::{Failure, Outcome};
use crate::output::{Output, unwritten};
use crate::progress;
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::trajectory::{self, Row};

/// Columns of the result.
pub const HEADER: &str = "t,fx,fy,fz,tx,ty,tz,regions,depth,radius,stick,tier,flags";

/// Ticks between two steps of the progress bar.
const PROGRESS_EVERY: usize = 1000;

/// Runs the core over a trajectory, offline and deterministic; one row of CSV per tick.
///
/// Columns: t [s], force and torque on the probe about its mass centre in world [N, N m], regions, largest depth [m], contact
/// radius of the deepest region [m], stuck share of its area, tier, flags in hexadecimal (0 = clean).
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor eval tests/scenes/cube-twist.toml tests/scenes/cube-twist.csv -o wrench.csv")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Trajectory file (CSV with header t,px,py,pz,qw,qx,qy,qz)
    trajectory: PathBuf,
    /// Fidelity in place of the scene's
    #[arg(long, value_name = "T")]
    tier: Option<TierName>,
    /// Samples per region in place of the scene's, 16 to 256 for bristle, 16 to 1024 for paper
    #[arg(long, value_name = "N")]
    samples: Option<usize>,
    /// Result file; standard output when not given
    #[arg(short, value_name = "OUT.csv")]
    output: Option<PathBuf>,
    /// Deformed surface at the first tick with t >= T_S (not available in this version)
    #[arg(long, value_name = "T_S=FILE.ply")]
    surface: Vec<String>,
    /// Print what the device would get, after the guard's limits, in place of the contact's wrench
    #[arg(long)]
    guard: bool,
}

/// A tier on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum TierName {
    /// Closed-form curves, no samples
    Point,
    /// The paper's equations; not predictive in torque
    Paper,
    /// Calibrated bristles
    Bristle,
}

impl From<TierName> for Tier {
    fn from(name: TierName) -> Self {
        match name {
            TierName::Point => Self::Point,
            TierName::Paper => Self::Paper,
            TierName::Bristle => Self::Bristle,
        }
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    if !args.surface.is_empty() {
        return Err(Failure::bad_input("--surface: deformed surfaces are not available in this version; leave the option out"));
    }
    let scene = Scene::load(&args.scene)?;
    let rows = trajectory::load(&args.trajectory)?;
    let params = params(&scene, args);
    let mut simulation = Simulation::new(&scene, &params).map_err(|invalid| refused(args, &invalid))?;
    let mut output = Output::create(args.output.as_deref())?;
    match write_table(&mut simulation, &rows, args.guard, &mut output) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(unwritten(&error)),
        _ => output.finish(),
    }
}

/// The scene's parameters with the command line's in their place. The scene's own have been validated, so of these only the
/// number of samples can be refused.
fn params(scene: &Scene, args: &Args) -> ParamsSpec {
    let mut params = if args.guard { scene.params } else { scene.contact_only() };
    params.tier = args.tier.map_or(params.tier, Tier::from);
    params.samples = args.samples.unwrap_or(params.samples);
    params
}

/// The number of samples is refused: as the command line gives it, or as the scene does for another tier.
fn refused(args: &Args, invalid: &Invalid) -> Failure {
    let given = match args.samples {
        Some(samples) => format!("--samples {samples}"),
        None => format!("{}: {} = {}", args.scene.display(), invalid.name, invalid.value),
    };
    Failure::bad_input(format!("{given}: allowed is {}", invalid.allowed))
}

fn write_table(simulation: &mut Simulation<'_>, rows: &[Row], guarded: bool, out: &mut impl Write) -> io::Result<()> {
    let bar = progress::bar(rows.len() as u64, "evaluating");
    writeln!(out, "{HEADER}")?;
    for (index, row) in rows.iter().enumerate() {
        write_row(out, row, &simulation.tick(row), guarded)?;
        if index % PROGRESS_EVERY == 0 {
            bar.set_position(index as u64);
        }
    }
    bar.finish_and_clear();
    Ok(())
}

/// One tick; `{}` prints the shortest text that reads back as the same f32.
fn write_row(out: &mut impl Write, row: &Row, tick: &TickOutput, guarded: bool) -> io::Result<()> {
    let wrench = if guarded { tick.wrench } else { tick.contact };
    let ([fx, fy, fz], [tx, ty, tz]) = (wrench.force.to_array(), wrench.torque.to_array());
    let report = &tick.report;
    let (depth, radius, stick, tier) = (report.depth, report.radius, report.stick, report.tier.name());
    write!(out, "{},{fx},{fy},{fz},{tx},{ty},{tz},{},{depth},{radius},{stick},{tier},", row.written_t, report.regions)?;
    match report.flags.0 {
        0 => writeln!(out, "0"),
        bits => writeln!(out, "{bits:#x}"),
    }
}

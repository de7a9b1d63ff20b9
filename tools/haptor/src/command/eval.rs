//! `haptor eval`: the core over a trajectory, one row per tick. Everything is read and checked before anything is written.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use haptor_contact::{Invalid, Output as TickOutput, Params, ParamsSpec, Tier};
use haptor_wire::Deformation;

use crate::failure::{Failure, Outcome};
use crate::output::{Output, unwritten};
use crate::progress;
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::surface::{self, Request};
use crate::table;
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
    /// Deformed object at the first tick with t >= T_S: binary PLY, x,y,z deformed, ux,uy,uz displacement [m]; may be repeated
    #[arg(long, value_name = "T_S=FILE.ply")]
    surface: Vec<Request>,
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
    /// Cells on the elastic surface, 52 or 112
    Influence,
    /// The same, with the body's own table by finite elements
    Green,
}

impl From<TierName> for Tier {
    fn from(name: TierName) -> Self {
        match name {
            TierName::Point => Self::Point,
            TierName::Paper => Self::Paper,
            TierName::Bristle => Self::Bristle,
            TierName::Influence => Self::Influence,
            TierName::Green => Self::Green,
        }
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let scene = Scene::load(&args.scene)?;
    let rows = trajectory::load(&args.trajectory)?;
    let params = params(&scene, args);
    Params::new(&params).map_err(|invalid| refused(args, &invalid))?;
    refuse_shared_files(args)?;
    refuse_rigid_scene(args, &scene)?;
    let table = table::of(&scene, params.tier, &args.scene.display().to_string())?;
    let mut simulation = Simulation::with_table(&scene, &params, table.as_ref()).map_err(|invalid| refused(args, &invalid))?;
    let body = scene.extras.deformation == Deformation::Full;
    let pictures: Result<Vec<_>, _> = args.surface.iter().map(|request| Picture::new(args, request, &rows, body)).collect();
    let mut pictures = pictures?;
    let mut output = Output::create(args.output.as_deref())?;
    write_all(&mut simulation, &rows, args.guard, &mut output, &mut pictures).map_err(|error| unwritten(&error))?;
    output.finish()?;
    pictures.into_iter().try_for_each(|picture| picture.output.finish())
}

/// A surface that is to be written after the tick of one row.
struct Picture {
    row: usize,
    /// With the motion of the whole body.
    body: bool,
    output: Output,
}

impl Picture {
    fn new(args: &Args, request: &Request, rows: &[Row], body: bool) -> Result<Self, Failure> {
        let Request { time, file } = request;
        let row = rows.iter().position(|row| row.t >= *time).ok_or_else(|| {
            let end = &rows[rows.len() - 1].written_t;
            Failure::bad_input(format!("--surface {time}={}: {} ends at {end} s", file.display(), args.trajectory.display()))
        })?;
        Ok(Self { row, body, output: Output::create(Some(file))? })
    }
}

/// A scene that computes no deformation has no surface to write.
fn refuse_rigid_scene(args: &Args, scene: &Scene) -> Outcome {
    if args.surface.is_empty() || scene.extras.deformation != Deformation::None {
        return Ok(());
    }
    let file = args.scene.display();
    Err(Failure::bad_input(format!("--surface: {file} says deformation = \"none\"; set it to \"local\" or \"full\"")))
}

/// Two results in one file, or a result in an input: the later would take the earlier's place.
fn refuse_shared_files(args: &Args) -> Outcome {
    let same = |path: &Path| std::fs::canonicalize(path).unwrap_or(path.to_owned());
    let results: Vec<&Path> =
        args.output.iter().chain(args.surface.iter().map(|request| &request.file)).map(PathBuf::as_path).collect();
    let inputs = [same(&args.scene), same(&args.trajectory)];
    for (index, file) in results.iter().enumerate() {
        let refuse = |why| Err(Failure::bad_input(format!("{}: {why}; give each result a file of its own", file.display())));
        if inputs.contains(&same(file)) {
            return refuse("is an input of this command and would be overwritten");
        }
        if results[..index].iter().any(|other| same(other) == same(file)) {
            return refuse("asked for twice");
        }
    }
    Ok(())
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

/// All ticks: the table, and the surfaces as their rows come. A reader of the table that has left ends the table only.
fn write_all(
    simulation: &mut Simulation<'_>,
    rows: &[Row],
    guarded: bool,
    table: &mut impl Write,
    pictures: &mut [Picture],
) -> io::Result<()> {
    let bar = progress::bar(rows.len() as u64, "evaluating");
    let mut read = still_read(writeln!(table, "{HEADER}"))?;
    for (index, row) in rows.iter().enumerate() {
        if !read && pictures.iter().all(|picture| picture.row < index) {
            break;
        }
        let tick = simulation.tick(row);
        read = read && still_read(write_row(table, row, &tick, guarded))?;
        for picture in pictures.iter_mut().filter(|picture| picture.row == index) {
            surface::write(&simulation.surface(row, picture.body), simulation.skin(), &mut picture.output)?;
        }
        if index % PROGRESS_EVERY == 0 {
            bar.set_position(index as u64);
        }
    }
    bar.finish_and_clear();
    Ok(())
}

/// False when the reader has left, which is no failure.
fn still_read(written: io::Result<()>) -> io::Result<bool> {
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        written => written.map(|()| true),
    }
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

//! `haptor record`: a session in a file.

use std::path::PathBuf;

use super::bake;
use super::run::{Session, start};
use crate::failure::{Failure, Outcome};
use crate::output::{unwritten, write_file};
use crate::scene::Scene;
use crate::session::offline;
use crate::trajectory;

/// Records a session: of a device that is felt, or of a trajectory without any device.
///
/// With --device the real-time host is started as by `haptor run`, and everything it reads and sends goes into the file. With --trajectory the poses of a CSV file
/// are answered offline, the same bytes every time. Either way the file carries its scene and can be computed again: `haptor replay FILE --verify`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: haptor record -o session.haptor tests/scenes/cube-twist.toml --device sim --rt ignore --seconds 5\n\
                        Offline: haptor record -o session.haptor tests/scenes/cube-twist.toml --trajectory tests/scenes/cube-twist.csv"
)]
pub struct Args {
    /// The recording to write
    #[arg(short, value_name = "FILE")]
    output: PathBuf,
    /// Poses to answer offline (CSV, as `haptor eval` reads it)
    #[arg(long, value_name = "CSV", conflicts_with_all = ["device", "rt", "preset", "seconds"])]
    trajectory: Option<PathBuf>,
    #[command(flatten)]
    session: Session,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    match &args.trajectory {
        Some(trajectory) => offline(args, trajectory),
        None => start(&args.session, Some(&args.output)),
    }
}

fn offline(args: &Args, path: &std::path::Path) -> Outcome {
    let (scene, name) = (Scene::load(&args.session.scene)?, args.session.scene.display().to_string());
    let rows = trajectory::load(path)?;
    let work = tempfile::tempdir().map_err(|error| unwritten(&error))?;
    let model = work.path().join("scene.model");
    bake::bake(&scene, &name, &model)?;
    let model = std::fs::read(&model).map_err(|error| unwritten(&error))?;
    // the trajectory's own, unless another is asked for
    let own = rows.first().map_or(crate::config::RATE, |row| (1.0 / row.dt).round() as u32);
    let rate = args.session.rate.unwrap_or(own);
    let file = offline::record(&model, &rows, rate).map_err(|what| Failure::bad_input(format!("{}: {what}", path.display())))?;
    write_file(&args.output, &file)
}

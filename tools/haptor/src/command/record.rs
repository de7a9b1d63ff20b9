//! `haptor record`: a session in a file.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::bake;
use super::run::{Session, start};
use crate::client::{Address, ClientError, Connection, address};
use crate::failure::{Failure, Outcome};
use crate::output::{Output, unwritten, write_file};
use crate::programs;
use crate::scene::Scene;
use crate::session::offline;
use crate::trajectory;

/// Records a session: of a device that is felt, or of a trajectory without any device.
///
/// With --device the real-time host is started as by `haptor run`, and everything it reads and sends goes into the file. With --trajectory the poses of a CSV file
/// are answered offline, the same bytes every time. With the address of a running host (HOST:PORT or unix:PATH) in the scene's place its session is recorded from
/// now on. Either way the file carries its scene and can be computed again: `haptor replay FILE --verify`.
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
    let running = args.session.scene.to_string_lossy().parse::<Address>().ok().filter(|_| !args.session.scene.exists());
    match (&args.trajectory, running) {
        (None, Some(address)) => along(args, &address),
        (Some(trajectory), _) => offline(args, trajectory),
        (None, None) => start(&args.session, Some(&args.output), false),
    }
}

/// Records a session that runs already, from now until its end, Ctrl-C, or the time asked for.
fn along(args: &Args, address: &Address) -> Outcome {
    let failed = |error: ClientError| Failure::problem(error.to_string());
    let token = address::token(args.session.token_file())?;
    let mut host = Connection::open(address, token).map_err(failed)?;
    let interrupted = programs::note_interrupts()?;
    let until = args.session.seconds().map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let mut out = Output::create(Some(&args.output))?;
    host.record(&mut out, || interrupted.load(Ordering::Relaxed) || until.is_some_and(|until| Instant::now() >= until))?;
    out.finish()
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

//! `haptor tell`: asks something of a running host, from a shell or a script.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use haptor_engine::work::budget;
use haptor_wire::{ToViewer, Wish, WorkBudget};

use super::bake::bake;
use crate::client::{Address, ClientError, Connection, Token, address};
use crate::failure::{Failure, Outcome};
use crate::output::{say, unwritten, write_file};
use crate::progress;
use crate::scene::Scene;

/// Attempts to upload a model over a connection that is lost again and again; each goes on where the one before ended.
const UPLOADS: u32 = 5;

/// Asks something of a running host and says what came of it.
///
/// The host lets viewers in when it was started with --viewer. Exit 0 when it was done, 1 when there is no host or it says why not.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor tell 127.0.0.1:21278 stop\n\
                        Another scene: haptor tell 127.0.0.1:21278 scene tests/scenes/mallet.toml\n\
                        Half a million instructions a tick at most: haptor tell 127.0.0.1:21278 budget 500000")]
pub struct Args {
    /// Address of the host: HOST:PORT or unix:PATH
    addr: Address,
    /// File with the host's token; HAPTOR_TOKEN of the environment when not given
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    #[command(subcommand)]
    what: What,
}

/// What a host can be asked for.
#[derive(Debug, clap::Subcommand)]
enum What {
    /// Emergency stop: zero force at once, the device brakes until `rearm`
    Stop,
    /// Back from an emergency stop; forces come back when they are small
    Rearm,
    /// Fade the force to zero and let the core stand
    Freeze,
    /// Let the core go on; forces come back when they are small
    Resume,
    /// Place the device so that the probe stands where the scene starts it; without contact only
    Tare,
    /// Run another scene: baked, uploaded, and taken over behind a faded force
    Scene {
        /// Scene file (TOML)
        scene: PathBuf,
    },
    /// Limit the work of a tick from the next one on, in this scene and in every one after it: tier and samples go down before a tick takes more
    Budget {
        /// auto: what this machine does in 60 % of the period, measured now; off: no limit; scene: what each scene says; or instructions, 10000 to 1000000000
        #[arg(value_name = "scene|auto|off|N", value_parser = budget)]
        budget: WorkBudget,
    },
    /// Fetch the baked file of the scene that runs
    Fetch {
        /// The file to write
        #[arg(short, value_name = "MODEL")]
        output: PathBuf,
    },
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let token = address::token(args.token_file.as_deref())?;
    let mut host = Connection::open(&args.addr, token).map_err(failed)?;
    let wish = match &args.what {
        What::Stop => Wish::EStop,
        What::Rearm => Wish::Rearm,
        What::Freeze => Wish::Freeze(true),
        What::Resume => Wish::Freeze(false),
        What::Tare => Wish::Tare,
        What::Scene { scene } => return activate(&args.addr, token, host, scene),
        What::Budget { budget } => return limit(&mut host, *budget),
        What::Fetch { output } => return write_file(output, &host.download().map_err(failed)?),
    };
    host.request(wish).map_err(failed)
}

/// The host says what a tick may spend before it says that it was done; where no device has answered yet, it says nothing of it.
fn limit(host: &mut Connection, budget: WorkBudget) -> Outcome {
    host.request(Wish::Budget(budget)).map_err(failed)?;
    let mut holds = None;
    while let Some(message) = host.next(Duration::ZERO).map_err(failed)? {
        if let ToViewer::Device(hello) = message {
            holds = Some(hello.work);
        }
    }
    match holds {
        Some(Some(work)) => say(format_args!("a tick may spend {work} instructions")),
        Some(None) => say("the work of a tick has no limit"),
        None => {}
    }
    Ok(())
}

fn activate(address: &Address, token: Token, mut host: Connection, path: &Path) -> Outcome {
    let scene = Scene::load(path)?;
    let work = tempfile::tempdir().map_err(|error| unwritten(&error))?;
    let model = work.path().join("scene.model");
    bake(&scene, &path.display().to_string(), &model)?;
    let file = std::fs::read(&model).map_err(|error| unwritten(&error))?;
    let began = Instant::now();
    let bar = progress::bar(file.len() as u64, "uploading");
    let mut attempts = 1;
    let digest = loop {
        match host.upload(&file, |have, _| bar.set_position(have)) {
            Err(error) if error.is_lost_connection() && attempts < UPLOADS => {
                attempts += 1;
                host = Connection::open(address, token).map_err(failed)?;
            }
            other => break other.map_err(failed)?,
        }
    };
    bar.finish_and_clear();
    host.request(Wish::Activate(digest)).map_err(failed)?;
    say(format_args!("{} bytes uploaded in {:.1} s; scene {digest:016x} runs", file.len(), began.elapsed().as_secs_f64()));
    Ok(())
}

/// What went wrong, as a problem: what was asked was well said.
#[expect(clippy::needless_pass_by_value, reason = "for map_err")]
fn failed(error: ClientError) -> Failure {
    Failure::problem(error.to_string())
}

//! `haptor mesh repair` and `reduce`: a better mesh in a new file, with what was done and how far it is from the old one.

use std::path::PathBuf;

use haptor_mesh::deviation::{Deviation, deviation};
use haptor_mesh::repair::{HOLE_EDGES, MAX_HOLE_EDGES};
use haptor_mesh::{MendSpec, Mended, Mesh, check, mend, reduce as shrink, weld};
use serde_json::{Value, json};

use super::file::{self, File};
use crate::failure::{Failure, Outcome};
use crate::output::say;
use crate::progress;

/// Mends equal corners, doubled and flat triangles, flipped faces and small holes; says what was done, and exits 1 with what could not be
///
/// The new file is in metres, whatever the old one's unit. It is written even where something is left to mend.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor mesh repair scan.obj --unit mm -o scan.stl --triangles 20000")]
pub struct Repair {
    #[command(flatten)]
    file: File,
    /// Mended mesh, in metres; its name's end says the format: .stl, .ply or .obj
    #[arg(short, value_name = "OUT")]
    output: PathBuf,
    /// Closes holes whose rim has up to this many edges, 0 to 1024
    #[arg(long, value_name = "EDGES", default_value_t = HOLE_EDGES as u64, value_parser = clap::value_parser!(u64).range(0..=MAX_HOLE_EDGES as u64))]
    holes: u64,
    /// Then reduces it to this many triangles, 4 to 5000000
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(4..=5_000_000))]
    triangles: Option<u64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Makes a mesh of fewer triangles and says how far its surface is from the old one
///
/// Edges collapse where that costs the surface least, and only where the mesh stays as sound as it was: what is a solid stays one. The
/// deviation is measured both ways between the two surfaces. The new file is in metres, whatever the old one's unit.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor mesh reduce scan.ply --triangles 5000 -o small.stl")]
pub struct Reduce {
    #[command(flatten)]
    file: File,
    /// Most triangles of the new mesh, 4 to 5000000; more than the default make no difference to the hand or the window
    #[arg(long, value_name = "N", default_value_t = shrink::CAPACITY as u64, value_parser = clap::value_parser!(u64).range(4..=5_000_000))]
    triangles: u64,
    /// New mesh, in metres; its name's end says the format: .stl, .ply or .obj
    #[arg(short, value_name = "OUT")]
    output: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Steps of the bar while a mesh is reduced.
const STEPS: u64 = 100;

/// Runs `repair`.
pub fn repair(args: &Repair) -> Outcome {
    file::check_name(&args.output)?;
    // clap keeps it below MAX_HOLE_EDGES
    let spec = MendSpec { hole_edges: args.holes as usize, ..MendSpec::default() };
    let (mut mesh, mended) = mend(&args.file.load()?, &spec);
    if mesh.triangles.is_empty() {
        return Err(args.file.bad("nothing is left of it once equal corners are joined; check the unit"));
    }
    let reduced = args.triangles.map(|triangles| Reduced::of(&mesh, triangles));
    if let Some(reduced) = &reduced {
        mesh.clone_from(&reduced.mesh);
    }
    file::write(&mesh, &args.output)?;
    let undone = mended.undone();
    if args.json {
        let mut value = done_json(&mended);
        value["undone"] = json!(undone);
        value["reduced"] = json!(reduced.as_ref().map(Reduced::json));
        say(format_args!("{value:#}"));
    } else {
        let done = mended.done();
        done.iter().for_each(say);
        if done.is_empty() {
            say("nothing to mend");
        }
        reduced.iter().for_each(|reduced| say(reduced.text()));
    }
    if undone.is_empty() {
        Ok(())
    } else {
        Err(Failure::problem(format!("{}: still wrong: {}", args.output.display(), undone.join("; "))))
    }
}

/// Runs `reduce`.
pub fn reduce(args: &Reduce) -> Outcome {
    file::check_name(&args.output)?;
    let mesh = weld(&args.file.load()?, None);
    let reduced = Reduced::of(&mesh, args.triangles);
    file::write(&reduced.mesh, &args.output)?;
    say(if args.json { format!("{:#}", reduced.json()) } else { reduced.text() });
    // few triangles may be one too few for a thin body
    let problems = check(&reduced.mesh).problems();
    match check(&mesh).is_solid() && !problems.is_empty() {
        true => Err(Failure::problem(format!("{}: {}: allow more triangles", args.output.display(), problems.join("; ")))),
        false => Ok(()),
    }
}

fn done_json(mended: &Mended) -> Value {
    json!({
        "vertices_joined": mended.vertices,
        "triangles_collapsed": mended.collapsed,
        "triangles_doubled": mended.doubled,
        "triangles_turned": mended.turned,
        "holes_closed": mended.holes,
        "triangles_added": mended.added,
        "flat_triangles_mended": mended.swapped,
    })
}

/// A mesh that was reduced, from how many triangles, and how far it is from what it was.
struct Reduced {
    before: usize,
    asked: u64,
    mesh: Mesh,
    deviation: Deviation,
}

impl Reduced {
    fn of(mesh: &Mesh, asked: u64) -> Self {
        let bar = progress::bar(STEPS, "reducing");
        let reduced = shrink::reduce(mesh, asked as usize, &mut |share| bar.set_position((share * STEPS as f64) as u64));
        bar.finish_and_clear();
        let deviation = deviation(mesh, &reduced).unwrap_or_default();
        Self { before: mesh.triangles.len(), asked, mesh: reduced, deviation }
    }

    fn text(&self) -> String {
        let (after, Deviation { max, rms }) = (self.mesh.triangles.len(), self.deviation);
        let short = if after as u64 > self.asked {
            format!(" ({} were asked for; fewer would do harm)", self.asked)
        } else {
            String::new()
        };
        format!("{} to {after} triangles{short}, off by {max:.2e} m at most, {rms:.2e} m in the mean square", self.before)
    }

    fn json(&self) -> Value {
        json!({
            "triangles_before": self.before,
            "triangles": self.mesh.triangles.len(),
            "deviation_max_m": self.deviation.max,
            "deviation_rms_m": self.deviation.rms,
        })
    }
}

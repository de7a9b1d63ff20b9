//! `haptor mesh bake`: a mesh as the core reads it, with the errors that this costs.

use std::path::PathBuf;
use std::time::Instant;

use haptor_mesh::body::{Body, Part, Recipe, Role};
use haptor_mesh::kept::Fetched;
use haptor_mesh::{BakeSpec, properties};
use haptor_wire::sections::{GRID, SECTION_OVERHEAD, encode_section};
use serde_json::{Value, json};

use super::file::File;
use crate::failure::{Failure, Outcome};
use crate::output::{self, say};
use crate::scene::{fetch_body, grid_contents};

/// Bakes a mesh for the core: a distance field and surface samples in progressive order, with the errors they have
///
/// OUT holds what `haptor bake SCENE` puts behind the scene for this mesh, one after the other for each convex part: sections of kind 2 (a mesh), each
/// `kind u32 | n u32 | n bytes | CRC-32`, little endian; the n bytes are f32: first node (3), spacing, nodes along x, y, z; least (3) and largest (3) coordinates,
/// volume, reach, number of samples; a coefficient a node, x fastest; each sample's position (3), normal (3) and area. Metres, in the body's frame: an object stands on the
/// middle of its base, a probe has its mass centre at the origin. What was baked is kept in the cache folder, where scenes find it: by the digest
/// of the file and of these settings.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor mesh bake part.stl --unit mm --role probe -o part.grid")]
pub struct Args {
    #[command(flatten)]
    file: File,
    /// Baked mesh
    #[arg(short, value_name = "OUT")]
    output: PathBuf,
    /// What it is in the scene; a probe with hollows is cut into convex parts
    #[arg(long, value_enum, default_value = "object")]
    role: RoleName,
    /// Cells of the distance field along the longest side, 8 to 120
    #[arg(long, default_value_t = BakeSpec::default().cells)]
    cells: usize,
    /// Surface samples, 1 to 2048
    #[arg(long, default_value_t = BakeSpec::default().samples)]
    samples: usize,
    /// Mend what is usually wrong first, as `haptor mesh repair` does
    #[arg(long)]
    repair: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A role on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum RoleName {
    /// The elastic body
    Object,
    /// The rigid body
    Probe,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let role = match args.role {
        RoleName::Object => Role::Object,
        RoleName::Probe => Role::Probe,
    };
    let bake = BakeSpec { cells: args.cells, samples: args.samples };
    let recipe = Recipe { scale: args.file.scale(), role, mend: args.repair, bake };
    let start = Instant::now();
    let fetched =
        fetch_body(args.file.bytes()?, args.file.extension().as_deref(), &recipe).map_err(|error| args.file.bad(error))?;
    let seconds = start.elapsed().as_secs_f64();
    output::write_file(&args.output, &sections(&fetched.result)?)?;
    say(if args.json { format!("{:#}", json(&fetched, seconds)) } else { text(&fetched, seconds) });
    Ok(())
}

fn sections(body: &Body) -> Result<Vec<u8>, Failure> {
    let mut file = Vec::new();
    for part in &body.parts {
        let (start, contents) = (file.len(), grid_contents(&part.baked));
        file.resize(start + contents.len() + SECTION_OVERHEAD, 0);
        encode_section(GRID, &contents, &mut file[start..]).map_err(Failure::problem)?;
    }
    Ok(file)
}

/// Share by which the volume inside the baked field differs from the mesh's.
fn volume_error(part: &Part) -> f64 {
    let volume = properties(&part.mesh).map_or(f64::NAN, |solid| solid.volume);
    part.baked.field_volume().map_or(f64::NAN, |found| found / volume - 1.0)
}

fn text(fetched: &Fetched<Body>, seconds: f64) -> String {
    let Body { parts, mended, hollow, .. } = &fetched.result;
    let from = if fetched.computed { "baked" } else { "from the cache" };
    let mut lines = vec![format!("{} in {seconds:.2} s, {from}", counted(parts.len(), "part"))];
    lines.extend(mended.iter().map(|line| format!("mended        {line}")));
    lines.push(format!("hollow        {:.2e} m, {:.2} % of the diagonal", hollow.depth, 100.0 * hollow.share));
    for part in parts {
        let baked = &part.baked;
        let [x, y, z] = baked.counts;
        lines.push(format!("grid          {x} x {y} x {z} nodes, {:.3e} m apart", baked.spacing));
        lines.push(format!(
            "  off by      {:.2e} m at most, {:.2e} m in the mean square, at the mesh's own points",
            baked.error.max, baked.error.rms
        ));
        lines.push(format!("  volume      off by {:+.2} %", 100.0 * volume_error(part)));
        lines.push(format!("  samples     {}", baked.samples.len()));
    }
    lines.join("\n")
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn json(fetched: &Fetched<Body>, seconds: f64) -> Value {
    let part = |part: &Part| {
        json!({
            "nodes": part.baked.counts,
            "spacing_m": part.baked.spacing,
            "distance_error_max_m": part.baked.error.max,
            "distance_error_rms_m": part.baked.error.rms,
            "volume_error": volume_error(part),
            "samples": part.baked.samples.len(),
            "triangles": part.mesh.triangles.len(),
            "position_m": part.position.to_array(),
        })
    };
    let Body { parts, hollow, mended, .. } = &fetched.result;
    json!({
        "parts": parts.iter().map(part).collect::<Vec<_>>(),
        "hollow_depth_m": hollow.depth,
        "hollow_share": hollow.share,
        "mended": mended,
        "from_cache": !fetched.computed,
        "seconds": seconds,
    })
}

//! `haptor bake`: everything the host needs in one file.

use std::path::{Path, PathBuf};

use haptor_mesh::Mesh;
use haptor_wire::FrameError;
use haptor_wire::scene::{FILE_MAX, encode_file};
use haptor_wire::sections::{GREEN, GRID, SECTION_OVERHEAD, SKIN, encode_section};

use crate::failure::{Failure, Outcome};
use crate::output;
use crate::scene::Scene;
use crate::skins;
use crate::table;

/// Bakes a scene: everything the host needs in one file.
///
/// The device is placed so that its origin puts the probe 5 mm above the middle of the object's top. Of the scene's [guard] limits
/// and the device's own the lower ones hold; a limit that the scene leaves out is the device's. For tier green the body's own table
/// is computed, or taken from the cache folder, and goes into the file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor bake tests/scenes/cube-twist.toml -o cube-twist.model")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Baked file
    #[arg(short, value_name = "MODEL")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let scene = Scene::load(&args.scene)?;
    bake(&scene, &args.scene.display().to_string(), &args.output)
}

/// The mesh to look at; one that is too large to be carried is told and left empty.
fn looks(mesh: &Mesh, name: &str) -> Vec<u8> {
    skins::contents(mesh).unwrap_or_else(|| {
        eprintln!(
            "haptor: note: {name}: a mesh of {} triangles is too large to be carried for viewers; reduce it",
            mesh.triangles.len()
        );
        Vec::new()
    })
}

/// Bakes a scene called `name` in messages into a file.
///
/// # Errors
/// [`Failure::BadInput`] when the host cannot run the scene or the file cannot be written.
pub fn bake(scene: &Scene, name: &str, path: &Path) -> Outcome {
    let baked = scene.bake().map_err(|what| Failure::bad_input(format!("{name}: {what}")))?;
    let problem = |error: FrameError| Failure::problem(format!("{name}: {error}"));
    let mut file = vec![0; FILE_MAX];
    let length = encode_file(&baked, &mut file).map_err(problem)?;
    file.truncate(length);
    let mut append = |kind, contents: &[u8]| {
        let start = file.len();
        file.resize(start + contents.len() + SECTION_OVERHEAD, 0);
        encode_section(kind, contents, &mut file[start..]).map_err(problem)
    };
    if let Some(table) = table::of(scene, scene.params.tier, name)? {
        append(GREEN, &table::contents(&table.spec()))?;
    }
    for skin in scene.skins() {
        append(GRID, &skin.contents())?;
    }
    for skin in scene.skins() {
        append(SKIN, &looks(&skin.mesh, name))?;
    }
    output::write_file(path, &file)
}

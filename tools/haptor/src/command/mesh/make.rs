//! `haptor mesh make`: simple solids to try meshes with, and the models that the ready scenes use.

use std::path::PathBuf;

use haptor_mesh::models::Model;
use haptor_mesh::{DVec3, Mesh, tessellate};

use super::file;
use crate::failure::{Failure, Outcome};

/// Writes a simple solid or a ready model as a mesh, in metres: to try meshes with, and to compare them with the shape
///
/// Simple solids lie about their mass centre. The models are the ones in `tests/meshes`: a mallet and a compass to hold, an organ to press.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: haptor mesh make ellipsoid 0.05,0.05,0.03 -o stone.stl\n         haptor mesh make organ -o organ.ply"
)]
pub struct Args {
    /// Which solid
    shape: Solid,
    /// Its sizes [m]: sphere R; box X,Y,Z; ellipsoid semi-axes A,B,C; cylinder, cone and capsule R,H; the models take none
    #[arg(value_delimiter = ',')]
    sizes: Vec<f64>,
    /// Corners around a round solid, 8 to 1024
    #[arg(long, default_value_t = 128, value_parser = clap::value_parser!(u32).range(8..=1024))]
    sides: u32,
    /// Mesh file; its name's end says the format: .stl, .ply or .obj
    #[arg(short, value_name = "OUT")]
    output: PathBuf,
}

/// A solid on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Solid {
    /// Radius
    Sphere,
    /// Edges
    Box,
    /// Semi-axes
    Ellipsoid,
    /// Radius, height
    Cylinder,
    /// Radius, height; tip down
    Cone,
    /// Radius, height of the straight part
    Capsule,
    /// A barrel on its side with a handle
    Mallet,
    /// Two legs with round tips
    Compass,
    /// A smooth convex body without symmetry
    Organ,
}

/// Sizes a solid may have \[m\]: those of a scene.
const SIZES: std::ops::RangeInclusive<f64> = 1.0e-6..=1.0e2;

impl Args {
    fn mesh(&self) -> Result<Mesh, Failure> {
        if let Some(size) = self.sizes.iter().find(|size| !SIZES.contains(size)) {
            return Err(Failure::bad_input(format!("size {size}: allowed is 1e-6 to 1e2 m")));
        }
        let sides = self.sides;
        Ok(match (self.shape, self.sizes.as_slice()) {
            (Solid::Sphere, &[r]) => tessellate::ellipsoid(DVec3::splat(r), sides),
            (Solid::Box, &[x, y, z]) => tessellate::cuboid(DVec3::new(x, y, z)),
            (Solid::Ellipsoid, &[a, b, c]) => tessellate::ellipsoid(DVec3::new(a, b, c), sides),
            (Solid::Cylinder, &[r, h]) => tessellate::cylinder(r, h, sides),
            (Solid::Cone, &[r, h]) => tessellate::cone(r, h, sides),
            (Solid::Capsule, &[r, h]) => tessellate::capsule(r, h, sides),
            (Solid::Mallet, []) => Model::Mallet.mesh(),
            (Solid::Compass, []) => Model::Compass.mesh(),
            (Solid::Organ, []) => Model::Organ.mesh(),
            (solid, sizes) => {
                let count = match solid {
                    Solid::Sphere => "one, its radius",
                    Solid::Box => "three, its edges",
                    Solid::Ellipsoid => "three, its semi-axes",
                    Solid::Cylinder | Solid::Cone | Solid::Capsule => "two, its radius and height",
                    Solid::Mallet | Solid::Compass | Solid::Organ => "none, it has its own",
                };
                return Err(Failure::bad_input(
                    format!("{} sizes: a {solid:?} takes {count}, parted by commas", sizes.len()).to_lowercase(),
                ));
            }
        })
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    file::write(&args.mesh()?, &args.output)
}

//! `haptor mesh`: what a mesh file holds, whether it is the skin of a solid, and meshes of simple solids.

use std::path::PathBuf;

use haptor_mesh::{DVec3, Findings, Mesh, Properties, check, load_mesh, properties, tessellate, weld, write_stl};

use crate::failure::{Failure, Outcome};
use crate::output::{self, say, unwritten};

/// Looks into mesh files (STL) and makes them.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor mesh check part.stl --scale 0.001")]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Prints size, volume, mass centre, inertia and what is wrong; exit 2 when unreadable
    #[command(after_help = "Example: haptor mesh info part.stl --scale 0.001 --json")]
    Info(File),
    /// Tells whether the mesh is the skin of a solid: exit 0 when it is, 1 with what is wrong when not, 2 when unreadable
    #[command(after_help = "Example: haptor mesh check part.stl --scale 0.001")]
    Check(File),
    /// Writes a simple solid as a mesh, in metres, about its mass centre: to try meshes with, and to compare them with the shape
    #[command(after_help = "Example: haptor mesh make ellipsoid 0.05,0.05,0.03 -o stone.stl")]
    Make(Make),
}

#[derive(Debug, clap::Args)]
struct Make {
    /// Which solid
    shape: Solid,
    /// Its sizes [m]: sphere R; box X,Y,Z; ellipsoid semi-axes A,B,C; cylinder, cone and capsule R,H
    #[arg(value_delimiter = ',', required = true)]
    sizes: Vec<f64>,
    /// Corners around a round solid, 8 to 1024
    #[arg(long, default_value_t = 128, value_parser = clap::value_parser!(u32).range(8..=1024))]
    sides: u32,
    /// Mesh file (binary STL)
    #[arg(short, value_name = "FILE.stl")]
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
}

/// Sizes a solid may have \[m\]: those of a scene.
const SIZES: std::ops::RangeInclusive<f64> = 1.0e-6..=1.0e2;

impl Make {
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
            (solid, sizes) => {
                let count = match solid {
                    Solid::Sphere => "one, its radius",
                    Solid::Box => "three, its edges",
                    Solid::Ellipsoid => "three, its semi-axes",
                    Solid::Cylinder | Solid::Cone | Solid::Capsule => "two, its radius and height",
                };
                return Err(Failure::bad_input(
                    format!("{} sizes: a {solid:?} takes {count}, parted by commas", sizes.len()).to_lowercase(),
                ));
            }
        })
    }
}

#[derive(Debug, clap::Args)]
struct File {
    /// Mesh file (STL, OBJ or PLY)
    file: PathBuf,
    /// Takes the file's unit to metres: 0.001 for millimetres
    #[arg(long, default_value_t = 1.0)]
    scale: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A mesh and what is known about it.
struct Examined {
    mesh: Mesh,
    findings: Findings,
    properties: Option<Properties>,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    match &args.action {
        Action::Info(file) => {
            let examined = examine(file)?;
            let text = if file.json { examined.json() } else { examined.text() };
            say(text.trim_end());
            Ok(())
        }
        Action::Check(file) => {
            let examined = examine(file)?;
            let problems = examined.findings.problems();
            if file.json {
                say(examined.json().trim_end());
            }
            if problems.is_empty() {
                if !file.json {
                    say(format_args!("{}: a solid", file.file.display()));
                }
                return Ok(());
            }
            Err(Failure::problem(format!("{}: {}", file.file.display(), problems.join("; "))))
        }
        Action::Make(make) => {
            let mut file = Vec::new();
            write_stl(&make.mesh()?, &mut file).map_err(|error| unwritten(&error))?;
            output::write_file(&make.output, &file)
        }
    }
}

fn examine(file: &File) -> Result<Examined, Failure> {
    let loaded =
        load_mesh(&file.file, file.scale).map_err(|error| Failure::bad_input(format!("{}: {error}", file.file.display())))?;
    let mesh = weld(&loaded, None);
    let (findings, properties) = (check(&mesh), properties(&mesh));
    Ok(Examined { mesh, findings, properties })
}

impl Examined {
    fn text(&self) -> String {
        let size = self.mesh.bounds().map(|(low, high)| high - low).unwrap_or_default();
        let mut lines = vec![
            format!("vertices      {}", self.mesh.vertices.len()),
            format!("triangles     {}", self.mesh.triangles.len()),
            format!("pieces        {}", self.findings.pieces),
            format!("size          {} x {} x {} m", size.x, size.y, size.z),
            format!("area          {} m^2", self.mesh.area()),
        ];
        if let Some(p) = &self.properties {
            lines.push(format!("volume        {} m^3", p.volume));
            lines.push(format!("mass centre   {} {} {} m", p.centre.x, p.centre.y, p.centre.z));
            lines.push("inertia about the mass centre at 1 kg/m^3 [kg m^2]".to_owned());
            let rows = p.inertia.transpose();
            lines.extend(
                [rows.x_axis, rows.y_axis, rows.z_axis]
                    .map(|row| format!("  {:>12.5e} {:>12.5e} {:>12.5e}", row.x, row.y, row.z)),
            );
        }
        let problems = self.findings.problems();
        lines.push(format!("solid         {}", if problems.is_empty() { "yes" } else { "no" }));
        lines.extend(problems.iter().map(|problem| format!("  {problem}")));
        lines.join("\n") + "\n"
    }

    fn json(&self) -> String {
        let (p, f) = (self.properties, self.findings);
        let rows = p.map(|p| p.inertia.transpose().to_cols_array_2d());
        let value = serde_json::json!({
            "vertices": self.mesh.vertices.len(),
            "triangles": self.mesh.triangles.len(),
            "pieces": f.pieces,
            "area_m2": self.mesh.area(),
            "volume_m3": p.map(|p| p.volume),
            "mass_centre_m": p.map(|p| p.centre.to_array()),
            "inertia_kg_m2_at_1_kg_per_m3": rows,
            "solid": f.is_solid(),
            "problems": f.problems(),
        });
        format!("{value:#}\n")
    }
}

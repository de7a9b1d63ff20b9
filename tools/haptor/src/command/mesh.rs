//! `haptor mesh`: what a mesh file holds and whether it is the skin of a solid.

use std::path::PathBuf;

use haptor_mesh::{Findings, Mesh, Properties, check, load_stl, properties, weld};

use crate::failure::{Failure, Outcome};
use crate::output::say;

/// Looks into mesh files (STL).
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
}

#[derive(Debug, clap::Args)]
struct File {
    /// Mesh file (STL, ASCII or binary)
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
    }
}

fn examine(file: &File) -> Result<Examined, Failure> {
    let loaded =
        load_stl(&file.file, file.scale).map_err(|error| Failure::bad_input(format!("{}: {error}", file.file.display())))?;
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

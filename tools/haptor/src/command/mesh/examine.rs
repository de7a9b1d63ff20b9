//! `haptor mesh info` and `check`: everything that is known about a mesh, and whether a scene can use it.

use haptor_mesh::body::unit_hint;
use haptor_mesh::convex::{CONVEX, Hollow, hollow};
use haptor_mesh::{Crossings, Findings, Mesh, Properties, check as find, crossings, properties, reduce, weld};
use serde_json::json;

use super::file::File;
use crate::failure::{Failure, Outcome};
use crate::output::say;

/// Prints size, volume, mass centre, inertia, how far it is from convex and what is wrong; exit 2 when unreadable
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor mesh info part.stl --unit mm --json")]
pub struct Info {
    #[command(flatten)]
    file: File,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Tells whether the mesh is the skin of a solid: exit 0 when it is, 1 with what is wrong when not, 2 when unreadable
///
/// What a scene bears but a user should know is a warning on standard error: hollows (an elastic object is taken as convex), triangles that cross,
/// several pieces, a size that looks like another unit, more triangles than are of use.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor mesh check part.stl --unit mm --require-convex 0.01")]
pub struct Check {
    #[command(flatten)]
    file: File,
    /// Hollows deeper than this share of the diagonal are a problem (exit 1) [default without a value: 0.002]
    #[arg(long, value_name = "SHARE", num_args = 0..=1, default_missing_value = "0.002")]
    require_convex: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs `info`.
pub fn info(args: &Info) -> Outcome {
    let examined = Examined::of(&args.file)?;
    say(if args.json { examined.json(&examined.problems(None)) } else { examined.text() }.trim_end());
    Ok(())
}

/// Runs `check`.
pub fn check(args: &Check) -> Outcome {
    if let Some(share) = args.require_convex.filter(|share| !(0.0..=1.0).contains(share)) {
        return Err(Failure::bad_input(format!("--require-convex {share}: allowed is 0 to 1, a share of the diagonal")));
    }
    let examined = Examined::of(&args.file)?;
    let problems = examined.problems(args.require_convex);
    let name = args.file.name();
    if args.json {
        say(examined.json(&problems).trim_end());
    } else {
        examined.warnings.iter().for_each(|warning| eprintln!("haptor: note: {name}: {warning}"));
    }
    match problems.as_slice() {
        [] if args.json => Ok(()),
        [] => {
            say(format_args!("{name}: a solid"));
            Ok(())
        }
        problems => Err(Failure::problem(format!("{name}: {}", problems.join("; ")))),
    }
}

/// A mesh and what is known about it.
struct Examined {
    scale: f64,
    mesh: Mesh,
    findings: Findings,
    properties: Option<Properties>,
    hollow: Option<Hollow>,
    crossings: Crossings,
    warnings: Vec<String>,
}

impl Examined {
    fn of(file: &File) -> Result<Self, Failure> {
        let mesh = weld(&file.load()?, None);
        let (findings, properties) = (find(&mesh), properties(&mesh));
        let (hollow, crossings) = (hollow(&mesh), crossings(&mesh));
        let mut examined = Self { scale: file.scale(), mesh, findings, properties, hollow, crossings, warnings: Vec::new() };
        examined.warnings = examined.warnings();
        Ok(examined)
    }

    fn size(&self) -> haptor_mesh::DVec3 {
        self.mesh.bounds().map(|(low, high)| high - low).unwrap_or_default()
    }

    fn warnings(&self) -> Vec<String> {
        let hollow = self.hollow.filter(|hollow| !hollow.is_convex()).map(|hollow| {
            format!(
                "is not convex: its surface lies up to {:.2e} m, {:.1} % of its diagonal, under its hull; an elastic object is felt as if each part of the \
                 probe touched it once, a probe is cut into convex parts",
                hollow.depth,
                100.0 * hollow.share
            )
        });
        let Crossings { pairs, complete } = self.crossings;
        let crossing =
            (pairs > 0).then(|| format!("has {} of triangles that cross: it runs through itself", counted(pairs, complete)));
        let pieces = (self.findings.pieces > 1)
            .then(|| format!("has {} pieces that do not touch; they are taken as one rigid body", self.findings.pieces));
        let triangles = self.mesh.triangles.len();
        let many = (triangles > reduce::CAPACITY).then(|| {
            let most = reduce::CAPACITY;
            format!(
                "has {triangles} triangles, more than {most} make no difference to the hand: haptor mesh reduce --triangles {most}"
            )
        });
        [unit_hint(self.size(), self.scale), pieces, hollow, crossing, many].into_iter().flatten().collect()
    }

    fn problems(&self, require_convex: Option<f64>) -> Vec<String> {
        let share = self.hollow.map_or(0.0, |hollow| hollow.share);
        let hollow = require_convex.filter(|&most| share > most).map(|most| {
            format!(
                "hollows of {:.2} % of the diagonal, allowed is up to {:.2} %: take the convex parts apart or fill them",
                100.0 * share,
                100.0 * most
            )
        });
        let volume = self.properties.is_none().then(|| "it encloses no volume".to_owned());
        self.findings.problems().into_iter().chain(volume).chain(hollow).collect()
    }

    fn text(&self) -> String {
        let (size, f) = (self.size(), self.findings);
        let yes = |yes: bool| if yes { "yes" } else { "no" };
        let mut lines = vec![
            format!("vertices      {}", self.mesh.vertices.len()),
            format!("triangles     {}", self.mesh.triangles.len()),
            format!("pieces        {}", f.pieces),
            format!("size          {} x {} x {} m (1 in the file is {} m)", size.x, size.y, size.z, self.scale),
            format!("area          {} m^2", self.mesh.area()),
            format!("watertight    {}", yes(f.boundary_edges == 0)),
            format!("manifold      {}", yes(f.non_manifold_edges == 0)),
            format!("oriented      {}", yes(f.flipped_edges == 0 && f.inside_out == 0)),
            format!("crossings     {}", counted(self.crossings.pairs, self.crossings.complete)),
        ];
        if let Some(Hollow { depth, share }) = self.hollow {
            let share = 100.0 * share;
            lines.push(format!(
                "convex        {} (deepest hollow {depth:.2e} m, {share:.2} % of the diagonal)",
                yes(share <= 100.0 * CONVEX)
            ));
        }
        lines.extend(self.mass_lines());
        let problems = self.problems(None);
        lines.push(format!("solid         {}", yes(problems.is_empty())));
        lines.extend(problems.iter().chain(&self.warnings).map(|line| format!("  {line}")));
        lines.join("\n") + "\n"
    }

    fn mass_lines(&self) -> Vec<String> {
        let Some(p) = &self.properties else { return Vec::new() };
        let mut lines = vec![
            format!("volume        {} m^3", p.volume),
            format!("mass centre   {} {} {} m", p.centre.x, p.centre.y, p.centre.z),
            "inertia about the mass centre at 1 kg/m^3 [kg m^2]".to_owned(),
        ];
        let rows = p.inertia.transpose();
        let row = |row: haptor_mesh::DVec3| format!("  {:>12.5e} {:>12.5e} {:>12.5e}", row.x, row.y, row.z);
        lines.extend([rows.x_axis, rows.y_axis, rows.z_axis].map(row));
        lines
    }

    fn json(&self, problems: &[String]) -> String {
        let (p, f) = (self.properties, self.findings);
        let rows = p.map(|p| p.inertia.transpose().to_cols_array_2d());
        let value = json!({
            "vertices": self.mesh.vertices.len(),
            "triangles": self.mesh.triangles.len(),
            "pieces": f.pieces,
            "size_m": self.size().to_array(),
            "scale": self.scale,
            "area_m2": self.mesh.area(),
            "boundary_edges": f.boundary_edges,
            "non_manifold_edges": f.non_manifold_edges,
            "flipped_edges": f.flipped_edges,
            "flat_triangles": f.slivers,
            "pieces_inside_out": f.inside_out,
            "crossing_pairs": self.crossings.pairs,
            "crossing_pairs_all_asked": self.crossings.complete,
            "hollow_depth_m": self.hollow.map(|hollow| hollow.depth),
            "hollow_share": self.hollow.map(|hollow| hollow.share),
            "volume_m3": p.map(|p| p.volume),
            "mass_centre_m": p.map(|p| p.centre.to_array()),
            "inertia_kg_m2_at_1_kg_per_m3": rows,
            "solid": self.problems(None).is_empty(),
            "problems": problems,
            "warnings": self.warnings,
        });
        format!("{value:#}\n")
    }
}

fn counted(pairs: usize, complete: bool) -> String {
    format!("{}{pairs} pairs", if complete { "" } else { "at least " })
}

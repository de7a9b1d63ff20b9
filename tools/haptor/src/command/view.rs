//! `haptor view`: one picture of a scene, drawn without a display.

use std::path::{Path, PathBuf};

use haptor_viewer::{DQuat, DVec3, MAX_SIDE, MIN_SIDE, Mesh, Pose, Region, Shot, Surface, draw};
use haptor_wire::{BakedScene, Deformation};

use crate::failure::{Failure, Outcome};
use crate::output;
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::surface;
use crate::trajectory::{self, Row};

/// Draws a picture of a scene: object, deformed and coloured by how far its surface moved; probe, contact regions (blue stick, orange
/// slip), force (red) and torque (violet), with a legend.
///
/// Without a trajectory the probe hovers 5 mm above the object; with one it is where the trajectory has it at the first row with
/// t >= T_S, after all ticks up to there have been computed.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor view --shot twist.png --scene tests/scenes/cube-twist.toml \
                        --trajectory tests/scenes/cube-twist.csv --at 1.2")]
pub struct Args {
    /// Address of a running host to look at (the window is not in this build)
    addr: Option<String>,
    /// Picture to draw (PNG)
    #[arg(long, value_name = "FILE.png", requires = "scene")]
    shot: Option<PathBuf>,
    /// Scene file (TOML)
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Trajectory file (CSV)
    #[arg(long, value_name = "CSV", requires = "shot")]
    trajectory: Option<PathBuf>,
    /// Time of the picture [s]; the trajectory's end when not given
    #[arg(long, value_name = "T_S", requires = "trajectory")]
    at: Option<f64>,
    /// Width and height [pixels]
    #[arg(long, value_name = "WxH", default_value = "960x720", value_parser = size)]
    size: (u32, u32),
}

/// Room above a force drawn at its full length.
const FORCE_ROOM: f64 = 1.1;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let (Some(shot), Some(scene)) = (&args.shot, &args.scene) else {
        return Err(Failure::bad_input("the window is not in this build; draw a picture with --shot FILE.png --scene SCENE"));
    };
    if args.addr.is_some() {
        return Err(Failure::bad_input("give an address or --shot, not both"));
    }
    let name = scene.display().to_string();
    let scene = Scene::load(scene)?;
    let baked = scene.bake().map_err(|what| Failure::bad_input(format!("{name}: {what}")))?;
    let moment = match &args.trajectory {
        Some(path) => moment(&scene, path, args.at)?,
        None => Moment::at_rest(&baked),
    };
    let skins: Vec<Mesh> = scene.skins().map(|skin| skin.mesh.clone()).collect();
    let image = draw(&moment.shot(&baked, &skins, args.size));
    let png = image.png().map_err(|error| Failure::problem(format!("the picture cannot be encoded: {error}")))?;
    output::write_file(shot, &png)
}

/// What the picture shows beside the bodies.
#[derive(Debug, Default)]
struct Moment {
    position: DVec3,
    rotation: DQuat,
    force: DVec3,
    torque: DVec3,
    /// Largest force up to now \[N\].
    peak_force: f64,
    /// Largest torque up to now \[N m\].
    peak_torque: f64,
    regions: Vec<Region>,
    surface: Option<Surface>,
}

impl Moment {
    /// The probe where a session starts.
    fn at_rest(baked: &BakedScene) -> Self {
        Self { position: DVec3::from_array(baked.place.p_wd.map(f64::from)), ..Self::default() }
    }

    fn shot<'a>(&self, scene: &'a BakedScene, skins: &'a [Mesh], size: (u32, u32)) -> Shot<'a> {
        Shot {
            scene,
            skins,
            pose: Pose { position: self.position, rotation: self.rotation },
            force: self.force,
            torque: self.torque,
            // nothing felt yet: any scale draws nothing
            force_scale: if self.peak_force > 0.0 { FORCE_ROOM * self.peak_force } else { 1.0 },
            torque_scale: if self.peak_torque > 0.0 { 1.5 * self.peak_torque } else { 1.0 },
            regions: self.regions.clone(),
            surface: self.surface.clone(),
            size,
        }
    }
}

/// Runs the trajectory up to the time asked for.
fn moment(scene: &Scene, path: &Path, at: Option<f64>) -> Result<Moment, Failure> {
    let rows = trajectory::load(path)?;
    let last = match at {
        Some(at) => rows.iter().position(|row| row.t >= at).ok_or_else(|| {
            let end = &rows[rows.len() - 1].written_t;
            Failure::bad_input(format!("--at {at}: {} ends at {end} s", path.display()))
        })?,
        None => rows.len() - 1,
    };
    let params = scene.contact_only();
    let mut simulation = Simulation::new(scene, &params).map_err(Failure::bad_input)?;
    let mut moment = Moment::default();
    rows[..=last].iter().for_each(|row| moment.advance(&mut simulation, row));
    moment.regions = simulation.patches().map(region).collect();
    let amount = scene.extras.deformation;
    if amount != Deformation::None {
        moment.surface = Some(deformed(&simulation, &rows[last], amount == Deformation::Full));
    }
    Ok(moment)
}

impl Moment {
    fn advance(&mut self, simulation: &mut Simulation<'_>, row: &Row) {
        let wrench = simulation.tick(row).contact;
        let probe = simulation.probe(row);
        (self.position, self.rotation) = (wide(probe.position), probe.rotation.as_dquat());
        (self.force, self.torque) = (wide(wrench.force), wide(wrench.torque));
        self.peak_force = self.peak_force.max(self.force.length());
        self.peak_torque = self.peak_torque.max(self.torque.length());
    }
}

fn deformed(simulation: &Simulation<'_>, row: &Row, body: bool) -> Surface {
    let (mut mesh, displacement) = surface::deformed(&simulation.surface(row, body), simulation.skin());
    let moved = displacement.iter().map(|&u| wide(u)).collect::<Vec<_>>();
    mesh.vertices.iter_mut().zip(&moved).for_each(|(vertex, moved)| *vertex += *moved);
    Surface { mesh, moved: moved.iter().map(|u| u.length()).collect() }
}

fn region(patch: haptor_contact::PatchReport) -> Region {
    Region { centre: wide(patch.centre), normal: wide(patch.normal), radius: patch.radius.into(), stick: patch.stick.into() }
}

fn wide(v: haptor_contact::Vec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(f64::from))
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let allowed = || format!("allowed is WIDTHxHEIGHT, each {MIN_SIDE} to {MAX_SIDE}, e.g. 960x720");
    let (width, height) = text.split_once('x').ok_or_else(allowed)?;
    let side = |text: &str| text.parse().ok().filter(|side| (MIN_SIDE..=MAX_SIDE).contains(side)).ok_or_else(allowed);
    Ok((side(width)?, side(height)?))
}

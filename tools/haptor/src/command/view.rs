//! `haptor view`: the window on a running host, the same in lines of text, and one picture of a scene drawn without a display.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use haptor_viewer::feed::{Displacement, Frame, Mode, Pose, Region, Stage, Wrench};
use haptor_viewer::picture::{ColourBy, Settings};
use haptor_viewer::{DVec3, MAX_SIDE, MIN_SIDE, Mesh, Shot, Vec3, View, draw};
use haptor_wire::{BakedScene, Deformation};

use super::watch::watch;
use crate::client::Address;
use crate::client::{Viewer, address};
use crate::failure::{Failure, Outcome};
use crate::looks::live::Live;
use crate::output;
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::surface;
use crate::trajectory::{self, Row};
use crate::window;

/// Shows a running host in a window: the deforming object, the probe, what is felt, plots, and the keys and buttons to steer it.
///
/// With --shot draws a picture of a scene instead, without a display: object, deformed and coloured by how far its surface moved or by the pressure on it; probe, contact regions
/// (blue core that sticks, orange ring that slips), force (red) and torque (violet), with a legend.
///
/// Without a trajectory the probe hovers 5 mm above the object; with one it is where the trajectory has it at the first row with
/// t >= T_S, after all ticks up to there have been computed.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor view --shot twist.png --scene tests/scenes/cube-twist.toml \
                        --trajectory tests/scenes/cube-twist.csv --at 1.2")]
pub struct Args {
    /// Address of a running host that lets viewers in (started with --viewer), HOST:PORT or unix:PATH [default: 127.0.0.1:21278]
    addr: Option<Address>,
    /// Follow the host in lines of text, two a second, instead of in the window
    #[arg(long, conflicts_with = "shot")]
    text: bool,
    /// How long to follow it [s]; until its session ends when not given
    #[arg(long, requires = "text", value_parser = super::run::seconds)]
    seconds: Option<f64>,
    /// File with the host's token; HAPTOR_TOKEN of the environment when not given
    #[arg(long, value_name = "FILE", conflicts_with = "shot")]
    token_file: Option<PathBuf>,
    /// Title of the window; the address when not given
    #[arg(long, conflicts_with_all = ["shot", "text"])]
    title: Option<String>,
    /// How long to wait for a host that is about to start [s]
    #[arg(long, value_name = "S", default_value = "0", conflicts_with_all = ["shot", "text"], value_parser = clap::value_parser!(u64).range(0..=600))]
    wait: u64,
    /// Picture to draw (PNG)
    #[arg(long, value_name = "FILE.png", requires = "scene", conflicts_with = "addr")]
    shot: Option<PathBuf>,
    /// Scene file (TOML)
    #[arg(long, requires = "shot")]
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
    /// What the object's colours say: displacement, pressure or none
    #[arg(long, value_name = "WHAT", default_value = "displacement", value_parser = colour)]
    colour: ColourBy,
    /// Where the eye stands: degrees to the right of the front, degrees above the level, and m from the scene's middle (fitted when left out)
    #[arg(long, value_name = "AZ,EL[,DIST]", allow_hyphen_values = true, value_parser = orbit)]
    orbit: Option<View>,
}

/// Time between two attempts to connect to a host that is about to start.
const TRY_EVERY: Duration = Duration::from_millis(100);

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    if args.text {
        return watch(&args.addr.clone().unwrap_or_default(), args.token_file.as_deref(), args.seconds);
    }
    match (&args.shot, &args.scene) {
        (Some(shot), Some(scene)) => picture(args, shot, scene),
        _ => look(args),
    }
}

/// The window on a running host.
fn look(args: &Args) -> Outcome {
    window::check()?;
    let (address, token) = (args.addr.clone().unwrap_or_default(), address::token(args.token_file.as_deref())?);
    let until = Instant::now() + Duration::from_secs(args.wait);
    let viewer = loop {
        match Viewer::connect(address.clone(), token) {
            Ok(viewer) => break viewer,
            Err(error) if !error.is_lost_connection() || Instant::now() >= until => {
                return Err(Failure::problem(error));
            }
            Err(_) => thread::sleep(TRY_EVERY),
        }
    };
    let name = args.title.clone().unwrap_or_else(|| address.to_string());
    let source = Live::new(viewer, name.clone()).map_err(anyhow::Error::from)?;
    window::show(Box::new(source), &name)
}

/// One picture.
fn picture(args: &Args, shot: &Path, scene: &Path) -> Outcome {
    let name = scene.display().to_string();
    let scene = Scene::load(scene)?;
    let baked = scene.bake().map_err(|what| Failure::bad_input(format!("{name}: {what}")))?;
    let moment = match &args.trajectory {
        Some(path) => moment(&scene, path, args.at)?,
        None => Moment::at_rest(&baked),
    };
    let skins: Vec<Mesh> = scene.skins().map(|skin| skin.mesh.clone()).collect();
    let image = draw(&Shot {
        stage: Arc::new(moment.stage(haptor_viewer::stage(&baked, &skins))),
        frame: moment.frame,
        settings: Settings { colour_by: args.colour, ..Settings::default() },
        view: args.orbit.unwrap_or_default(),
        size: args.size,
    });
    let png = image.png().map_err(|error| Failure::problem(format!("the picture cannot be encoded: {error}")))?;
    output::write_file(shot, &png)
}

/// What the picture shows beside the bodies.
#[derive(Debug, Default)]
struct Moment {
    frame: Frame,
    /// Largest force up to now \[N\].
    peak_force: f64,
    /// Largest torque up to now \[N m\].
    peak_torque: f64,
    /// The object at rest, finer near the contacts, when it is deformed.
    object: Option<Mesh>,
}

impl Moment {
    /// The probe where a session starts.
    fn at_rest(baked: &BakedScene) -> Self {
        let probe = Pose { position: DVec3::from_array(baked.place.p_wd.map(f64::from)), ..Pose::default() };
        Self { frame: Frame { probe, ..Frame::default() }, ..Self::default() }
    }

    /// The stage with the object in the triangles of this moment.
    fn stage(&self, stage: Stage) -> Stage {
        let object = self.object.clone().unwrap_or_else(|| stage.object.clone());
        Stage { object, force_scale: self.peak_force, torque_scale: self.peak_torque, ..stage }
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
    moment.frame.regions = simulation.patches().map(region).collect();
    let amount = scene.extras.deformation;
    if amount != Deformation::None {
        moment.deform(&simulation, &rows[last], amount == Deformation::Full);
    }
    Ok(moment)
}

impl Moment {
    fn advance(&mut self, simulation: &mut Simulation<'_>, row: &Row) {
        let output = simulation.tick(row);
        let probe = simulation.probe(row);
        let (force, torque) = (wide(output.contact.force), wide(output.contact.torque));
        self.peak_force = self.peak_force.max(force.length());
        self.peak_torque = self.peak_torque.max(torque.length());
        self.frame.time = row.t;
        self.frame.probe = Pose { position: wide(probe.position), rotation: probe.rotation.as_dquat() };
        self.frame.contact = Wrench { force, torque };
        self.frame.depth = output.report.depth.into();
        self.frame.mode = Mode::Running;
    }

    fn deform(&mut self, simulation: &Simulation<'_>, row: &Row, body: bool) {
        let (object, moved) = surface::deformed(&simulation.surface(row, body), simulation.skin());
        self.frame.displacement = Some(Displacement { tick: self.frame.tick, moved: moved.into() });
        self.object = Some(object);
    }
}

fn region(patch: haptor_contact::PatchReport) -> Region {
    let radius = f64::from(patch.radius);
    Region {
        centre: wide(patch.centre),
        normal: wide(patch.normal),
        radius,
        stick_radius: Region::core(radius, patch.stick.into()),
        force: wide(patch.force),
        torque: wide(patch.torque),
        pressure: None,
    }
}

fn wide(v: Vec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(f64::from))
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let allowed = || format!("allowed is WIDTHxHEIGHT, each {MIN_SIDE} to {MAX_SIDE}, e.g. 960x720");
    let (width, height) = text.split_once('x').ok_or_else(allowed)?;
    let side = |text: &str| text.parse().ok().filter(|side| (MIN_SIDE..=MAX_SIDE).contains(side)).ok_or_else(allowed);
    Ok((side(width)?, side(height)?))
}

fn colour(text: &str) -> Result<ColourBy, String> {
    let found = ColourBy::ALL.into_iter().find(|by| by.name() == text);
    found.ok_or_else(|| format!("allowed is {}", ColourBy::ALL.map(ColourBy::name).join(", ")))
}

/// Steepest view \[degrees\]: beyond it the picture would be upside down.
const STEEPEST: f64 = 90.0;

fn orbit(text: &str) -> Result<View, String> {
    let allowed = || {
        format!(
            "allowed is AZIMUTH,ELEVATION[,DISTANCE]: degrees, -{STEEPEST} to {STEEPEST} degrees, m above 0, e.g. 30,20 or 30,20,0.5"
        )
    };
    let numbers: Vec<f64> = text.split(',').map(|part| part.trim().parse()).collect::<Result<_, _>>().map_err(|_| allowed())?;
    let (azimuth, elevation, distance) = match numbers[..] {
        [azimuth, elevation] => (azimuth, elevation, None),
        [azimuth, elevation, distance] => (azimuth, elevation, Some(distance)),
        _ => return Err(allowed()),
    };
    let good = azimuth.is_finite() && elevation.abs() <= STEEPEST && distance.is_none_or(|d| d > 0.0 && d.is_finite());
    if good { Ok(View { azimuth, elevation, distance }) } else { Err(allowed()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_angles_and_a_distance() {
        let view = |azimuth, elevation, distance| Ok(View { azimuth, elevation, distance });
        assert_eq!(orbit("30,20"), view(30.0, 20.0, None));
        assert_eq!(orbit("-400, -90, 0.5"), view(-400.0, -90.0, Some(0.5)));
        for bad in ["", "30", "30,91", "30,20,0", "nan,0", "0,nan", "0,0,inf", "1,2,3,4", "a,b"] {
            assert!(orbit(bad).unwrap_err().contains("AZIMUTH,ELEVATION"), "{bad}");
        }
    }

    #[test]
    fn colours_have_names() {
        assert_eq!(colour("pressure"), Ok(ColourBy::Pressure));
        assert_eq!(colour("none"), Ok(ColourBy::Nothing));
        assert!(colour("rainbow").unwrap_err().contains("displacement, pressure, none"));
    }
}

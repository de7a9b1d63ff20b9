//! What is measured: the shipped scenes along their trajectories, and the scenes on which other programs are measured beside this one (`tests/bench/peers`): a ball on the
//! cube, and one to ten balls on a box or an ellipsoid.

use std::f64::consts::TAU;
use std::fmt::Write;

use haptor_contact::{ParamsSpec, Quat, Tier, Vec3};

use crate::failure::Failure;
use crate::scene::Scene;
use crate::trajectory::{self, Row};

/// A scene and the motion in it.
#[derive(Clone, Debug)]
pub struct Stand {
    /// Its name.
    pub name: String,
    /// The bodies and their parameters.
    pub scene: Scene,
    /// The motion.
    pub rows: Vec<Row>,
    kind: Kind,
}

/// Which settings a scene is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A shipped scene: the tiers.
    Shipped,
    /// The ball on the cube: everything.
    Ball,
    /// Several regions: detection and the tiers that others compare with.
    Regions,
}

/// Settings of every scene.
const ALL: &[Kind] = &[Kind::Shipped, Kind::Ball, Kind::Regions];

/// Settings of the ball on the cube alone.
const BALL_ONLY: &[Kind] = &[Kind::Ball];

/// How a scene is computed.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its name.
    pub name: &'static str,
    /// Fidelity.
    pub tier: Tier,
    samples: usize,
    friction: bool,
    /// The whole deformed surface is computed after each tick.
    pub surface: bool,
    /// Needs the table of a body, seconds of work before the first tick: measured only when asked for by its name.
    pub only_named: bool,
    kinds: &'static [Kind],
}

impl Setting {
    /// The scene's parameters, in this setting.
    pub fn params(&self, scene: &Scene) -> ParamsSpec {
        let mut params = ParamsSpec { tier: self.tier, samples: self.samples, ..scene.params };
        if !self.friction {
            (params.friction_dynamic, params.friction_static) = (0.0, None);
        }
        params
    }
}

/// A tier with friction.
const fn tier(name: &'static str, tier: Tier, samples: usize, kinds: &'static [Kind]) -> Setting {
    Setting { name, tier, samples, friction: true, surface: false, only_named: false, kinds }
}

/// Every setting. `no friction` finds contacts, follows regions and presses, and holds nothing: the share of detection.
const SETTINGS: [Setting; 11] = [
    Setting { friction: false, ..tier("no friction", Tier::Point, 64, &[Kind::Ball, Kind::Regions]) },
    tier("point", Tier::Point, 64, ALL),
    tier("paper 64", Tier::Paper, 64, &[Kind::Shipped, Kind::Ball]),
    tier("bristle 16", Tier::Bristle, 16, BALL_ONLY),
    tier("bristle 64", Tier::Bristle, 64, ALL),
    tier("bristle 256", Tier::Bristle, 256, BALL_ONLY),
    tier("influence 52", Tier::Influence, 52, ALL),
    tier("influence 112", Tier::Influence, 112, BALL_ONLY),
    Setting { surface: true, ..tier("bristle 64, surface of 4096", Tier::Bristle, 64, BALL_ONLY) },
    Setting { surface: true, ..tier("influence 52, surface of 4096", Tier::Influence, 52, BALL_ONLY) },
    Setting { only_named: true, ..tier("green 52", Tier::Green, 52, ALL) },
];

/// The shipped scenes: name, scene file, trajectory.
const SHIPPED: [(&str, &str, &str); 4] = [
    (
        "cube-twist",
        include_str!("../../../../tests/scenes/cube-twist.toml"),
        include_str!("../../../../tests/scenes/cube-twist.csv"),
    ),
    ("mallet", include_str!("../../../../tests/scenes/mallet.toml"), include_str!("../../../../tests/scenes/mallet.csv")),
    ("compass", include_str!("../../../../tests/scenes/compass.toml"), include_str!("../../../../tests/scenes/compass.csv")),
    (
        "ten-regions",
        include_str!("../../../../tests/scenes/ten-regions.toml"),
        include_str!("../../../../tests/scenes/ten-regions.csv"),
    ),
];

/// Radius of each ball of a scene with several regions \[m\].
const BALL: f64 = 0.01;

/// Radius of the ring on which the balls stand \[m\]: ten are 31 mm apart.
const RING: f64 = 0.05;

/// Edges of the box under several balls \[m\].
const BOX: [f64; 3] = [0.2, 0.2, 0.1];

/// Semi-axes of the ellipsoid under several balls \[m\].
const ELLIPSOID: [f64; 3] = [0.12, 0.1, 0.08];

/// Balls on the ring.
const COUNTS: [u32; 4] = [1, 2, 5, 10];

/// Ticks of a round of the motion, at 1 kHz: a hand's pace.
const ROUND: u32 = 1024;

/// How far a motion goes.
struct Reach {
    depth: f64,
    wave: f64,
    shift: f64,
    angle: f64,
}

/// Of the ball on the cube: 2.5 to 3.5 mm, 1 mm, half a radian.
const DEEP: Reach = Reach { depth: 0.003, wave: 5.0e-4, shift: 1.0e-3, angle: 0.5 };

/// Of several balls: 0.7 to 1.3 mm, half a millimetre, and 2.5 mm on the ring; all stay in contact.
const SHALLOW: Reach = Reach { depth: 0.001, wave: 3.0e-4, shift: 5.0e-4, angle: 0.05 };

impl Stand {
    /// The settings that it is measured in.
    pub fn settings(&self) -> impl Iterator<Item = &'static Setting> + use<> {
        let kind = self.kind;
        SETTINGS.iter().filter(move |setting| setting.kinds.contains(&kind))
    }

    /// What `--case` is looked for in.
    pub fn case(&self, setting: &Setting) -> String {
        format!("{}, {}", self.name, setting.name)
    }
}

/// Every scene.
///
/// # Errors
/// None but a defect of this program: each is read as a user's would be.
pub fn stands() -> Result<Vec<Stand>, Failure> {
    let mut stands = Vec::new();
    for (name, scene, poses) in SHIPPED {
        let (line, rows) = (name.to_owned(), trajectory::parse(poses.as_bytes()));
        let rows = rows.map_err(|(at, what)| Failure::problem(format!("{line}:{at}: {what}")))?;
        stands.push(Stand { name: line, scene: read(name, scene)?, rows, kind: Kind::Shipped });
    }
    let scene = read("ball-on-cube", SHIPPED[0].1)?;
    let rows = motion(f64::from(scene.touch_height()), &DEEP);
    stands.push(Stand { name: "ball-on-cube".to_owned(), scene, rows, kind: Kind::Ball });
    for (body, object, height) in [("box", box_object(), BOX[2]), ("ellipsoid", ellipsoid_object(), 2.0 * ELLIPSOID[2])] {
        for count in COUNTS {
            let name = format!("{body}-k{count}");
            let scene = read(&name, &balls(&object, body, height, count))?;
            stands.push(Stand { name, scene, rows: motion(height, &SHALLOW), kind: Kind::Regions });
        }
    }
    Ok(stands)
}

fn read(name: &str, text: &str) -> Result<Scene, Failure> {
    Scene::parse(name, text).map_err(|error| Failure::Problem(error.into()))
}

/// Presses, shifts and twists that stick and slip, with the probe's origin about `height` \[m\].
fn motion(height: f64, reach: &Reach) -> Vec<Row> {
    let row = |tick| {
        let t = TAU * f64::from(tick) / f64::from(ROUND);
        let depth = reach.depth + reach.wave * (3.0 * t).sin();
        let position = [reach.shift * t.sin(), 0.7 * reach.shift * (2.0 * t).cos(), height - depth];
        let angle = reach.angle * (t + 0.3).sin();
        Row {
            written_t: String::new(),
            t: f64::from(tick) * 1.0e-3,
            dt: 1.0e-3,
            position: Vec3::from_array(position.map(|x| x as f32)),
            rotation: Quat::from_rotation_z(angle as f32),
        }
    };
    (0..ROUND).map(row).collect()
}

fn box_object() -> String {
    format!("shape = \"box\"\nsize = {BOX:?}\n")
}

fn ellipsoid_object() -> String {
    format!("shape = \"ellipsoid\"\nsemi_axes = {ELLIPSOID:?}\n")
}

/// Balls on a ring about the object's top, each touching where it stands; the probe's origin is level with the top.
fn balls(object: &str, body: &str, height: f64, count: u32) -> String {
    let mut text = format!("[object]\n{object}young_modulus = 3.0e6\npoisson_ratio = 0.5\ndensity = 1100.0\n");
    text += "[probe]\nshape = \"compound\"\nmass = 1.0\n";
    for i in 0..count {
        let angle = TAU * f64::from(i) / f64::from(count);
        let (x, y) = (RING * angle.cos(), RING * angle.sin());
        let [nx, ny, nz, z] = if body == "box" { [0.0, 0.0, 1.0, height] } else { on_ellipsoid(x, y) };
        let place = [x + BALL * nx, y + BALL * ny, z - height + BALL * nz];
        let _ = write!(text, "[[probe.part]]\nshape = \"sphere\"\nradius = {BALL:?}\nposition = {place:?}\n");
    }
    text + "[friction]\ndynamic = 0.75\n"
}

/// Normal, and height above the base \[m\], of the ellipsoid's upper side over a point of its base.
fn on_ellipsoid(x: f64, y: f64) -> [f64; 4] {
    let [a, b, c] = ELLIPSOID;
    let z = c * (1.0 - (x / a).powi(2) - (y / b).powi(2)).sqrt();
    let gradient = [x / (a * a), y / (b * b), z / (c * c)];
    let length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
    let [nx, ny, nz] = gradient.map(|g| g / length);
    [nx, ny, nz, z + c]
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use crate::simulation::Simulation;

    use super::*;

    #[test]
    fn every_case_has_a_name_of_its_own_and_parameters_that_the_core_takes() {
        let mut names = HashSet::new();
        for stand in stands().unwrap() {
            for setting in stand.settings() {
                assert!(names.insert(stand.case(setting)), "{}", stand.case(setting));
                assert!(setting.tier == Tier::Green || Simulation::new(&stand.scene, &setting.params(&stand.scene)).is_ok());
            }
        }
        assert_eq!(names.len(), 4 * 5 + 11 + 8 * 5);
    }

    #[test]
    fn balls_on_a_ring_are_as_many_regions_all_the_way() {
        for stand in stands().unwrap().into_iter().filter(|stand| stand.kind == Kind::Regions) {
            let count = stand.scene.probe.parts.len();
            let setting = stand.settings().find(|setting| setting.name == "no friction").unwrap();
            let mut simulation = Simulation::new(&stand.scene, &setting.params(&stand.scene)).unwrap();
            let outputs: Vec<_> = stand.rows.iter().map(|row| simulation.tick(row)).collect();
            // one birth a tick
            assert!(outputs[count..].iter().all(|output| usize::from(output.report.regions) == count), "{}", stand.name);
            assert!(outputs.iter().all(|output| output.report.depth < 0.0025), "{}", stand.name);
        }
    }
}

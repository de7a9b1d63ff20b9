//! How far the core's deformed surface is from finite elements, case by case, over `tests/truth/surface_fields.json`.
//!
//! An **error** is the largest distance between the two displacements over a case's points, over the case's own motion: the depth for
//! a dent, the rim's motion (radius x turn) for a twist, the shift for a drag. Bonded discs are compared as flat punches that stick.

use std::collections::BTreeMap;
use std::fmt::Write;

use haptor_contact::surface::Surface;
use haptor_contact::{
    Input, MAX_BRISTLES, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Patch, Pose, ProbePart, ProbeShape, Quat,
    Scratch, State, Tier, Vec2, Vec3, profile, step,
};
use serde::Deserialize;

use crate::bodies;

const FIELDS: &str = include_str!("../truth/surface_fields.json");

/// Radius of the pressed sphere \[m\].
const SPHERE: f32 = 0.02;
/// Young's modulus of every case \[Pa\].
const YOUNG: f32 = 3.0e6;
/// Ticks of a twist: the curves do not depend on it.
const TICKS: usize = 200;
/// Depth at which bonded discs are laid on \[m\]; with `BOND` of friction nothing slips.
const LAID_ON: f32 = 1.0e-3;
/// Friction of a bonded disc.
const BOND: f32 = 10.0;

#[derive(Deserialize)]
struct Table {
    cases: Vec<Case>,
}

/// One case of the table.
#[derive(Debug, Deserialize)]
pub struct Case {
    source: String,
    body: String,
    motion: String,
    radius: f32,
    depth: f32,
    poisson: f32,
    friction: f32,
    /// Turn \[rad\] or shift \[m\].
    amount: f32,
    /// Of two legs: distance from the axis \[m\], and what each holds when turned by the amount \[N, N m\].
    #[serde(default)]
    offset: f32,
    #[serde(default)]
    force: f32,
    #[serde(default)]
    torque: f32,
    points: Vec<(String, f32, f32, f32, f32, f32, f32)>,
}

/// Largest errors of one case, as shares of the case's motion.
#[derive(Debug)]
pub struct Found {
    /// Table of truth, body, motion, Poisson's ratio, place: what belongs in one line of a summary.
    pub kind: String,
    /// The case within its kind: radius or depth, and turn.
    pub case: String,
    /// Tier that held the patch.
    pub tier: Tier,
    /// Radius of the contact \[m\].
    pub radius: f32,
    /// Largest error of the tangential part where the motion is tangential, of the whole vector for a dent.
    pub along: f64,
    /// Largest error of the whole vector.
    pub whole: f64,
}

/// Errors of every case under `tier`: for `paper` of those where its own equations act, for `green` of those that the body has a part in.
pub fn measure(tier: Tier) -> Vec<Found> {
    let table: Table = serde_json::from_str(FIELDS).expect("the table parses");
    let asked = |case: &&Case| match tier {
        Tier::Paper => case.source == "B5",
        Tier::Green => case.source != "B5",
        _ => true,
    };
    table.cases.iter().filter(asked).flat_map(|case| compare(case, tier)).collect()
}

/// The place where a case happens, after and before its tangential motion.
struct Played {
    before: Vec<Vec3>,
    after: Vec<Vec3>,
    radius: f32,
}

fn compare(case: &Case, tier: Tier) -> Vec<Found> {
    let played = play(case, tier);
    let press = case.motion == "press";
    let unit = match case.motion.as_str() {
        "press" => case.depth,
        "bonded drag" => case.amount,
        "bonded legs" => (case.offset + case.radius) * case.amount,
        _ => case.radius * case.amount,
    };
    let mut worst: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for (point, (after, before)) in case.points.iter().zip(played.after.iter().zip(&played.before)) {
        let (place, _, _, _, ux, uy, uz) = point;
        let found = if press { *after } else { *after - *before };
        let off = found - Vec3::new(*ux, *uy, *uz);
        let share = |v: Vec3| f64::from(v.length() / unit);
        let (along, whole) = (share(if press { Vec3::Z * off.z } else { off.with_z(0.0) }), share(off));
        let entry = worst.entry(place).or_default();
        *entry = (entry.0.max(along), entry.1.max(whole));
    }
    let poisson = if case.poisson > 0.49 { 0.5 } else { case.poisson };
    let kind = |place: &str| format!("{} | {} | {} | {poisson} | {place}", case.source, case.body, case.motion);
    let label = if case.source == "B2" || case.source == "B5" {
        format!("depth {:.0} mm, {:.0} deg", 1.0e3 * case.depth, case.amount.to_degrees())
    } else if case.offset > 0.0 {
        format!("legs {:.0} mm off", 1.0e3 * case.offset)
    } else {
        format!("radius {:.0} mm", 1.0e3 * case.radius)
    };
    let found = |(place, (along, whole)): (&&str, &(f64, f64))| Found {
        kind: kind(place),
        case: label.clone(),
        tier,
        radius: played.radius,
        along: *along,
        whole: *whole,
    };
    worst.iter().map(found).collect()
}

fn play(case: &Case, tier: Tier) -> Played {
    let bonded = case.motion.starts_with("bonded");
    let object = match case.body.as_str() {
        "cube" => ObjectShape::Box { size: Vec3::splat(0.1) },
        _ => ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) },
    };
    let parts = parts(case, &object);
    let material = Material { young_modulus: YOUNG, poisson_ratio: case.poisson, density: 1100.0 };
    let green = (tier == Tier::Green).then(|| bodies::green(object, material));
    let model = Model::new(&ModelSpec { green, ..ModelSpec::new(object, material, &parts) }).expect("a valid scene");
    let friction = if bonded { BOND } else { case.friction };
    let samples = if tier == Tier::Green { 52 } else { 64 };
    let spec = ParamsSpec { tier, samples, friction_dynamic: friction, ..ParamsSpec::default() };
    let params = Params::new(&spec).expect("valid parameters");
    let (mut state, mut scratch) = (Box::new(State::<2, MAX_BRISTLES, MAX_BRISTLES>::new()), Scratch::<2>::new());
    let depth = if bonded { LAID_ON } else { case.depth };
    let place = Vec3::Z * (object.height() + SPHERE - depth);
    let mut tick = |rotation: Quat| {
        let input = Input { pose: Pose::new(place, rotation), dt: 1.0e-2 };
        step(&model, &params, &mut state, &mut scratch, input);
        state.patches().to_vec()
    };
    let rest: Vec<Vec3> = case.points.iter().map(|p| Vec3::new(p.1, p.2, p.3)).collect();
    let moved = |patches: &[Patch]| {
        let mut moved = vec![Vec3::ZERO; rest.len()];
        Surface { model: &model, params: &params, patches, p_wp: place, body: true }.update(&rest, &mut moved);
        moved
    };
    // one patch is born per tick
    let mut patches = tick(Quat::IDENTITY);
    parts.iter().skip(1).for_each(|_| patches = tick(Quat::IDENTITY));
    assert_eq!(patches.len(), parts.len());
    if bonded {
        for patch in &mut patches {
            patch.footprint.radius = case.radius;
            patch.footprint.fullness = profile::FULLNESS_PUNCH;
            // enough load that a unit of motion is far from slip
            patch.footprint.load = 1.0e6;
            // what the solver rounded off while the disc was laid on is none of its motion
            patch.grip.force = Vec2::ZERO;
            patch.grip.torque = 0.0;
        }
    }
    let before = moved(&patches);
    if bonded {
        patches.iter_mut().for_each(|patch| bond(case, patch, material.shear_modulus()));
    } else {
        (1..=TICKS).for_each(|i| patches = tick(Quat::from_rotation_z(case.amount * i as f32 / TICKS as f32)));
    }
    Played { before, after: moved(&patches), radius: patches[0].footprint.radius }
}

/// The probe: a disc or a ball in the middle, or two balls where the legs of a compass stand.
fn parts(case: &Case, object: &ObjectShape<'_>) -> Vec<ProbePart<'static>> {
    if let ObjectShape::Ellipsoid { semi_axes } = *object
        && case.offset > 0.0
    {
        let share = case.offset / semi_axes.x;
        let top = Vec3::new(case.offset, 0.0, semi_axes.z * (1.0 - share * share).sqrt());
        let normal = (top / (semi_axes * semi_axes)).normalize();
        // in the probe's frame, whose origin is a ball's radius less the depth above the pole
        let centre = top + normal * (SPHERE - LAID_ON) - Vec3::Z * (semi_axes.z + SPHERE - LAID_ON);
        let leg = |position: Vec3| ProbePart { position, ..ProbePart::at_origin(ProbeShape::Sphere { radius: SPHERE }) };
        return vec![leg(centre), leg(centre.with_x(-centre.x))];
    }
    let punch = ProbeShape::Cylinder { radius: case.radius, height: 0.04 };
    let bonded = case.motion.starts_with("bonded");
    vec![ProbePart::at_origin(if bonded { punch } else { ProbeShape::Sphere { radius: SPHERE } })]
}

/// Gives the patch the grip of a bonded disc that moved by the case's amount: 1/K = 1/K_local + C.
fn bond(case: &Case, patch: &mut Patch, g: f32) {
    let a = case.radius;
    if case.offset > 0.0 {
        patch.grip.force = patch.to_patch(Vec3::Y * (case.force * patch.centre.x.signum()));
        patch.grip.torque = case.torque;
    } else if case.motion == "bonded drag" {
        let local = (2.0 - case.poisson) / (8.0 * g * a);
        patch.grip.force = patch.to_patch(Vec3::X * (case.amount / (local + patch.body.drag)));
        patch.grip.torque = 0.0;
    } else {
        let convex = 1.0 - 0.735 * (a / patch.object_radius).min(0.9);
        let local = 3.0 / (16.0 * g * a * a * a * convex);
        patch.grip.force = Vec2::ZERO;
        patch.grip.torque = case.amount / (local + patch.body.twist);
    }
}

/// The summary as a Markdown document.
pub fn document() -> String {
    let mut text = String::from(INTRODUCTION);
    for tier in [Tier::Bristle, Tier::Point, Tier::Green, Tier::Paper] {
        let mut kinds: BTreeMap<String, Vec<Found>> = BTreeMap::new();
        for found in measure(tier) {
            kinds.entry(found.kind.clone()).or_default().push(found);
        }
        let _ = writeln!(text, "\n## Tier `{}`\n\n{HEAD}", tier.name());
        for (kind, cases) in kinds {
            let worst = |read: fn(&Found) -> f64| {
                cases.iter().max_by(|a, b| read(a).total_cmp(&read(b))).map(|f| (100.0 * read(f), f.case.as_str())).unwrap()
            };
            let ((along, case), (whole, whole_case)) = (worst(|f| f.along), worst(|f| f.whole));
            let _ = writeln!(text, "| {kind} | {} | {along:.1} ({case}) | {whole:.1} ({whole_case}) |", cases.len());
        }
    }
    text
}

const INTRODUCTION: &str = "\
# Accuracy of the deformed surface

Written by `cargo run --release -p haptor-tests --bin accuracy -- -o tests/bench/ACCURACY.md`; the gates are in `tests/it/surface.rs`.

Truth: finite elements (`tests/truth/surface_fields.json`), rubber of 3 MPa, a cube of 0.1 m edges and an ellipsoid of semi-axes 60, 50, 40 mm. B1, B4: bonded disc,
twisted and dragged on the cube's top; B2, B5: sphere of 20 mm pressed, then twisted with Coulomb friction; B3: bonded disc twisted on the ellipsoid's pole, and a compass of two
bonded legs turned about the axis, which hold what finite elements found. An error is the
largest distance between the two displacements over a case's points, in per cent of the motion: of the depth (press), of radius x turn (twist; of the outermost point of the legs), of the shift (drag). \"Along\" is the part
along z of a dent and the level part of a twist or drag; \"whole\" is the whole vector. The worst case of each line is named. On bonded discs the tiers do not differ; `paper`
is shown where its own twisting equations (10) to (13) act.
";

const HEAD: &str = "| table | body | motion | nu | where | cases | along, % | whole, % |\n|---|---|---|---|---|---|---|---|";

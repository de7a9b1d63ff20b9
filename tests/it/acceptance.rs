//! The shared tables of truth, row by row, for tiers `point` and `bristle`.
//!
//! A row is an input and an expected figure. Tolerances are relative to the largest value of the kind (mu P, T_max), as the accuracy statements of
//! the tiers are.
//!
//! **Two readings of a sphere.** Half-space rows of sources A3, A4 and B6 were made with the small-strain sphere, a = sqrt(R d) and
//! F = 4/3 E* sqrt(R) d^1.5. The core uses the true sphere (7 % less T_max at d = R/4), which the finite-element rows B2 and B5 confirm.
//! Friction does not care which sphere made P and a: these rows are compared in the contact's own units (`support::led`), the row's in
//! its sphere's and the core's in the core's. Rows B2, B5 and A1 are compared as they are, in newtons and newton metres.

use haptor_contact::{Material, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Tier};
use serde::Deserialize;

use crate::support::drive::{CUBE, Drive, RUBBER};
use crate::support::exact::zero;
use crate::support::led::{Shift, Units, lead, worst};
use crate::support::tables::{CombinedPath, combined_table, drag_table};

const ACCEPTANCE: &str = include_str!("../truth/acceptance.json");
const STRAIGHT: &str = include_str!("../truth/straight_paths.json");
const TURNING: &str = include_str!("../truth/turning_paths.json");

/// Ticks of every monotone motion: a second's worth at 1 kHz is not needed, the curves do not depend on it.
const TICKS: usize = 200;

#[derive(Deserialize)]
struct Acceptance {
    checks: Vec<Check>,
}

#[derive(Deserialize)]
struct Check {
    name: String,
    quantity: String,
    expected: f64,
    source: String,
    inputs: Inputs,
}

/// The union of all rows' inputs; absent ones are 0.
#[derive(Deserialize, Default)]
#[serde(default)]
#[allow(non_snake_case, reason = "the table's own names")]
struct Inputs {
    R_m: f64,
    delta_m: f64,
    nu: f64,
    mu: f64,
    twist_deg: f64,
    shift_m: f64,
    a_m: f64,
}

fn rows(name: &str, quantity: &str) -> Vec<Check> {
    let table: Acceptance = serde_json::from_str(ACCEPTANCE).expect("the table parses");
    let rows: Vec<Check> = table.checks.into_iter().filter(|row| row.name == name && row.quantity == quantity).collect();
    assert!(!rows.is_empty(), "no row {name} {quantity}");
    rows
}

fn params(tier: Tier, samples: usize, mu: f64) -> ParamsSpec {
    ParamsSpec { tier, samples, friction_dynamic: mu as f32, ..ParamsSpec::default() }
}

/// The row's ball, pressed to its depth on `object`.
fn pressed(object: ObjectShape<'static>, row: &Inputs, tier: Tier) -> Drive {
    let mut drive = Drive::ball(object, row.R_m as f32, row.nu as f32, &params(tier, 64, row.mu));
    drive.press_to(drive.position.z, row.delta_m as f32);
    drive
}

/// Units of the small-strain sphere that rows of A3, A4 were made with.
fn small_strain(row: &Inputs) -> Units {
    let material = Material { poisson_ratio: row.nu as f32, ..RUBBER };
    let (a, modulus) = ((row.R_m * row.delta_m).sqrt(), f64::from(material.contact_modulus()));
    let load = 4.0 / 3.0 * modulus * row.R_m.sqrt() * row.delta_m.powf(1.5);
    Units::new(load, a, row.mu, f64::from(material.shear_modulus()), row.nu)
}

const TIERS: [Tier; 2] = [Tier::Point, Tier::Bristle];

#[test]
fn force_and_radius_of_a_sphere_on_the_half_space() {
    for row in rows("sphere_halfspace", "F") {
        let found = pressed(ObjectShape::HalfSpace, &row.inputs, Tier::Point).load();
        assert!((found / row.expected - 1.0).abs() < 0.01, "{} m: {found} N, expected {}", row.inputs.delta_m, row.expected);
    }
    for row in rows("sphere_halfspace", "a") {
        let found = pressed(ObjectShape::HalfSpace, &row.inputs, Tier::Point).radius();
        assert!((found / row.expected - 1.0).abs() < 0.02, "{} m: {found} m, expected {}", row.inputs.delta_m, row.expected);
    }
}

/// nu = 0.5: 1 %; the cube is stiffer to a compressible body by up to 1.9 %, which no tier models.
#[test]
fn force_of_a_sphere_on_the_cube() {
    for row in rows("sphere_cube_0.1m", "F") {
        let found = pressed(CUBE, &row.inputs, Tier::Point).load();
        let tolerance = if row.inputs.nu > 0.4 { 0.01 } else { 0.02 };
        let off = found / row.expected - 1.0;
        assert!(off.abs() < tolerance, "nu {} {} m: {found} N off by {off}", row.inputs.nu, row.inputs.delta_m);
    }
}

#[test]
fn twist_on_the_half_space() {
    for tier in TIERS {
        for row in rows("twist_monotone_hertz_halfspace", "T") {
            let theirs = small_strain(&row.inputs);
            let mut drive = pressed(ObjectShape::HalfSpace, &row.inputs, tier);
            let ours = Units::of(&drive, row.inputs.mu);
            let x = row.inputs.twist_deg.to_radians() / theirs.angle;
            let found = lead(&mut drive, &ours, &[[0.0, 0.0, x]], TICKS)[0];
            let expected = row.expected / theirs.torque;
            assert!((found[2] - expected).abs() < 0.02, "{tier:?} x {x}: {found:?} expected {expected}");
            assert!(found[0].hypot(found[1]) < 1e-3, "{tier:?} x {x}: a twist makes no drag, {found:?}");
        }
    }
}

#[test]
fn reversal_from_20_degrees() {
    for tier in TIERS {
        for row in rows("twist_reversal_from_20deg", "T") {
            let theirs = small_strain(&row.inputs);
            let mut drive = pressed(ObjectShape::HalfSpace, &row.inputs, tier);
            let ours = Units::of(&drive, row.inputs.mu);
            let x = |degrees: f64| degrees.to_radians() / theirs.angle;
            let path = [[0.0, 0.0, x(20.0)], [0.0, 0.0, x(row.inputs.twist_deg)]];
            let found = lead(&mut drive, &ours, &path, TICKS)[1][2];
            let expected = row.expected / theirs.torque;
            let tolerance = if tier == Tier::Point { 0.03 } else { 0.02 };
            assert!((found - expected).abs() < tolerance, "{tier:?} {}: {found} expected {expected}", row.inputs.twist_deg);
        }
    }
}

#[test]
fn drag_on_the_half_space() {
    for tier in TIERS {
        for row in rows("drag_monotone_hertz_halfspace", "Q") {
            let theirs = small_strain(&row.inputs);
            let mut drive = pressed(ObjectShape::HalfSpace, &row.inputs, tier);
            let ours = Units::of(&drive, row.inputs.mu);
            let s = row.inputs.shift_m / theirs.shift;
            let found = lead(&mut drive, &ours, &[[s, 0.0, 0.0]], TICKS)[0];
            let expected = row.expected / theirs.force;
            assert!((found[0] - expected).abs() < 0.02, "{tier:?} s {s}: {found:?} expected {expected}");
            assert!(found[1].abs() < 1e-3 && found[2].abs() < 1e-3, "{tier:?} s {s}: {found:?}");
        }
    }
}

/// Against finite elements, in newton metres. nu = 0.5: 2 % of T_max. Compressible: friction and pressure disturb each other, 4 %.
#[test]
fn twist_on_the_cube() {
    for tier in TIERS {
        let mut worst = [0.0_f64; 3];
        for row in rows("sphere_twist_cube_0.1m", "T") {
            let mut drive = pressed(CUBE, &row.inputs, tier);
            let full = Units::of(&drive, row.inputs.mu).torque;
            drive.turn(glam::Vec3::Z, row.inputs.twist_deg.to_radians() as f32, TICKS);
            let off = (drive.held()[2] - row.expected).abs() / full;
            let group = if row.inputs.nu > 0.46 {
                0
            } else if row.inputs.nu > 0.4 {
                1
            } else {
                2
            };
            worst[group] = worst[group].max(off);
            assert_eq!(row.source, "B5");
        }
        println!("{tier:?}: worst of T_max at nu 0.5, 0.45, 0.3: {worst:?}");
        assert!(worst[0] < 0.02 && worst[1] < 0.04 && worst[2] < 0.04, "{tier:?}: {worst:?}");
    }
}

/// Against finite elements, in newtons: the body's own shear and bending take up to half of the shift.
#[test]
fn drag_on_the_cube() {
    let table = drag_table();
    for tier in TIERS {
        let mut worst = 0.0_f64;
        for row in &table.rows {
            let inputs = Inputs { R_m: table.R_m, delta_m: row.delta_m, nu: row.nu, mu: row.mu, ..Inputs::default() };
            let mut drive = pressed(CUBE, &inputs, tier);
            let mut last = 0.0;
            for (shift, expected) in row.dt_m.iter().zip(&row.Q_N) {
                drive.shift(glam::Vec3::X * (shift - last) as f32, TICKS / 4);
                last = *shift;
                let off = (drive.held()[0] - expected).abs() / (row.mu * row.F_N);
                worst = worst.max(off);
                assert!(off < 0.02, "{tier:?} nu {} {} m, shift {shift} m: off by {off} of mu P", row.nu, row.delta_m);
            }
        }
        println!("drag on the cube, {tier:?}: worst {worst:.4} of mu P");
    }
}

/// Torque per twist and force per drag of a probe that sticks, at `share` of full slip \[N m/rad, N/m\].
fn stuck_stiffness(mut drive: Drive, share: f64) -> (f64, f64) {
    let units = Units::of(&drive, 10.0);
    let twist = (share * units.angle) as f32;
    drive.turn(glam::Vec3::Z, twist, 4);
    let torque = drive.held()[2] / f64::from(twist);
    let shift = (share * units.shift) as f32;
    drive.shift(glam::Vec3::X * shift, 4);
    (torque, drive.held()[0] / f64::from(shift))
}

/// The flat end of a cylinder of radius `a`, pressed hard on the cube so that nothing slips.
fn bonded_disc(a: f64, nu: f64) -> Drive {
    let disc = ProbePart::at_origin(ProbeShape::Cylinder { radius: a as f32, height: 0.02 });
    let material = Material { poisson_ratio: nu as f32, ..RUBBER };
    let mut drive = Drive::new(CUBE, material, &[disc], &params(Tier::Point, 64, 10.0));
    drive.press_to(CUBE.height() + 0.01, 1.0e-4);
    drive
}

/// A disc glued to the cube: K_theta 2 %, K_t 3 %, the table's own tolerances.
#[test]
fn stuck_discs_on_the_cube() {
    for row in rows("bonded_twist_cube_0.1m", "K_theta/G") {
        let found = stuck_stiffness(bonded_disc(row.inputs.a_m, 0.5), 0.1).0 / f64::from(RUBBER.shear_modulus());
        let off = found / row.expected - 1.0;
        println!("twist, a {}: {off:.4}", row.inputs.a_m);
        assert!(off.abs() < 0.02, "a {}: {found} off by {off}", row.inputs.a_m);
    }
    for row in rows("bonded_drag_cube_0.1m", "K") {
        let found = stuck_stiffness(bonded_disc(row.inputs.a_m, row.inputs.nu), 0.1).1;
        let off = found / row.expected - 1.0;
        println!("drag, a {} nu {}: {off:.4}", row.inputs.a_m, row.inputs.nu);
        assert!(off.abs() < 0.03, "a {} nu {}: {found} off by {off}", row.inputs.a_m, row.inputs.nu);
    }
}

/// The ellipsoid of the table: semi-axes 60, 50, 40 mm.
const ELLIPSOID: ObjectShape<'static> = ObjectShape::Ellipsoid { semi_axes: glam::Vec3::new(0.06, 0.05, 0.04) };

/// A ball stuck on top of the ellipsoid with the table's contact radius. The table's own tolerance, 5 %.
#[test]
fn a_stuck_patch_on_the_ellipsoid() {
    for row in rows("ellipsoid_one", "K_theta") {
        let at = |depth: f64| {
            let mut drive = Drive::ball(ELLIPSOID, 0.05, 0.5, &params(Tier::Point, 64, 10.0));
            drive.press_to(drive.position.z, depth as f32);
            drive
        };
        let depth = zero(1.0e-5, 0.02, |depth| at(depth).radius() - row.inputs.a_m);
        let found = stuck_stiffness(at(depth), 1.0e-3).0;
        let off = found / row.expected - 1.0;
        println!("ellipsoid, a {}: {off:.4}", row.inputs.a_m);
        assert!(off.abs() < 0.05, "a {}: {found} off by {off}", row.inputs.a_m);
    }
}

/// A path with its answers, in the contact's units.
struct Known {
    name: String,
    poses: Vec<Shift>,
    answers: Vec<[f64; 3]>,
}

fn combined() -> (Inputs, Vec<Known>) {
    let table = combined_table();
    let known = |path: &CombinedPath| Known {
        name: path.name.clone(),
        poses: path.dx_m.iter().zip(&path.phi_rad).map(|(s, phi)| [s / table.dt0_m, 0.0, phi / table.phi_unit_rad]).collect(),
        answers: path.Q_N.iter().zip(&path.T_Nm).map(|(q, t)| [q / table.Qmax_N, 0.0, t / table.Tmax_Nm]).collect(),
    };
    let inputs = Inputs { R_m: table.R_m, delta_m: table.delta_m, nu: table.nu, mu: table.mu, ..Inputs::default() };
    (inputs, table.paths.iter().map(known).collect())
}

/// Boundary elements, shift and twist together, every step of every path. Pure paths 2 %, mixed 5 %. `point` has no memory
/// of where in the contact the traction stands: its mixed paths are held to 20 %, and to the limit surface.
#[test]
fn combined_shift_and_twist() {
    let (inputs, paths) = combined();
    for path in paths {
        let pure = path.name == "twist" || path.name == "drag" || path.name == "twist_loop";
        for tier in TIERS {
            let mut drive = pressed(ObjectShape::HalfSpace, &inputs, tier);
            let units = Units::of(&drive, inputs.mu);
            let found = lead(&mut drive, &units, &path.poses, 20);
            let (drag, torque) = worst(&found, &path.answers);
            println!("{} {tier:?}: {drag:.4} of mu P, {torque:.4} of T_max", path.name);
            let mixed = if tier == Tier::Bristle { 0.05 } else { 0.2 };
            let tolerance = if pure { 0.02 } else { mixed };
            assert!(drag < tolerance && torque < tolerance, "{} {tier:?}: {drag} {torque}", path.name);
            for answer in found {
                let used = answer[0].hypot(answer[1]).powf(1.725) + answer[2].abs().powf(1.725);
                assert!(used < 1.02, "{} {tier:?}: beyond the limit surface, {answer:?}", path.name);
            }
        }
    }
}

/// Full slip with v = omega a, the rim as fast as the middle: what slips moves along the normal of the limit surface. Shift in s0, angle in phi0, of which v = omega a takes 8/pi times as many.
#[test]
fn full_slip_follows_the_normal_of_the_limit_surface() {
    let (inputs, _) = combined();
    let poses: Vec<Shift> =
        (1..=400).map(|i| 0.02 * f64::from(i)).map(|way| [way, 0.0, way * 8.0 / std::f64::consts::PI]).collect();
    for tier in TIERS {
        let mut drive = pressed(ObjectShape::HalfSpace, &inputs, tier);
        let units = Units::of(&drive, inputs.mu);
        let found = lead(&mut drive, &units, &poses, 1)[poses.len() - 1];
        println!("{tier:?}: {found:?}");
        assert!((found[0] - 0.884).abs() < 0.03 && (found[2] - 0.375).abs() < 0.03, "{tier:?}: {found:?}");
    }
}

#[derive(Deserialize)]
struct Paths {
    profile: String,
    unconverged: usize,
    paths: Vec<Led>,
}

#[derive(Deserialize)]
struct Led {
    name: String,
    pose: Vec<Shift>,
    answer: Vec<[f64; 3]>,
}

fn reference_paths(text: &str, expected: usize) -> Vec<Known> {
    let table: Paths = serde_json::from_str(text).expect("the table parses");
    assert_eq!((table.profile.as_str(), table.unconverged, table.paths.len()), ("hertz", 0, expected));
    table.paths.into_iter().map(|p| Known { name: p.name, poses: p.pose, answers: p.answer }).collect()
}

/// Worst differences over all `paths` in a tier with `samples`.
fn worst_of(paths: &[Known], tier: Tier, samples: usize) -> (f64, f64) {
    let mut all = (0.0_f64, 0.0_f64);
    for path in paths {
        let mut drive = Drive::ball(ObjectShape::HalfSpace, 0.02, 0.5, &params(tier, samples, 0.75));
        drive.press_to(0.02, 1.0e-3);
        let units = Units::of(&drive, 0.75);
        let (drag, torque) = worst(&lead(&mut drive, &units, &path.poses, 1), &path.answers);
        let pure = ["twist", "drag", "twist_loop", "drag_loop"].contains(&path.name.as_str());
        assert!(samples < 64 || !pure || drag.max(torque) < 0.02, "{samples} {}: {drag} {torque}", path.name);
        all = (all.0.max(drag), all.1.max(torque));
    }
    all
}

/// Boundary elements on paths that keep their direction and on paths that turn under load.
#[test]
fn straight_and_turning_paths() {
    let straight = reference_paths(STRAIGHT, 14);
    let turning = reference_paths(TURNING, 27);
    let cases = [
        (Tier::Bristle, 64, 0.06, 0.04),
        (Tier::Bristle, 16, 0.08, 0.08),
        (Tier::Bristle, 256, 0.06, 0.06),
        (Tier::Point, 64, 0.30, 0.25),
    ];
    for (tier, samples, drag_most, torque_most) in cases {
        for (kind, paths) in [("straight", &straight), ("turning", &turning)] {
            let (drag, torque) = worst_of(paths, tier, samples);
            let found = format!("{kind}, {tier:?}, {samples} samples: {drag:.4} of mu P, {torque:.4} of T_max");
            println!("{found}");
            assert!(drag <= drag_most && torque <= torque_most, "{found}");
        }
    }
}

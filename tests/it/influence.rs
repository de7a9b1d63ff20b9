//! Tier `influence` against boundary elements and the closed forms it is built to meet.

use std::f64::consts::PI;

use glam::{Quat, Vec3};
use haptor_contact::tier::influence::table::{ALONG, CROSS, REACH};
use haptor_contact::{
    Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Scratch, Tier, step,
};
use serde::Deserialize;

use crate::support::drive::{CUBE, Drive, FullState, RUBBER};
use crate::support::led::{Shift, Units, follow, lead, worst};
use crate::support::tables::{CombinedPath, combined_table, drag_table, pressed_table};

const STRAIGHT: &str = include_str!("../truth/straight_paths.json");
const TURNING: &str = include_str!("../truth/turning_paths.json");

/// Cells, and the most that any answer of any path may be off, of mu P and of T_max, at four sweeps.
const PROMISES: [(usize, f64); 2] = [(52, 0.06), (112, 0.03)];

#[derive(Deserialize)]
struct Paths {
    paths: Vec<Known>,
}

/// A path with its answers, in the contact's units.
#[derive(Deserialize)]
struct Known {
    name: String,
    pose: Vec<Shift>,
    answer: Vec<[f64; 3]>,
}

fn combined() -> Vec<Known> {
    let table = combined_table();
    let known = |path: &CombinedPath| Known {
        name: path.name.clone(),
        pose: path.dx_m.iter().zip(&path.phi_rad).map(|(s, phi)| [s / table.dt0_m, 0.0, phi / table.phi_unit_rad]).collect(),
        answer: path.Q_N.iter().zip(&path.T_Nm).map(|(q, t)| [q / table.Qmax_N, 0.0, t / table.Tmax_Nm]).collect(),
    };
    table.paths.iter().map(known).collect()
}

fn paths(text: &str) -> Vec<Known> {
    let table: Paths = serde_json::from_str(text).expect("the table parses");
    table.paths
}

fn params(samples: usize, friction: f32) -> ParamsSpec {
    ParamsSpec { tier: Tier::Influence, samples, sweeps: 4, friction_dynamic: friction, ..ParamsSpec::default() }
}

/// A ball of 20 mm pressed 1 mm into the half space.
fn ball(samples: usize, nu: f32, friction: f32) -> Drive {
    let mut drive = Drive::ball(ObjectShape::HalfSpace, 0.02, nu, &params(samples, friction));
    drive.press_to(0.02, 1.0e-3);
    drive
}

/// Worst differences over `known`, each pose reached in `ticks` ticks.
fn worst_of(known: &[Known], samples: usize, ticks: usize) -> (f64, f64) {
    known.iter().fold((0.0, 0.0), |(most_drag, most_torque), path| {
        let mut drive = ball(samples, 0.5, 0.75);
        let units = Units::of(&drive, 0.75);
        let (drag, torque) = worst(&lead(&mut drive, &units, &path.pose, ticks), &path.answer);
        assert!(drag.max(torque) < 0.06, "{} cells, {}: {drag} of mu P, {torque} of T_max", samples, path.name);
        (most_drag.max(drag), most_torque.max(torque))
    })
}

#[test]
fn boundary_elements_on_every_path() {
    let sets = [("combined", combined()), ("straight", paths(STRAIGHT)), ("turning", paths(TURNING))];
    for (samples, promise) in PROMISES {
        for (name, known) in &sets {
            for ticks in [1, 4] {
                let (drag, torque) = worst_of(known, samples, ticks);
                println!("{name}, {samples} cells, {ticks} ticks a row: {drag:.4} of mu P, {torque:.4} of T_max");
                assert!(drag < promise && torque < promise, "{name}, {samples} cells, {ticks} ticks: {drag} {torque}");
            }
        }
    }
}

/// A hand does not move evenly: the same path in ticks of very unequal length, some of them at rest, costs at most 1 % more.
#[test]
fn uneven_ticks_change_little() {
    for (samples, promise) in PROMISES.map(|(samples, promise)| (samples, promise + 0.01)) {
        let mut most = 0.0_f64;
        for path in paths(STRAIGHT).iter().chain(&paths(TURNING)) {
            let stops = [0.0, 0.7, 0.7, 0.75, 1.0];
            let mut last = [0.0; 3];
            let mut poses = Vec::new();
            for pose in &path.pose {
                poses.extend(stops[1..].iter().map(|part| std::array::from_fn(|k| last[k] + (pose[k] - last[k]) * part)));
                last = *pose;
            }
            let mut drive = ball(samples, 0.5, 0.75);
            let units = Units::of(&drive, 0.75);
            let found: Vec<_> = lead(&mut drive, &units, &poses, 1).into_iter().skip(3).step_by(4).collect();
            let (drag, torque) = worst(&found, &path.answer);
            most = most.max(drag).max(torque);
        }
        println!("{samples} cells, uneven ticks: {most:.4}");
        assert!(most < promise, "{samples} cells: {most}");
    }
}

/// Loads that change under friction: what is shed, kept, and enters free, on a grid that is laid anew as the contact grows and shrinks.
#[test]
fn boundary_elements_under_changing_loads() {
    let table = pressed_table();
    for (samples, most) in [(52, 0.08), (112, 0.05)] {
        let mut all = 0.0_f64;
        for path in &table.histories {
            let (drag, torque) = worst(&follow(path, &params(samples, 0.75), 2), &path.answer);
            println!("{samples} cells, {}: {drag:.4} {torque:.4}", path.name);
            all = all.max(drag).max(torque);
        }
        println!("{samples} cells, changing loads: {all:.4}");
        assert!(all < most, "{samples} cells: {all}");
    }
}

/// Force per drag and torque per twist of a flat end that sticks, over Mindlin's 8 G a/(2 - nu) and Reissner's and Sagoci's 16/3 G a^3.
#[test]
fn stuck_flat_ends_meet_mindlin_and_reissner_sagoci() {
    for (samples, tolerance) in [(52, 0.06), (112, 0.05)] {
        for nu in [0.3_f32, 0.5] {
            let a = 0.01_f64;
            let part = ProbePart::at_origin(ProbeShape::Cylinder { radius: a as f32, height: 0.02 });
            let material = Material { poisson_ratio: nu, ..RUBBER };
            let g = f64::from(material.shear_modulus());
            let start = || {
                let mut drive = Drive::new(ObjectShape::HalfSpace, material, &[part], &params(samples, 10.0));
                drive.press_to(0.01, 1.0e-4);
                drive
            };
            let (mut dragged, mut twisted) = (start(), start());
            dragged.shift(Vec3::X * 1.0e-5, 20);
            twisted.turn(Vec3::Z, 1.0e-3, 20);
            let drag = dragged.held()[0] / 1.0e-5 / (8.0 * g * a / (2.0 - f64::from(nu)));
            let twist = twisted.held()[2] / 1.0e-3 / (16.0 / 3.0 * g * a.powi(3));
            println!("{samples} cells, nu {nu}: drag {drag:.4}, twist {twist:.4} of the closed forms");
            assert!((drag - 1.0).abs() < tolerance && (twist - 1.0).abs() < tolerance, "{samples} nu {nu}: {drag} {twist}");
        }
    }
}

/// Drag of a ball against Cattaneo and Mindlin, twist against Lubkin's integral, in part slip and beyond.
#[test]
fn balls_meet_cattaneo_and_lubkin() {
    for (samples, tolerance) in [(52, 0.04), (112, 0.02)] {
        let mut most = (0.0_f64, 0.0_f64);
        let poses = |k: usize, step: f64| -> Vec<Shift> {
            (1..=40).map(|i| std::array::from_fn(|axis| if axis == k { step * f64::from(i) } else { 0.0 })).collect()
        };
        for nu in [0.3, 0.5] {
            let mut drive = ball(samples, nu, 0.75);
            let units = Units::of(&drive, 0.75);
            for (pose, found) in poses(0, 0.03).iter().zip(lead(&mut drive, &units, &poses(0, 0.03), 4)) {
                most.0 = most.0.max((found[0] - (1.0 - (1.0 - pose[0].min(1.0)).powf(1.5))).abs());
                assert!(found[1].abs() < 0.01 && found[2].abs() < 0.01, "{found:?}");
            }
            let mut drive = ball(samples, nu, 0.75);
            for (pose, found) in poses(2, 0.1).iter().zip(lead(&mut drive, &units, &poses(2, 0.1), 4)) {
                let x = pose[2];
                let lubkin = 1.0 - (-x * (1.0 + 0.1029 * x) / (1.0 + 0.0427 * x)).exp();
                most.1 = most.1.max((found[2] - lubkin).abs());
                assert!(found[0].hypot(found[1]) < 0.01, "{found:?}");
            }
        }
        println!("{samples} cells: {:.4} of mu P from Cattaneo, {:.4} of T_max from Lubkin", most.0, most.1);
        assert!(most.0 < tolerance && most.1 < tolerance, "{samples} cells: {most:?}");
    }
}

/// Against finite elements, in newtons: the body's own shear and bending are in the sweeps.
#[test]
fn drag_on_the_cube() {
    let table = drag_table();
    for samples in [52, 112] {
        let mut most = 0.0_f64;
        for row in &table.rows {
            let mut drive = Drive::ball(CUBE, table.R_m as f32, row.nu as f32, &params(samples, row.mu as f32));
            drive.press_to(drive.position.z, row.delta_m as f32);
            let mut last = 0.0;
            for (shift, expected) in row.dt_m.iter().zip(&row.Q_N) {
                drive.shift(Vec3::X * (shift - last) as f32, 50);
                last = *shift;
                most = most.max((drive.held()[0] - expected).abs() / (row.mu * row.F_N));
            }
        }
        println!("drag on the cube, {samples} cells: {most:.4} of mu P");
        assert!(most < 0.03, "{samples} cells: {most}");
    }
}

/// Static above dynamic friction: the torque passes what dynamic friction alone would hold and falls back to it.
#[test]
fn breakaway_falls_to_dynamic_friction() {
    for breakaway in [haptor_contact::Breakaway::Smooth, haptor_contact::Breakaway::Sharp] {
        let spec = ParamsSpec { friction_static: Some(0.9), breakaway, ..params(52, 0.6) };
        let mut drive = Drive::ball(ObjectShape::HalfSpace, 0.02, 0.5, &spec);
        drive.press_to(0.02, 1.0e-3);
        let units = Units::of(&drive, 0.6);
        let poses: Vec<Shift> = (1..=200).map(|i| [0.025 * f64::from(i), 0.0, 0.0]).collect();
        let found = lead(&mut drive, &units, &poses, 4);
        let end = found.last().expect("poses")[0];
        let peak = found.iter().map(|answer| answer[0]).fold(0.0, f64::max);
        println!("{breakaway:?}: peak {peak:.4}, end {end:.4} of mu_d P");
        assert!((end - 1.0).abs() < 0.01 && peak > 1.02 && peak <= 1.501, "{breakaway:?}: {peak} {end}");
    }
}

/// What is held stays held to the bit.
#[test]
fn holding_still_holds() {
    let mut drive = ball(112, 0.5, 0.75);
    let units = Units::of(&drive, 0.75);
    let held = lead(&mut drive, &units, &[[0.4, 0.2, 0.5]], 50)[0];
    let (position, rotation) = (drive.position, drive.rotation);
    for _ in 0..1000 {
        drive.tick(position, rotation);
    }
    assert_eq!(units.share(drive.held()), held);
    assert_eq!(drive.report().tier, Tier::Influence);
}

/// A tier that takes over from another takes up what that held.
#[test]
fn a_change_of_tier_keeps_the_wrench() {
    let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
    let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, RUBBER, &ball)).expect("valid model");
    for (from, to) in [((Tier::Bristle, 64), (Tier::Influence, 52)), ((Tier::Influence, 112), (Tier::Bristle, 64))] {
        let [before, after] = [from, to].map(|(tier, samples)| ParamsSpec { tier, samples, ..params(52, 0.75) });
        let [before, after] = [before, after].map(|spec| Params::new(&spec).expect("valid parameters"));
        let (mut state, mut scratch) = (Box::new(FullState::new()), Scratch::<16>::new());
        let mut tick = |params: &Params, part: f32| {
            let pose = Pose::new(Vec3::new(1.0e-4 * part, 5.0e-5 * part, 0.019), Quat::from_rotation_z(0.01 * part));
            step(&model, params, &mut state, &mut scratch, Input { pose, dt: 1.0e-3 }).contact
        };
        let held = (0..=20).map(|i| tick(&before, i as f32 / 20.0)).last().expect("ticks");
        let taken = tick(&after, 1.0);
        assert!(held.force.truncate().length() > 1.0 && held.torque.z.abs() > 1.0e-4, "{held:?}");
        let off = (taken.force - held.force).length() / held.force.truncate().length();
        let off_torque = (taken.torque.z - held.torque.z).abs() / held.torque.z.abs();
        println!("{from:?} to {to:?}: {off:.4} {off_torque:.4}");
        assert!(off < 0.15 && off_torque < 0.15, "{from:?} to {to:?}: {held:?} {taken:?}");
    }
}

/// Mixed second difference of a corner function over the unit square about (i, j).
fn square(i: usize, j: usize, corner: impl Fn(f64, f64) -> f64) -> f64 {
    let (x, y) = (i as f64, j as f64);
    corner(x + 0.5, y + 0.5) - corner(x - 0.5, y + 0.5) - corner(x + 0.5, y - 0.5) + corner(x - 0.5, y - 0.5)
}

#[test]
fn every_entry_of_the_table_is_its_closed_form() {
    for j in 0..REACH {
        for i in 0..REACH {
            let along = square(i, j, |x, y| y * (x / y.abs()).asinh());
            let cross = square(i, j, |x, y| -x.hypot(y));
            assert!((f64::from(ALONG[j][i]) - along).abs() < 2.0e-7, "along {i} {j}: {along}");
            assert!((f64::from(CROSS[j][i]) - cross).abs() < 2.0e-7, "cross {i} {j}: {cross}");
        }
    }
    // a square's own integral of 1/r
    assert!((f64::from(2.0 * ALONG[0][0]) - 4.0 * 1.0_f64.asinh()).abs() < 1.0e-6);
    // far away a cell is a point: x^2/r^3
    assert!((f64::from(ALONG[8][15]) - 225.0 / 17.0_f64.powi(3)).abs() < 1.0e-4 * PI);
}

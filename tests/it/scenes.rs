//! The ready scenes show what the paper's figures show, in every tier, and their curves are the ones that are kept.
//!
//! What does not depend on kept curves: torque turns with the direction of the twist, the torque of two legs is force x offset, ten
//! regions are ten, nothing jumps, no region holds more than friction lets it.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, Mutex, OnceLock};
use std::thread;

use haptor_contact::{
    Flags, Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, PatchReport, Pose, ProbePart, ProbeShape, Quat,
    Scratch, State, Tier, Vec3, Wrench, patch_report, step,
};
use haptor_wire::{self as wire, scene_file::decode_file};

use crate::cli::{built, haptor, root};

#[path = "../support/golden.rs"]
mod golden;

/// Dynamic and static friction of every ready scene (the paper's table I).
const MU: f64 = 0.75;

/// The tool, built once.
fn tool() -> PathBuf {
    static TOOL: OnceLock<PathBuf> = OnceLock::new();
    TOOL.get_or_init(|| built("haptor")).clone()
}

#[test]
fn curves_are_the_kept_ones() {
    let jobs: Vec<_> = golden::all().collect();
    let wrong: Vec<String> = thread::scope(|scope| {
        let threads = jobs.iter().map(|&(scene, tier)| {
            scope.spawn(move || {
                let file = golden::file(root(), scene, tier);
                let Ok(expected) = fs::read_to_string(&file) else {
                    return Some(format!("there is no {}; make it: {}", file.display(), golden::ACCEPT));
                };
                golden::difference(scene, tier, &expected, &golden::thinned(&result(scene, tier, "")))
            })
        });
        let threads: Vec<_> = threads.collect();
        threads.into_iter().filter_map(|thread| thread.join().expect("a comparison ends")).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_difference_is_told_with_scene_tier_row_column_share_and_what_to_do() {
    let (scene, tier) = ("mallet", golden::TIERS[2]);
    let expected = "t,fz,tier\n0,4,bristle\n0.02,-8,bristle\n0.04,2,bristle\n";
    let told = golden::difference(scene, tier, expected, &expected.replace(",2,", ",2.5,").replace("-8", "-8.2")).unwrap();
    for words in ["mallet, tier bristle", "first at t = 0.02: fz is -8.2, expected -8 (2.5", "t = 0.04: fz (6.25", "--accept"] {
        assert!(told.contains(words), "{words:?} is not in {told}");
    }
    assert!(golden::difference(scene, tier, expected, &expected.replace("0.04,2,bristle\n", "")).unwrap().contains("2 rows"));
    assert_eq!(golden::difference(scene, tier, expected, expected), None);
}

/// The trajectory command that a scene's first lines show makes the trajectory beside it.
#[test]
fn the_trajectories_are_those_of_the_commands_in_the_scenes() {
    for scene in &golden::SCENES[1..] {
        let expected = fs::read_to_string(root().join(format!("tests/scenes/{scene}.csv"))).unwrap();
        assert_eq!(trajectory(scene, &[], str::to_owned), expected, "{scene}");
    }
}

/// The trajectory of the command in a scene's first lines, each word changed, and with more options.
fn trajectory(scene: &str, more: &[&str], change: impl Fn(&str) -> String) -> String {
    let text = fs::read_to_string(root().join(format!("tests/scenes/{scene}.toml"))).unwrap();
    let lines = text.lines().skip_while(|line| !line.contains("haptor trajectory")).take_while(|line| line.starts_with("#   "));
    let words: Vec<&str> = lines.flat_map(str::split_whitespace).filter(|word| !matches!(*word, "#" | "\\")).collect();
    let words = &words[1..words.iter().position(|&word| word == "-o").expect("the command ends with -o FILE")];
    let output = haptor().args(words.iter().map(|word| change(word))).args(more).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// One result: columns by name.
type Table = HashMap<String, Vec<f64>>;

/// The result of a scene over its own trajectory (empty `poses`) or over another, in a tier. Each is computed once for all tests.
fn result(scene: &str, tier: golden::Tier, poses: &str) -> Arc<String> {
    static DONE: Mutex<BTreeMap<String, Arc<OnceLock<Arc<String>>>>> = Mutex::new(BTreeMap::new());
    let key = format!("{scene} {} {poses}", tier.name);
    let place = Arc::clone(DONE.lock().unwrap().entry(key).or_default());
    Arc::clone(place.get_or_init(|| Arc::new(evaluated(scene, tier, poses))))
}

fn evaluated(scene: &str, tier: golden::Tier, poses: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut command = golden::eval(&tool(), root(), scene, tier);
    if !poses.is_empty() {
        let file = folder.path().join("poses.csv");
        fs::write(&file, poses).unwrap();
        let words: Vec<_> = command.get_args().map(ToOwned::to_owned).collect();
        command = Command::new(tool());
        command.current_dir(root()).args(&words[..2]).arg(&file).args(&words[3..]);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn table(scene: &str, tier: golden::Tier, poses: &str) -> Table {
    columns(&result(scene, tier, poses))
}

/// The numbers of a result; tier and flags are left out.
fn columns(text: &str) -> Table {
    let mut lines = text.lines();
    let names: Vec<_> = lines.next().unwrap().split(',').take(11).collect();
    let mut table: Table = names.iter().map(|name| ((*name).to_owned(), Vec::new())).collect();
    for line in lines {
        for (name, field) in names.iter().zip(line.split(',')) {
            table.get_mut(*name).unwrap().push(field.parse().unwrap());
        }
    }
    table
}

fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |peak, value| value.abs().max(peak))
}

/// The value at the last tick with t <= `time`.
fn at(table: &Table, column: &str, time: f64) -> f64 {
    let index = table["t"].iter().rposition(|&t| t <= time + 1.0e-9).unwrap();
    table[column][index]
}

/// Ends of the two twists of mallet and compass, in the rest that follows \[s\].
const TWISTED: [f64; 2] = [0.36, 0.80];

#[test]
fn the_torque_opposes_the_twist_and_turns_with_it() {
    for tier in golden::TIERS {
        for scene in ["mallet", "compass"] {
            let table = table(scene, tier, "");
            let [forth, back] = TWISTED.map(|time| at(&table, "tz", time));
            let case = format!("{scene} {}: {forth} N m forth, {back} N m back", tier.name);
            assert!(forth < 0.0 && back > 0.0, "{case}");
            assert!((forth + back).abs() <= 0.02 * peak(&table["tz"]), "{case}");
        }
    }
}

/// The mirror image of a motion gives the mirror image of its torque, tick by tick.
#[test]
fn the_mallet_twisted_the_other_way_first_feels_the_opposite() {
    let mirrored = trajectory("mallet", &[], |word| match word.strip_prefix("twist=") {
        Some(angle) => format!("twist={}", angle.strip_prefix('-').map_or(format!("-{angle}"), str::to_owned)),
        None => word.to_owned(),
    });
    for tier in golden::TIERS {
        let (one, other) = (table("mallet", tier, ""), table("mallet", tier, &mirrored));
        let torque = peak(&one["tz"]);
        for (row, (a, b)) in one["tz"].iter().zip(&other["tz"]).enumerate() {
            assert!((a + b).abs() <= 0.02 * torque, "{} row {row}: {a} and {b} N m", tier.name);
        }
    }
}

#[test]
fn ten_tips_are_ten_regions_until_they_are_lifted() {
    for tier in golden::TIERS {
        let table = table("ten-regions", tier, "");
        assert_eq!(peak(&table["regions"]), 10.0, "{}", tier.name);
        // from the end of the press to the start of the lift
        for (t, regions) in table["t"].iter().zip(&table["regions"]).filter(|(t, _)| (0.12..0.98).contains(*t)) {
            assert_eq!(*regions, 10.0, "{} at {t} s", tier.name);
        }
        let born: Vec<_> = table["regions"].windows(2).map(|pair| pair[1] - pair[0]).filter(|&change| change > 0.0).collect();
        assert_eq!(born, [1.0; 10], "{}: born one by one", tier.name);
    }
}

/// Largest step of force or torque in a tick, as a share of its peak. A press ends slowly, so that the largest step of a smooth law
/// comes where 25 um of a tick meet half the depth: about 4 % here.
const STEP: f64 = 0.05;

/// A tick of half the length takes half the step where nothing jumps, and the whole step where something does.
const HALVED: f64 = 0.6;

/// Steps up to this share of the peak need not halve: a slip front that passes one more bristle. Tier `influence` lets whole cells go where
/// the contact shrinks under a lifted, twisted probe: measured 2.6 % with 52 cells. Tier `point` forgets a turn of a compass' leg at once: measured 2.7 % of the
/// torque, 0.05 N, in one tick at 2 kHz.
fn small(tier: golden::Tier) -> f64 {
    if matches!(tier.name, "influence" | "point") { 0.03 } else { 0.01 }
}

#[test]
fn neither_force_nor_torque_jumps() {
    for tier in golden::TIERS.iter().filter(|tier| tier.name != "paper") {
        // ten regions of tier `influence` take a minute in a debug build; one and two show what ten would
        let costs = |scene: &str| scene == "ten-regions" && tier.name == "influence";
        for scene in golden::SCENES[1..].iter().filter(|scene| !costs(scene)) {
            let finer = trajectory(scene, &["--rate", "2000"], str::to_owned);
            let (whole, half) = (table(scene, *tier, ""), table(scene, *tier, &finer));
            for columns in [["fx", "fy", "fz"], ["tx", "ty", "tz"]] {
                let (size, [at_1_khz, at_2_khz]) = (largest(&whole, columns), [&whole, &half].map(|t| largest_step(t, columns)));
                let case = format!("{scene} {} {columns:?}: {at_1_khz} then {at_2_khz} of {size}", tier.name);
                assert!(at_1_khz <= STEP * size, "{case}");
                assert!(at_2_khz <= (HALVED * at_1_khz).max(small(*tier) * size), "{case}");
            }
        }
    }
}

fn largest(table: &Table, columns: [&str; 3]) -> f64 {
    (0..table["t"].len()).map(|k| columns.map(|c| table[c][k].powi(2)).iter().sum::<f64>().sqrt()).fold(0.0, f64::max)
}

fn largest_step(table: &Table, columns: [&str; 3]) -> f64 {
    let step = |k: usize| columns.map(|c| (table[c][k] - table[c][k - 1]).powi(2)).iter().sum::<f64>().sqrt();
    (1..table["t"].len()).map(step).fold(0.0, f64::max)
}

/// A scene as it is baked, in a tier whose patches can be looked into.
fn patches_over(scene: &str, tier: Tier, mut look: impl FnMut(f64, &[PatchReport], Wrench<haptor_contact::World>, Vec3)) {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("scene.model");
    haptor().args(["bake", &format!("tests/scenes/{scene}.toml"), "-o"]).arg(&model).assert().success();
    let baked = decode_file(&fs::read(model).unwrap()).unwrap();
    let parts: Vec<_> = baked.probe.as_slice().iter().map(part).collect();
    let material = Material { young_modulus: baked.young_modulus, poisson_ratio: baked.poisson_ratio, density: baked.density };
    let spec = ModelSpec { fixed_below: Some(baked.fixed_below), ..ModelSpec::new(object(&baked.object), material, &parts) };
    let samples = if tier == Tier::Influence { 52 } else { 64 };
    let spec_params = ParamsSpec { tier, samples, region_distance: baked.region_distance, ..ParamsSpec::default() };
    let (model, params) = (Model::new(&spec).unwrap(), Params::new(&spec_params).unwrap());
    let (mut state, mut scratch) = (Box::new(State::<16, 128, 128>::new()), Scratch::<16>::new());
    let poses = fs::read_to_string(root().join(format!("tests/scenes/{scene}.csv"))).unwrap();
    for row in poses.lines().skip(1) {
        let row: Vec<f64> = row.split(',').map(|field| field.parse().unwrap()).collect();
        let [x, y, z, qw, qx, qy, qz] = std::array::from_fn(|k| row[k + 1] as f32);
        let pose = Pose::new(Vec3::new(x, y, z), Quat::from_xyzw(qx, qy, qz, qw));
        let output = step(&model, &params, &mut state, &mut scratch, Input { pose, dt: 1.0e-3 });
        assert_eq!(output.report.tier, tier, "{scene}: the tier was lowered");
        assert!(!output.report.flags.contains(Flags::TIER_LOWERED), "{scene} {tier:?}: too little room");
        let patches: Vec<_> = state.patches().iter().map(patch_report).collect();
        look(row[0], &patches, output.contact, pose.position);
    }
}

fn object(shape: &wire::ObjectShape) -> ObjectShape<'static> {
    match *shape {
        wire::ObjectShape::Box { size } => ObjectShape::Box { size: Vec3::from_array(size) },
        wire::ObjectShape::Ellipsoid { semi_axes } => ObjectShape::Ellipsoid { semi_axes: Vec3::from_array(semi_axes) },
        ref other => panic!("{other:?} is in no ready scene"),
    }
}

fn part(part: &wire::ProbePart) -> ProbePart<'static> {
    let shape = match part.shape {
        wire::ProbeShape::Sphere { radius } => ProbeShape::Sphere { radius },
        wire::ProbeShape::Box { size } => ProbeShape::Box { size: Vec3::from_array(size) },
        wire::ProbeShape::Capsule { radius, height } => ProbeShape::Capsule { radius, height },
        wire::ProbeShape::Cylinder { radius, height } => ProbeShape::Cylinder { radius, height },
        wire::ProbeShape::Ellipsoid { semi_axes } => ProbeShape::Ellipsoid { semi_axes: Vec3::from_array(semi_axes) },
        ref other => panic!("{other:?} is in no ready scene"),
    };
    let [w, x, y, z] = part.rotation;
    ProbePart { shape, position: Vec3::from_array(part.position), rotation: Quat::from_xyzw(x, y, z, w) }
}

/// Torque of the compass over the legs' drag x offset: the rest is the legs' own torsion, which full slip makes
/// 3 pi/16 a / offset = 4 % for contacts of 1.7 mm radius 25 mm from the axis.
const COMPASS: std::ops::RangeInclusive<f64> = 1.0..=1.06;

#[test]
fn the_compass_feels_mostly_leg_force_times_offset() {
    for tier in [Tier::Point, Tier::Bristle, Tier::Influence] {
        let mut seen = 0;
        patches_over("compass", tier, |t, patches, felt, origin| {
            if !TWISTED.iter().any(|time| (t - time).abs() < 1.0e-6) {
                return;
            }
            assert_eq!(patches.len(), 2, "{tier:?} at {t} s");
            let of_forces: f32 = patches.iter().map(|p| (p.centre - origin).cross(p.force).z).sum();
            let share = f64::from(felt.torque.z / of_forces);
            assert!(COMPASS.contains(&share), "{tier:?} at {t} s: {share}");
            seen += 1;
        });
        assert_eq!(seen, 2, "{tier:?}");
    }
}

/// A region may hold this much more than friction allows: rounding, and the fit of the two budgets' curve (PHYSICS 3.2).
const OVER: f64 = 1.03;

#[test]
fn no_region_holds_more_than_friction_lets_it_and_sticking_ones_stand_beside_slipping_ones() {
    for tier in [Tier::Point, Tier::Bristle, Tier::Influence] {
        for scene in golden::SCENES.into_iter().filter(|&scene| scene != "ten-regions" || tier != Tier::Influence) {
            let (mut worst, mut mixed) = (0.0_f64, false);
            patches_over(scene, tier, |_, patches, _, _| {
                worst = patches.iter().map(|patch| budget(patch, longer(scene))).fold(worst, f64::max);
                let sticks = |least: f32, most: f32| patches.iter().any(|p| p.stick >= least && p.stick <= most);
                mixed |= sticks(0.3, 1.0) && sticks(0.0, 0.05);
            });
            assert!(worst <= OVER, "{scene} {tier:?}: {worst} of the friction budget");
            assert!(worst >= 0.95, "{scene} {tier:?}: never near slip, {worst}");
            assert!(mixed || scene != "ten-regions", "{tier:?}: no region sticks while another slips");
        }
    }
}

/// Torque of full slip over that of a round contact: the mallet's is 1.8 times longer than wide (theory.md, equation 5.5).
fn longer(scene: &str) -> f64 {
    if scene == "mallet" { 1.065 } else { 1.0 }
}

/// Share of the friction budget that a region uses: (Q/(mu P))^1.725 + (T/T_max)^1.725, T_max `longer` times that of a round contact.
fn budget(patch: &PatchReport, longer: f64) -> f64 {
    let load = f64::from(patch.force.dot(patch.normal));
    if load <= 0.0 {
        return 0.0;
    }
    let drag = f64::from((patch.force - patch.normal * patch.force.dot(patch.normal)).length());
    let most = 3.0 * std::f64::consts::PI / 16.0 * MU * load * f64::from(patch.radius) * longer;
    (drag / (MU * load)).powf(1.725) + (f64::from(patch.torque.dot(patch.normal).abs()) / most).powf(1.725)
}

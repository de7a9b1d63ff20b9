//! The dearest inputs that a search has found for the ready scenes stay as dear as they are, and the command that finds them keeps what it says.
//!
//! The inputs lie in `tests/bench/worst`, their counts in `tests/bench/WORST.md`; `cargo xtask timing --kept` counts them anew, `cargo xtask timing` searches anew.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::{build, haptor, released, root};

#[path = "../support/worst.rs"]
mod worst;

use crate::counts::counting::callgrind::{self, Job};
use worst::{Kept, rows};

/// How much a count may grow.
const GROWTH: f64 = 1.02;

fn table() -> Vec<Kept> {
    let file = worst::table_file(Path::new(root()));
    let text =
        fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}; make it: cargo xtask timing", file.display()));
    let rows = rows(&text);
    let inputs = fs::read_dir(root().join(worst::FOLDER)).unwrap().count();
    assert!(inputs > 0 && rows.len() == inputs, "{} has {} rows for {inputs} inputs", file.display(), rows.len());
    rows
}

/// Instructions of the dearest tick of a kept input at a level, by the released program.
fn counted(program: &Path, kept: &Kept, level: &[String]) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("ticks.haptor");
    haptor()
        .arg("record")
        .arg("-o")
        .arg(&recording)
        .arg(kept.scene_file())
        .arg("--trajectory")
        .arg(kept.input())
        .assert()
        .success();
    let file = recording.to_string_lossy();
    let args: Vec<&str> = [&*file].into_iter().chain(level.iter().map(String::as_str)).chain(["count"]).collect();
    let marked = &["haptor_host::measure::run::measured_tick"];
    let job = Job { program, args: &args, keep: &[], pattern: "*measured_*", marked, lines: false, folder: folder.path() };
    let said: Value = serde_json::from_str(&job.run().unwrap()).unwrap();
    let ticks = said["ticks"].as_u64().unwrap() as usize;
    (0..ticks).map(|call| callgrind::total(&job.dump(call).unwrap()).unwrap()).max().unwrap()
}

#[test]
fn no_worst_tick_grew_beyond_the_table() {
    let program = released("haptor-host", "haptor-measure");
    let grown: Vec<_> = table()
        .iter()
        .filter_map(|kept| {
            let found = counted(&program, kept, &kept.args());
            let growth = found as f64 / kept.worst as f64;
            (growth > GROWTH).then(|| {
                format!("{}: {found} instructions, the table has {} ({:+.1} %)", kept.name(), kept.worst, 100.0 * (growth - 1.0))
            })
        })
        .collect();
    assert!(grown.is_empty(), "{}\nif this is the price of something: cargo xtask timing --kept", grown.join("\n"));
}

/// A budget that a tick is given is kept on the dearest inputs that a search with that budget has found, and on those that are dearest without one.
#[test]
fn a_tick_with_a_budget_costs_no_more_than_that() {
    let program = released("haptor-host", "haptor-measure");
    let (within, free): (Vec<_>, Vec<_>) = table().into_iter().partition(|kept| kept.work().is_some());
    assert!(!within.is_empty(), "no row has a budget");
    for kept in &within {
        let work: u64 = kept.work().and_then(|work| work.parse().ok()).unwrap();
        assert!(kept.worst <= work, "{}: {} instructions", kept.name(), kept.worst);
        for other in free.iter().filter(|other| other.scene == kept.scene) {
            let found = counted(&program, other, &kept.args());
            assert!(found <= work, "{}, input of {}: {found} instructions", kept.name(), other.name());
        }
    }
}

#[test]
fn what_the_search_found_is_no_cheaper_than_the_fixed_motions() {
    for kept in table() {
        assert!(kept.worst >= kept.motions, "{}: a fixed motion costs more; search anew: cargo xtask timing", kept.name());
    }
}

/// The tool of this build beside the released measuring program.
fn folder_of_programs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let put = |from: PathBuf, name: &str| fs::copy(from, folder.path().join(name)).unwrap();
    put(crate::cli::built("haptor"), "haptor");
    put(released("haptor-host", "haptor-measure"), "haptor-measure");
    folder
}

/// The table's second column is no invention: today's fixed motions of one scene are not dearer than its kept inputs.
#[test]
fn fixed_motions_of_the_cube_cost_no_more_than_the_table_says() {
    let programs = folder_of_programs();
    let mut tool = assert_cmd::Command::new(programs.path().join("haptor"));
    let args = ["timing", "tests/scenes/cube-twist.toml", "--search-seconds", "0", "--ticks", "0", "--json"];
    let said = tool.current_dir(root()).args(args).assert().success();
    let report: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
    for level in report["levels"].as_array().unwrap() {
        let name = format!("cube-twist, {}", level["name"].as_str().unwrap());
        let kept = table().into_iter().find(|kept| kept.name() == name).unwrap_or_else(|| panic!("no row {name}"));
        let motions = level["motions"].as_array().unwrap().iter().filter(|motion| motion["plain"] == true);
        let worst = motions.map(|motion| motion["worst"].as_u64().unwrap()).max().unwrap();
        assert!(
            worst as f64 <= GROWTH * kept.worst as f64,
            "{name}: a fixed motion costs {worst}, the kept input {}",
            kept.worst
        );
        let stages: u64 = level["stages"].as_object().unwrap().values().map(|count| count.as_u64().unwrap()).sum();
        assert_eq!(stages, level["dearest"]["cost"].as_u64().unwrap(), "{name}: stages do not add up");
    }
    let of_two = |why: &str| why.starts_with("cannot be: the probe has one part");
    let missing: Vec<_> = unmet(&report).into_iter().filter(|(_, why)| !of_two(why)).collect();
    assert_eq!(missing, [], "not exercised");
    let vertices = report["levels"].as_array().unwrap().iter().flat_map(|level| level["units"].as_array().unwrap());
    let costs: Vec<_> = vertices.filter(|unit| unit["one_more"] == "vertex of the surface").collect();
    assert_eq!(costs.len(), report["levels"].as_array().unwrap().len());
    // the surface is computed alike in every tier: a vertex under one patch, with the motion of the body
    assert!(costs.iter().all(|unit| (100.0..500.0).contains(&unit["cost"].as_f64().unwrap())), "{costs:?}");
}

/// Conditions that were not met, and why.
fn unmet(report: &Value) -> Vec<(String, String)> {
    let listed = report["exercised"]["not_met"].as_object().unwrap();
    listed.iter().map(|(condition, why)| (condition.clone(), why.as_str().unwrap().to_owned())).collect()
}

const TWO_BALLS: &str = "\
[object]
shape = 'box'
size = [0.1, 0.1, 0.1]
young_modulus = 3.0e6
poisson_ratio = 0.5
density = 1100.0
compliance = { normal = 0.0, drag = 1.0e-5, twist = 1.0e-2 }

[probe]
shape = 'compound'
mass = 1.0

[[probe.part]]
shape = 'sphere'
radius = 0.01
position = [-0.02, 0.0, 0.0]

[[probe.part]]
shape = 'sphere'
radius = 0.01
position = [0.02, 0.0, 0.0]

[friction]
dynamic = 0.75
";

/// Every branch is exercised where the probe has two parts, and what is known before is measured too.
#[test]
fn two_parts_bring_about_every_condition() {
    let (programs, folder) = (folder_of_programs(), tempfile::tempdir().unwrap());
    let scene = folder.path().join("two-balls.toml");
    fs::write(&scene, TWO_BALLS).unwrap();
    // a motion that costs next to nothing and is dearer than no other
    let known = folder.path().join("two-balls-point.csv");
    fs::write(&known, "t,px,py,pz,qw,qx,qy,qz\n0,0,0,0.2,1,0,0,0\n0.001,0,0,0.2,1,0,0,0\n").unwrap();
    let mut tool = assert_cmd::Command::new(programs.path().join("haptor"));
    let args = ["timing", "two-balls.toml", "--search-seconds", "0", "--ticks", "1000000000", "--time-seconds", "1", "--json"];
    let said = tool.current_dir(folder.path()).args(args).args(["--known", "."]).assert().success();
    let report: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
    assert_eq!(unmet(&report), [], "not exercised");
    let of_merged = |level: &Value| {
        level["motions"].as_array().unwrap().iter().any(|m| m["motion"].as_str() == Some("one region of all patches, 2 parts"))
    };
    assert!(report["levels"].as_array().unwrap().iter().all(of_merged));
    assert_eq!(report["other_coupling"]["name"], "virtual coupling");
    for level in report["levels"].as_array().unwrap() {
        let ticks = level["time"]["ticks"].as_u64().unwrap();
        assert!(0 < ticks && ticks < 1_000_000_000, "a run ends when its time is over: {ticks}");
    }
}

#[test]
fn a_seed_finds_the_same_twice_and_what_is_saved_is_computed_again() {
    let (programs, folder) = (folder_of_programs(), tempfile::tempdir().unwrap());
    let run = |name: &str| {
        let saved = folder.path().join(name);
        let args = [
            "timing",
            "tests/scenes/cube-twist.toml",
            "--tier",
            "point",
            "--generations",
            "2",
            "--seed",
            "5",
            "--ticks",
            "0",
            "--json",
        ];
        let mut tool = assert_cmd::Command::new(programs.path().join("haptor"));
        tool.current_dir(root());
        let said = tool.args(args).arg("--save").arg(&saved).assert().success().get_output().stdout.clone();
        haptor().arg("replay").arg(&saved).arg("--verify").assert().success();
        (said, fs::read(&saved).unwrap())
    };
    assert_eq!(run("first.haptor"), run("second.haptor"));
}

#[test]
fn what_cannot_be_measured_is_told() {
    build("haptor-host");
    for (args, part) in [
        (&["tests/scenes/cube-twist.toml", "--tier", "bristle", "--samples", "9"][..], "16"),
        (&["tests/scenes/cube-twist.toml", "--tier", "green"], "table"),
        (&["tests/scenes/cube-twist.toml", "--poses", "missing.csv"], "missing.csv"),
        (&["tests/scenes/cube-twist.toml", "--rate", "9"], "100"),
    ] {
        let assert = haptor().arg("timing").args(args).assert().code(2);
        let said = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
        assert!(said.contains(part), "{args:?}: {said}");
    }
}

//! `haptor trade`: errors and instructions of a first look at the ready scenes are those that are kept in `tests/bench/trade.json`, and the recommendation follows them.
//!
//! The released tool is asked: its instructions are what is shipped, and its errors are those of every build.

use std::fs;
use std::process::Command;

use serde_json::Value;

use crate::cli::{released, root};

/// How far an error may move, as a share of its scale, before the kept table is out of date: half of what the tables show.
const TOLERANCE: f64 = 5.0e-4;

/// How much instructions may grow.
const GROWTH: f64 = 1.02;

/// What to do about a difference.
const SAID: &str = "if it is meant, run `cargo xtask trade`";

fn tool() -> Command {
    let mut command = Command::new(released("haptor", "haptor"));
    command.current_dir(root());
    command
}

fn first_look(scene: &str) -> Value {
    let scene = format!("tests/scenes/{scene}.toml");
    let output = tool().args(["trade", &scene, "--quick", "--no-time", "--json"]).output().expect("the tool can be started");
    assert!(output.status.success(), "{scene}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

fn points(scene: &Value) -> &Vec<Value> {
    scene["points"].as_array().expect("a list of points")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Every error of a point, with its name.
fn errors(point: &Value) -> Vec<(String, f64)> {
    let felt = ["normal", "twist", "mixed", "reversal"].map(|figure| (figure, &point["errors"][figure]));
    let seen = ["full", "local"].map(|level| (level, &point["surface"][level]));
    let all = felt.into_iter().chain(seen);
    all.flat_map(|(name, off)| ["max", "rms"].map(|kind| (format!("{name} {kind}"), number(&off[kind])))).collect()
}

#[test]
fn a_first_look_is_the_one_that_is_kept() {
    let kept = fs::read_to_string(root().join("tests/bench/trade.json")).expect("the table is kept");
    let kept: Vec<Value> = serde_json::from_str(&kept).expect("the table parses");
    let scenes = fs::read_dir(root().join("tests/scenes")).unwrap();
    let scenes = scenes.filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|its| its == "toml")).count();
    assert_eq!(kept.len(), scenes, "scenes kept, and ready; {SAID}");
    for scene in kept {
        let name = scene["scene"].as_str().expect("a scene has a name");
        let found = first_look(name);
        assert_eq!(found["unconverged"], 0, "{name}");
        assert_eq!(points(&found).len(), points(&scene).len(), "{name}: points; {SAID}");
        for (now, then) in points(&found).iter().zip(points(&scene)) {
            let setting = &now["setting"];
            assert_eq!(*setting, then["setting"], "{name}; {SAID}");
            for ((figure, now), (_, then)) in errors(now).into_iter().zip(errors(then)) {
                assert!((now - then).abs() < TOLERANCE, "{name}, {setting}, {figure}: {now}, kept is {then}; {SAID}");
            }
            let [now, then] = [now, then].map(|point| number(&point["cost"]["worst_instructions"]));
            assert!(now > 0.0 && now <= GROWTH * then, "{name}, {setting}: {now} instructions, kept are {then}; {SAID}");
        }
    }
}

/// On the ball on the cube bristles are better than closed curves where a path turns, and both meet the truth in a plain twist.
#[test]
fn the_recommendation_follows_the_errors() {
    let found = first_look("cube-twist");
    let worst = |setting: &str, figure: &str| {
        let points = found["points"].as_array().expect("points");
        let point = points.iter().find(|point| point["setting"] == setting).expect("the setting was tried");
        point["errors"][figure]["max"].as_f64().expect("a number")
    };
    assert!(worst("bristle 64", "twist") < 0.03 && worst("point", "twist") < 0.03);
    assert!(worst("bristle 64", "mixed") < worst("point", "mixed"));
    let recommended = found["recommended"].as_str().expect("a setting");
    assert!(recommended.starts_with("bristle"), "{recommended}");
}

/// Limits that nothing meets change no file and are told.
#[test]
fn nothing_is_written_where_nothing_meets_the_limits() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("ball.toml");
    let text = fs::read_to_string(root().join("tests/scenes/cube-twist.toml")).expect("a ready scene");
    fs::write(&scene, &text).expect("a writable folder");
    let asked = |error: &str| {
        let mut command = tool();
        command.arg("trade").arg(&scene).args(["--quick", "--no-cost", "--tier=point", "--write", "--error", error]);
        command.output().expect("the tool can be started")
    };
    assert_eq!(asked("0.1").status.code(), Some(1));
    assert_eq!(fs::read_to_string(&scene).unwrap(), text);
    assert_eq!(asked("1000").status.code(), Some(0));
    assert_eq!(fs::read_to_string(&scene).unwrap(), text.replace("tier = \"bristle\"", "tier = \"point\""));
}

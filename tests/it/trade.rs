//! `haptor trade`: the errors of a first look at the ready scenes are those that are kept in `tests/bench/trade.json`, and the recommendation follows them.

use std::fs;

use serde_json::Value;

use crate::cli::{haptor, root};

/// How far an error may move, as a share of its scale, before the kept table is out of date: half of what the tables show.
const TOLERANCE: f64 = 5.0e-4;

/// Tiers that are tried again.
const TIERS: [&str; 2] = ["point", "bristle"];

fn first_look(scene: &str) -> Value {
    let scene = format!("tests/scenes/{scene}.toml");
    let mut command = haptor();
    command.args(["trade", &scene, "--quick", "--no-cost", "--json"]).args(TIERS.map(|tier| format!("--tier={tier}")));
    let output = command.output().expect("the tool can be started");
    assert!(output.status.success(), "{scene}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

#[test]
fn errors_of_a_first_look_are_those_that_are_kept() {
    let kept = fs::read_to_string(root().join("tests/bench/trade.json")).expect("the table is kept");
    let kept: Vec<Value> = serde_json::from_str(&kept).expect("the table parses");
    assert!(kept.len() >= 4, "{} scenes", kept.len());
    for scene in kept {
        let name = scene["scene"].as_str().expect("a scene has a name");
        let found = first_look(name);
        assert_eq!(found["unconverged"], 0, "{name}");
        let points = found["points"].as_array().expect("a list of points");
        assert!(points.len() >= 3, "{name}: {} points", points.len());
        for point in points {
            let setting = &point["setting"];
            let same = scene["points"].as_array().expect("points").iter().find(|kept| kept["setting"] == *setting);
            let same = same.unwrap_or_else(|| panic!("{name}: {setting} is not kept; run `cargo xtask trade --errors`"));
            for figure in ["normal", "twist", "mixed", "reversal"] {
                for kind in ["max", "rms"] {
                    let read = |of: &Value| of["errors"][figure][kind].as_f64().expect("a number");
                    let (now, then) = (read(point), read(same));
                    let said = "if it is meant, run `cargo xtask trade`";
                    assert!((now - then).abs() < TOLERANCE, "{name}, {setting}, {figure} {kind}: {now}, kept is {then}; {said}");
                }
            }
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
        let mut command = haptor();
        command.arg("trade").arg(&scene).args(["--quick", "--no-cost", "--tier=point", "--write", "--error", error]);
        command.output().expect("the tool can be started")
    };
    assert_eq!(asked("0.1").status.code(), Some(1));
    assert_eq!(fs::read_to_string(&scene).unwrap(), text);
    assert_eq!(asked("1000").status.code(), Some(0));
    assert_eq!(fs::read_to_string(&scene).unwrap(), text.replace("tier = \"bristle\"", "tier = \"point\""));
}

//! Every malformed scene or trajectory ends with exit 2, names file, line, key or row and what is allowed, and writes nothing.

use std::fs;
use std::path::Path;

use crate::cli::{haptor, root};

/// A scene that is good; each row of a table spoils one thing.
const SCENE: &str = r#"[object]
shape = "box"
size = [0.1, 0.1, 0.1]
young_modulus = 3.0e6
poisson_ratio = 0.5
density = 1100.0

[probe]
shape = "sphere"
radius = 0.02
mass = 1.0

[friction]
static = 0.8
dynamic = 0.75

[contact]
region_distance = 0.004
max_regions = 10

[model]
tier = "bristle"
samples = 64
sweeps = 4
deformation = "full"
coupling = "direct"
breakaway = "smooth"
gravity = false
"#;

const HEAD: &str = "t,px,py,pz,qw,qx,qy,qz\n";
const ROW: &str = "0,0,0,0.119,1,0,0,0\n";

/// Runs `eval` on the texts in a folder of its own; yields exit code and standard error, having made sure that nothing was written.
fn eval(scene: &[u8], trajectory: &[u8], more: &[&str]) -> (i32, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("s.toml"), scene).unwrap();
    fs::write(path("t.csv"), trajectory).unwrap();
    let output =
        haptor().current_dir(folder.path()).args(["eval", "s.toml", "t.csv", "-o", "out.csv"]).args(more).output().unwrap();
    let code = output.status.code().expect("not killed");
    if code != 0 {
        assert!(output.stdout.is_empty(), "a failure prints nothing on standard output");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "a failure writes nothing");
    }
    (code, String::from_utf8(output.stderr).unwrap())
}

fn refused(name: &str, (code, message): (i32, String), parts: &[&str]) {
    assert_eq!(code, 2, "{name}: {message}");
    for part in parts {
        assert!(message.contains(part), "{name}: {message:?} lacks {part:?}");
    }
    assert_eq!(message.lines().count(), 1, "{name}: one line, not {message:?}");
}

#[test]
fn the_unspoilt_scene_is_good() {
    assert_eq!(eval(SCENE.as_bytes(), format!("{HEAD}{ROW}").as_bytes(), &[]), (0, String::new()));
}

#[test]
fn a_spoilt_scene_is_refused_by_line_key_value_and_range() {
    let table: &[(&str, &str, &[&str])] = &[
        // what is replaced, by what, what the message says
        ("young_modulus = 3.0e6", "young_modulus = -3e6", &["s.toml:4:", "object.young_modulus = -3e6", "1e2 to 1e12 Pa"]),
        ("young_modulus = 3.0e6", "young_modulus = nan", &["s.toml:4:", "object.young_modulus = nan", "1e2 to 1e12 Pa"]),
        ("young_modulus = 3.0e6", "young_modulus = inf", &["s.toml:4:", "object.young_modulus = inf", "1e2 to 1e12 Pa"]),
        ("young_modulus = 3.0e6", "young_modulus = 1e39", &["s.toml:4:", "object.young_modulus = 1e39", "1e2 to 1e12 Pa"]),
        ("young_modulus = 3.0e6", "young_modulus = \"3e6\"", &["s.toml:4:", "\"3e6\"", "type string", "young_modulus = 3.0e6"]),
        ("young_modulus = 3.0e6", "young_modulus = true", &["s.toml:4:", "type boolean"]),
        ("young_modulus = 3.0e6\n", "", &["s.toml:1:", "object.young_modulus is missing", "add young_modulus = 3.0e6"]),
        ("poisson_ratio = 0.5", "poisson_ratio = 0.51", &["s.toml:5:", "object.poisson_ratio = 0.51", "0 to 0.5"]),
        ("density = 1100.0", "density = 0", &["s.toml:6:", "object.density = 0", "above 0"]),
        ("size = [0.1, 0.1, 0.1]", "size = [0.1, 0.1]", &["s.toml:3:", "object.size = [0.1, 0.1]", "three edge lengths"]),
        ("size = [0.1, 0.1, 0.1]", "size = [0.1, 0.1, -0.1]", &["s.toml:3:", "object.size = [0.1, 0.1, -0.1]", "1e-6 to 1e2 m"]),
        ("size = [0.1, 0.1, 0.1]", "size = [0.1, 0.1, \"a\"]", &["s.toml:3:", "type string", "three edge lengths"]),
        ("size = [0.1, 0.1, 0.1]", "size = 0.1", &["s.toml:3:", "object.size = 0.1", "type float"]),
        ("size = [0.1, 0.1, 0.1]", "sise = [0.1, 0.1, 0.1]", &["s.toml:3:", "object.sise", "did you mean size?"]),
        ("size = [", "colour = \"red\"\nsize = [", &["s.toml:3:", "object.colour", "unknown key", "shape box", "young_modulus"]),
        ("size = [", "radius = 0.1\nsize = [", &["s.toml:3:", "object.radius", "unknown key", "shape box"]),
        ("shape = \"box\"", "shape = \"boks\"", &["s.toml:2:", "object.shape = \"boks\"", "half_space", "did you mean box?"]),
        ("shape = \"box\"", "shape = \"mesh\"", &["s.toml:3:", "object.size", "unknown key", "did you mean file?"]),
        ("shape = \"box\"", "shape = \"half_space\"", &["s.toml:3:", "object.size", "shape half_space"]),
        ("density", "fixed_below = 0.1\ndensity", &["s.toml:6:", "object.fixed_below = 0.1", "below the object's height"]),
        (
            "density",
            "compliance = { normal = 0.0, drag = -1.0, twist = 0.0 }\ndensity",
            &["s.toml:6:", "object.compliance.drag = -1.0"],
        ),
        ("density", "compliance = { normal = 0.0, drag = 0.0 }\ndensity", &["s.toml:6:", "object.compliance.twist is missing"]),
        ("density", "compliance = 3\ndensity", &["s.toml:6:", "object.compliance = 3", "type integer", "normal, drag and twist"]),
        ("radius = 0.02", "radius = 0", &["s.toml:10:", "probe.radius = 0", "1e-6 to 1e2 m"]),
        ("radius = 0.02", "radius = 0.02\nsize = [1, 1, 1]", &["s.toml:11:", "probe.size", "shape sphere"]),
        ("radius = 0.02", "radius = 0.02\nheight = 0.1", &["s.toml:11:", "probe.height", "shape sphere"]),
        ("shape = \"sphere\"", "shape = \"mesh\"", &["s.toml:8:", "probe.file is missing", "STL, OBJ or PLY file"]),
        ("shape = \"sphere\"", "shape = \"cone\"", &["s.toml:8:", "probe.height is missing"]),
        ("shape = \"sphere\"\nradius = 0.02", "shape = \"compound\"\npart = []", &["s.toml:10:", "probe.part", "1 to 16"]),
        (
            "shape = \"sphere\"\nradius = 0.02",
            "shape = \"compound\"\npart = [{ shape = \"sphere\", radius = 0.01 }, { shape = \"sphere\", radius = -1 }]",
            &["s.toml:10:", "probe.part[1].radius = -1", "1e-6 to 1e2 m"],
        ),
        (
            "shape = \"sphere\"\nradius = 0.02",
            "shape = \"compound\"\npart = [{ shape = \"sphere\", radius = 0.01, rotation = [1.1, 0, 0, 0] }]",
            &["s.toml:10:", "probe.part[0].rotation = [1.1, 0, 0, 0]", "unit quaternion"],
        ),
        (
            "shape = \"sphere\"\nradius = 0.02",
            "shape = \"compound\"\npart = [{ shape = \"sphere\", radius = 0.01, position = [2e3, 0, 0] }]",
            &["s.toml:10:", "probe.part[0].position = [2e3, 0, 0]", "1e3 m"],
        ),
        ("mass = 1.0", "mass = -1", &["s.toml:11:", "probe.mass = -1", "0 to 1e4 kg"]),
        ("static = 0.8", "static = 0.7", &["s.toml:14:", "friction.static = 0.7", "friction.dynamic to 10"]),
        ("dynamic = 0.75", "dynamic = 11", &["s.toml:15:", "friction.dynamic = 11", "0 to 10"]),
        ("dynamic = 0.75\n", "", &["s.toml:13:", "friction.dynamic is missing"]),
        ("[friction]\nstatic = 0.8\ndynamic = 0.75\n", "", &["friction is missing", "dynamic = 0.75"]),
        ("region_distance = 0.004", "region_distance = -1", &["s.toml:18:", "contact.region_distance = -1"]),
        ("max_regions = 10", "max_regions = 11", &["s.toml:19:", "contact.max_regions = 11", "1 to 10"]),
        ("max_regions = 10", "max_regions = 2.5", &["s.toml:19:", "contact.max_regions = 2.5", "whole number"]),
        ("max_regions = 10", "max_regions = -1", &["s.toml:19:", "contact.max_regions = -1", "1 to 10"]),
        (
            "tier = \"bristle\"",
            "tier = \"exact\"",
            &["s.toml:22:", "model.tier = \"exact\"", "point, paper, bristle, influence or green"],
        ),
        ("tier = \"bristle\"", "tier = \"influence\"", &["model.samples = 64", "52 or 112 for tiers influence and green"]),
        ("tier = \"bristle\"", "tier = \"green\"", &["model.samples = 64", "52 or 112 for tiers influence and green"]),
        ("samples = 64", "samples = 15", &["s.toml:23:", "model.samples = 15", "16 to"]),
        ("samples = 64", "samples = 1000000000000000000000", &["s.toml:23:", "model.samples"]),
        ("sweeps = 4", "sweeps = 0", &["s.toml:24:", "model.sweeps = 0", "1 to 32"]),
        (
            "deformation = \"full\"",
            "deformation = \"some\"",
            &["s.toml:25:", "model.deformation = \"some\"", "none, local or full"],
        ),
        ("coupling = \"direct\"", "coupling = \"virtuel\"", &["s.toml:26:", "direct or virtual", "did you mean virtual?"]),
        (
            "[model]",
            "[coupling]\nmax_force = 3\n\n[model]",
            &["s.toml:21:", "coupling", "needs coupling = \"virtual\" in [model]"],
        ),
        ("breakaway = \"smooth\"", "breakaway = 1", &["s.toml:27:", "model.breakaway = 1", "smooth or sharp"]),
        ("gravity = false", "gravity = 9.81", &["s.toml:28:", "model.gravity = 9.81", "true or false"]),
        ("gravity", "work = 9999\ngravity", &["s.toml:28:", "model.work = 9999", "1e4 to 1e9"]),
        ("gravity", "work = 5000000000\ngravity", &["s.toml:28:", "model.work = 5000000000", "1e4 to 1e9"]),
        ("gravity", "work = 1.5e5\ngravity", &["s.toml:28:", "model.work = 1.5e5", "whole number"]),
        ("gravity", "paper_length = 0.0\ngravity", &["s.toml:28:", "model.paper_length = 0.0", "1e-6 to 1e2 m"]),
        (
            "gravity",
            "force_law = { kind = \"cube\" }\ngravity",
            &["s.toml:28:", "model.force_law.kind = \"cube\"", "did you mean cubic?"],
        ),
        ("gravity", "force_law = { kind = \"cubic\", k1 = -1, k3 = 0 }\ngravity", &["s.toml:28:", "model.force_law.k1 = -1"]),
        ("gravity", "force_law = { kind = \"hertz\", k1 = 1 }\ngravity", &["s.toml:28:", "model.force_law.k1", "unknown key"]),
        ("gravity", "force_law = { kind = \"table\", step = 1e-4, force = [0, 1] }\ngravity", &["s.toml:28:", "16 numbers"]),
        ("[model]", "[guard]\nmax_force = 0\n\n[model]", &["s.toml:22:", "guard.max_force = 0", "above 0"]),
        ("[model]", "[guard]\nmax_forces = 1\n\n[model]", &["s.toml:22:", "guard.max_forces", "did you mean max_force?"]),
        (
            "[model]",
            "[guard.passivity]\ndelay_ticks = 9\n\n[model]",
            &["s.toml:22:", "guard.passivity.delay_ticks = 9", "0 to 8"],
        ),
        ("[model]", "[guard.passivity]\nreserve = 0\n\n[model]", &["s.toml:22:", "guard.passivity.reserve = 0", "above 0 J"]),
        ("[model]", "[guard.passivity]\nmax_dampin = 0\n\n[model]", &["s.toml:22:", "did you mean max_damping?"]),
        ("[model]", "[guard]\npassivity = true\n\n[model]", &["s.toml:22:", "guard.passivity = true", "max_damping"]),
        ("[model]", "[modle]", &["s.toml:21:", "modle", "did you mean model?"]),
        ("[model]", "[extra]\n\n[model]", &["s.toml:21:", "extra", "unknown key", "friction"]),
        ("[model]", "[model", &["s.toml:21:", "not TOML"]),
        ("[model]", "[contact]", &["s.toml:21:", "not TOML"]),
        ("mass = 1.0", "mass = 1.0\nmass = 2.0", &["s.toml:12:", "not TOML"]),
        ("[object]", "object = 3\n[other]", &["s.toml:1:", "object = 3", "type integer"]),
    ];
    for (old, new, parts) in table {
        assert!(SCENE.contains(old), "{old:?} is not in the scene");
        let scene = SCENE.replacen(old, new, 1);
        refused(new, eval(scene.as_bytes(), format!("{HEAD}{ROW}").as_bytes(), &[]), parts);
    }
}

#[test]
fn a_spoilt_coupling_is_refused_by_line_key_value_and_range() {
    let good = SCENE.replace("\"direct\"", "\"virtual\"");
    let table: &[(&str, &[&str])] = &[
        ("translational_stiffness = 0", &["s.toml:31:", "coupling.translational_stiffness = 0", "1 to 1e6 N/m"]),
        ("translational_stiffness = \"hard\"", &["s.toml:31:", "type string", "translational_stiffness = 800.0"]),
        ("rotational_stiffness = 1e5", &["s.toml:31:", "coupling.rotational_stiffness = 1e5", "1e-4 to 1e4 N m/rad"]),
        ("translational_damping = -1", &["s.toml:31:", "coupling.translational_damping = -1", "0 to 1e5 N s/m"]),
        ("rotational_damping = inf", &["s.toml:31:", "coupling.rotational_damping = inf", "0 to 1e3 N m s/rad"]),
        ("max_force = 0", &["s.toml:31:", "coupling.max_force = 0", "above 0, or infinity"]),
        ("max_torque = -0.1", &["s.toml:31:", "coupling.max_torque = -0.1", "above 0, or infinity"]),
        (
            "stiffness = 800",
            &["s.toml:31:", "coupling.stiffness", "unknown key", "translational_stiffness, rotational_stiffness"],
        ),
    ];
    for (line, parts) in table {
        let scene = format!("{good}\n[coupling]\n{line}\n");
        refused(line, eval(scene.as_bytes(), format!("{HEAD}{ROW}").as_bytes(), &[]), parts);
    }
    let scene = format!("{good}\n[coupling]\nmax_torque = inf\n");
    assert_eq!(eval(scene.as_bytes(), format!("{HEAD}{ROW}").as_bytes(), &[]), (0, String::new()));
}

#[test]
fn a_scene_that_is_no_text_or_not_there_is_refused() {
    let good = format!("{HEAD}{ROW}");
    refused("empty", eval(b"", good.as_bytes(), &[]), &["s.toml:1:", "object is missing"]);
    refused("bytes", eval(b"[object]\n\xff\xfe", good.as_bytes(), &[]), &["s.toml:2:", "not UTF-8"]);
    refused("huge", eval(&vec![b'#'; 2 << 20], good.as_bytes(), &[]), &["s.toml:", "1048576"]);
    let output = haptor().args(["eval", "no-such.toml", "t.csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no-such.toml: cannot be read"));
}

#[test]
fn a_spoilt_trajectory_is_refused_by_row_column_value_and_rule() {
    let table: &[(&str, &str, &[&str])] = &[
        ("nothing", "", &["t.csv:1:", "empty", "t,px,py,pz,qw,qx,qy,qz"]),
        ("no rows", HEAD, &["t.csv:1:", "no rows"]),
        ("no header", ROW, &["t.csv:1:", "header", "t,px,py,pz,qw,qx,qy,qz"]),
        ("another header", "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n", &["t.csv:1:", "\"t,x,y,z,qw,qx,qy,qz\"", "must be t,px"]),
        ("header in other order", "t,px,py,pz,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n", &["t.csv:1:", "must be t,px,py,pz,qw"]),
        ("seven columns", "{}0,0,0,0.1,1,0,0\n", &["t.csv:2:", "7 columns", "must be 8"]),
        ("nine columns", "{}{row}1,0,0,0.1,1,0,0,0,0\n", &["t.csv:3:", "9 columns"]),
        ("a word", "{}0,0,0,high,1,0,0,0\n", &["t.csv:2:", "column pz = \"high\"", "must be a number"]),
        ("a gap", "{}0,,0,0.1,1,0,0,0\n", &["t.csv:2:", "column px", "is empty"]),
        ("not a number", "{}0,0,nan,0.1,1,0,0,0\n", &["t.csv:2:", "column py = \"nan\"", "must be finite"]),
        ("infinity", "{}{row}inf,0,0,0.1,1,0,0,0\n", &["t.csv:3:", "column t = \"inf\"", "must be finite"]),
        ("overflow", "{}0,0,0,1e400,1,0,0,0\n", &["t.csv:2:", "column pz = \"1e400\"", "must be finite"]),
        ("too far", "{}0,1000.5,0,0.1,1,0,0,0\n", &["t.csv:2:", "column px = \"1000.5\"", "-1000 to 1000 m"]),
        ("too late", "{}2e9,0,0,0.1,1,0,0,0\n", &["t.csv:2:", "column t = \"2e9\"", "1e9 s"]),
        ("same time", "{}{row}0,0,0,0.1,1,0,0,0\n", &["t.csv:3:", "column t = \"0\"", "time must increase"]),
        ("time back", "{}{row}-0.1,0,0,0.1,1,0,0,0\n", &["t.csv:3:", "column t = \"-0.1\"", "the row before has 0"]),
        ("no time at all", "{}{row}1e-320,0,0,0.1,1,0,0,0\n", &["t.csv:3:", "time must increase by more"]),
        ("long quaternion", "{}0,0,0,0.1,1.002,0,0,0\n", &["t.csv:2:", "length 1.002", "within 1e-3", "normalise"]),
        ("no quaternion", "{}0,0,0,0.1,0,0,0,0\n", &["t.csv:2:", "length 0", "unit quaternion"]),
        ("row after a blank line", "{}{row}\n1,x,0,0.1,1,0,0,0\n", &["t.csv:4:", "column px = \"x\""]),
    ];
    for (name, text, parts) in table {
        let text = text.replacen("{}", HEAD, 1).replacen("{row}", ROW, 1);
        refused(name, eval(SCENE.as_bytes(), text.as_bytes(), &[]), parts);
    }
    let bytes = [HEAD.as_bytes(), b"0,0,0,\xff,1,0,0,0\n"].concat();
    refused("bytes", eval(SCENE.as_bytes(), &bytes, &[]), &["t.csv:2:", "not UTF-8"]);
}

#[test]
fn bad_usage_is_refused() {
    let good = format!("{HEAD}{ROW}");
    let table: &[(&[&str], &str)] =
        &[(&["--samples", "3"], "--samples 3: allowed is 16 to"), (&["--surface", "99=x.ply"], "ends at")];
    for (more, part) in table {
        refused(part, eval(SCENE.as_bytes(), good.as_bytes(), more), &[part]);
    }
    for args in [
        &["eval"][..],
        &["eval", "a", "b", "--tier", "exact"],
        &["no-such"],
        &["eval", "a", "b", "--no-such"],
        &["view"],
        &["demo", "--view"],
    ] {
        assert_eq!(haptor().args(args).output().unwrap().status.code(), Some(2), "{args:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let (scene, trajectory) = (root().join("tests/scenes/cube-twist.toml"), root().join("tests/scenes/cube-twist.csv"));
    for target in [folder.path(), &folder.path().join("no/such/folder.csv")] {
        let output = haptor().arg("eval").args([&scene, &trajectory]).arg("-o").arg(target).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", target.display());
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Commands that measure for minutes refuse what they cannot end with before they begin: each names option, value and what is allowed.
#[test]
fn long_measurements_are_refused_at_once() {
    let table: &[(&str, &str, &str)] = &[
        ("trade", "--rate -5", "'-5' for '--rate <HZ>': allowed is 100 to 10000 Hz"),
        ("trade", "--ticks 0", "'0' for '--ticks <N>': allowed is 1 to 1000000000 ticks"),
        ("trade", "--depth nan", "'nan' for '--depth <M>': allowed is 1e-9 to 1 m"),
        ("trade", "--picture no/such/folder.png", "no/such/folder.png: cannot be written: there is no folder no/such"),
        ("timing", "--rate abc", "'abc' for '--rate <HZ>': allowed is 100 to 8000 Hz"),
        ("timing", "--search-seconds -1", "'-1' for '--search-seconds <S>': allowed is 0 to 1000000 s"),
        ("timing", "--tier bristle --samples 5", "'5' for '--samples <N>': allowed is 16 to 1024"),
        ("timing", "--tier bristle --samples 300", "--samples 300: model.samples is 300"),
        ("timing", "--cpu 100000", "'100000' for '--cpu <N>': allowed are the CPUs that this process may use: "),
        ("timing", "--known no/such", "no/such: no folder; --known takes one with files SCENE-TIER-SAMPLES.csv"),
        ("timing", "--png no/such/folder.png", "no/such/folder.png: cannot be written: there is no folder no/such"),
        ("timing", "--save tests", "tests: cannot be written: it is a directory"),
        ("timing", "-o README.md", "README.md: cannot be made: "),
    ];
    for (command, more, part) in table {
        let output = haptor().args([command, "tests/scenes/cube-twist.toml"]).args(more.split(' ')).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{command} {more}: {said}");
        assert!(said.contains(part), "{command} {more}: {said}");
    }
}

#[test]
fn what_was_there_stays_when_the_input_is_bad() {
    let folder = tempfile::tempdir().unwrap();
    let out: &Path = &folder.path().join("out.csv");
    fs::write(out, "earlier").unwrap();
    let bad = folder.path().join("bad.toml");
    fs::write(&bad, SCENE.replace("0.02", "-1")).unwrap();
    for command in ["eval", "bake"] {
        let mut tool = haptor();
        tool.arg(command).arg(&bad);
        if command == "eval" {
            tool.arg(root().join("tests/scenes/cube-twist.csv"));
        }
        let output = tool.arg("-o").arg(out).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert_eq!(fs::read_to_string(out).unwrap(), "earlier", "{command}");
    }
}

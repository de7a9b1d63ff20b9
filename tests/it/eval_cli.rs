//! `haptor eval` as scripts use it: columns, round trip, the same bytes twice, what the options change; and its neighbours
//! `bake`, `trajectory`, `view`, `mesh`, `devices`.

use std::fs;
use std::path::PathBuf;

use haptor_firmware_sim::preset::PRESETS;

use crate::cli::{haptor, root};

const HEADER: &str = "t,fx,fy,fz,tx,ty,tz,regions,depth,radius,stick,tier,flags";

fn scene() -> PathBuf {
    root().join("tests/scenes/cube-twist.toml")
}

fn trajectory() -> PathBuf {
    root().join("tests/scenes/cube-twist.csv")
}

/// What the tool prints, having ended well.
fn said(args: &[&str]) -> Vec<u8> {
    let output = haptor().args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn eval(more: &[&str]) -> String {
    let (scene, trajectory) = (scene(), trajectory());
    let files = ["eval", scene.to_str().unwrap(), trajectory.to_str().unwrap()];
    String::from_utf8(said(&[&files, more].concat())).unwrap()
}

#[test]
fn one_row_a_tick_under_the_stated_header() {
    let table = eval(&[]);
    let given = fs::read_to_string(trajectory()).unwrap();
    assert_eq!(table.lines().next(), Some(HEADER));
    assert_eq!(table.lines().count(), given.lines().count());
    for (row, pose) in table.lines().zip(given.lines()).skip(1) {
        let fields: Vec<_> = row.split(',').collect();
        assert_eq!(fields.len(), 13, "{row}");
        assert_eq!(Some(fields[0]), pose.split(',').next(), "time as given");
        for number in &fields[1..11] {
            let value: f32 = number.parse().unwrap();
            assert!(value.is_finite(), "{row}");
            assert_eq!(&value.to_string(), number, "reads back as the same number");
        }
        assert_eq!((fields[11], fields[12]), ("bristle", "0"), "{row}");
    }
}

#[test]
fn the_same_bytes_twice_and_to_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("out.csv");
    let first = eval(&[]);
    assert_eq!(first, eval(&[]));
    assert_eq!(eval(&["-o", file.to_str().unwrap()]), "");
    assert_eq!(fs::read_to_string(&file).unwrap(), first);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn options_take_the_place_of_the_scene() {
    for tier in ["point", "paper", "bristle"] {
        let table = eval(&["--tier", tier]);
        assert!(table.lines().skip(1).all(|row| row.split(',').nth(11) == Some(tier)), "{tier}");
    }
    assert_ne!(eval(&["--samples", "128"]), eval(&[]));
    let largest =
        |table: &str| table.lines().skip(1).map(|row| row.split(',').nth(3).unwrap().parse::<f32>().unwrap()).fold(0.0, f32::max);
    assert!(largest(&eval(&[])) > 20.0);
    assert!(largest(&eval(&["--guard"])) <= 8.5);
}

/// The scene with a virtual coupling, and the force and torque that `eval` gives at 1.3 s, pressed by 1 mm, twisted and at rest.
fn coupled(numbers: &str, more: &[&str]) -> [f32; 2] {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("virtual.toml");
    let text = fs::read_to_string(scene()).unwrap();
    fs::write(&file, format!("{text}coupling = \"virtual\"\n[coupling]\n{numbers}\n")).unwrap();
    let trajectory = trajectory();
    let files = ["eval", file.to_str().unwrap(), trajectory.to_str().unwrap()];
    let table = String::from_utf8(said(&[&files, more].concat())).unwrap();
    let row: Vec<&str> = table.lines().find(|row| row.starts_with("1.3,")).unwrap().split(',').collect();
    [3, 6].map(|column: usize| row[column].parse().unwrap())
}

#[test]
fn a_virtual_coupling_puts_its_spring_before_the_contact() {
    // 1 mm of the handle is shared by 800 N/m of the spring and 7.4 kN/m of the rubber at the depth that is left
    let [force, torque] = coupled("", &[]);
    assert!((0.70..0.75).contains(&force), "{force} N");
    assert!((-0.0006..-0.0002).contains(&torque), "{torque} N m: 3 pi/16 mu P a of the lighter press");
    // a stiff spring would press as a direct coupling does, with 23.7 N; it may pull with what the scene says or the device shows
    let light = "translational_stiffness = 1e6\ntranslational_damping = 1.0\n";
    let [force, _] = coupled(&format!("{light}max_force = 1.0"), &[]);
    assert!((0.98..1.02).contains(&force), "{force} N of 1 N");
    let [force, _] = coupled(light, &[]);
    assert!((8.4..8.6).contains(&force), "{force} N of a Premium's 8.5 N");
    // at rest the hand gets what the contact gives
    let ([contact, _], [hand, _]) = (coupled("", &[]), coupled("", &["--guard"]));
    assert!((hand / contact - 1.0).abs() < 1e-2, "{hand} N, contact {contact} N");
}

#[test]
fn flags_of_the_guard_show_only_with_the_guard() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside.csv");
    fs::write(&inside, "t,px,py,pz,qw,qx,qy,qz\n0,0,0,0.119,1,0,0,0\n0.001,0,0,0.119,1,0,0,0\n").unwrap();
    let flags = |more: &[&str]| {
        let table = said(&[&["eval", scene().to_str().unwrap(), inside.to_str().unwrap()], more].concat());
        let table = String::from_utf8(table).unwrap();
        table.lines().skip(1).map(|row| row.split(',').nth(12).unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(flags(&[]), ["0", "0"]);
    let ramping = haptor_contact::Flags::RAMPING_IN.0;
    for flags in flags(&["--guard"]) {
        let bits = u32::from_str_radix(flags.trim_start_matches("0x"), 16).unwrap();
        assert_eq!(bits & ramping, ramping, "{flags}");
    }
}

#[test]
fn the_shipped_trajectory_is_what_the_tool_writes() {
    assert_eq!(said(&["trajectory", "press-twist-slide"]), fs::read(trajectory()).unwrap());
}

#[test]
fn a_target_that_is_no_file_is_written_and_not_replaced() {
    assert_eq!(eval(&["-o", "/dev/stdout"]), eval(&[]));
    eval(&["-o", "/dev/null"]);
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn a_baked_scene_reads_back_with_the_probe_above_the_object() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cube.model");
    said(&["bake", scene().to_str().unwrap(), "-o", file.to_str().unwrap()]);
    let baked = haptor_wire::scene::decode_file(&fs::read(&file).unwrap()).unwrap();
    assert_eq!(baked.object, haptor_wire::ObjectShape::Box { size: [0.1; 3] });
    assert!((baked.place.p_wd[2] - 0.125).abs() < 1e-6, "{:?}", baked.place);
}

#[test]
fn a_picture_is_drawn_without_a_display() {
    let folder = tempfile::tempdir().unwrap();
    let draw = |name: &str| {
        let file = folder.path().join(name);
        let (scene, trajectory) = (scene(), trajectory());
        let input = ["--scene", scene.to_str().unwrap(), "--trajectory", trajectory.to_str().unwrap(), "--at", "0.9"];
        said(&[&["view", "--size", "80x60", "--shot", file.to_str().unwrap()], &input[..]].concat());
        fs::read(file).unwrap()
    };
    let picture = draw("a.png");
    assert_eq!(picture[..8], *b"\x89PNG\r\n\x1a\n");
    assert_eq!(picture, draw("b.png"));
}

#[test]
fn a_mesh_is_told_from_a_broken_one() {
    let folder = tempfile::tempdir().unwrap();
    let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let stl = |faces: &[[usize; 3]]| {
        let vertex = |index: usize| format!("vertex {} {} {}\n", corners[index][0], corners[index][1], corners[index][2]);
        let facet =
            |face: &[usize; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", face.map(vertex).concat());
        format!("solid s\n{}endsolid s\n", faces.iter().map(facet).collect::<String>())
    };
    let table = [
        ("whole", stl(&faces), 0, "a solid"),
        ("open", stl(&faces[1..]), 1, "3 boundary edges"),
        ("none", "x".to_owned(), 2, "STL"),
    ];
    for (name, text, code, part) in table {
        let file = folder.path().join(name);
        fs::write(&file, text).unwrap();
        let output = haptor().args(["mesh", "check"]).arg(&file).output().unwrap();
        let all = [output.stdout, output.stderr].concat();
        assert_eq!(output.status.code(), Some(code), "{name}");
        assert!(String::from_utf8_lossy(&all).contains(part), "{name}: {}", String::from_utf8_lossy(&all));
    }
    let info = said(&["mesh", "info", "--json", folder.path().join("whole").to_str().unwrap()]);
    let info: serde_json::Value = serde_json::from_slice(&info).unwrap();
    assert!((info["volume_m3"].as_f64().unwrap() - 1.0 / 6.0).abs() < 1e-12, "{info}");
}

#[test]
fn devices_lists_what_the_simulation_simulates() {
    let listed: serde_json::Value = serde_json::from_slice(&said(&["devices", "--json"])).unwrap();
    let listed = listed["simulated"].as_array().unwrap();
    assert_eq!(listed.len(), PRESETS.len());
    for (row, preset) in listed.iter().zip(PRESETS) {
        assert_eq!(row["name"], preset.name);
        assert_eq!(row["max_force_n"].as_f64().unwrap() as f32, preset.max_force, "{}", preset.name);
        assert_eq!(row["max_torque_nm"].as_f64().unwrap() as f32, preset.max_torque, "{}", preset.name);
    }
}

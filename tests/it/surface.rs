//! The deformed surface: within its stated errors of finite elements, and written by `haptor eval --surface` as scripts read it.

use std::fs;
use std::path::{Path, PathBuf};

use haptor_contact::Tier;
use haptor_tests::accuracy::{self, Found};

use crate::cli::{haptor, root};

/// Largest allowed errors, per cent of the motion, by the beginning of the kind and the largest contact radius \[m\] they hold for: of the
/// part along the motion, of the whole vector. What `tests/bench/ACCURACY.md` shows, rounded up.
const GATES: [(&str, &str, f32, f64, f64); 16] = [
    ("B1 | cube | bonded twist", "top", 0.02, 2.2, 2.2),
    ("B1 | cube | bonded twist", "top", 1.0, 3.2, 3.2),
    ("B1 | cube | bonded twist", "side", 1.0, 3.2, 3.2),
    ("B4 | cube | bonded twist", "top", 1.0, 3.6, 3.6),
    ("B4 | cube | bonded twist", "side", 1.0, 4.8, 4.8),
    ("B2 | cube | press", "top", 1.0, 1.8, 2.7),
    ("B2 | cube | press", "side", 1.0, 1.8, 4.8),
    ("B5 | cube | twist", "top", 1.0, 8.9, 8.9),
    ("B5 | cube | twist", "side", 1.0, 0.9, 0.9),
    ("B4 | cube | bonded drag | 0.5", "top", 1.0, 2.7, 2.9),
    ("B4 | cube | bonded drag | 0.5", "side", 1.0, 5.5, 5.5),
    ("B4 | cube | bonded drag | 0.3", "top", 1.0, 3.8, 3.9),
    ("B4 | cube | bonded drag | 0.3", "side", 1.0, 4.1, 4.9),
    ("B3 | ellipsoid | bonded twist", "surface", 0.008, 4.5, 4.5),
    ("B3 | ellipsoid | bonded twist", "surface", 1.0, 7.5, 7.5),
    ("B3 | ellipsoid | bonded legs", "surface", 1.0, 20.9, 20.9),
];

/// The same for tier `green`, whose body is a table.
const GREEN_GATES: [(&str, &str, f32, f64, f64); 10] = [
    ("B1 | cube | bonded twist", "top", 1.0, 2.4, 3.9),
    ("B1 | cube | bonded twist", "side", 1.0, 1.9, 1.9),
    ("B4 | cube | bonded twist", "top", 1.0, 2.5, 2.9),
    ("B4 | cube | bonded twist", "side", 1.0, 2.0, 2.0),
    ("B2 | cube | press", "top", 1.0, 1.1, 1.2),
    ("B2 | cube | press", "side", 1.0, 0.4, 0.8),
    ("B4 | cube | bonded drag", "top", 1.0, 4.4, 4.6),
    ("B4 | cube | bonded drag", "side", 1.0, 6.1, 6.5),
    ("B3 | ellipsoid | bonded twist", "surface", 1.0, 4.5, 4.5),
    ("B3 | ellipsoid | bonded legs", "surface", 1.0, 7.0, 7.0),
];

#[test]
fn fields_are_within_their_errors_of_finite_elements() {
    for (tier, gates) in [(Tier::Bristle, &GATES[..]), (Tier::Point, &GATES[..]), (Tier::Green, &GREEN_GATES[..])] {
        let all = accuracy::measure(tier);
        for &(kind, place, radius, along, whole) in gates {
            let gated: Vec<&Found> =
                all.iter().filter(|f| f.kind.starts_with(kind) && f.kind.ends_with(place) && f.radius <= radius).collect();
            assert!(!gated.is_empty(), "no case of {kind} {place}");
            for found in gated {
                let inside = 100.0 * found.along <= along && 100.0 * found.whole <= whole;
                assert!(inside, "{found:?}: allowed {along} % along, {whole} % whole");
            }
        }
    }
}

#[test]
fn the_committed_table_is_the_measured_one() {
    let committed = fs::read_to_string(root().join("tests/bench/ACCURACY.md")).unwrap();
    assert_eq!(
        committed,
        accuracy::document(),
        "write it anew: cargo run -p haptor-tests --bin accuracy -- -o tests/bench/ACCURACY.md"
    );
}

/// A binary little-endian PLY file as this project writes it.
struct Ply {
    vertices: Vec<[f32; 6]>,
    faces: Vec<[u32; 3]>,
}

fn read(path: &Path) -> Ply {
    let bytes = fs::read(path).unwrap();
    let end = b"end_header\n";
    let body = bytes.windows(end.len()).position(|window| window == end).expect("a header that ends") + end.len();
    let header = std::str::from_utf8(&bytes[..body]).unwrap();
    let lines: Vec<&str> = header.lines().collect();
    assert_eq!(lines[..2], ["ply", "format binary_little_endian 1.0"]);
    let count = |element: &str| lines.iter().find_map(|line| line.strip_prefix(element)).unwrap().parse::<usize>().unwrap();
    let (vertices, faces) = (count("element vertex "), count("element face "));
    let properties: Vec<&str> = lines.iter().filter_map(|line| line.strip_prefix("property float ")).collect();
    assert_eq!(properties, ["x", "y", "z", "ux", "uy", "uz"]);
    assert!(lines.contains(&"property list uchar int vertex_indices"));
    let (points, corners) = bytes[body..].split_at(24 * vertices);
    assert_eq!(corners.len(), 13 * faces);
    let word = |bytes: &[u8], at: usize| <[u8; 4]>::try_from(&bytes[4 * at..4 * at + 4]).unwrap();
    Ply {
        vertices: points.chunks(24).map(|v| std::array::from_fn(|i| f32::from_le_bytes(word(v, i)))).collect(),
        faces: corners
            .chunks(13)
            .map(|face| {
                assert_eq!(face[0], 3);
                std::array::from_fn(|i| u32::from_le_bytes(word(&face[1..], i)))
            })
            .collect(),
    }
}

fn eval(scene: &Path, more: &[&str]) -> std::process::Output {
    let trajectory = root().join("tests/scenes/cube-twist.csv");
    haptor().arg("eval").arg(scene).arg(trajectory).args(more).output().unwrap()
}

fn cube() -> PathBuf {
    root().join("tests/scenes/cube-twist.toml")
}

#[test]
fn eval_writes_the_deformed_cube() {
    let folder = tempfile::tempdir().unwrap();
    let (early, late) = (folder.path().join("early.ply"), folder.path().join("late.ply"));
    let requests = [format!("0={}", early.display()), format!("1.2={}", late.display())];
    let plain = eval(&cube(), &[]);
    let output = eval(&cube(), &["--surface", &requests[0], "--surface", &requests[1]]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.stdout, plain.stdout, "surfaces do not change the table");

    let free = read(&early);
    assert!(free.vertices.len() >= 4_000);
    let pressed = read(&late);
    assert!(pressed.vertices.len() >= 4_000 && pressed.faces.len() > 2 * 3_900);
    assert!(pressed.faces.iter().flatten().all(|&corner| (corner as usize) < pressed.vertices.len()));
    let (mut deepest, mut most_around) = (0.0_f32, 0.0_f32);
    for &[x, y, z, ux, uy, uz] in &pressed.vertices {
        assert!([x, y, z, ux, uy, uz].iter().all(|number| number.is_finite()));
        let rest = [x - ux, y - uy, z - uz];
        assert!(rest[0].abs() < 0.050_01 && rest[1].abs() < 0.050_01 && (-1.0e-5..0.100_01).contains(&rest[2]), "{rest:?}");
        if rest[2] < 1.0e-7 {
            assert_eq!([ux, uy, uz], [0.0; 3], "the base is held");
        }
        deepest = deepest.min(uz);
        most_around = most_around.max(rest[0] * uy - rest[1] * ux);
    }
    assert!((-0.01..-0.0005).contains(&deepest), "{deepest}");
    assert!(most_around > 1.0e-7, "the surface turns with the probe: {most_around}");

    let first = fs::read(&late).unwrap();
    assert!(eval(&cube(), &["--surface", &requests[1]]).status.success());
    assert_eq!(fs::read(&late).unwrap(), first, "the same bytes twice");
}

#[test]
fn bad_requests_end_with_2_and_write_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (table, late, good) = (path("out.csv"), format!("9999={}", path("late.ply")), format!("0={}", path("good.ply")));
    let nowhere = format!("0={}", path("missing/x.ply"));
    let same = format!("0={table}");
    let rows: [(&[&str], &str); 6] = [
        (&["--surface", &good, "--surface", &late], "ends at"),
        (&["--surface", &good, "--surface", "soon=x.ply"], "T_S=FILE.ply"),
        (&["--surface", "x.ply"], "T_S=FILE.ply"),
        (&["--surface", &good, "--surface", &nowhere], "cannot be written"),
        (&["--surface", &same], "asked for twice"),
        (&["--surface", &good, "--surface", &good], "asked for twice"),
    ];
    for (more, message) in rows {
        let output = eval(&cube(), &[&["-o", &table], more].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {said}");
        assert!(said.contains(message), "{more:?}: {said}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{more:?} wrote something");
    }
}

#[test]
fn the_scene_says_how_much_deforms() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(cube()).unwrap();
    let with = |word: &str| {
        let lines: Vec<_> = text.lines().filter(|line| !line.starts_with("deformation")).collect();
        let scene = folder.path().join(format!("{word}.toml"));
        fs::write(&scene, lines.join("\n").replace("[model]", &format!("[model]\ndeformation = \"{word}\""))).unwrap();
        let picture = folder.path().join(format!("{word}.ply"));
        (eval(&scene, &["--surface", &format!("1.2={}", picture.display())]), picture)
    };
    let (refused, picture) = with("none");
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("deformation"), "{}", String::from_utf8_lossy(&refused.stderr));
    assert!(!picture.exists());
    let side = |word: &str| {
        let (output, picture) = with(word);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        // how far the side faces turn at mid height
        let level = |v: &&[f32; 6]| (v[2] - v[5] - 0.05).abs() < 0.006 && (v[0] - v[3]).abs() > 0.049_99;
        read(&picture).vertices.iter().filter(level).map(|v| v[4].abs()).fold(0.0, f32::max)
    };
    let (local, full) = (side("local"), side("full"));
    assert!(full > 2.0 * local, "{local} {full}");
}

//! Mesh files through the tool: what is told about them, mended, reduced, baked and kept; the shipped meshes and the scenes that use them.

use std::fs;
use std::path::Path;

use haptor_mesh::models::Model;
use haptor_mesh::{DVec3, Mesh, save_as, tessellate};
use haptor_wire::scene_file::{decode_file, sections};
use haptor_wire::sections::{GRID, SECTION_OVERHEAD};
use serde_json::Value;

use crate::cli::{haptor, root};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Exit code, standard output, standard error; results are kept in the folder `cache` of this one.
    fn run(&self, args: &[&str]) -> (i32, String, String) {
        let output =
            haptor().current_dir(self.path()).env("XDG_CACHE_HOME", self.path().join("cache")).args(args).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code().expect("not killed"), text(output.stdout), text(output.stderr))
    }

    fn good(&self, args: &[&str]) -> String {
        let (code, out, told) = self.run(args);
        assert_eq!((code, told.as_str()), (0, ""), "{args:?}");
        out
    }

    fn json(&self, args: &[&str]) -> Value {
        let (_, out, told) = self.run(&[args, &["--json"]].concat());
        serde_json::from_str(&out).unwrap_or_else(|error| panic!("{args:?}: {error}: {out}{told}"))
    }

    fn save(&self, name: &str, mesh: &Mesh) {
        let extension = name.rsplit('.').next();
        fs::write(self.path().join(name), save_as(mesh, extension).expect("a known format")).unwrap();
    }

    fn kept(&self) -> Vec<std::path::PathBuf> {
        let Ok(entries) = fs::read_dir(self.path().join("cache/haptor/mesh")) else { return Vec::new() };
        entries.map(|entry| entry.unwrap().path()).collect()
    }
}

/// 60 x 40 x 40 mm, in millimetres.
fn egg() -> Mesh {
    tessellate::ellipsoid(DVec3::new(30.0, 20.0, 20.0), 64)
}

fn open_egg() -> Mesh {
    let mut open = egg();
    open.triangles.drain(700..706);
    (0..40).for_each(|k| open.triangles[10 * k].swap(0, 1));
    open
}

#[test]
fn the_shipped_meshes_are_those_that_the_tool_makes() {
    let folder = Folder::new();
    for model in Model::ALL {
        let name = format!("{}.ply", model.name());
        folder.good(&["mesh", "make", model.name(), "-o", &name]);
        let shipped = fs::read(root().join("tests/meshes").join(&name)).unwrap();
        assert_eq!(fs::read(folder.path().join(&name)).unwrap(), shipped, "{name}");
        assert!(shipped.len() < 400_000, "{name}: {} bytes", shipped.len());
    }
}

#[test]
fn a_solid_is_told_in_every_format_and_unit() {
    let folder = Folder::new();
    for name in ["egg.stl", "egg.ply", "egg.obj"] {
        folder.save(name, &egg());
        let found = folder.json(&["mesh", "info", name, "--unit", "mm"]);
        assert_eq!(
            (&found["solid"], &found["pieces"], &found["crossing_pairs"]),
            (&true.into(), &1.into(), &0.into()),
            "{found}"
        );
        let number = |key: &str| found[key].as_f64().unwrap();
        assert!((number("volume_m3") / 5.0265e-5 - 1.0).abs() < 0.01 && number("hollow_share") < 1e-6, "{found}");
        assert!((found["size_m"][0].as_f64().unwrap() - 0.06).abs() < 1e-6 && number("scale") == 0.001, "{found}");
        assert_eq!(folder.good(&["mesh", "check", name, "--scale", "0.001"]), format!("{name}: a solid\n"));
        let text = folder.good(&["mesh", "info", name, "--unit", "mm"]);
        assert!(["watertight    yes", "oriented      yes", "convex        yes"].iter().all(|line| text.contains(line)), "{text}");
    }
    let (code, out, told) = folder.run(&["mesh", "check", "egg.stl"]);
    assert!(code == 0 && out.contains("a solid"), "{out}");
    assert!(told.contains("egg.stl: is 60.000 m across: if the file is in millimetres, scale 0.001 makes it 0.060 m"), "{told}");
}

#[test]
fn what_is_wrong_is_a_problem_and_what_a_scene_bears_is_a_warning() {
    let folder = Folder::new();
    folder.save("open.stl", &open_egg());
    let (code, out, told) = folder.run(&["mesh", "check", "open.stl", "--unit", "mm"]);
    assert!(code == 1 && out.is_empty(), "{out}");
    assert!(["open.stl: ", "boundary edges", "disagree"].iter().all(|part| told.contains(part)), "{told}");
    let found = folder.json(&["mesh", "info", "open.stl", "--unit", "mm"]);
    assert!(found["solid"] == false && found["boundary_edges"].as_u64() > Some(3), "{found}");

    folder.save("compass.ply", &Model::Compass.mesh());
    let (code, _, told) = folder.run(&["mesh", "check", "compass.ply"]);
    assert!(code == 0 && told.contains("compass.ply: is not convex") && told.contains("% of its diagonal"), "{told}");
    for (share, expected) in [(None, 1), (Some("0.01"), 1), (Some("0.9"), 0), (Some("2"), 2)] {
        let args = ["mesh", "check", "compass.ply", "--require-convex"].into_iter().chain(share);
        let (code, _, told) = folder.run(&args.collect::<Vec<_>>());
        assert_eq!(code, expected, "{share:?}: {told}");
        assert!(expected != 1 || told.contains("error: compass.ply: hollows of"), "{told}");
    }
}

#[test]
fn unreadable_files_are_refused_by_name_reason_and_what_to_do() {
    let folder = Folder::new();
    let head = |count: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let stl = save_as(&egg(), Some("stl")).unwrap();
    let table: [(&str, Vec<u8>, &[&str]); 7] = [
        ("empty.stl", vec![], &["empty file", "export"]),
        ("text.obj", b"hello".to_vec(), &["no triangle"]),
        ("text.step", b"ISO-10303-21;".to_vec(), &["no STL, OBJ or PLY file"]),
        ("cut.stl", stl[..5000].to_vec(), &["promises 3968 triangles", "cut short"]),
        ("many.ply", head("4000000000").into_bytes(), &["4000000000 vertices, allowed is up to 15000000", "reduce"]),
        ("lying.ply", head("9000000").into_bytes(), &["promises 9000000 of vertex", "cut short"]),
        ("points.obj", b"v 0 0 0\nv 1 1 1\n".to_vec(), &["2 vertices"]),
    ];
    for (name, bytes, parts) in &table {
        fs::write(folder.path().join(name), bytes).unwrap();
        for command in
            [&["info"][..], &["check"], &["bake", "-o", "out"], &["repair", "-o", "out.stl"], &["reduce", "-o", "out.stl"]]
        {
            let (code, out, told) = folder.run(&[&["mesh"], command, &[*name]].concat());
            assert_eq!((code, out.as_str(), told.lines().count()), (2, "", 1), "{command:?} {name}: {told}");
            assert!(told.contains(name) && parts.iter().all(|part| told.contains(part)), "{command:?} {name}: {told}");
        }
    }
    for name in [".", "none.stl", "/dev/zero"] {
        let (code, _, told) = folder.run(&["mesh", "info", name]);
        assert!(code == 2 && told.contains("cannot be opened"), "{name}: {told}");
    }
    assert!(!folder.path().join("out").exists() && !folder.path().join("out.stl").exists());
}

#[test]
fn a_broken_mesh_is_mended_reduced_and_measured() {
    let folder = Folder::new();
    folder.save("open.stl", &open_egg());
    let out = folder.good(&["mesh", "repair", "open.stl", "--unit", "mm", "-o", "whole.ply", "--triangles", "1000"]);
    for part in ["triangles turned over", "1 holes closed", "6 triangles added", "3968 to 1000 triangles, off by"] {
        assert!(out.contains(part), "{part}: {out}");
    }
    assert_eq!(folder.good(&["mesh", "check", "whole.ply"]), "whole.ply: a solid\n");
    let found = folder.json(&["mesh", "reduce", "whole.ply", "--triangles", "300", "-o", "small.obj"]);
    let (max, rms) = (found["deviation_max_m"].as_f64().unwrap(), found["deviation_rms_m"].as_f64().unwrap());
    assert!(found["triangles"] == 300 && (1e-6..2e-3).contains(&max) && rms < max, "{found}");
    let (code, out, _) = folder.run(&["mesh", "check", "small.obj"]);
    assert_eq!((code, out.as_str()), (0, "small.obj: a solid\n"));

    // what is not allowed to be closed is told, and the rest is written
    let (code, _, told) = folder.run(&["mesh", "repair", "open.stl", "--holes", "3", "-o", "still.stl"]);
    assert!(code == 1 && told.contains("rims not closed") && folder.path().join("still.stl").exists(), "{told}");
    let (code, _, told) = folder.run(&["mesh", "repair", "open.stl", "-o", "out.step"]);
    assert!(code == 2 && told.contains(".stl, .ply or .obj"), "{told}");
}

#[test]
fn a_baked_mesh_is_kept_and_found_again_and_damage_does_no_harm() {
    let folder = Folder::new();
    folder.save("compass.stl", &Model::Compass.mesh());
    let bake = |output: &str| {
        folder.json(&["mesh", "bake", "compass.stl", "--role", "probe", "--cells", "24", "--samples", "128", "-o", output])
    };
    let first = bake("first.grid");
    let parts = first["parts"].as_array().unwrap();
    assert!(first["from_cache"] == false && parts.len() > 1 && parts.len() <= 16, "{first}");
    for part in parts {
        let number = |key: &str| part[key].as_f64().unwrap();
        assert!(
            number("distance_error_rms_m") < number("distance_error_max_m")
                && number("distance_error_max_m") < number("spacing_m"),
            "{part}"
        );
        assert!(number("volume_error").abs() < 0.2 && number("samples") == 128.0, "{part}");
    }
    let file = fs::read(folder.path().join("first.grid")).unwrap();
    let mut rest = file.as_slice();
    for _ in parts {
        let word = |at: usize| u32::from_le_bytes(rest[at..at + 4].try_into().unwrap());
        assert_eq!(word(0), GRID);
        rest = &rest[word(4) as usize + SECTION_OVERHEAD..];
    }
    assert!(rest.is_empty());

    let same = |output: &str| assert_eq!(fs::read(folder.path().join(output)).unwrap(), file);
    assert_eq!(bake("second.grid")["from_cache"], true);
    same("second.grid");
    let [kept] = &folder.kept()[..] else { panic!("{:?}", folder.kept()) };
    let mut bytes = fs::read(kept).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(kept, bytes).unwrap();
    let (code, out, told) =
        folder.run(&["mesh", "bake", "compass.stl", "--role", "probe", "--cells", "24", "--samples", "128", "-o", "third.grid"]);
    assert!(code == 0 && told.contains("the cache is of no use: damaged") && out.contains("baked"), "{out} {told}");
    same("third.grid");
    assert_eq!(bake("fourth.grid")["from_cache"], true);

    let (code, _, told) = folder.run(&["mesh", "bake", "compass.stl", "--cells", "7", "-o", "no.grid"]);
    assert!(code == 2 && told.contains("cells is 7, allowed is 8 to 120"), "{told}");
}

const SCENE: &str = "[object]
shape = \"mesh\"
file = \"egg.stl\"
scale = 0.001
young_modulus = 3.0e6
poisson_ratio = 0.5

[probe]
shape = \"sphere\"
radius = 0.01

[friction]
dynamic = 0.75
";

#[test]
fn a_scene_mends_on_request_takes_hollows_as_deep_as_it_says_and_is_quick_the_second_time() {
    let folder = Folder::new();
    let poses = "t,px,py,pz,qw,qx,qy,qz\n0,0,0,0.0497,1,0,0,0\n0.001,0,0,0.0496,1,0,0,0\n";
    fs::write(folder.path().join("t.csv"), poses).unwrap();
    let eval = |scene: &str| {
        fs::write(folder.path().join("s.toml"), scene).unwrap();
        folder.run(&["eval", "s.toml", "t.csv"])
    };
    folder.save("egg.stl", &egg());
    let (code, whole, told) = eval(SCENE);
    assert_eq!((code, told.as_str(), folder.kept().len()), (0, "", 1));
    assert_eq!(eval(SCENE).1, whole);
    assert_eq!(folder.kept().len(), 1);

    folder.save("egg.stl", &open_egg());
    let (code, _, told) = eval(SCENE);
    assert!(code == 2 && told.contains("not the skin of a solid") && told.contains("repair = true"), "{told}");
    let (code, mended, told) = eval(&SCENE.replace("scale", "repair = true\nscale"));
    assert!(code == 0 && told.contains("note: s.toml:3: object.file = \"egg.stl\": was mended: "), "{told}");
    let force = |table: &str| table.lines().last().unwrap().split(',').nth(3).unwrap().parse::<f64>().unwrap();
    assert!(force(&whole) > 0.1 && (force(&mended) / force(&whole) - 1.0).abs() < 0.02, "{mended} {whole}");

    // a dent of 8 % of the diagonal in the side
    let dented =
        egg().mapped(|v| DVec3::new(v.x - 12.0 * (-(v.y * v.y + v.z * v.z) / 50.0).exp() * f64::from(v.x > 0.0), v.y, v.z));
    folder.save("egg.stl", &dented);
    let (code, _, told) = eval(SCENE);
    assert!(code == 2 && told.contains("object.file") && told.contains("object.max_hollow"), "{told}");
    let (code, _, told) = eval(&SCENE.replace("scale", "max_hollow = 0.3\nscale"));
    assert!(code == 0 && told.contains("m deep); a part of the probe makes one contact there"), "{told}");
    let (code, _, told) = eval(&SCENE.replace("scale", "max_hollow = 2\nscale"));
    assert!(code == 2 && told.contains("s.toml:4: object.max_hollow = 2: allowed is"), "{told}");
}

/// A scene's wrench along its own path: a row of numbers per tick.
fn felt(scene: &str, path: &str) -> Vec<[f64; 6]> {
    let files = [format!("tests/scenes/{scene}.toml"), format!("tests/scenes/{path}.csv")];
    let output = haptor().arg("eval").args(files).output().unwrap();
    assert!(output.status.success(), "{scene}: {}", String::from_utf8_lossy(&output.stderr));
    let table = String::from_utf8(output.stdout).unwrap();
    let row = |line: &str| std::array::from_fn(|i| line.split(',').nth(1 + i).unwrap().parse().unwrap());
    table.lines().skip(1).map(row).collect()
}

fn largest(rows: &[[f64; 6]], column: usize) -> f64 {
    rows.iter().map(|row| row[column].abs()).fold(0.0, f64::max)
}

/// Largest force upwards and largest torque about the handle, mesh over primitives.
#[test]
fn the_mesh_scenes_are_felt_as_their_primitives() {
    for (mesh, primitives) in [("mallet-mesh", "mallet"), ("compass-mesh", "compass")] {
        let (copy, truth) = (felt(mesh, mesh), felt(primitives, primitives));
        let ratio = |column: usize| largest(&copy, column) / largest(&truth, column);
        println!("{mesh}: force {:.4}, torque {:.4} of the primitives'", ratio(2), ratio(5));
        assert!((ratio(2) - 1.0).abs() < 0.05 && (ratio(5) - 1.0).abs() < 0.05, "{mesh}: force {} torque {}", ratio(2), ratio(5));
    }
}

#[test]
fn the_organ_is_pressed_and_baked_for_the_host() {
    let rows = felt("organ", "organ");
    assert!(rows.iter().flatten().all(|value| value.is_finite()));
    // Hertz for a ball of 8 mm 3 mm into a half space of the same tissue: 0.26 N
    assert!((0.2..0.3).contains(&largest(&rows, 2)) && largest(&rows, 5) > 1e-5, "{} N", largest(&rows, 2));
    let folder = Folder::new();
    let scene = root().join("tests/scenes/organ.toml");
    folder.good(&["bake", scene.to_str().unwrap(), "-o", "organ.model"]);
    let file = fs::read(folder.path().join("organ.model")).unwrap();
    assert!(decode_file(&file).is_ok() && sections(&file).unwrap().count() == 2, "a grid, and a mesh to look at");
}

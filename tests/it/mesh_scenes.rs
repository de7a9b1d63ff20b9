//! Scenes with meshes through the tool and the host: what is made, checked, baked, felt, drawn and refused.

use std::fs;
use std::path::Path;

use haptor_contact::{Pose, Quat, Vec3};
use haptor_engine::Scene;
use haptor_mesh::{DVec3, Mesh, tessellate, write_stl};
use haptor_wire::scene_file::{decode_file, sections};
use haptor_wire::{ObjectShape, ProbeShape};

use crate::cli::haptor;

/// A ball of a mesh on a cube of a mesh.
const SCENE: &str = "[object]
shape = \"mesh\"
file = \"cube.stl\"
young_modulus = 3.0e6
poisson_ratio = 0.5

[probe]
shape = \"mesh\"
file = \"ball.stl\"

[friction]
dynamic = 0.75
";

const TRAJECTORY: &str = "t,px,py,pz,qw,qx,qy,qz\n0,0,0,0.119,1,0,0,0\n0.001,0,0,0.119,1,0,0,0\n";

/// Force of a ball of 20 mm pressed 1 mm into the cube, as the primitives give it [N].
const PRESSED: f32 = 23.73;

fn run(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let output = haptor().current_dir(folder).args(args).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().expect("not killed"), text(output.stdout), text(output.stderr))
}

fn good(folder: &Path, args: &[&str]) -> String {
    let (code, out, told) = run(folder, args);
    assert_eq!((code, told.as_str()), (0, ""), "{args:?}");
    out
}

fn with_cube_and_ball() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    good(folder.path(), &["mesh", "make", "box", "0.1,0.1,0.1", "-o", "cube.stl"]);
    good(folder.path(), &["mesh", "make", "sphere", "0.02", "-o", "ball.stl"]);
    fs::write(folder.path().join("s.toml"), SCENE).unwrap();
    fs::write(folder.path().join("t.csv"), TRAJECTORY).unwrap();
    folder
}

#[test]
fn a_mesh_scene_is_evaluated_baked_run_by_the_host_and_drawn() {
    let folder = with_cube_and_ball();
    let table = good(folder.path(), &["eval", "s.toml", "t.csv"]);
    let force: f32 = table.lines().last().unwrap().split(',').nth(3).unwrap().parse().unwrap();
    assert!((force / PRESSED - 1.0).abs() < 0.03, "{force} N, primitives {PRESSED} N");

    good(folder.path(), &["bake", "s.toml", "-o", "s.model"]);
    let file = fs::read(folder.path().join("s.model")).unwrap();
    let baked = decode_file(&file).unwrap();
    assert_eq!(baked.object, ObjectShape::Mesh { grid: 0 });
    assert_eq!(baked.probe.as_slice()[0].shape, ProbeShape::Mesh { grid: 1 });
    // a grid for each, and a mesh to look at
    assert_eq!(sections(&file).unwrap().count(), 4);
    // a ball of 1 kg: 2/5 m r^2
    let moments = baked.inertia.expect("the mesh's own").moments;
    assert!(moments.iter().all(|moment| (moment / 1.6e-4 - 1.0).abs() < 0.01), "{moments:?}");

    let scene = Scene::read(&file).unwrap();
    let mut core = scene.engine().unwrap();
    let pressed = Pose::new(Vec3::new(0.0, 0.0, 0.119 - baked.place.p_wd[2]), Quat::IDENTITY);
    let felt = core.step(&pressed, 1.0e-3);
    assert!((felt.contact_force[2] / force - 1.0).abs() < 1.0e-3, "{felt:?}, eval {force} N");

    // a grid that is gone
    let named = |file: &[u8]| Scene::read(file).unwrap_err().to_string();
    let without: Vec<u8> = file[..file.len() - from_second(&file)].to_vec();
    assert!(named(&without).contains("probe: the file carries 1 meshes, none of number 1"), "{}", named(&without));

    good(folder.path(), &["view", "--shot", "s.png", "--scene", "s.toml", "--size", "64x48"]);
    assert!(fs::read(folder.path().join("s.png")).unwrap().starts_with(b"\x89PNG"));
}

/// Length of a file's sections from the second on.
fn from_second(file: &[u8]) -> usize {
    let rest = sections(file).unwrap().skip(1).map(Result::unwrap);
    rest.map(|section| section.contents.len() + haptor_wire::sections::SECTION_OVERHEAD).sum()
}

/// An L of three cubes, each with edges of 20 mm.
fn ell() -> Mesh {
    let outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
    let vertices = [0.0, 1.0].iter().flat_map(|&z| outline.map(|(x, y)| DVec3::new(x, y, z) * 0.02)).collect();
    let sides = (0..6_u32).flat_map(|k| [[k, (k + 1) % 6, (k + 1) % 6 + 6], [k, (k + 1) % 6 + 6, k + 6]]);
    let caps = [4, 5, 0, 1].into_iter().flat_map(|k: u32| [[3, (k + 1) % 6, k], [9, k + 6, (k + 1) % 6 + 6]]);
    Mesh { vertices, triangles: sides.chain(caps).collect() }
}

#[test]
fn a_mesh_that_cannot_be_felt_is_refused_by_line_file_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, mesh: &Mesh| {
        let mut bytes = Vec::new();
        write_stl(mesh, &mut bytes).unwrap();
        fs::write(folder.path().join(name), bytes).unwrap();
    };
    let cube = tessellate::cuboid(DVec3::splat(0.1));
    save("cube.stl", &cube);
    save("open.stl", &Mesh { triangles: cube.triangles[1..].to_vec(), ..cube.clone() });
    save("inside-out.stl", &cube.mapped(|v| -v));
    save("tiny.stl", &tessellate::cuboid(DVec3::splat(1e-7)));
    save("huge.stl", &tessellate::cuboid(DVec3::splat(300.0)));
    save("ell.stl", &ell());
    fs::write(folder.path().join("text.stl"), "no mesh at all").unwrap();
    fs::write(folder.path().join("t.csv"), TRAJECTORY).unwrap();
    let table: &[(&str, &[&str])] = &[
        ("shape = \"mesh\"", &["s.toml:1:", "object.file is missing", "relative to the scene"]),
        ("shape = \"mesh\"\nfile = 3", &["s.toml:3:", "object.file = 3", "type integer"]),
        ("shape = \"mesh\"\nfile = \"none.stl\"", &["s.toml:3:", "object.file = \"none.stl\"", "cannot be opened"]),
        ("shape = \"mesh\"\nfile = \".\"", &["s.toml:3:", "not a regular file"]),
        ("shape = \"mesh\"\nfile = \"text.stl\"", &["s.toml:3:", "no readable binary STL file"]),
        ("shape = \"mesh\"\nfile = \"open.stl\"", &["s.toml:3:", "not the skin of a solid", "holes"]),
        ("shape = \"mesh\"\nfile = \"inside-out.stl\"", &["s.toml:3:", "not the skin of a solid", "inside out"]),
        ("shape = \"mesh\"\nfile = \"tiny.stl\"", &["s.toml:3:", "1.000e-7", "1e-6 to 1e2 m", "scale"]),
        ("shape = \"mesh\"\nfile = \"huge.stl\"", &["s.toml:3:", "3.000e2", "1e-6 to 1e2 m", "scale"]),
        ("shape = \"mesh\"\nfile = \"ell.stl\"", &["s.toml:3:", "hollows of 16.", "up to 5 %"]),
        ("shape = \"mesh\"\nfile = \"cube.stl\"\nscale = 0", &["s.toml:4:", "object.scale = 0", "above 0"]),
        ("shape = \"mesh\"\nfile = \"cube.stl\"\nscale = 1e9", &["s.toml:3:", "check the scale"]),
        ("shape = \"box\"\nsize = [1, 1, 1]\nfile = \"cube.stl\"", &["s.toml:4:", "object.file", "unknown key"]),
    ];
    for (shape, parts) in table {
        let scene = SCENE.replacen("shape = \"mesh\"\nfile = \"cube.stl\"", shape, 1);
        fs::write(folder.path().join("s.toml"), scene).unwrap();
        for command in [&["eval", "s.toml", "t.csv", "-o", "out"][..], &["bake", "s.toml", "-o", "out"]] {
            let (code, out, told) = run(folder.path(), command);
            assert_eq!((code, out.as_str(), told.lines().count()), (2, "", 1), "{shape}: {told}");
            assert!(parts.iter().all(|part| told.contains(part)), "{shape}: {told:?} lacks one of {parts:?}");
            assert!(!folder.path().join("out").exists());
        }
    }
}

#[test]
fn sizes_that_make_no_solid_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (args, part) in [
        (["box", "1,2"], "2 sizes: a box takes three"),
        (["sphere", "0"], "size 0: allowed is 1e-6 to 1e2 m"),
        (["cone", "0.1"], "a cone takes two"),
    ] {
        let (code, _, told) = run(folder.path(), &["mesh", "make", args[0], args[1], "-o", "x.stl"]);
        assert!(code == 2 && told.contains(part), "{args:?}: {told}");
    }
}

//! Good files of every format, a table of bad ones, and thousands of damaged ones: an answer in words, never a panic.

use super::*;
use crate::{check, properties, tessellate, weld, write_stl};

/// A tetrahedron of edge 1 along the axes.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn binary_stl(corners: &[[f32; 3]], faces: &[[usize; 3]], count: u32, header: &[u8]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..header.len()].copy_from_slice(header);
    bytes.extend(count.to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|&corner| corners[corner]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn good_binary_stl() -> Vec<u8> {
    binary_stl(&CORNERS, &FACES, 4, b"")
}

fn ascii_stl(name: &str) -> Vec<u8> {
    let mut text = format!("solid{name}\n");
    for face in FACES {
        text += "facet normal 0 0 0\n outer loop\n";
        for corner in face {
            let [x, y, z] = CORNERS[corner];
            text += &format!("  vertex {x:e} {y} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    (text + &format!("endsolid{name}\n")).into_bytes()
}

fn obj() -> Vec<u8> {
    let mut text = "# caf\u{e9}\nmtllib none.mtl\no body\n".to_owned();
    CORNERS.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
    text += "vn 0 0 1\ng part\nusemtl red\n";
    FACES.iter().for_each(|[a, b, c]| text += &format!("f {}//1 {}/99/1 {}\n", a + 1, b + 1, *c as i64 - 4));
    let mut bytes = text.into_bytes();
    // Latin-1, as old exporters write
    bytes.extend(b"# \xe9t\xe9\n");
    bytes
}

#[derive(Clone, Copy, PartialEq)]
enum Order {
    Text,
    Little,
    Big,
}

fn ply(order: Order, kind: &str, vertices: u64, faces: u64) -> Vec<u8> {
    let name = match order {
        Order::Text => "ascii",
        Order::Little => "binary_little_endian",
        Order::Big => "binary_big_endian",
    };
    let head = format!(
        "ply\nformat {name} 1.0\ncomment made\nelement vertex {vertices}\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\nproperty uchar red\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let mut bytes = head.into_bytes();
    for corner in CORNERS {
        match order {
            Order::Text => bytes.extend(format!("{} {} {} 7\n", corner[0], corner[1], corner[2]).bytes()),
            _ => {
                for value in corner {
                    let (wide, narrow) = (f64::from(value), value);
                    match (order, kind) {
                        (Order::Big, "double") => bytes.extend(wide.to_be_bytes()),
                        (_, "double") => bytes.extend(wide.to_le_bytes()),
                        (Order::Big, _) => bytes.extend(narrow.to_be_bytes()),
                        _ => bytes.extend(narrow.to_le_bytes()),
                    }
                }
                bytes.push(7);
            }
        }
    }
    for face in FACES {
        match order {
            Order::Text => bytes.extend(format!("3 {} {} {}\n", face[0], face[1], face[2]).bytes()),
            _ => {
                bytes.push(3);
                let of = |corner: usize| {
                    let corner = corner as i32;
                    if order == Order::Big { corner.to_be_bytes() } else { corner.to_le_bytes() }
                };
                bytes.extend(face.iter().flat_map(|&corner| of(corner)));
            }
        }
    }
    bytes
}

/// One good file of each kind, the end of its name, its format.
fn good() -> Vec<(&'static str, Vec<u8>, Format)> {
    vec![
        ("binary STL", good_binary_stl(), Format::StlBinary),
        ("binary STL that calls itself solid", binary_stl(&CORNERS, &FACES, 4, b"solid from a CAD program"), Format::StlBinary),
        ("ASCII STL", ascii_stl(" made by hand"), Format::StlText),
        ("ASCII STL without a name", ascii_stl(""), Format::StlText),
        ("ASCII STL in capitals", ascii_stl(" x").to_ascii_uppercase(), Format::StlText),
        ("OBJ", obj(), Format::Obj),
        ("PLY, ASCII", ply(Order::Text, "float", 4, 4), Format::Ply),
        ("PLY, little endian", ply(Order::Little, "float", 4, 4), Format::Ply),
        ("PLY, big endian", ply(Order::Big, "double", 4, 4), Format::Ply),
        ("PLY, Windows lines", ply(Order::Text, "float32", 4, 4).replace_lines(), Format::Ply),
    ]
}

trait Lines {
    fn replace_lines(self) -> Self;
}

impl Lines for Vec<u8> {
    fn replace_lines(self) -> Self {
        self.iter().flat_map(|&byte| if byte == b'\n' { vec![b'\r', b'\n'] } else { vec![byte] }).collect()
    }
}

#[test]
fn every_format_gives_the_same_solid_whatever_its_name_says() {
    for (name, bytes, format) in good() {
        for extension in [None, Some("stl"), Some("obj"), Some("ply"), Some("txt")] {
            assert_eq!(format_of(&bytes, extension), Some(format), "{name}");
            let mesh = weld(&read_mesh(bytes.clone(), extension, 0.001).unwrap_or_else(|error| panic!("{name}: {error}")), None);
            assert!(check(&mesh).is_solid(), "{name}: {:?}", check(&mesh));
            assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4), "{name}");
            let volume = properties(&mesh).unwrap().volume;
            assert!((volume * 6.0e9 - 1.0).abs() < 1e-6, "{name}: {volume}");
        }
    }
}

#[test]
fn two_solids_of_one_file_are_both_read() {
    let both = [ascii_stl(" one"), ascii_stl("")].concat();
    assert_eq!(read_mesh(both, None, 1.0).unwrap().triangles.len(), 8);
}

#[test]
fn polygons_become_triangles() {
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1 1 0 0\nv 1 1 1\nv 0 2 2 2\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let mesh = read_mesh(cube.into(), Some("obj"), 1.0).unwrap();
    assert!(mesh.triangles.len() == 12 && check(&mesh).is_solid());
    assert!((properties(&mesh).unwrap().volume - 1.0).abs() < 1e-12);
}

/// Name, bytes, end of the file's name, words of the message.
type Bad = (&'static str, Vec<u8>, &'static str, &'static [&'static str]);

fn bad_stl() -> Vec<Bad> {
    let nan = [[f32::NAN, 0.0, 0.0], CORNERS[1], CORNERS[2], CORNERS[3]];
    let far = [[2.0e6, 0.0, 0.0], CORNERS[1], CORNERS[2], CORNERS[3]];
    let cut = good_binary_stl()[..200].to_vec();
    vec![
        ("nothing", vec![], "stl", &["empty file"]),
        ("text", b"hello".to_vec(), "stl", &["no readable binary STL", "5 bytes"]),
        ("text of no format", b"hello".to_vec(), "txt", &["no STL, OBJ or PLY"]),
        ("no triangles", binary_stl(&CORNERS, &[], 0, b""), "stl", &["holds no triangle"]),
        ("count of none, then data", binary_stl(&CORNERS, &FACES, 0, b""), "stl", &["promises no triangle", "200 bytes follow"]),
        ("count beyond the data", binary_stl(&CORNERS, &FACES, 4_000_000_000, b""), "stl", &["promises 4000000000", "has 284"]),
        ("cut short", cut, "stl", &["promises 4 triangles in 284 bytes", "200", "cut short"]),
        ("not a number", binary_stl(&nan, &FACES, 4, b""), "stl", &["coordinate NaN", "-1000 to 1000 m"]),
        ("too far", binary_stl(&far, &FACES, 4, b""), "stl", &["coordinate 2000 m", "check the scale"]),
        ("ASCII, cut short", ascii_stl(" x")[..120].to_vec(), "stl", &["no readable ASCII STL"]),
        ("ASCII, no number", replaced(ascii_stl(" x"), "vertex 1e0", "vertex one"), "stl", &["no readable ASCII STL", "float"]),
        ("ASCII, infinite", replaced(ascii_stl(" x"), "vertex 1e0", "vertex inf"), "stl", &["no readable ASCII STL", "finite"]),
        ("ASCII, no triangles", b"solid x\nendsolid x\n".to_vec(), "stl", &["holds no triangle"]),
        (
            "ASCII, endless line",
            [b"solid x\n".to_vec(), vec![b'a'; 1 << 20]].concat(),
            "stl",
            &["line 2 has 1048576 bytes", "65536"],
        ),
        (
            "ASCII, then something else",
            [ascii_stl(" x"), b"v 1 2 3".to_vec()].concat(),
            "stl",
            &["after a solid's end", "v 1 2 3"],
        ),
    ]
}

fn bad_obj() -> Vec<Bad> {
    let with = |last: &str| [&obj()[..], last.as_bytes()].concat();
    vec![
        ("points only", b"v 0 0 0\nv 1 0 0\np 1 2\n".to_vec(), "obj", &["no triangle, but 2 vertices", "1 lines or points"]),
        ("lines only", b"v 0 0 0\nv 1 0 0\nl 1 2\n".to_vec(), "obj", &["no triangle", "1 lines or points"]),
        ("faces of two corners", b"v 0 0 0\nv 1 0 0\nf 1 2\n".to_vec(), "obj", &["1 faces of fewer than three corners"]),
        ("corner beyond", with("f 1 2 99\n"), "obj", &["no readable OBJ", "not among the file's 4"]),
        ("corner 0", with("f 0 1 2\n"), "obj", &["not among the file's 4"]),
        ("corner before the first", with("f -9 1 2\n"), "obj", &["not among the file's 4"]),
        ("largest corner", with("f 9223372036854775807 -9223372036854775808 1\n"), "obj", &["not among"]),
        ("corner of letters", with("f a b c\n"), "obj", &["line 16", "face parse error"]),
        ("not a number", with("v nan 0 0\nf 5 1 2\n"), "obj", &["coordinate NaN"]),
        ("infinite", with("v 1e999 0 0\nf 5 1 2\n"), "obj", &["coordinate inf"]),
        ("two coordinates", with("v 1 2\n"), "obj", &["line 16", "position parse error"]),
        ("weight of nothing", with("v 1 2 3 0\n"), "obj", &["line 16", "scaling"]),
        ("an empty face", b"v 0 0 0\nf\n".to_vec(), "obj", &["holds no triangle"]),
        ("comments only", b"# nothing here\n".to_vec(), "obj", &["holds no triangle"]),
        ("endless line", with(&format!("f {}", "1 ".repeat(40_000))), "obj", &["line 16 has 80002 bytes"]),
        ("binary", vec![0xff; 500], "obj", &["holds no triangle"]),
    ]
}

fn replaced(bytes: Vec<u8>, from: &str, to: &str) -> Vec<u8> {
    String::from_utf8(bytes).expect("text").replace(from, to).into_bytes()
}

fn bad_ply() -> Vec<Bad> {
    let text = || ply(Order::Text, "float", 4, 4);
    let without = |element: &str| replaced(text(), element, "comment");
    let huge = b"ply\nformat binary_little_endian 1.0\nelement nothing 18446744073709551615\nend_header\n".to_vec();
    let empty = b"ply\nformat binary_little_endian 1.0\nelement nothing 4000000000\nelement vertex 1\nproperty float x\nproperty float y\n\
        property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n............"
        .to_vec();
    vec![
        ("no header's end", b"ply\nformat ascii 1.0\n".to_vec(), "ply", &["no end_header"]),
        ("no format", replaced(text(), "format ascii 1.0\n", ""), "ply", &["No format line"]),
        ("no vertex", b"ply\nformat ascii 1.0\nend_header\n".to_vec(), "ply", &["no element vertex"]),
        ("no face", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n".to_vec(),
            "ply", &["no triangle, but 1 vertices"]),
        ("no z", without("property float z"), "ply", &["vertices have no z"]),
        ("no corners", without("property list uchar int vertex_indices"), "ply", &["faces have no vertex_indices"]),
        ("4e9 vertices", ply(Order::Little, "float", 4_000_000_000, 4), "ply", &["4000000000 vertices", "15000000"]),
        ("4e9 faces", ply(Order::Little, "float", 4, 4_000_000_000), "ply", &["4000000000 faces", "5000000"]),
        ("a million vertices", ply(Order::Big, "float", 1_000_000, 4), "ply", &["promises 1000000 of vertex", "13000000 bytes", "cut short"]),
        ("a million faces", ply(Order::Text, "float", 4, 1_000_000), "ply", &["promises 1000000 of face", "2000000 bytes"]),
        ("nothing, without end", huge, "ply", &["no element vertex"]),
        ("4e9 of nothing", empty, "ply", &["no triangle, but 1 vertices and 0 faces"]),
        ("cut short", ply(Order::Little, "double", 4, 4)[..260].to_vec(), "ply", &["no readable PLY", "cut short"]),
        ("cut in a face", ply(Order::Little, "float", 4, 4).split_last().unwrap().1.to_vec(), "ply", &["face 3"]),
        ("corner beyond", replaced(text(), "3 0 2 1", "3 0 2 4"), "ply", &["face 0 names vertex 4", "there are 4"]),
        ("corner below", replaced(text(), "3 0 2 1", "3 0 2 -1"), "ply", &["face 0 names vertex -1"]),
        ("a list of 4e9", replaced(text(), "3 0 2 1", "4000000000 0 2 1"), "ply", &["face 0", "found only 3"]),
        ("not a number", replaced(text(), "1 0 0 7", "nan 0 0 7"), "ply", &["no readable PLY", "vertex 1"]),
        ("coordinates are lists", replaced(text(), "property float x", "property list uchar float x"), "ply", &["no readable PLY", "x"]),
        ("corners are numbers", replaced(text(), "list uchar int vertex", "int vertex"), "ply", &["no readable PLY", "vertex_indices"]),
        ("faces first", b"ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 1\nproperty float x\n\
            property float y\nproperty float z\nend_header\n3 0 0 0\n1 2 3\n".to_vec(), "ply", &["faces come before"]),
        ("an unknown word", replaced(text(), "comment made", "remark made"), "ply", &["no readable PLY", "remark made"]),
    ]
}

#[test]
fn what_no_solid_can_use_is_refused_with_the_reason() {
    for (name, bytes, extension, words) in [bad_stl(), bad_obj(), bad_ply()].concat() {
        let message = match read_mesh(bytes, Some(extension), 0.001) {
            Ok(mesh) => panic!("{name}: read as {} triangles", mesh.triangles.len()),
            Err(error) => error.to_string(),
        };
        assert!(words.iter().all(|word| message.contains(word)), "{name}: {message:?} lacks one of {words:?}");
        assert!(message.len() < 400 && !message.contains('\n'), "{name}: {message}");
    }
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = read_mesh(good_binary_stl(), None, scale).unwrap_err().to_string();
        assert!(message.contains("scale") && message.contains("0.001"), "{message}");
    }
}

#[test]
fn more_triangles_than_allowed_are_refused_before_they_are_read() {
    let mut stl = binary_stl(&CORNERS, &[], 5_000_001, b"");
    stl.resize(84 + 50 * 5_000_001, 0);
    let message = read_mesh(stl, None, 1.0).unwrap_err().to_string();
    assert!(message.contains("5000001 triangles, allowed is up to 5000000"), "{message}");
}

/// A generator of its own: the same cases on every machine (G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, 2014).
struct Noise(u64);

impl Noise {
    fn below(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % most.max(1) as u64) as usize
    }
}

/// Cuts, flips, puts in, takes out, doubles.
fn damage(bytes: &mut Vec<u8>, noise: &mut Noise) {
    for _ in 0..=noise.below(4) {
        let at = noise.below(bytes.len());
        let end = (at + noise.below(16)).min(bytes.len());
        match noise.below(6) {
            0 => bytes.truncate(at),
            1 if at < bytes.len() => bytes[at] ^= 1 << noise.below(8),
            2 if at < bytes.len() => bytes[at] = [0, 0xff, b' ', b'\n', b'9', b'-', b'.', b'e'][noise.below(8)],
            3 => bytes.splice(at..at, b"99999999999 -1 nan 1e400 / \n"[..noise.below(28)].iter().copied()).for_each(drop),
            4 => bytes.drain(at..end).for_each(drop),
            _ => bytes.extend_from_within(at..end),
        }
    }
}

#[test]
fn damaged_files_are_read_or_refused_and_what_is_read_is_sound() {
    let mut noise = Noise(7);
    let (mut read, mut refused) = (0, 0);
    for (name, bytes, _) in good() {
        for _ in 0..2000 {
            let mut damaged = bytes.clone();
            damage(&mut damaged, &mut noise);
            let extension = [None, Some("stl"), Some("obj"), Some("ply")][noise.below(4)];
            match read_mesh(damaged, extension, 1.0) {
                Ok(mesh) => {
                    read += 1;
                    let count = mesh.vertices.len() as u32;
                    assert!(mesh.triangles.iter().flatten().all(|&corner| corner < count), "{name}");
                    assert!(mesh.vertices.iter().all(|v| v.abs().max_element() <= MAX_COORDINATE), "{name}");
                    // and whatever comes after a file is read bears it
                    let welded = weld(&mesh, None);
                    let _ = (check(&welded).problems(), properties(&welded));
                }
                Err(error) => {
                    refused += 1;
                    let message = error.to_string();
                    assert!(message.len() < 400 && !message.contains('\n'), "{name}: {message}");
                }
            }
        }
    }
    assert!(read > 2000 && refused > 2000, "{read} read, {refused} refused: the damage is one-sided");
}

#[test]
fn a_mesh_saved_and_named_otherwise_is_still_told_by_its_contents() {
    let mut file = Vec::new();
    write_stl(&tessellate::cuboid(DVec3::ONE), &mut file).unwrap();
    assert_eq!(read_mesh(file, Some("obj"), 1.0).unwrap().triangles.len(), 12);
}

#[test]
fn what_is_no_regular_file_is_not_opened() {
    for (path, word) in [("/", "directory"), ("/dev/zero", "regular file"), ("/no/such/file.stl", "No such file")] {
        let message = load_mesh(Path::new(path), 1.0).unwrap_err().to_string();
        assert!(message.contains("cannot be opened") && message.contains(word), "{message}");
    }
}

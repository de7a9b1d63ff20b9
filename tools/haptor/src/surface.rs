//! The deformed object as a file: its surface in triangles, finer near the contacts, every vertex displaced by the core.
//!
//! PLY, binary, little-endian: vertices `x y z` (deformed) and `ux uy uz` (displacement), float, m, world; faces as lists of three.

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::PathBuf;

use haptor_contact::surface::Surface;
use haptor_contact::{ObjectShape, Vec3};
use haptor_mesh::{DVec3, Mesh, tessellate};

/// Fewest vertices of a surface.
const MIN_VERTICES: usize = 4_000;

/// Vertices at which refinement stops: near contacts a million times smaller than the object it would go on for long.
const MAX_VERTICES: usize = 1_000_000;

/// Sides of a round body before refinement: a chord is then within 0.03 % of the radius.
const SIDES: u32 = 128;

/// Edge of the square that is shown of a half space \[m\].
const HALF_SPACE_EDGE: f64 = 0.2;

/// Edges under a contact, per contact radius.
const EDGES_PER_RADIUS: f64 = 8.0;

/// Growth of the edges with the distance from a contact.
const GROWTH: f64 = 0.2;

/// A surface asked for on the command line, `T_S=FILE.ply`.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Time \[s\]: the first tick at or after it.
    pub time: f64,
    /// Where to.
    pub file: PathBuf,
}

impl std::str::FromStr for Request {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let allowed = || "allowed is T_S=FILE.ply, seconds and a file, e.g. 1.2=twist.ply".to_owned();
        let (time, file) = text.split_once('=').filter(|(_, file)| !file.is_empty()).ok_or_else(allowed)?;
        let time: f64 = time.trim().parse().ok().filter(|time: &f64| time.is_finite()).ok_or_else(allowed)?;
        Ok(Self { time, file: file.into() })
    }
}

/// The undeformed surface of `object` in world, of at least `vertices`, finer near contacts: each has a place and a radius \[m\]. `skin` is a mesh object's
/// own.
pub fn at_rest(object: &ObjectShape<'_>, skin: Option<&Mesh>, near: &[(DVec3, f64)], vertices: usize) -> Mesh {
    let coarse = skin.map_or_else(|| coarse(object), Mesh::clone);
    // 2.4 vertices per square of the longest edge on average; less is asked for until there are enough
    let mut longest = (coarse.area() / vertices as f64).sqrt() * 2.0;
    loop {
        let edge = |p: DVec3| near.iter().fold(longest, |edge, &(centre, a)| edge.min(edge_near((p - centre).length(), a)));
        let mesh = refined(coarse.clone(), edge, |p| onto(object, p));
        if mesh.vertices.len() >= vertices {
            return mesh;
        }
        longest *= 0.8;
    }
}

/// Longest edge at a distance from a contact of radius `a`; a contact without extent asks for nothing.
fn edge_near(distance: f64, a: f64) -> f64 {
    if a > 0.0 { (a / EDGES_PER_RADIUS).max(GROWTH * (distance - a)) } else { f64::INFINITY }
}

/// The fewest triangles that have the object's form.
fn coarse(object: &ObjectShape<'_>) -> Mesh {
    let up = |mesh: Mesh| mesh.mapped(|p| p + DVec3::Z * (f64::from(object.height()) / 2.0));
    match *object {
        ObjectShape::HalfSpace => {
            let c = HALF_SPACE_EDGE / 2.0;
            let corners = [(-c, -c), (c, -c), (c, c), (-c, c)];
            Mesh {
                vertices: corners.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
            }
        }
        ObjectShape::Box { size } => up(tessellate::cuboid(wide(size))),
        ObjectShape::Sphere { radius } => up(tessellate::ellipsoid(DVec3::splat(radius.into()), SIDES)),
        ObjectShape::Ellipsoid { semi_axes } => up(tessellate::ellipsoid(wide(semi_axes), SIDES)),
        ObjectShape::Cylinder { radius, height } => up(tessellate::cylinder(radius.into(), height.into(), SIDES)),
        ObjectShape::Mesh(mesh) => coarse(&mesh.stand_in()),
    }
}

/// Brings the middle of an edge back to a round surface; flat ones contain it.
fn onto(object: &ObjectShape<'_>, p: DVec3) -> DVec3 {
    let semi_axes = match *object {
        ObjectShape::Sphere { radius } => DVec3::splat(radius.into()),
        ObjectShape::Ellipsoid { semi_axes } => wide(semi_axes),
        _ => return p,
    };
    let centre = DVec3::Z * semi_axes.z;
    let unit = (p - centre) / semi_axes;
    centre + unit / unit.length() * semi_axes
}

/// Splits edges in the middle until none is longer than `edge` at its middle. An edge is split for both its triangles, so that
/// the surface stays closed.
fn refined(mut mesh: Mesh, edge: impl Fn(DVec3) -> f64, onto: impl Fn(DVec3) -> DVec3) -> Mesh {
    loop {
        let before = mesh.vertices.len();
        let mut middles: HashMap<(u32, u32), Option<u32>> = HashMap::new();
        let mut triangles = Vec::with_capacity(2 * mesh.triangles.len());
        for [a, b, c] in std::mem::take(&mut mesh.triangles) {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| split(&mut mesh.vertices, a, b, &edge, &onto))
            };
            let middles = [middle(a, b), middle(b, c), middle(c, a)];
            divide([a, b, c], middles, &mut triangles);
        }
        mesh.triangles = triangles;
        if mesh.vertices.len() == before || mesh.vertices.len() > MAX_VERTICES {
            return mesh;
        }
    }
}

/// The new vertex in the middle of an edge that is too long.
fn split(vertices: &mut Vec<DVec3>, a: u32, b: u32, edge: impl Fn(DVec3) -> f64, onto: impl Fn(DVec3) -> DVec3) -> Option<u32> {
    let (from, to) = (vertices[a as usize], vertices[b as usize]);
    let middle = (from + to) / 2.0;
    if (to - from).length() <= edge(middle) {
        return None;
    }
    vertices.push(onto(middle));
    Some(vertices.len() as u32 - 1)
}

/// One triangle with new vertices on some of its edges ab, bc, ca; the sense of turn is kept.
fn divide([a, b, c]: [u32; 3], middles: [Option<u32>; 3], out: &mut Vec<[u32; 3]>) {
    match middles {
        [None, None, None] => out.push([a, b, c]),
        [Some(ab), None, None] => out.extend([[a, ab, c], [ab, b, c]]),
        [Some(ab), Some(bc), None] => out.extend([[ab, b, bc], [a, ab, bc], [a, bc, c]]),
        [Some(ab), Some(bc), Some(ca)] => out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]),
        [ab, bc, ca] => divide([b, c, a], [bc, ca, ab], out),
    }
}

/// The surface at rest and how far each of its vertices has moved \[m\].
pub fn deformed(surface: &Surface<'_>, skin: Option<&Mesh>) -> (Mesh, Vec<Vec3>) {
    let near: Vec<_> = surface.patches.iter().map(|p| (wide(p.at_rest()), f64::from(p.footprint.radius))).collect();
    let mesh = at_rest(&surface.model.object(), skin, &near, MIN_VERTICES);
    let rest: Vec<Vec3> = mesh.vertices.iter().map(|&v| narrow(v)).collect();
    let mut moved = vec![Vec3::ZERO; rest.len()];
    surface.update(&rest, &mut moved);
    (mesh, moved)
}

/// Writes the deformed object.
///
/// # Errors
/// Those of the writer.
pub fn write(surface: &Surface<'_>, skin: Option<&Mesh>, out: &mut impl Write) -> io::Result<()> {
    let (mesh, moved) = deformed(surface, skin);
    let rest: Vec<Vec3> = mesh.vertices.iter().map(|&v| narrow(v)).collect();
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment haptor: deformed surface, m, world\nelement vertex {}\n",
        rest.len()
    )?;
    for name in ["x", "y", "z", "ux", "uy", "uz"] {
        writeln!(out, "property float {name}")?;
    }
    write!(out, "element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.triangles.len())?;
    for (&p, &u) in rest.iter().zip(&moved) {
        for number in (p + u).to_array().into_iter().chain(u.to_array()) {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        triangle.iter().try_for_each(|corner| out.write_all(&corner.to_le_bytes()))?;
    }
    Ok(())
}

fn wide(v: Vec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(f64::from))
}

fn narrow(v: DVec3) -> Vec3 {
    Vec3::from_array(v.to_array().map(|x| x as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_mesh::check;

    #[test]
    fn surfaces_are_closed_fine_enough_and_finer_under_a_contact() {
        let shapes = [
            ObjectShape::Box { size: Vec3::new(0.1, 0.2, 0.05) },
            ObjectShape::Sphere { radius: 0.05 },
            ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) },
            ObjectShape::Cylinder { radius: 0.05, height: 0.1 },
            ObjectShape::HalfSpace,
        ];
        for object in shapes {
            let contact = [(DVec3::Z * f64::from(object.height()), 0.004)];
            let (free, pressed) = (at_rest(&object, None, &[], MIN_VERTICES), at_rest(&object, None, &contact, MIN_VERTICES));
            let near = |mesh: &Mesh| {
                mesh.vertices.iter().filter(|v| (**v - DVec3::Z * f64::from(object.height())).length() < 0.004).count()
            };
            assert!(free.vertices.len() >= MIN_VERTICES && free.vertices.len() < 20 * MIN_VERTICES, "{object:?}");
            assert!(near(&pressed) > 150 && near(&pressed) > 2 * near(&free), "{object:?}: {}", near(&pressed));
            if object != ObjectShape::HalfSpace {
                assert!(check(&pressed).is_solid(), "{object:?}: {:?}", check(&pressed));
            }
        }
    }

    #[test]
    fn requests_are_time_and_file() {
        let request = |text: &str| text.parse::<Request>();
        assert_eq!(request("1.5=a=b.ply"), Ok(Request { time: 1.5, file: "a=b.ply".into() }));
        for bad in ["", "1.5", "=x.ply", "1.5=", "soon=x.ply", "nan=x.ply", "inf=x.ply"] {
            assert!(request(bad).unwrap_err().contains("T_S=FILE.ply"), "{bad}");
        }
    }
}

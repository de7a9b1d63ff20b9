//! The things in a picture as triangles in world: bodies, ground, arrows, discs.

use glam::{DQuat, DVec3};
use haptor_mesh::{Mesh, tessellate};
use haptor_wire::{ObjectShape, ProbePart, ProbeShape};

/// Points on a ring of a round body: its outline is smooth at any size of picture.
const SIDES: u32 = 96;

/// Edge of the patch that stands for a half space \[m\].
pub const PATCH: f64 = 0.2;

/// The object at rest; a mesh is one of `skins`.
pub fn object(shape: &ObjectShape, skins: &[Mesh]) -> Mesh {
    let up = |mesh: Mesh, height: f64| mesh.mapped(|v| v + height * DVec3::Z);
    match *shape {
        ObjectShape::HalfSpace => up(tessellate::cuboid(DVec3::new(PATCH, PATCH, PATCH / 10.0)), -PATCH / 20.0),
        ObjectShape::Box { size } => up(tessellate::cuboid(wide(size)), f64::from(size[2]) / 2.0),
        ObjectShape::Sphere { radius } => up(tessellate::ellipsoid(DVec3::splat(radius.into()), SIDES), radius.into()),
        ObjectShape::Ellipsoid { semi_axes } => up(tessellate::ellipsoid(wide(semi_axes), SIDES), semi_axes[2].into()),
        ObjectShape::Cylinder { radius, height } => {
            up(tessellate::cylinder(radius.into(), height.into(), SIDES), f64::from(height) / 2.0)
        }
        ObjectShape::Mesh { grid } => skin(skins, grid),
    }
}

fn skin(skins: &[Mesh], number: u8) -> Mesh {
    skins.get(usize::from(number)).cloned().unwrap_or_default()
}

/// A part of the probe, in the probe's frame; a mesh is one of `skins`.
pub fn part(part: &ProbePart, skins: &[Mesh]) -> Mesh {
    let mesh = match part.shape {
        ProbeShape::Sphere { radius } => tessellate::ellipsoid(DVec3::splat(radius.into()), SIDES),
        ProbeShape::Box { size } => tessellate::cuboid(wide(size)),
        ProbeShape::Cylinder { radius, height } => tessellate::cylinder(radius.into(), height.into(), SIDES),
        ProbeShape::Cone { radius, height } => tessellate::cone(radius.into(), height.into(), SIDES),
        ProbeShape::Capsule { radius, height } => tessellate::capsule(radius.into(), height.into(), SIDES),
        ProbeShape::Ellipsoid { semi_axes } => tessellate::ellipsoid(wide(semi_axes), SIDES),
        ProbeShape::Mesh { grid } => skin(skins, grid),
    };
    let [w, x, y, z] = part.rotation.map(f64::from);
    let rotation = DQuat::from_xyzw(x, y, z, w).normalize();
    mesh.mapped(|v| wide(part.position) + rotation * v)
}

/// An arrow from `tail` along `reach`, as thick as `radius` \[m\].
pub fn arrow(tail: DVec3, reach: DVec3, radius: f64) -> Vec<Mesh> {
    let length = reach.length();
    let head = (4.5 * radius).min(0.5 * length);
    let along = DQuat::from_rotation_arc(DVec3::Z, reach.normalize_or(DVec3::Z));
    let shaft = tessellate::cylinder(radius, length - head, SIDES / 2);
    // the cone's tip points down its own axis: turned over, and up to the end
    let tip = tessellate::cone(2.4 * radius, head, SIDES / 2)
        .mapped(|v| DVec3::new(v.x, -v.y, -v.z) + (length - 0.75 * head) * DVec3::Z);
    let shaft = shaft.mapped(|v| v + 0.5 * (length - head) * DVec3::Z);
    [shaft, tip].map(|mesh| mesh.mapped(|v| tail + along * v)).into()
}

/// A ring segment about `axis`: an arc from angle 0 to `angle` \[rad\] with a head, for a torque.
pub fn arc(centre: DVec3, axis: DVec3, ring: f64, angle: f64, radius: f64) -> Vec<Mesh> {
    let frame = DQuat::from_rotation_arc(DVec3::Z, axis.normalize_or(DVec3::Z));
    let at = |t: f64| centre + frame * (ring * DVec3::new(t.cos(), t.sin(), 0.0));
    let steps = 40_u32;
    let mut meshes: Vec<_> = (0..steps)
        .map(|k| {
            let (a, b) = (at(angle * f64::from(k) / f64::from(steps)), at(angle * f64::from(k + 1) / f64::from(steps)));
            let turn = DQuat::from_rotation_arc(DVec3::Z, (b - a).normalize_or(DVec3::Z));
            let length = 1.2 * a.distance(b);
            tessellate::cylinder(radius, length, SIDES / 4).mapped(|v| (a + b) / 2.0 + turn * v)
        })
        .collect();
    let ahead = frame * DVec3::new(-angle.sin(), angle.cos(), 0.0) * angle.signum();
    meshes.extend(arrow(at(angle) - 2.6 * radius * ahead, 5.0 * radius * ahead, radius).into_iter().skip(1));
    meshes
}

/// A disc about `centre`.
pub fn disc(centre: DVec3, normal: DVec3, radius: f64) -> Mesh {
    let turn = DQuat::from_rotation_arc(DVec3::Z, normal.normalize_or(DVec3::Z));
    let rim = (0..SIDES).map(|k| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(SIDES);
        centre + turn * (radius * DVec3::new(angle.cos(), angle.sin(), 0.0))
    });
    let vertices = rim.chain([centre]).collect();
    let triangles = (0..SIDES).map(|k| [SIDES, k, (k + 1) % SIDES]).collect();
    Mesh { vertices, triangles }
}

/// The ground as tiles: those of one colour, and those of the other.
pub fn ground(reach: f64, height: f64) -> [Mesh; 2] {
    let tiles = 12_i32;
    let edge = 2.0 * reach / f64::from(tiles);
    let mut colours = [Mesh::default(), Mesh::default()];
    for (i, j) in (0..tiles * tiles).map(|k| (k % tiles, k / tiles)) {
        let mesh = &mut colours[((i + j) % 2) as usize];
        let first = mesh.vertices.len() as u32;
        let corner = |a: i32, b: i32| DVec3::new(f64::from(i + a) * edge - reach, f64::from(j + b) * edge - reach, height);
        mesh.vertices.extend([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    colours
}

/// f32 to f64.
pub fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

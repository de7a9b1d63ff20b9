//! The bodies of a baked scene as triangles.

use glam::{DQuat, DVec3};
use haptor_mesh::{Mesh, tessellate};
use haptor_wire::{BakedScene, ObjectShape, ProbePart, ProbeShape};

use crate::feed::Stage;

/// Points on a ring of a round body: its outline is smooth at any size of picture.
const SIDES: u32 = 96;

/// Edge of the patch that stands for a half space \[m\].
const PATCH: f64 = 0.2;

/// A baked scene as a stage; `skins` are the meshes of the scene, by the number that a shape calls them, one that is missing is not drawn.
/// Names, tick and scales are left to be filled in.
pub fn stage(scene: &BakedScene, skins: &[Mesh]) -> Stage {
    Stage {
        object: object(&scene.object, skins),
        is_ground: scene.object == ObjectShape::HalfSpace,
        probe: scene.probe.as_slice().iter().map(|each| part(each, skins)).collect(),
        ..Stage::default()
    }
}

/// The object at rest; a mesh is one of `skins`.
fn object(shape: &ObjectShape, skins: &[Mesh]) -> Mesh {
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
fn part(part: &ProbePart, skins: &[Mesh]) -> Mesh {
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

/// f32 to f64.
fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

//! Object and probe as the core takes them, from shapes on the wire and what their file carries.

use haptor_contact as contact;
use haptor_contact::green::Green;
use haptor_contact::{MAX_PARTS, MeshShape, Quat, Vec3};
use haptor_wire as wire;
use haptor_wire::BakedScene;
use heapless::Vec;

use crate::error::SceneError;

/// Meshes of a file at most: an object and the parts of a probe.
pub const MAX_MESHES: usize = 1 + MAX_PARTS;

/// Where shapes that are meshes are found.
pub trait Meshes<'a> {
    /// The mesh that the shape at `key` calls by its number.
    ///
    /// # Errors
    /// [`SceneError::NoMesh`] when there is none.
    fn mesh(&self, key: &'static str, number: u8) -> Result<MeshShape<'a>, SceneError>;
}

/// A file that carries no meshes.
#[derive(Clone, Copy, Debug)]
pub struct NoMeshes;

impl<'a> Meshes<'a> for NoMeshes {
    fn mesh(&self, key: &'static str, number: u8) -> Result<MeshShape<'a>, SceneError> {
        Err(SceneError::NoMesh { key, number, found: 0 })
    }
}

/// Object, parts of the probe, and the table of the object's own Green's function if there is one.
#[derive(Clone, Debug)]
pub struct Bodies<'a> {
    /// The elastic object.
    pub object: contact::ObjectShape<'a>,
    /// The probe's convex parts.
    pub parts: Vec<contact::ProbePart<'a>, MAX_PARTS>,
    /// The object's own table.
    pub green: Option<Green<'a>>,
}

impl<'a> Bodies<'a> {
    /// The bodies of a scene.
    ///
    /// # Errors
    /// [`SceneError`] when a shape names a mesh that is not there, or tier `green` finds no table.
    pub fn new(baked: &BakedScene, meshes: &impl Meshes<'a>, green: Option<Green<'a>>) -> Result<Self, SceneError> {
        if baked.tier == wire::Tier::Green && green.is_none() {
            return Err(SceneError::NoTable);
        }
        let parts = baked.probe.as_slice().iter().map(|part| probe_part(part, meshes));
        Ok(Self { object: object_shape(&baked.object, meshes)?, parts: parts.collect::<Result<_, _>>()?, green })
    }
}

fn object_shape<'a>(shape: &wire::ObjectShape, meshes: &impl Meshes<'a>) -> Result<contact::ObjectShape<'a>, SceneError> {
    use wire::ObjectShape as From;
    Ok(match *shape {
        From::HalfSpace => contact::ObjectShape::HalfSpace,
        From::Box { size } => contact::ObjectShape::Box { size: Vec3::from_array(size) },
        From::Sphere { radius } => contact::ObjectShape::Sphere { radius },
        From::Ellipsoid { semi_axes } => contact::ObjectShape::Ellipsoid { semi_axes: Vec3::from_array(semi_axes) },
        From::Cylinder { radius, height } => contact::ObjectShape::Cylinder { radius, height },
        From::Mesh { grid } => contact::ObjectShape::Mesh(meshes.mesh("object", grid)?),
    })
}

/// As it is written; whether its rotation is one, the core's constructor checks.
fn probe_part<'a>(part: &wire::ProbePart, meshes: &impl Meshes<'a>) -> Result<contact::ProbePart<'a>, SceneError> {
    let [w, x, y, z] = part.rotation;
    Ok(contact::ProbePart {
        shape: probe_shape(&part.shape, meshes)?,
        position: Vec3::from_array(part.position),
        rotation: Quat::from_xyzw(x, y, z, w),
    })
}

fn probe_shape<'a>(shape: &wire::ProbeShape, meshes: &impl Meshes<'a>) -> Result<contact::ProbeShape<'a>, SceneError> {
    use wire::ProbeShape as From;
    Ok(match *shape {
        From::Sphere { radius } => contact::ProbeShape::Sphere { radius },
        From::Box { size } => contact::ProbeShape::Box { size: Vec3::from_array(size) },
        From::Cylinder { radius, height } => contact::ProbeShape::Cylinder { radius, height },
        From::Cone { radius, height } => contact::ProbeShape::Cone { radius, height },
        From::Capsule { radius, height } => contact::ProbeShape::Capsule { radius, height },
        From::Ellipsoid { semi_axes } => contact::ProbeShape::Ellipsoid { semi_axes: Vec3::from_array(semi_axes) },
        From::Mesh { grid } => contact::ProbeShape::Mesh(meshes.mesh("probe", grid)?),
    })
}

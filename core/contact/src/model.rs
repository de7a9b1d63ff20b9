//! The constant world: an elastic object and a rigid probe made of convex parts, primitives or meshes.

use glam::{Quat, Vec3};

use crate::coupling::inertia::{self, Inertia};
use crate::error::{Invalid, require};
use crate::green::Green;
use crate::limits::{MAX_DISTANCE, MAX_PARTS, QUATERNION_TOLERANCE};
use crate::mesh_shape::MeshShape;

/// The elastic material, linear and isotropic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus E \[Pa\], 1e2 to 1e12.
    pub young_modulus: f32,
    /// Poisson's ratio nu, 0 to 0.5, both included.
    pub poisson_ratio: f32,
    /// Density \[kg/m^3\].
    pub density: f32,
}

impl Material {
    /// Shear modulus G = E / (2 (1 + nu)) \[Pa\] (paper, equation 3).
    pub fn shear_modulus(&self) -> f32 {
        self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))
    }

    /// Contact modulus against a rigid probe, E* = E / (1 - nu^2) \[Pa\].
    pub fn contact_modulus(&self) -> f32 {
        self.young_modulus / (1.0 - self.poisson_ratio * self.poisson_ratio)
    }
}

/// Shape of the elastic object at rest. Its base centre is the world origin, +z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectShape<'a> {
    /// Solid below z = 0.
    HalfSpace,
    /// Box of edges `size` \[m\], standing on z = 0.
    Box {
        /// Edge lengths along x, y, z \[m\].
        size: Vec3,
    },
    /// Sphere whose lowest point is the origin.
    Sphere {
        /// Radius \[m\].
        radius: f32,
    },
    /// Ellipsoid whose lowest point is the origin.
    Ellipsoid {
        /// Semi-axes along x, y, z \[m\].
        semi_axes: Vec3,
    },
    /// Upright cylinder standing on z = 0.
    Cylinder {
        /// Radius \[m\].
        radius: f32,
        /// Height \[m\].
        height: f32,
    },
    /// Body given by a mesh whose base lies at z = 0.
    Mesh(MeshShape<'a>),
}

impl ObjectShape<'_> {
    /// Height of the highest point above the base \[m\]; 0 for the half space.
    pub fn height(&self) -> f32 {
        match *self {
            Self::HalfSpace => 0.0,
            Self::Box { size } => size.z,
            Self::Sphere { radius } => 2.0 * radius,
            Self::Ellipsoid { semi_axes } => 2.0 * semi_axes.z,
            Self::Cylinder { height, .. } => height,
            Self::Mesh(mesh) => mesh.bounds().1.z,
        }
    }

    /// Height below which the surface is held unless the scene says otherwise \[m\]: 0 for box and cylinder,
    /// an eighth of the height for round bodies; a mesh takes that of its stand-in ([`MeshShape::stand_in`]).
    pub fn default_fixed_below(&self) -> f32 {
        match self {
            Self::HalfSpace | Self::Box { .. } | Self::Cylinder { .. } => 0.0,
            Self::Sphere { .. } | Self::Ellipsoid { .. } => 0.125 * self.height(),
            Self::Mesh(mesh) => mesh.stand_in().default_fixed_below(),
        }
    }
}

/// A convex primitive of the probe, in the part's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeShape<'a> {
    /// Ball about the origin.
    Sphere {
        /// Radius \[m\].
        radius: f32,
    },
    /// Box about the origin.
    Box {
        /// Edge lengths \[m\].
        size: Vec3,
    },
    /// Cylinder about the origin, axis z; its flat end is the flat punch.
    Cylinder {
        /// Radius \[m\].
        radius: f32,
        /// Height \[m\].
        height: f32,
    },
    /// Cone with its tip towards -z; the origin is the mass centre, 3/4 of the height above the tip.
    Cone {
        /// Radius of the base \[m\].
        radius: f32,
        /// Height \[m\].
        height: f32,
    },
    /// Cylinder with round ends, axis z.
    Capsule {
        /// Radius \[m\].
        radius: f32,
        /// Length of the straight part \[m\].
        height: f32,
    },
    /// Ellipsoid about the origin.
    Ellipsoid {
        /// Semi-axes \[m\].
        semi_axes: Vec3,
    },
    /// Convex body given by a mesh.
    Mesh(MeshShape<'a>),
}

impl ProbeShape<'_> {
    /// The shape itself where it is a primitive, which borrows nothing; `None` for a mesh.
    pub(crate) fn primitive(&self) -> Option<ProbeShape<'static>> {
        Some(match *self {
            Self::Sphere { radius } => ProbeShape::Sphere { radius },
            Self::Box { size } => ProbeShape::Box { size },
            Self::Cylinder { radius, height } => ProbeShape::Cylinder { radius, height },
            Self::Cone { radius, height } => ProbeShape::Cone { radius, height },
            Self::Capsule { radius, height } => ProbeShape::Capsule { radius, height },
            Self::Ellipsoid { semi_axes } => ProbeShape::Ellipsoid { semi_axes },
            Self::Mesh(_) => return None,
        })
    }
}

/// One part of the probe: a shape, placed in the probe frame p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePart<'a> {
    /// The shape.
    pub shape: ProbeShape<'a>,
    /// Position of the part's origin in p \[m\].
    pub position: Vec3,
    /// Rotation from the part's frame to p, unit quaternion.
    pub rotation: Quat,
}

impl<'a> ProbePart<'a> {
    /// A part whose frame is the probe's.
    pub const fn at_origin(shape: ProbeShape<'a>) -> Self {
        Self { shape, position: Vec3::ZERO, rotation: Quat::IDENTITY }
    }

    /// The part with at most so many samples of its mesh.
    pub(crate) fn coarser(&self, samples: usize) -> Self {
        match self.shape {
            ProbeShape::Mesh(mesh) => Self { shape: ProbeShape::Mesh(mesh.coarser(samples)), ..*self },
            _ => *self,
        }
    }
}

/// Compliances of the object's body beyond those of the half space, at the contact, in the contact's directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compliance {
    /// C_n: along the normal \[m/N\].
    pub normal: f32,
    /// C_t: along the surface \[m/N\].
    pub drag: f32,
    /// C_theta: about the normal \[rad/(N m)\].
    pub twist: f32,
}

/// Everything a [`Model`] is made from.
#[derive(Clone, Copy, Debug)]
pub struct ModelSpec<'a> {
    /// Shape of the elastic object.
    pub object: ObjectShape<'a>,
    /// The elastic material.
    pub material: Material,
    /// Surface points at or below this height are held \[m\]; `None` takes the shape's default.
    pub fixed_below: Option<f32>,
    /// Body compliances given by the scene; `None` takes the closed forms and the beam estimate of `theory.md` section 7.
    pub compliance: Option<Compliance>,
    /// The body's own Green's function, computed by a tool; `None` takes the closed forms. `compliance`, where given, goes before it.
    pub green: Option<Green<'a>>,
    /// The probe's convex parts, 1 to [`MAX_PARTS`].
    pub probe: &'a [ProbePart<'a>],
    /// Mass of the probe \[kg\], 0 to 1e4.
    pub mass: f32,
    /// Inertia of the probe; `None` spreads the mass evenly over the volume of its parts.
    pub inertia: Option<Inertia>,
    /// Length l of equation 2 on a half space, which has no fixed point \[m\].
    pub paper_length: f32,
}

impl<'a> ModelSpec<'a> {
    /// Spec with the defaults of the scene file: 1 kg, shape's own fixed height, computed compliances, l = 0.1 m.
    pub const fn new(object: ObjectShape<'a>, material: Material, probe: &'a [ProbePart<'a>]) -> Self {
        Self {
            object,
            material,
            fixed_below: None,
            compliance: None,
            green: None,
            probe,
            mass: 1.0,
            inertia: None,
            paper_length: 0.1,
        }
    }
}

/// A validated scene. Never changes while ticks run; borrows the probe's parts and what meshes hold.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    pub(crate) object: ObjectShape<'a>,
    pub(crate) material: Material,
    pub(crate) fixed_below: f32,
    pub(crate) compliance: Option<Compliance>,
    pub(crate) green: Option<Green<'a>>,
    pub(crate) probe: &'a [ProbePart<'a>],
    pub(crate) mass: f32,
    pub(crate) inertia: Inertia,
    pub(crate) paper_length: f32,
}

/// Lengths a scene may use \[m\]: below, f32 products of four lengths leave the normal range; above, see [`MAX_DISTANCE`].
const LENGTH_RANGE: core::ops::RangeInclusive<f32> = 1.0e-6..=1.0e2;

impl<'a> Model<'a> {
    /// Validates the spec.
    ///
    /// # Errors
    /// [`Invalid`] names the first value out of range.
    pub fn new(spec: &ModelSpec<'a>) -> Result<Self, Invalid> {
        check_material(&spec.material)?;
        check_object(&spec.object)?;
        check_probe(spec.probe)?;
        check_compliance(spec.compliance)?;
        require(spec.mass >= 0.0 && spec.mass <= 1.0e4, "probe.mass", spec.mass, "0 to 1e4 kg")?;
        let inertia = spec.inertia.unwrap_or_else(|| inertia::of_parts(spec.probe, spec.mass));
        inertia.check()?;
        require(LENGTH_RANGE.contains(&spec.paper_length), "model.paper_length", spec.paper_length, "1e-6 to 1e2 m")?;
        let fixed_below = spec.fixed_below.unwrap_or(spec.object.default_fixed_below());
        let top = if spec.object == ObjectShape::HalfSpace { f32::MAX } else { spec.object.height() };
        require(fixed_below >= 0.0 && fixed_below < top, "object.fixed_below", fixed_below, "0 to below the object's height, m")?;
        Ok(Self {
            object: spec.object,
            material: spec.material,
            fixed_below,
            compliance: spec.compliance,
            green: spec.green,
            probe: spec.probe,
            mass: spec.mass,
            inertia,
            paper_length: spec.paper_length,
        })
    }

    /// Shape of the elastic object.
    pub fn object(&self) -> ObjectShape<'a> {
        self.object
    }

    /// The elastic material.
    pub fn material(&self) -> Material {
        self.material
    }

    /// The body's own Green's function, where a tool has computed it.
    pub fn green(&self) -> Option<&Green<'a>> {
        self.green.as_ref()
    }

    /// The table that tells what the body adds to the half space; a scene's own compliances go before it.
    pub(crate) fn table(&self) -> Option<&Green<'a>> {
        if self.compliance.is_none() { self.green.as_ref() } else { None }
    }

    /// Height at and below which nothing moves \[m\]; minus infinity for a half space.
    pub(crate) fn base(&self) -> f32 {
        if self.object == ObjectShape::HalfSpace { f32::NEG_INFINITY } else { self.fixed_below }
    }

    /// Inertia of the probe about its mass centre.
    pub fn inertia(&self) -> Inertia {
        self.inertia
    }

    /// The probe's parts.
    pub fn probe(&self) -> &'a [ProbePart<'a>] {
        self.probe
    }
}

fn check_material(material: &Material) -> Result<(), Invalid> {
    let Material { young_modulus: e, poisson_ratio: nu, density } = *material;
    require((1.0e2..=1.0e12).contains(&e), "object.young_modulus", e, "1e2 to 1e12 Pa")?;
    require((0.0..=0.5).contains(&nu), "object.poisson_ratio", nu, "0 to 0.5")?;
    require(density > 0.0 && density <= 1.0e5, "object.density", density, "above 0 to 1e5 kg/m^3")
}

fn check_length(name: &'static str, length: f32) -> Result<(), Invalid> {
    require(LENGTH_RANGE.contains(&length), name, length, "1e-6 to 1e2 m")
}

fn check_lengths(name: &'static str, lengths: Vec3) -> Result<(), Invalid> {
    lengths.to_array().iter().try_for_each(|&length| check_length(name, length))
}

fn check_object(object: &ObjectShape<'_>) -> Result<(), Invalid> {
    match *object {
        ObjectShape::HalfSpace => Ok(()),
        ObjectShape::Box { size } => check_lengths("object.size", size),
        ObjectShape::Sphere { radius } => check_length("object.radius", radius),
        ObjectShape::Ellipsoid { semi_axes } => check_lengths("object.semi_axes", semi_axes),
        ObjectShape::Cylinder { radius, height } => {
            check_length("object.radius", radius)?;
            check_length("object.height", height)
        }
        ObjectShape::Mesh(mesh) => check_base(&mesh),
    }
}

/// How far a mesh's base may stand off z = 0, as a share of its height: rounding of a file's coordinates, not a misplaced body.
const BASE_TOLERANCE: f32 = 1.0e-3;

fn check_base(mesh: &MeshShape<'_>) -> Result<(), Invalid> {
    let (low, high) = mesh.bounds();
    check_lengths("object.mesh (extents)", high - low)?;
    require(low.z.abs() <= BASE_TOLERANCE * high.z, "object.mesh (lowest z)", low.z, "0: the base of an object lies at z = 0")
}

fn check_probe(parts: &[ProbePart<'_>]) -> Result<(), Invalid> {
    require((1..=MAX_PARTS).contains(&parts.len()), "probe.part (count)", parts.len() as f32, "1 to 16 parts")?;
    parts.iter().try_for_each(check_part)
}

fn check_part(part: &ProbePart<'_>) -> Result<(), Invalid> {
    match part.shape {
        ProbeShape::Sphere { radius } => check_length("probe.radius", radius)?,
        ProbeShape::Box { size } => check_lengths("probe.size", size)?,
        ProbeShape::Ellipsoid { semi_axes } => check_lengths("probe.semi_axes", semi_axes)?,
        ProbeShape::Cylinder { radius, height }
        | ProbeShape::Cone { radius, height }
        | ProbeShape::Capsule { radius, height } => {
            check_length("probe.radius", radius)?;
            check_length("probe.height", height)?;
        }
        ProbeShape::Mesh(mesh) => {
            let (low, high) = mesh.bounds();
            check_lengths("probe.mesh (extents)", high - low)?;
        }
    }
    let reach = part.position.length();
    require(reach <= MAX_DISTANCE, "probe.position", reach, "within 1e3 m of the mass centre")?;
    let norm = part.rotation.length();
    require((norm - 1.0).abs() <= QUATERNION_TOLERANCE, "probe.rotation (length)", norm, "a unit quaternion, within 1e-3")
}

fn check_compliance(compliance: Option<Compliance>) -> Result<(), Invalid> {
    let Some(Compliance { normal, drag, twist }) = compliance else { return Ok(()) };
    require(normal >= 0.0, "object.compliance.normal", normal, "0 or more, m/N")?;
    require(drag >= 0.0, "object.compliance.drag", drag, "0 or more, m/N")?;
    require(twist >= 0.0, "object.compliance.twist", twist, "0 or more, rad/(N m)")
}

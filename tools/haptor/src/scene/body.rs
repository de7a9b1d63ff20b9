//! `[object]` and `[probe]`: shapes, material, mass. A key that does not belong to the shape is an error.

use haptor_contact::{Compliance, Inertia, MAX_PARTS, Material, ObjectShape, ProbePart, ProbeShape, Quat, Vec3};

use super::document::{Key, SceneError, Section, key};
use super::skin::{self, Skin};

/// The elastic body.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its shape.
    pub shape: ObjectShape<'static>,
    /// Its skin, when it is a mesh.
    pub skin: Option<Skin>,
    /// Its material.
    pub material: Material,
    /// Surface points at or below this are held \[m\]; `None` takes the shape's default.
    pub fixed_below: Option<f32>,
    /// Body compliances, when the scene gives them.
    pub compliance: Option<Compliance>,
}

/// The rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Its parts, 1 to [`MAX_PARTS`].
    pub parts: Vec<ProbePart<'static>>,
    /// The skin of each part, for those that are meshes.
    pub skins: Vec<Option<Skin>>,
    /// Inertia of a probe that is one mesh \[kg m^2\].
    pub inertia: Option<Inertia>,
    /// True when the file lists the parts itself, so that messages name the part.
    pub compound: bool,
    /// Mass \[kg\].
    pub mass: f32,
}

const SIZE: Key = key("size", "three edge lengths, each 1e-6 to 1e2 m", "[0.1, 0.1, 0.1]");
const SEMI_AXES: Key = key("semi_axes", "three semi-axes, each 1e-6 to 1e2 m", "[0.05, 0.05, 0.05]");
const RADIUS: Key = key("radius", "a number, 1e-6 to 1e2 m", "0.02");
const HEIGHT: Key = key("height", "a number, 1e-6 to 1e2 m", "0.05");
const FIXED_BELOW: Key = key("fixed_below", "a number, 0 to below the object's height, m", "0.0");
const YOUNG_MODULUS: Key = key("young_modulus", "a number, 1e2 to 1e12 Pa", "3.0e6");
const POISSON_RATIO: Key = key("poisson_ratio", "a number, 0 to 0.5", "0.5");
const DENSITY: Key = key("density", "a number, above 0 to 1e5 kg/m^3", "1100.0");
const COMPLIANCE: Key = key("compliance", "a table of normal, drag and twist", "{ normal = 0.0, drag = 0.0, twist = 0.0 }");
const NORMAL: Key = key("normal", "a number, 0 or more, m/N", "0.0");
const DRAG: Key = key("drag", "a number, 0 or more, m/N", "0.0");
const TWIST: Key = key("twist", "a number, 0 or more, rad/(N m)", "0.0");
const MASS: Key = key("mass", "a number, 0 to 1e4 kg", "1.0");
const PART: Key = key("part", "a list of 1 to 16 parts, each [[probe.part]]", "[{ shape = \"sphere\", radius = 0.02 }]");
const POSITION: Key = key("position", "three coordinates within 1e3 m", "[0.0, 0.0, 0.0]");
const ROTATION: Key = key("rotation", "a unit quaternion [qw, qx, qy, qz], within 1e-3", "[1.0, 0.0, 0.0, 0.0]");

const OBJECT_SHAPE: Key = key("shape", "box, ellipsoid, sphere, cylinder, half_space or mesh", "\"box\"");
const PROBE_SHAPE: Key = key("shape", "sphere, box, ellipsoid, capsule, cylinder, cone, compound or mesh", "\"sphere\"");
const PART_SHAPE: Key = key("shape", "sphere, box, ellipsoid, capsule, cylinder, cone or mesh", "\"sphere\"");

/// Density of a body that gives none \[kg/m^3\]: water. The statics of this version do not use it.
const DEFAULT_DENSITY: f32 = 1000.0;

/// Mass of a probe that gives none \[kg\], as in the core's own default.
const DEFAULT_MASS: f32 = 1.0;

#[derive(Clone, Copy)]
enum ObjectKind {
    Box,
    Ellipsoid,
    Sphere,
    Cylinder,
    HalfSpace,
    Mesh,
}

const OBJECT_KINDS: [(&str, ObjectKind); 6] = [
    ("box", ObjectKind::Box),
    ("ellipsoid", ObjectKind::Ellipsoid),
    ("sphere", ObjectKind::Sphere),
    ("cylinder", ObjectKind::Cylinder),
    ("half_space", ObjectKind::HalfSpace),
    ("mesh", ObjectKind::Mesh),
];

#[derive(Clone, Copy)]
enum ProbeKind {
    Sphere,
    Box,
    Ellipsoid,
    Capsule,
    Cylinder,
    Cone,
    Compound,
    Mesh,
}

const PROBE_KINDS: [(&str, ProbeKind); 8] = [
    ("sphere", ProbeKind::Sphere),
    ("box", ProbeKind::Box),
    ("ellipsoid", ProbeKind::Ellipsoid),
    ("capsule", ProbeKind::Capsule),
    ("cylinder", ProbeKind::Cylinder),
    ("cone", ProbeKind::Cone),
    ("compound", ProbeKind::Compound),
    ("mesh", ProbeKind::Mesh),
];

/// Reads `[object]`.
pub fn object(section: &Section<'_, '_>) -> Result<Object, SceneError> {
    let kind = section.word(OBJECT_SHAPE, &OBJECT_KINDS)?;
    let skin = if matches!(kind, ObjectKind::Mesh) { Some(skin::object(section)?) } else { None };
    let shape = match &skin {
        Some(skin) => ObjectShape::Mesh(skin.shape),
        None => object_shape(section, kind)?,
    };
    let half_space = shape == ObjectShape::HalfSpace;
    let object = Object {
        shape,
        skin,
        fixed_below: if half_space { None } else { section.optional_number(FIXED_BELOW)? },
        material: Material {
            young_modulus: section.number(YOUNG_MODULUS)?,
            poisson_ratio: section.number(POISSON_RATIO)?,
            density: section.optional_number(DENSITY)?.unwrap_or(DEFAULT_DENSITY),
        },
        compliance: section.optional_section(COMPLIANCE)?.map(|inner| compliance(&inner)).transpose()?,
    };
    section.finish(&format!("an object of shape {}", name_of(&OBJECT_KINDS, kind)))?;
    Ok(object)
}

fn object_shape(section: &Section<'_, '_>, kind: ObjectKind) -> Result<ObjectShape<'static>, SceneError> {
    Ok(match kind {
        // a mesh has been read by whoever asks
        ObjectKind::HalfSpace | ObjectKind::Mesh => ObjectShape::HalfSpace,
        ObjectKind::Box => ObjectShape::Box { size: vector(section, SIZE)? },
        ObjectKind::Ellipsoid => ObjectShape::Ellipsoid { semi_axes: vector(section, SEMI_AXES)? },
        ObjectKind::Sphere => ObjectShape::Sphere { radius: section.number(RADIUS)? },
        ObjectKind::Cylinder => ObjectShape::Cylinder { radius: section.number(RADIUS)?, height: section.number(HEIGHT)? },
    })
}

fn compliance(section: &Section<'_, '_>) -> Result<Compliance, SceneError> {
    let compliance = Compliance { normal: section.number(NORMAL)?, drag: section.number(DRAG)?, twist: section.number(TWIST)? };
    section.finish("object.compliance")?;
    Ok(compliance)
}

/// Reads `[probe]`.
pub fn probe(section: &Section<'_, '_>) -> Result<Probe, SceneError> {
    let kind = section.word(PROBE_SHAPE, &PROBE_KINDS)?;
    let (parts, per_mass) = match kind {
        ProbeKind::Compound => (parts(section)?, None),
        ProbeKind::Mesh => {
            let (parts, inertia) = skin::probe(section)?;
            (parts.into_iter().map(Made::at_its_place).collect(), Some(inertia))
        }
        _ => (vec![Made { part: ProbePart::at_origin(probe_shape(section, kind)?), skin: None }], None),
    };
    let mass = section.optional_number(MASS)?.unwrap_or(DEFAULT_MASS);
    section.finish(&format!("a probe of shape {}", name_of(&PROBE_KINDS, kind)))?;
    let inertia = per_mass.map(|i| Inertia { moments: i.moments * mass, products: i.products * mass });
    let (parts, skins) = parts.into_iter().map(|made| (made.part, made.skin)).unzip();
    Ok(Probe { parts, skins, inertia, compound: matches!(kind, ProbeKind::Compound), mass })
}

/// A part, with its skin when it is a mesh.
struct Made {
    part: ProbePart<'static>,
    skin: Option<Skin>,
}

impl Made {
    /// A part of a mesh, in the mesh's frame.
    fn at_its_place(part: skin::Part) -> Self {
        let shape = ProbeShape::Mesh(part.skin.shape);
        Self { part: ProbePart { position: part.position, ..ProbePart::at_origin(shape) }, skin: Some(part.skin) }
    }

    /// The same with that frame placed in the probe's.
    fn placed(self, position: Vec3, rotation: Quat) -> Self {
        let part = ProbePart { position: position + rotation * self.part.position, rotation, ..self.part };
        Self { part, ..self }
    }
}

fn probe_shape(section: &Section<'_, '_>, kind: ProbeKind) -> Result<ProbeShape<'static>, SceneError> {
    let radius = || section.number(RADIUS);
    let height = || section.number(HEIGHT);
    Ok(match kind {
        ProbeKind::Sphere => ProbeShape::Sphere { radius: radius()? },
        ProbeKind::Box => ProbeShape::Box { size: vector(section, SIZE)? },
        ProbeKind::Ellipsoid => ProbeShape::Ellipsoid { semi_axes: vector(section, SEMI_AXES)? },
        ProbeKind::Capsule => ProbeShape::Capsule { radius: radius()?, height: height()? },
        ProbeKind::Cylinder => ProbeShape::Cylinder { radius: radius()?, height: height()? },
        ProbeKind::Cone => ProbeShape::Cone { radius: radius()?, height: height()? },
        // meshes have been read by whoever asks
        ProbeKind::Mesh | ProbeKind::Compound => {
            return Err(section.error("shape", "a part is one of the simple shapes; list every part on its own"));
        }
    })
}

fn parts(section: &Section<'_, '_>) -> Result<Vec<Made>, SceneError> {
    let sections = section.sections(PART)?;
    let mut made = Vec::new();
    for inner in &sections {
        made.extend(part(inner)?);
    }
    if !(1..=MAX_PARTS).contains(&made.len()) {
        let what = format!("{} parts, allowed is 1 to {MAX_PARTS}; add or join parts", made.len());
        return Err(section.error("part", &what));
    }
    Ok(made)
}

/// One part of a compound: of a mesh with hollows, its convex parts.
fn part(section: &Section<'_, '_>) -> Result<Vec<Made>, SceneError> {
    let kind = section.word(PART_SHAPE, &PROBE_KINDS)?;
    let made = match kind {
        ProbeKind::Mesh => skin::probe(section)?.0.into_iter().map(Made::at_its_place).collect(),
        _ => vec![Made { part: ProbePart::at_origin(probe_shape(section, kind)?), skin: None }],
    };
    let position = section.optional_numbers(POSITION)?.map_or(Vec3::ZERO, Vec3::from_array);
    let rotation = section.optional_numbers(ROTATION)?.map_or(Quat::IDENTITY, |[w, x, y, z]| Quat::from_xyzw(x, y, z, w));
    section.finish(&format!("a part of shape {}", name_of(&PROBE_KINDS, kind)))?;
    Ok(made.into_iter().map(|made| made.placed(position, rotation)).collect())
}

fn vector(section: &Section<'_, '_>, key: Key) -> Result<Vec3, SceneError> {
    section.numbers(key).map(Vec3::from_array)
}

fn name_of<T: Copy>(kinds: &[(&'static str, T)], kind: T) -> &'static str {
    let same = |other: &T| std::mem::discriminant(other) == std::mem::discriminant(&kind);
    kinds.iter().find(|(_, other)| same(other)).map_or("", |(name, _)| name)
}

//! Bodies given by mesh files: loaded, checked, moved into the frame of the body, baked for the core.
//!
//! A **skin** is the mesh and what was baked from it. An object's skin stands on the middle of its bounds' base; that of a probe or of a part of one has its
//! mass centre at the origin. A probe whose mesh has hollows is cut into convex parts, because the core makes one contact a part; an object's hollows are
//! told, and refused where they are deep. Baked skins live as long as the program, which reads one scene.

use haptor_contact::{Inertia, MAX_PARTS, MeshShape, Vec3};
use haptor_mesh::bake::{about_mass_centre, on_its_base};
use haptor_mesh::convex::{CONVEX, CutSpec, concavity, cut};
use haptor_mesh::{BakeSpec, Baked, DVec3, Mesh, bake, check, load_mesh, properties, weld};

use super::document::{Key, SceneError, Section, key};
use crate::progress;

const FILE: Key = key("file", "the path of an STL, OBJ or PLY file, relative to the scene", "\"part.stl\"");
const SCALE: Key = key("scale", "a number above 0 that takes the file's unit to metres", "0.001");

/// Extents of a body along each axis \[m\]: those of the scene's other shapes.
const EXTENTS: std::ops::RangeInclusive<f64> = 1.0e-6..=1.0e2;

/// Deepest hollow of an object, as a share of its diagonal: one contact a part is wrong by more than that anyway.
const HOLLOW: f64 = 0.05;

/// Steps of the bar while a mesh is baked.
const STEPS: u64 = 100;

/// A body's mesh and what was baked from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// In the body's frame \[m\].
    pub mesh: Mesh,
    /// For the core.
    pub baked: &'static Baked,
    /// The shape that the core takes.
    pub shape: MeshShape<'static>,
}

/// A part of a probe, at its place in the mesh's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its skin.
    pub skin: Skin,
    /// Its mass centre from that of the whole mesh \[m\].
    pub position: Vec3,
}

/// Reads the keys of an object that is a mesh.
///
/// # Errors
/// [`SceneError`] at `file` or `scale`: what is wrong with the mesh.
pub fn object(section: &Section<'_, '_>) -> Result<Skin, SceneError> {
    let mesh = solid(section)?;
    let hollow = concavity(&mesh).unwrap_or(0.0);
    if hollow > HOLLOW {
        let what = format!(
            "has hollows of {:.1} % of its diagonal, allowed is up to {:.0} %: take its convex parts apart or fill them",
            100.0 * hollow,
            100.0 * HOLLOW
        );
        return Err(section.error("file", &what));
    }
    if hollow > CONVEX {
        let percent = 100.0 * hollow;
        section
            .note("file", &format!("has hollows of {percent:.1} % of its diagonal; a part of the probe makes one contact there"));
    }
    let based = on_its_base(&mesh).map(|(mesh, _)| mesh);
    skin(section, based.ok_or_else(|| nothing(section))?)
}

/// Reads the keys of a probe, or of a part of one, that is a mesh; yields its convex parts and its inertia per mass \[m^2\].
///
/// # Errors
/// As [`object`].
pub fn probe(section: &Section<'_, '_>) -> Result<(Vec<Part>, Inertia), SceneError> {
    let whole = solid(section)?;
    let (centred, _) = about_mass_centre(&whole).ok_or_else(|| nothing(section))?;
    let inertia = inertia(&centred).ok_or_else(|| nothing(section))?;
    if concavity(&centred).unwrap_or(0.0) <= CONVEX {
        return Ok((vec![Part { skin: skin(section, centred)?, position: Vec3::ZERO }], inertia));
    }
    let pieces = cut(&centred, &CutSpec { parts: MAX_PARTS, ..CutSpec::default() });
    section.note("file", &format!("has hollows: felt as {} convex parts", pieces.len()));
    let parts: Result<Vec<Part>, SceneError> = pieces.iter().map(|piece| part(section, piece)).collect();
    Ok((parts?, inertia))
}

fn part(section: &Section<'_, '_>, piece: &Mesh) -> Result<Part, SceneError> {
    let (mesh, centre) = about_mass_centre(piece).ok_or_else(|| nothing(section))?;
    Ok(Part { skin: skin(section, mesh)?, position: centre.as_vec3() })
}

/// The mesh of `file`, welded, checked to be the skin of one solid of a size that can be felt.
fn solid(section: &Section<'_, '_>) -> Result<Mesh, SceneError> {
    let path = section.beside(section.text(FILE)?);
    let scale = section.optional_number(SCALE)?.unwrap_or(1.0);
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(section.error("scale", &format!("allowed is {}; correct the value", SCALE.allowed)));
    }
    let loaded = load_mesh(&path, f64::from(scale));
    let mesh = weld(&loaded.map_err(|error| section.error("file", &error.to_string()))?, None);
    let problems = check(&mesh).problems();
    if !problems.is_empty() {
        let what =
            format!("is not the skin of a solid: {}; mend the mesh, `haptor mesh check` tells when it is", problems.join("; "));
        return Err(section.error("file", &what));
    }
    check_size(section, &mesh)?;
    Ok(mesh)
}

fn check_size(section: &Section<'_, '_>, mesh: &Mesh) -> Result<(), SceneError> {
    let (low, high) = mesh.bounds().ok_or_else(|| nothing(section))?;
    let DVec3 { x, y, z } = high - low;
    if [x, y, z].iter().all(|extent| EXTENTS.contains(extent)) {
        return Ok(());
    }
    let what =
        format!("is {x:.3e} x {y:.3e} x {z:.3e} m, allowed is 1e-6 to 1e2 m on every axis; give the scale of the file's unit");
    Err(section.error("file", &what))
}

fn skin(section: &Section<'_, '_>, mesh: Mesh) -> Result<Skin, SceneError> {
    let bar = progress::bar(STEPS, "baking a mesh");
    let baked = bake(&mesh, &BakeSpec::default(), &mut |share| bar.set_position((share * STEPS as f64) as u64));
    bar.finish_and_clear();
    let refused = |what: String| section.error("file", &format!("cannot be baked: {what}"));
    let baked: &'static Baked = Box::leak(Box::new(baked.map_err(|error| refused(error.to_string()))?));
    let shape = baked.shape().map_err(|invalid| refused(invalid.to_string()))?;
    Ok(Skin { mesh, baked, shape })
}

/// Inertia of a solid about its mass centre, per mass \[m^2\].
fn inertia(mesh: &Mesh) -> Option<Inertia> {
    let solid = properties(mesh)?;
    let tensor = solid.inertia * (1.0 / solid.volume);
    let [x, y, z] = [tensor.x_axis, tensor.y_axis, tensor.z_axis];
    Some(Inertia { moments: DVec3::new(x.x, y.y, z.z).as_vec3(), products: DVec3::new(x.y, x.z, y.z).as_vec3() })
}

fn nothing(section: &Section<'_, '_>) -> SceneError {
    section.error("file", "encloses no volume; give the mesh of a solid")
}

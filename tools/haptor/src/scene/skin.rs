//! Bodies given by mesh files: read, checked, moved into the frame of the body and baked by [`haptor_mesh::body`], or found in the cache folder.
//!
//! A **skin** is a part's mesh and what was baked from it. An object's skin stands on the middle of its bounds' base; that of a probe or of a part of one has
//! its mass centre at the origin. A probe whose mesh has hollows is cut into convex parts, because the core makes one contact a part; an object's hollows are
//! told, and refused where they are deeper than the scene allows. Skins live as long as the program, which reads one scene.

use haptor_contact::{Inertia, MeshShape, Vec3};
use haptor_mesh::body::{self, Body, Recipe, Role};
use haptor_mesh::kept::{Fetched, Keep};
use haptor_mesh::load::{extension, read_bytes};
use haptor_mesh::{BakeSpec, Baked, DMat3, DVec3, Mesh};

use super::document::{Key, SceneError, Section, key};
use crate::progress;

const FILE: Key = key("file", "the path of an STL, OBJ or PLY file, relative to the scene", "\"part.stl\"");
const SCALE: Key = key("scale", "a number above 0 that takes the file's unit to metres", "0.001");
const REPAIR: Key = key("repair", "true or false; true mends equal corners, flipped faces and small holes", "true");
const MAX_HOLLOW: Key = key("max_hollow", "a number, 0 to 1: depth of the deepest hollow over the diagonal", "0.05");

/// Deepest hollow of an object where the scene gives none, as a share of its diagonal: one contact a part is wrong by more than that anyway.
const HOLLOW: f32 = 0.05;

/// Steps of the bar while a mesh is baked.
const STEPS: u64 = 100;

/// A part's mesh and what was baked from it.
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
/// [`SceneError`] at `file`, `scale` or `max_hollow`: what is wrong with the mesh.
pub fn object(section: &Section<'_, '_>) -> Result<Skin, SceneError> {
    let body = read(section, Role::Object)?;
    let most = section.optional_number(MAX_HOLLOW)?.unwrap_or(HOLLOW);
    if !(0.0..=1.0).contains(&most) {
        return Err(section.error("max_hollow", &format!("allowed is {}; correct the value", MAX_HOLLOW.allowed)));
    }
    let hollow = body.hollow;
    let found = format!("has hollows of {:.1} % of its diagonal ({:.2e} m deep)", 100.0 * hollow.share, hollow.depth);
    if hollow.share > f64::from(most) {
        let what = format!(
            "{found}, allowed is up to {:.0} %: take its convex parts apart, fill them, or raise object.max_hollow",
            100.0 * most
        );
        return Err(section.error("file", &what));
    }
    if !hollow.is_convex() {
        section.note("file", &format!("{found}; a part of the probe makes one contact there"));
    }
    match body.parts.into_iter().next() {
        Some(part) => Ok(of_part(section, part)?.skin),
        None => Err(section.error("file", "encloses no volume; give the mesh of a solid")),
    }
}

/// Reads the keys of a probe, or of a part of one, that is a mesh; yields its convex parts and its inertia per mass \[m^2\].
///
/// # Errors
/// As [`object`].
pub fn probe(section: &Section<'_, '_>) -> Result<(Vec<Part>, Inertia), SceneError> {
    let body = read(section, Role::Probe)?;
    if !body.hollow.is_convex() {
        section.note("file", &format!("has hollows: felt as {} convex parts", body.parts.len()));
    }
    let inertia = inertia(&body.inertia);
    let parts: Result<Vec<Part>, SceneError> = body.parts.into_iter().map(|part| of_part(section, part)).collect();
    Ok((parts?, inertia))
}

/// The body of `file`.
fn read(section: &Section<'_, '_>, role: Role) -> Result<Body, SceneError> {
    let path = section.beside(section.text(FILE)?);
    let scale = section.optional_number(SCALE)?.unwrap_or(1.0);
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(section.error("scale", &format!("allowed is {}; correct the value", SCALE.allowed)));
    }
    let mend = section.optional_flag(REPAIR)?.unwrap_or(false);
    let refused = |error: &dyn std::fmt::Display| section.error("file", &error.to_string());
    let recipe = Recipe { scale: f64::from(scale), role, mend, bake: BakeSpec::default() };
    let bytes = read_bytes(&path).map_err(|error| refused(&error))?;
    let body = fetch_body(bytes, extension(&path).as_deref(), &recipe).map_err(|error| refused(&error))?.result;
    if let Some(hint) = body::unit_hint(body.size, f64::from(scale)) {
        section.note("file", &hint);
    }
    if !body.mended.is_empty() {
        section.note("file", &format!("was mended: {}", body.mended.join(", ")));
    }
    Ok(body)
}

/// The body of a mesh file's bytes, from the cache folder where it is there. A bar on standard error shows what is baked; what the cache folder
/// refuses is said there and does no harm.
///
/// # Errors
/// [`body::BodyError`] says what is wrong with the mesh.
pub fn fetch_body(bytes: Vec<u8>, extension: Option<&str>, recipe: &Recipe) -> Result<Fetched<Body>, body::BodyError> {
    let bar = progress::bar(STEPS, "baking a mesh");
    let mut share = |share: f64| bar.set_position((share * STEPS as f64) as u64);
    let fetched = body::fetch(bytes, extension, recipe, Body::KIND.folder().as_deref(), &mut share);
    bar.finish_and_clear();
    let fetched = fetched?;
    if let Some(trouble) = &fetched.trouble {
        eprintln!("haptor: the mesh was baked, but the cache is of no use: {trouble}");
    }
    Ok(fetched)
}

fn of_part(section: &Section<'_, '_>, part: body::Part) -> Result<Part, SceneError> {
    let baked: &'static Baked = Box::leak(Box::new(part.baked));
    let shape = baked.shape().map_err(|invalid| section.error("file", &format!("cannot be baked: {invalid}")))?;
    Ok(Part { skin: Skin { mesh: part.mesh, baked, shape }, position: part.position.as_vec3() })
}

/// Inertia of a solid about its mass centre, per mass \[m^2\].
fn inertia(tensor: &DMat3) -> Inertia {
    let [x, y, z] = [tensor.x_axis, tensor.y_axis, tensor.z_axis];
    Inertia { moments: DVec3::new(x.x, y.y, z.z).as_vec3(), products: DVec3::new(x.y, x.z, y.z).as_vec3() }
}

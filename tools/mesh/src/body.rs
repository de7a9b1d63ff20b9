//! From the bytes of a mesh file to the body that a scene needs, kept by digest so that the second time costs a fraction.
//!
//! Corners join, faults are mended where that is asked for, the mesh is checked to be the skin of one solid of a size that can be felt, reduced to the
//! triangles that are of use ([`CAPACITY`]) and moved into
//! the body's frame; hollows are measured; a probe with hollows is cut into convex parts, because the core makes one contact a part; each part is baked.
//! What comes out depends on the file's bytes, the [`Recipe`] and [`METHOD`] alone: that is its key among the kept results.

use std::path::Path;

use glam::{DMat3, DVec3};
use haptor_contact::MAX_PARTS;
use sha2::{Digest, Sha256};

use crate::bake::{about_mass_centre, on_its_base};
use crate::convex::{CutSpec, Hollow, cut, hollow};
use crate::deviation::deviation;
use crate::kept::{self, Fetched, Key};
use crate::load::{LoadError, format_of, read_mesh};
use crate::reduce::{CAPACITY, reduce};
use crate::repair::{MendSpec, mend};
use crate::{BakeError, BakeSpec, Baked, Mesh, bake, check, properties, weld};

mod contents;

/// Version of the method: bodies of another version are made anew.
pub const METHOD: u32 = 1;

/// Extents of a body along each axis \[m\]: those of the scene's other shapes.
pub const EXTENTS: std::ops::RangeInclusive<f64> = 1.0e-6..=1.0e2;

/// What the body is in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The elastic one: stands on the middle of its bounds' base.
    Object,
    /// The rigid one: its mass centre is the origin; hollows are cut into convex parts.
    Probe,
}

/// How a file becomes a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Takes the file's unit to metres.
    pub scale: f64,
    /// What it is in the scene.
    pub role: Role,
    /// Mend what is usually wrong before it is checked ([`crate::repair`]).
    pub mend: bool,
    /// How fine it is baked.
    pub bake: BakeSpec,
}

/// A body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its parts: one, or the convex parts of a probe with hollows.
    pub parts: Vec<Part>,
    /// Inertia of the whole about its mass centre, per mass \[m^2\].
    pub inertia: DMat3,
    /// Extents of the whole \[m\].
    pub size: DVec3,
    /// How far it is from convex.
    pub hollow: Hollow,
    /// What was mended or reduced, one line for each thing; empty where nothing was.
    pub mended: Vec<String>,
}

/// A part of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// In the part's frame \[m\].
    pub mesh: Mesh,
    /// What the core reads.
    pub baked: Baked,
    /// Origin of the part's frame in the body's \[m\].
    pub position: DVec3,
}

/// Why a file makes no body.
#[derive(Debug, thiserror::Error)]
pub enum BodyError {
    /// It is no mesh.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// It is not the skin of a solid.
    #[error("is not the skin of a solid: {}; {}", problems.join("; "),
        if *mended { "more than can be mended here" } else { "mend the mesh: `haptor mesh repair`, or repair = true in a scene" })]
    NotSolid {
        /// What is wrong with it.
        problems: Vec<String>,
        /// It has been mended as far as can be.
        mended: bool,
    },
    /// Too small or too large.
    #[error("is {:.3e} x {:.3e} x {:.3e} m, allowed is 1e-6 to 1e2 m on every axis; give the scale of the file's unit", .0.x, .0.y, .0.z)]
    Size(DVec3),
    /// It has no inside.
    #[error("encloses no volume; give the mesh of a solid")]
    NoVolume,
    /// It cannot be baked.
    #[error("cannot be baked: {0}")]
    Bake(#[from] BakeError),
}

/// The body of a file's bytes from `folder`, made and kept there if it is missing or damaged; `None` keeps nothing. `extension` is the end of
/// the file's name, in small letters; `progress` is told the share done, 0 to 1.
///
/// # Errors
/// [`BodyError`] says what is wrong with the mesh.
pub fn fetch(
    bytes: Vec<u8>,
    extension: Option<&str>,
    recipe: &Recipe,
    folder: Option<&Path>,
    progress: &mut dyn FnMut(f64),
) -> Result<Fetched<Body>, BodyError> {
    kept::fetch(&key(&bytes, extension, recipe), folder, || make(&read_mesh(bytes, extension, recipe.scale)?, recipe, progress))
}

/// Digest of everything a body depends on.
pub fn key(bytes: &[u8], extension: Option<&str>, recipe: &Recipe) -> Key {
    let Recipe { scale, role, mend, bake: BakeSpec { cells, samples } } = *recipe;
    let format = format_of(bytes, extension).map_or(u32::MAX, |format| format as u32);
    let mut digest = Sha256::new();
    for number in [METHOD, format, u32::from(role == Role::Probe), u32::from(mend), cells as u32, samples as u32] {
        digest.update(number.to_le_bytes());
    }
    digest.update(scale.to_le_bytes());
    digest.update(bytes);
    Key(digest.finalize().into())
}

/// Makes the body of a mesh.
///
/// # Errors
/// As [`fetch`].
pub fn make(loaded: &Mesh, recipe: &Recipe, progress: &mut dyn FnMut(f64)) -> Result<Body, BodyError> {
    let (mesh, mut mended) = solid(loaded, recipe.mend)?;
    let mesh = within_capacity(mesh, &mut mended);
    let framed = match recipe.role {
        Role::Object => on_its_base(&mesh),
        Role::Probe => about_mass_centre(&mesh),
    };
    let (mesh, _) = framed.ok_or(BodyError::NoVolume)?;
    let size = extents(&mesh).ok_or(BodyError::NoVolume)?;
    let whole = properties(&mesh).ok_or(BodyError::NoVolume)?;
    let hollow = hollow(&mesh).unwrap_or_default();
    let pieces = if recipe.role == Role::Object || hollow.is_convex() { vec![(mesh, DVec3::ZERO)] } else { convex_parts(&mesh)? };
    let count = pieces.len() as f64;
    let mut parts = Vec::new();
    for (index, (mesh, position)) in pieces.into_iter().enumerate() {
        let baked = bake(&mesh, &recipe.bake, &mut |share| progress((index as f64 + share) / count))?;
        parts.push(Part { mesh, baked, position });
    }
    Ok(Body { parts, inertia: whole.inertia * (1.0 / whole.volume), size, hollow, mended })
}

/// The skin of one solid of a size that can be felt, and what was mended.
fn solid(loaded: &Mesh, with_mending: bool) -> Result<(Mesh, Vec<String>), BodyError> {
    let (mesh, findings, mended) = if with_mending {
        let (mesh, mended) = mend(loaded, &MendSpec::default());
        (mesh, mended.left, if mended.is_untouched() { Vec::new() } else { mended.done() })
    } else {
        let mesh = weld(loaded, None);
        let findings = check(&mesh);
        (mesh, findings, Vec::new())
    };
    if !findings.is_solid() {
        return Err(BodyError::NotSolid { problems: findings.problems(), mended: with_mending });
    }
    let size = extents(&mesh).ok_or(BodyError::NoVolume)?;
    if !size.to_array().iter().all(|extent| EXTENTS.contains(extent)) {
        return Err(BodyError::Size(size));
    }
    Ok((mesh, mended))
}

/// The mesh with no more triangles than are of use; says in `changes` what that cost.
fn within_capacity(mesh: Mesh, changes: &mut Vec<String>) -> Mesh {
    if mesh.triangles.len() <= CAPACITY {
        return mesh;
    }
    let few = reduce(&mesh, CAPACITY, &mut |_| {});
    // a mesh that could not bear it stays as it is
    if !check(&few).is_solid() {
        return mesh;
    }
    let off = deviation(&mesh, &few).unwrap_or_default();
    let (before, after, max, rms) = (mesh.triangles.len(), few.triangles.len(), off.max, off.rms);
    changes
        .push(format!("reduced from {before} to {after} triangles, off by {max:.1e} m at most, {rms:.1e} m in the mean square"));
    few
}

fn extents(mesh: &Mesh) -> Option<DVec3> {
    mesh.bounds().map(|(low, high)| high - low)
}

/// Largest and smallest extent of what a hand presses or holds \[m\]: a mesh beyond them is probably in another unit.
const HELD: std::ops::RangeInclusive<f64> = 1.0e-3..=2.0;

/// What to try when a mesh of these extents \[m\], read with `scale`, is probably in another unit.
pub fn unit_hint(size: DVec3, scale: f64) -> Option<String> {
    let largest = size.max_element();
    if HELD.contains(&largest) {
        return None;
    }
    let in_millimetres = largest / scale * 1.0e-3;
    Some(if HELD.contains(&in_millimetres) {
        format!("is {largest:.3} m across: if the file is in millimetres, scale 0.001 makes it {in_millimetres:.3} m")
    } else {
        format!("is {largest:.1e} m across, beyond what a hand holds: check its unit and scale")
    })
}

/// The convex parts of a mesh, each about its mass centre, and where that is.
fn convex_parts(mesh: &Mesh) -> Result<Vec<(Mesh, DVec3)>, BodyError> {
    let pieces = cut(mesh, &CutSpec { parts: MAX_PARTS, ..CutSpec::default() });
    if pieces.is_empty() {
        return Err(BodyError::NoVolume);
    }
    pieces.iter().map(|piece| about_mass_centre(piece).ok_or(BodyError::NoVolume)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kept::Keep;
    use crate::{convex, tessellate, write_stl};

    const RECIPE: Recipe = Recipe { scale: 0.01, role: Role::Probe, mend: false, bake: BakeSpec { cells: 12, samples: 32 } };

    fn file(mesh: &Mesh) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_stl(mesh, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_body_comes_back_from_its_folder_to_the_bit_and_damage_makes_it_anew() {
        let folder = tempfile::tempdir().unwrap();
        let bytes = file(&convex::ell());
        let fetch = |recipe: &Recipe| fetch(bytes.clone(), Some("stl"), recipe, Some(folder.path()), &mut |_| {}).unwrap();
        let first = fetch(&RECIPE);
        assert!(first.computed && first.trouble.is_none() && first.result.parts.len() > 1, "{:?}", first.trouble);
        assert_eq!(first.result.hollow.share > 0.1, first.result.parts.len() > 1);
        let second = fetch(&RECIPE);
        assert!(!second.computed && second.result == first.result);
        let object = Recipe { role: Role::Object, ..RECIPE };
        assert!(fetch(&object).computed && !fetch(&object).computed);
        let path = Body::KIND.path(folder.path(), &key(&bytes, None, &RECIPE));
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let third = fetch(&RECIPE);
        assert!(third.computed && third.trouble.is_some() && third.result == first.result);
    }

    #[test]
    fn contents_of_another_shape_are_refused_not_trusted() {
        let body = make(&tessellate::cuboid(DVec3::ONE), &Recipe { scale: 1.0, ..RECIPE }, &mut |_| {}).unwrap();
        let contents = body.to_contents();
        assert_eq!(Body::from_contents(&contents).unwrap(), body);
        for at in 0..contents.len().min(2000) {
            assert!(Body::from_contents(&contents[..at]).is_err(), "{at}");
            let mut damaged = contents.clone();
            damaged[at] = 0xff;
            // whatever it says, it ends, and what is read can be asked for its shape
            if let Ok(body) = Body::from_contents(&damaged) {
                body.parts.iter().for_each(|part| drop(part.baked.shape()));
            }
        }
    }

    #[test]
    fn a_mesh_beyond_the_capacity_is_reduced_and_says_so() {
        let fine = tessellate::ellipsoid(DVec3::ONE, 160);
        assert!(fine.triangles.len() > CAPACITY);
        let body = make(&fine, &RECIPE, &mut |_| {}).unwrap();
        assert!(body.parts[0].mesh.triangles.len() <= CAPACITY, "{}", body.parts[0].mesh.triangles.len());
        assert!(body.mended[0].starts_with("reduced from 25280 to "), "{:?}", body.mended);
    }

    #[test]
    fn a_size_of_another_unit_is_noticed() {
        let hint = |largest: f64, scale: f64| unit_hint(DVec3::new(largest, 0.0, 0.0), scale).unwrap_or_default();
        assert!(hint(60.0, 1.0).contains("scale 0.001 makes it 0.060 m"), "{}", hint(60.0, 1.0));
        assert!(hint(1.0e-4, 0.001).contains("check its unit") && hint(0.3, 1.0).is_empty(), "{}", hint(1.0e-4, 0.001));
    }

    #[test]
    fn keys_tell_files_and_recipes_apart() {
        let bytes = file(&tessellate::cuboid(DVec3::ONE));
        let mut other = bytes.clone();
        other[90] ^= 1;
        let recipes = [
            Recipe { scale: 0.02, ..RECIPE },
            Recipe { role: Role::Object, ..RECIPE },
            Recipe { mend: true, ..RECIPE },
            Recipe { bake: BakeSpec { cells: 13, samples: 32 }, ..RECIPE },
            Recipe { bake: BakeSpec { cells: 12, samples: 33 }, ..RECIPE },
        ];
        let first = key(&bytes, None, &RECIPE);
        assert!(recipes.iter().all(|recipe| key(&bytes, None, recipe) != first) && key(&other, None, &RECIPE) != first);
        assert_eq!(key(&bytes, Some("obj"), &RECIPE), first);
    }

    #[test]
    fn a_broken_skin_is_refused_unless_it_is_to_be_mended() {
        let mut open = tessellate::ellipsoid(DVec3::ONE, 24);
        open.triangles.remove(50);
        let refused = make(&open, &RECIPE, &mut |_| {}).unwrap_err().to_string();
        assert!(refused.contains("3 boundary edges") && refused.contains("repair"), "{refused}");
        let mended = make(&open, &Recipe { mend: true, ..RECIPE }, &mut |_| {}).unwrap();
        assert_eq!(mended.mended, ["1 holes closed", "1 triangles added in them"]);
    }
}

//! Stage 5: displacement of the object's surface, where a region or a reader asks for it.
//!
//! Closed forms of a half space loaded on a disc (PHYSICS section 4; theory.md, section 4).

use glam::Vec3;

use crate::math::{PI, asin, root};
use crate::model::Model;
use crate::patch::Patch;

/// Displacement into the object \[m\] that `patch` makes at the surface point `p_wq`: the dent of a paraboloid with the same load
/// and radius. Inside the radius the surface follows the probe.
pub fn dent(model: &Model<'_>, patch: &Patch, p_wq: Vec3) -> f32 {
    let (a, load) = (patch.footprint.radius, patch.footprint.load);
    if a <= 0.0 || load <= 0.0 {
        return 0.0;
    }
    let offset = p_wq - patch.centre;
    let along = offset.dot(patch.normal);
    let r2 = offset.length_squared() - along * along;
    // 1/R of the paraboloid with this load and radius: a^3 / R = 3 P / (4 E*)
    let curvature = 0.75 * load / (model.material.contact_modulus() * a * a * a);
    let a2 = a * a;
    if r2 <= a2 {
        return curvature * (a2 - 0.5 * r2);
    }
    let r = root(r2);
    curvature / PI * ((2.0 * a2 - r2) * asin(a / r) + a * root(r2 - a2))
}

/// Displacement of the body beyond the half space's at the patch, by the grips of all patches \[m\]: shear and bending are shared, so
/// each patch rides on what the others carry.
pub fn body_drag(patches: &[Patch], i: usize) -> Vec3 {
    let here = &patches[i];
    let others = patches.iter().enumerate().filter(|(j, _)| *j != i);
    others.fold(Vec3::ZERO, |sum, (_, other)| sum + other.to_world(other.grip.force)) * here.body.drag
}

/// Displacement `u_w` of the surface at the centre of the patch \[m\], world: pressed in by its own depth, dragged along by what sticks.
pub fn at_centre(patch: &Patch) -> Vec3 {
    let drag = patch.to_world(patch.local.drag) * patch.grip.stick;
    drag - patch.normal * patch.depth
}

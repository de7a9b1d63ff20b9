//! Tier `paper`: equations (10) to (13) of Luo and Xiao, the rotation of surface points by twisting.
//!
//! Faithful, and **not predictive**: the rotation falls as 1/r where the half space's falls as 1/r^3. Readings: (10) as printed has
//! the dimension of a volume and is read as T l/(G J); the second row of (13) as printed does not depend on r and is read like the first.

use glam::Vec3;

use crate::math::{PI, direction, min, root};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;
use crate::stage::wrench::patch_force;
use crate::surface::block::{BLOCK, Block, inverse_root, more};
use crate::surface::section::Section;
use crate::tier::paper::{SHORTEST_LENGTH, stick_radius};

/// Equation (10): rotation of a point whose way to the fixed point along the axis is `l_w` \[m\], by a torque \[N m\] about an axis that
/// misses the region; `polar` is the polar second moment of the object's section \[m^4\].
pub fn rotation_by_torque(torque: f32, l_w: f32, shear_modulus: f32, polar: f32) -> f32 {
    torque * l_w / (shear_modulus * polar)
}

/// Equation (11), and the second row of (12): rotation of a contact point at distance `r` from the axis while the probe turns by `phi`.
pub fn rotation_in_contact(r: f32, phi: f32, r_m: f32, kinetic: f32, l_q: f32, shear_modulus: f32, ds: f32) -> f32 {
    if r <= r_m { phi } else { kinetic * l_q / (r * shear_modulus * ds) }
}

/// Equation (12), first row: rotation of a contact point inside r_md while the probe slides, from the shear stress of equation (2). It
/// returns the probe's own turn.
pub fn rotation_by_stress(stress: f32, l_q: f32, r: f32, shear_modulus: f32) -> f32 {
    stress * l_q / (r * shear_modulus)
}

/// Equation (13): rotation of a point outside the contact, at distance `r` from the axis, when points at `r_m` turn by `phi_m`.
pub fn rotation_outside(r: f32, r_m: f32, phi_m: f32) -> f32 {
    r_m * phi_m / r
}

/// The twist of one patch as the paper has it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Twist {
    /// Nothing turned, or nothing to turn about.
    None,
    /// The axis misses the region: equation (10), rotation per length \[rad/m\].
    Body { axis: Vec3, through: Vec3, per_length: f32 },
    /// The axis goes through the region: equations (11) to (13).
    Contact { axis: Vec3, centre: Vec3, radius: f32, phi: f32, r_m: f32, kinetic: f32, l: f32, shear_modulus: f32, ds: f32 },
}

impl Twist {
    /// The twist of `patch` under a probe with its mass centre at `p_wp`.
    pub fn new(model: &Model<'_>, params: &Params, patch: &Patch, p_wp: Vec3) -> Self {
        let phi = root(patch.paper.turned.length_squared());
        if phi <= 0.0 || patch.footprint.radius <= 0.0 {
            return Self::None;
        }
        let axis = direction(patch.paper.turned, patch.normal);
        let shear_modulus = model.material.shear_modulus();
        if patch.paper.torque == Vec3::ZERO {
            let Some(section) = Section::of(&model.object) else { return Self::None };
            let torque = -axis.dot((patch.centre - p_wp).cross(patch_force(patch)));
            return Self::Body {
                axis,
                through: p_wp,
                per_length: rotation_by_torque(torque, 1.0, shear_modulus, section.polar()),
            };
        }
        Self::in_contact(model, params, patch, axis, phi)
    }

    fn in_contact(model: &Model<'_>, params: &Params, patch: &Patch, axis: Vec3, phi: f32) -> Self {
        let radius = patch.footprint.radius;
        let shear_modulus = model.material.shear_modulus();
        let l = match Section::of(&model.object) {
            None => model.paper_length,
            Some(_) => patch.centre.dot(axis).abs(),
        };
        let l = crate::math::max(l, SHORTEST_LENGTH * radius);
        let n = params.samples as f32;
        let ds = PI * radius * radius / n;
        let kinetic = params.mu_d * patch.footprint.load / n;
        let limit = if patch.paper.sliding { kinetic } else { params.mu_s * patch.footprint.load / n };
        let r_m = min(stick_radius(limit, shear_modulus, phi / l, ds), radius);
        Self::Contact { axis, centre: patch.at_rest(), radius, phi, r_m, kinetic, l, shear_modulus, ds }
    }

    /// Adds the displacements of the points of a block over the fixed height `base`; they fade with the share of the way from the base up to the
    /// patch, `height` above it.
    pub fn add(&self, base: f32, height: f32, block: &mut Block) {
        match *self {
            Self::None => {}
            Self::Body { axis, through, per_length } => {
                turn_about(axis, through, block, |z, _, _| per_length * more(z - base, 0.0));
            }
            Self::Contact { axis, centre, radius, phi, r_m, kinetic, l, shear_modulus, ds } => {
                // at_r: beyond the stick radius all rows of (11) to (13) fall as 1/r
                let sliding = rotation_in_contact(1.0, phi, 0.0, kinetic, l, shear_modulus, ds);
                let outside = rotation_outside(1.0, r_m, phi);
                let per_height = 1.0 / height;
                turn_about(axis, centre, block, |z, r, per_r| {
                    let above = z - base;
                    let share = if above < height { above * per_height } else { 1.0 };
                    let falling = (if r <= radius { sliding } else { outside }) * per_r;
                    (if r <= r_m { phi } else { falling }) * share
                });
            }
        }
    }
}

/// Turns the block's points about the line along `axis` by what `turn` says of their height, their distance from the line and one over it.
#[inline(always)]
fn turn_about(axis: Vec3, through: Vec3, block: &mut Block, turn: impl Fn(f32, f32, f32) -> f32) {
    for i in 0..BLOCK {
        let (x, y, z) = (block.x[i] - through.x, block.y[i] - through.y, block.z[i] - through.z);
        let around = [axis.y * z - axis.z * y, axis.z * x - axis.x * z, axis.x * y - axis.y * x];
        let r2 = around[0] * around[0] + around[1] * around[1] + around[2] * around[2];
        let per_r = inverse_root(more(r2, f32::MIN_POSITIVE));
        let turn = turn(block.z[i], r2 * per_r, per_r);
        block.ux[i] += around[0] * turn;
        block.uy[i] += around[1] * turn;
        block.uz[i] += around[2] * turn;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tier::paper::shear_stress;

    #[test]
    fn the_equations_one_by_one() {
        assert_eq!(rotation_by_torque(2.0, 0.1, 1.0e6, 1.0e-6), 0.2);
        assert_eq!(rotation_in_contact(0.001, 0.3, 0.002, 1.0e-3, 0.1, 1.0e6, 1.0e-6), 0.3);
        assert!((rotation_in_contact(0.004, 0.3, 0.002, 1.0e-3, 0.1, 1.0e6, 1.0e-6) - 0.025).abs() < 1.0e-6);
        assert!((rotation_by_stress(shear_stress(0.002, 1.0e6, 0.3 / 0.1), 0.1, 0.002, 1.0e6) - 0.3).abs() < 1.0e-6);
        assert!((rotation_outside(0.01, 0.005, 0.2) - 0.1).abs() < 1.0e-6);
    }

    #[test]
    fn contact_and_outside_meet_where_static_and_dynamic_friction_agree() {
        let (g, ds, l, phi, kinetic) = (1.0e6_f32, 1.0e-6, 0.1, 3.0_f32, 0.03);
        let r_m = stick_radius(kinetic, g, phi / l, ds);
        let inside = rotation_in_contact(0.005, phi, r_m, kinetic, l, g, ds);
        assert!((inside / rotation_outside(0.005, r_m, phi) - 1.0).abs() < 1.0e-5);
    }
}

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
use crate::surface::beam::Section;
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
            let polar = section.bending.x + section.bending.y;
            return Self::Body { axis, through: p_wp, per_length: rotation_by_torque(torque, 1.0, shear_modulus, polar) };
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

    /// Displacement of the surface point `p_w`, `share` of the way from the base to the patch.
    pub fn displacement(&self, p_w: Vec3, above_base: f32, share: f32) -> Vec3 {
        match *self {
            Self::None => Vec3::ZERO,
            Self::Body { axis, through, per_length } => axis.cross(p_w - through) * (per_length * above_base),
            Self::Contact { axis, centre, radius, phi, r_m, kinetic, l, shear_modulus, ds } => {
                let around = axis.cross(p_w - centre);
                let r = root(around.length_squared());
                let turn = if r <= radius {
                    rotation_in_contact(r, phi, r_m, kinetic, l, shear_modulus, ds)
                } else {
                    let phi_m = rotation_in_contact(r_m, phi, r_m, kinetic, l, shear_modulus, ds);
                    rotation_outside(r, r_m, phi_m)
                };
                around * (turn * share)
            }
        }
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

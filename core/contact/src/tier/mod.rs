//! The tiers: what a patch holds against when it is dragged and twisted. All share [`Hold`].

pub mod bristle;
pub mod influence;
pub mod paper;
pub mod point;

use crate::footprint::Footprint;
use crate::limits::LEAST_FRICTION;
use crate::math::{cbrt, clamp, max, min, pow, root};
use crate::model::{Compliance, Model};
use crate::params::Params;
use crate::patch::{Patch, Shift};
use crate::profile::Profile;

/// What the tangential tiers need to know about a patch in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Hold {
    /// Contact radius a \[m\]: of equal area where the patch is long.
    pub radius: f32,
    /// Radius that the arms of a twist count by \[m\]: a, and more where the patch is long.
    pub arm: f32,
    /// Normal load P \[N\]; none where friction has too few digits to be followed ([`LEAST_FRICTION`]).
    pub load: f32,
    /// Pressure profile.
    pub profile: Profile,
    /// Full-stick drag stiffness K_t = 8 G a / (2 - nu) \[N/m\] (Mindlin).
    pub drag_stiffness: f32,
    /// Full-stick twist stiffness K_theta = 16/3 G a^3 (1 - 0.735 a/R_e) \[N m/rad\] (Reissner and Sagoci; convex body), more where the patch is long.
    pub twist_stiffness: f32,
    /// Static friction.
    pub mu_s: f32,
    /// Dynamic friction.
    pub mu_d: f32,
    /// The friction falls at once when a sample leaves stick.
    pub sharp: bool,
    /// Compliance of the body in series.
    pub body: Compliance,
    /// Shift that contact and body must take up in this tick.
    pub wanted: Shift,
}

/// Loss of twist stiffness on a convex body of radius R_e: K = K_half_space (1 - 0.735 a/R_e), good to 0.2 % up to a/R_e = 0.3.
const CONVEX_LOSS: f32 = 0.735;

/// Largest a/R_e the loss is applied to: beyond 0.9 the fitted line would go through zero.
const LARGEST_RATIO: f32 = 0.9;

impl Hold {
    /// Collects the figures of `patch`; the `ground` under it has moved so far, and `lever` is what the patch's arm adds to its drag compliance \[m/N\].
    pub fn new(model: &Model<'_>, params: &Params, patch: &Patch, ground: Shift, lever: f32) -> Self {
        let g = model.material.shear_modulus();
        let a = patch.footprint.radius;
        let convex = 1.0 - CONVEX_LOSS * min(a / patch.object_radius, LARGEST_RATIO);
        let longer = longer(patch.footprint.aspect);
        Self {
            radius: a,
            arm: a * longer,
            load: if is_followed(params, patch) { patch.footprint.load } else { 0.0 },
            profile: Profile::new(patch.footprint.fullness),
            drag_stiffness: 8.0 * g * a / (2.0 - model.material.poisson_ratio),
            twist_stiffness: 16.0 / 3.0 * g * a * a * a * stiffer(longer, model.material.poisson_ratio) * max(convex, 0.0),
            mu_s: params.mu_s,
            mu_d: params.mu_d,
            sharp: params.breakaway == crate::params::Breakaway::Sharp,
            body: Compliance { drag: patch.body.drag + lever, ..patch.body },
            wanted: patch.motion.step - (ground - patch.ground) + patch.pending,
        }
    }
}

impl Footprint {
    /// Radius that the arms of a twist count by \[m\]: the torque of full slip is mu P times it times the profile's share. More than `radius` where the patch
    /// is long (equation 5.5).
    pub fn arm(&self) -> f32 {
        self.radius * longer(self.aspect)
    }
}

/// Torque of full slip of an ellipse `aspect` times longer than wide, over that of the disc of equal area (equation 5.5).
fn longer(aspect: f32) -> f32 {
    if aspect <= 1.0 {
        return 1.0;
    }
    let quarter = root(root(min(aspect, LONGEST)));
    let power = quarter * quarter * quarter;
    let mean = 0.5 * (power + 1.0 / power);
    cbrt(mean * mean)
}

/// Stuck twist stiffness of an ellipse, over that of the disc of equal area, when its torque is `longer` times the disc's (equation 5.6).
fn stiffer(longer: f32, poisson_ratio: f32) -> f32 {
    if longer <= 1.0 { 1.0 } else { pow(longer, STIFFER + STIFFER_BY_POISSON * poisson_ratio) }
}

/// Aspect beyond which a patch counts as no longer: by then the stiffness's fit is off by a half.
const LONGEST: f32 = 100.0;

/// Exponent of the stiffness over the torque of a long patch, and what Poisson's ratio adds: within 1.5 % of the elliptic integrals up to an aspect of 3.
const STIFFER: f32 = 2.05;
/// See [`STIFFER`].
const STIFFER_BY_POISSON: f32 = 1.6;

/// The patch's friction budget is one that an f32 can share out.
fn is_followed(params: &Params, patch: &Patch) -> bool {
    params.mu_s * patch.footprint.load >= LEAST_FRICTION
}

/// What a tick leaves of a shift, held to twice the shift that takes contact and body from rest to full slip: more cannot matter, and where the
/// body is 1e7 times softer than the contact f32 would let it grow without end.
pub fn carried(hold: &Hold, rest: Shift) -> Shift {
    let full = hold.mu_s * hold.load;
    let most_drag = 2.0 * full * (1.0 / hold.drag_stiffness + hold.body.drag);
    let full_torque = full * hold.arm * hold.profile.full_slip_torque();
    let most_twist = 2.0 * full_torque * (1.0 / hold.twist_stiffness + hold.body.twist);
    let size = rest.drag.length();
    let drag = if size > most_drag { rest.drag * (most_drag / size) } else { rest.drag };
    let sound = drag.is_finite() && rest.twist.is_finite();
    if sound { Shift { drag, twist: clamp(rest.twist, -most_twist, most_twist) } } else { Shift::default() }
}

/// Share of the traction that leaves with the material when the patch rolls by `rolled`: the strip 2 a x rolled over pi a^2.
pub fn rolled_away(rolled: f32, radius: f32) -> f32 {
    if radius <= 0.0 { 1.0 } else { min(2.0 * rolled / (crate::math::PI * radius), 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of equations 5.5 and 5.6 over 4096 directions.
    fn exact(aspect: f64, nu: f64) -> (f64, f64) {
        const COUNT: i32 = 4096;
        let (long, wide) = (aspect.sqrt(), 1.0 / aspect.sqrt());
        let (mut reach, mut i1, mut i2, mut i3) = (0.0, 0.0, 0.0, 0.0);
        for k in 0..COUNT {
            let (s, c) = (core::f64::consts::TAU * f64::from(k) / f64::from(COUNT)).sin_cos();
            let h = (long * long * c * c + wide * wide * s * s).sqrt();
            let h3 = h * h * h * f64::from(COUNT);
            reach += h / f64::from(COUNT);
            i1 += (1.0 - nu * c * c) * s * s / h3;
            i2 += (1.0 - nu * s * s) * c * c / h3;
            i3 += c * c * s * s / h3;
        }
        let (a, b) = (i2 - nu * i3, i1 - nu * i3);
        (reach, (a + b) / (4.0 * (a * i1 + b * nu * i3)))
    }

    #[test]
    fn long_patches_against_the_integrals() {
        let long = |aspect: f32, nu: f32| (longer(aspect), stiffer(longer(aspect), nu));
        assert_eq!(long(1.0, 0.5), (1.0, 1.0));
        for (aspect, torque, stiffness) in [(1.2, 0.001, 0.01), (1.8, 0.001, 0.015), (3.0, 0.005, 0.025), (10.0, 0.01, 0.15)] {
            for nu in [0.0, 0.3, 0.5] {
                let (found, want) = (long(aspect, nu), exact(aspect.into(), nu.into()));
                let off = [f64::from(found.0) / want.0 - 1.0, f64::from(found.1) / want.1 - 1.0];
                assert!(off[0].abs() < torque && off[1].abs() < stiffness, "{aspect} {nu}: {off:?}");
            }
        }
    }
}

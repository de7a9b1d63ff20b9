//! The tiers: what a patch holds against when it is dragged and twisted. All share [`Hold`].

pub mod bristle;
pub mod influence;
pub mod paper;
pub mod point;

use crate::math::{clamp, max, min};
use crate::model::{Compliance, Model};
use crate::params::Params;
use crate::patch::{Patch, Shift};
use crate::profile::Profile;

/// What the tangential tiers need to know about a patch in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Hold {
    /// Contact radius a \[m\].
    pub radius: f32,
    /// Normal load P \[N\].
    pub load: f32,
    /// Pressure profile.
    pub profile: Profile,
    /// Full-stick drag stiffness K_t = 8 G a / (2 - nu) \[N/m\] (Mindlin).
    pub drag_stiffness: f32,
    /// Full-stick twist stiffness K_theta = 16/3 G a^3 (1 - 0.735 a/R_e) \[N m/rad\] (Reissner and Sagoci; convex body).
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
        Self {
            radius: a,
            load: patch.footprint.load,
            profile: Profile::new(patch.footprint.fullness),
            drag_stiffness: 8.0 * g * a / (2.0 - model.material.poisson_ratio),
            twist_stiffness: 16.0 / 3.0 * g * a * a * a * max(convex, 0.0),
            mu_s: params.mu_s,
            mu_d: params.mu_d,
            sharp: params.breakaway == crate::params::Breakaway::Sharp,
            body: Compliance { drag: patch.body.drag + lever, ..patch.body },
            wanted: patch.motion.step - (ground - patch.ground) + patch.pending,
        }
    }
}

/// What a tick leaves of a shift, held to twice the shift that takes contact and body from rest to full slip: more cannot matter, and where the
/// body is 1e7 times softer than the contact f32 would let it grow without end.
pub fn carried(hold: &Hold, rest: Shift) -> Shift {
    let full = hold.mu_s * hold.load;
    let most_drag = 2.0 * full * (1.0 / hold.drag_stiffness + hold.body.drag);
    let full_torque = full * hold.radius * hold.profile.full_slip_torque();
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

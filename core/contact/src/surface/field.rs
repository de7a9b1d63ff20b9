//! The field of one patch around its contact, prepared for many points: what does not depend on the point (theory.md, section 9.1).
//!
//! [`super::near`] evaluates it. Everything is counted in the patch's own frame: first axis along the grip's force, third along the normal.

use glam::{Vec2, Vec3};

use crate::math::{PI, cbrt, clamp, max, min, root};
use crate::model::Model;
use crate::params::{Params, Tier};
use crate::patch::Patch;
use crate::profile::{FULLNESS_HERTZ, FULLNESS_PUNCH};
use crate::tier::Hold;
use crate::tier::point::curve::Curve;

use super::local::{FAR, FAR_BOWL, FAR_BOWL_ACROSS, FAR_DISC, FAR_DISC_ACROSS, FAR_TURNED};
use super::motion::BodyMotion;
use super::slip_table::{self, Row};

/// The field of one patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    pub frame: Frame,
    pub dent: Dent,
    pub drag: Drag,
    pub turn: Turn,
    pub held: Held,
}

/// Where the patch is, and how its surroundings are measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub centre: Vec3,
    /// Along the grip's force, then at right angles to it, along the surface.
    pub first: Vec3,
    pub second: Vec3,
    pub normal: Vec3,
    /// The normal is the vertical to f32.
    pub upright: bool,
    pub radius: f32,
    pub inverse_radius: f32,
    /// Half the curvature of the object under the patch \[1/m\].
    pub half_curvature: f32,
    /// Base of the body \[m\]; minus infinity for a half space.
    pub base: f32,
    /// Height of the patch over the base \[m\], and one over it.
    pub height: f32,
    pub inverse_height: f32,
}

/// Equations (9.2) and (9.5).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Dent {
    /// Depth of the paraboloid that carries the Hertz share of the load \[m\].
    pub bowl: f32,
    /// Depth of the flat punch that carries the rest \[m\].
    pub disc: f32,
    /// Depth at the centre that the load does not account for \[m\].
    pub rest: f32,
    /// (1 + nu) P/(2 pi E) \[m^2\].
    pub force: f32,
    /// 1/(2 (1 - nu)).
    pub below: f32,
    /// Coefficients of the far dent.
    pub far: [f32; 3],
}

/// Equation (9.3).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Drag {
    pub poisson: f32,
    /// 1 - 2 nu.
    pub squeeze: f32,
    /// Lift of the patch in full slip, s_0/(2 - nu) \[m\].
    pub bowl: f32,
    /// Stick radius over a, its inverse square, and what the stuck middle takes off \[m\].
    pub stuck: f32,
    pub stuck_inverse: f32,
    pub inner: f32,
    /// Lift of the flat punch \[m\].
    pub disc: f32,
    /// Q/(4 pi G) \[m^2\].
    pub force: f32,
    pub far_along: [f32; 3],
    pub far_across: [f32; 3],
}

/// Equation (9.4).
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    /// Rotation by places of r/a, of the part in partial slip \[rad\].
    pub row: Row,
    /// Whether there is such a part.
    pub slips: bool,
    /// Rotation of the part that sticks as one \[rad\].
    pub disc: f32,
    pub far: [f32; 3],
}

/// What the probe, which keeps the contact as it is, takes back of the body's own motion under it: rise, and slopes along the two axes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    pub rise: f32,
    pub slope: Vec2,
}

/// Largest part of the dent's depth that is attributed to the probe's true shape rather than to other patches.
const SHAPE_SHARE: f32 = 0.1;

/// Stick radii below this share of a are none: what the innermost thousandth holds is below a millionth of the field.
const LEAST_STUCK: f32 = 1.0e-3;

/// Lean of a normal below which the patch counts as upright: less than the rounding of its coordinates.
const LEAST_LEAN: f32 = 1.0e-7;

impl Field {
    /// Prepares the field of `patch`; `None` where the patch has no extent.
    pub fn new(model: &Model<'_>, params: &Params, patch: &Patch) -> Option<Self> {
        if patch.footprint.radius <= 0.0 {
            return None;
        }
        let hold = Hold::new(model, params, patch, patch.ground, 0.0);
        let flat = clamp((patch.footprint.fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ), 0.0, 1.0);
        let turn = if params.tier == Tier::Paper { Turn::NONE } else { Turn::new(params, patch, &hold, flat) };
        Some(Self {
            frame: Frame::new(model, patch),
            dent: Dent::new(model, patch, flat),
            drag: Drag::new(model, params, patch, &hold, flat),
            turn,
            held: Held::default(),
        })
    }

    /// With what the probe, which keeps the contact as it is, takes back of the body's motion under it.
    #[must_use]
    pub fn held_against(mut self, body: &BodyMotion, patch: &Patch) -> Self {
        if body.is_none() {
            return self;
        }
        let Frame { centre, first, second, normal, radius, .. } = self.frame;
        let rise = |p: Vec3| body.at(p).dot(normal);
        let slope = |along: Vec3| (rise(centre + along * radius) - rise(centre - along * radius)) / (2.0 * radius);
        self.held =
            Held { rise: rise(centre) + patch.body.normal * patch.footprint.load, slope: Vec2::new(slope(first), slope(second)) };
        self
    }
}

impl Frame {
    fn new(model: &Model<'_>, patch: &Patch) -> Self {
        let base = model.base();
        let (centre, radius) = (patch.at_rest(), patch.footprint.radius);
        let pull = root(patch.grip.force.length_squared());
        let along = if pull > 0.0 { patch.grip.force / pull } else { Vec2::X };
        let first = patch.to_world(along);
        let height = max(centre.z - base, radius);
        Self {
            centre,
            first,
            second: patch.normal.cross(first),
            normal: patch.normal,
            upright: patch.normal.x.abs().max(patch.normal.y.abs()) < LEAST_LEAN && patch.normal.z > 0.0,
            radius,
            inverse_radius: 1.0 / radius,
            half_curvature: 0.5 / patch.object_radius,
            base,
            height,
            inverse_height: 1.0 / height,
        }
    }
}

impl Dent {
    fn new(model: &Model<'_>, patch: &Patch, flat: f32) -> Self {
        let (a, load) = (patch.footprint.radius, patch.footprint.load);
        if load <= 0.0 {
            return Self::default();
        }
        let nu = model.material.poisson_ratio;
        let per_radius = load / (model.material.contact_modulus() * a);
        let (bowl, disc) = (0.75 * per_radius * (1.0 - flat), 0.5 * per_radius * flat);
        let found = bowl + disc;
        let wanted = patch.depth - patch.body.normal * load - found;
        Self {
            bowl,
            disc,
            rest: clamp(wanted, -SHAPE_SHARE * found, SHAPE_SHARE * found),
            force: (1.0 + nu) * load / (2.0 * PI * model.material.young_modulus),
            below: 0.5 / (1.0 - nu),
            far: sum(&[(bowl, &FAR_BOWL), (disc, &FAR_DISC)]),
        }
    }
}

impl Drag {
    fn new(model: &Model<'_>, params: &Params, patch: &Patch, hold: &Hold, flat: f32) -> Self {
        let nu = model.material.poisson_ratio;
        let pull = root(patch.grip.force.length_squared());
        let none = Self { poisson: nu, squeeze: 1.0 - 2.0 * nu, stuck: 1.0, stuck_inverse: 1.0, ..Self::default() };
        if pull <= 0.0 {
            return none;
        }
        // never less than what is held: static friction may hold more than dynamic
        let full = max(params.mu_d * hold.load, pull);
        let stuck = cbrt(max(1.0 - pull / full, 0.0));
        let (stuck, sticks) = if stuck > LEAST_STUCK { (stuck, 1.0) } else { (1.0, 0.0) };
        let bowl = 1.5 * full / hold.drag_stiffness / (2.0 - nu) * (1.0 - flat);
        let disc = pull / hold.drag_stiffness / (2.0 - nu) * flat;
        let inner = bowl * stuck * stuck * sticks;
        let far = |bowl_far: &[f32; 3], disc_far: &[f32; 3]| {
            sum(&[(bowl, bowl_far), (-inner, &shrunk(bowl_far, stuck)), (disc, disc_far)])
        };
        Self {
            bowl,
            stuck,
            stuck_inverse: 1.0 / stuck,
            inner,
            disc,
            force: pull / (4.0 * PI * model.material.shear_modulus()),
            far_along: far(&FAR_BOWL, &FAR_DISC),
            far_across: far(&FAR_BOWL_ACROSS, &FAR_DISC_ACROSS),
            ..none
        }
    }
}

impl Turn {
    const NONE: Self = Self { row: Row::ZERO, slips: false, disc: 0.0, far: [0.0; 3] };

    /// The turn of the patch: what it was loaded to, and what each reversal since took back with doubled scale (Masing), where the tier
    /// remembers it.
    fn new(params: &Params, patch: &Patch, hold: &Hold, flat: f32) -> Self {
        let curve = Curve::twist(hold, params.mu_d);
        if curve.full() <= 0.0 {
            return Self::NONE;
        }
        let mut turn = Self::NONE;
        let (mut last, mut scale) = (0.0, 1.0);
        if params.tier == Tier::Point {
            for torque in patch.point.turning_torques() {
                turn.add(&curve, hold, (torque - last) / scale, scale, flat);
                (last, scale) = (torque, 2.0);
            }
        }
        turn.add(&curve, hold, (patch.grip.torque - last) / scale, scale, flat);
        turn
    }

    /// Adds `scale` times the field of a fresh patch that is loaded up to `torque`.
    fn add(&mut self, curve: &Curve, hold: &Hold, torque: f32, scale: f32, flat: f32) {
        if torque == 0.0 {
            return;
        }
        let z = min(curve.inverse(torque.abs()) / curve.slope_reach(), slip_table::LARGEST_TURN);
        let hertz = scale * z * curve.slope_reach() * torque.signum() * (1.0 - flat);
        // below the table's first row the rim sticks more and more, up to the whole patch
        let slipping = min(z / slip_table::SMALLEST_TURN, 1.0);
        let disc = scale * torque / hold.twist_stiffness;
        let stuck = hertz * (1.0 - slipping) + disc * flat;
        self.disc += stuck;
        let mut far = sum(&[(stuck, &FAR_TURNED)]);
        if hertz != 0.0 {
            self.slips = true;
            self.row.add(z, hertz * slipping);
            // far away the torque alone counts; the next term joins the table
            let lead = FAR_TURNED[0] * disc * (1.0 - flat) * slipping;
            let edge = slip_table::slip_field(z, 1.0 / FAR) * hertz * slipping;
            far[0] += lead;
            far[1] += (edge / (FAR * FAR * FAR) - lead) / (FAR * FAR);
        }
        self.far = sum(&[(1.0, &self.far), (1.0, &far)]);
    }
}

/// Coefficients of the series for s k in place of s.
fn shrunk(series: &[f32; 3], k: f32) -> [f32; 3] {
    let k2 = k * k;
    [series[0] * k, series[1] * (k * k2), series[2] * (k * k2 * k2)]
}

/// Weighted sum of series.
fn sum(parts: &[(f32, &[f32; 3])]) -> [f32; 3] {
    let mut all = [0.0; 3];
    for (weight, series) in parts {
        for (all, one) in all.iter_mut().zip(*series) {
            *all += weight * one;
        }
    }
    all
}

//! Tier `point`: closed-form curves, one number per direction, constant cost.
//!
//! Drag follows Cattaneo's curve, twist Lubkin's, both with Masing's rule on reversal and return-point memory. The two are joined by what the slip of
//! one takes from the other, and by the limit surface (Q/muP)^1.725 + (T/T_max)^1.725 <= 1, on which what slips moves along the surface's
//! normal (theory.md, section 6.1).

pub mod curve;
pub mod memory;
mod twist;

use glam::Vec2;

use crate::math::{clamp, max, min, pow, root};
use crate::patch::{Grip, Patch, Shift};
use crate::tier::{Hold, carried, rolled_away};
use curve::Curve;
use memory::{Memory, held};

/// Memory of one patch.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointMemory {
    drag: Memory,
    twist: Memory,
    /// Share of the way from static to dynamic friction, 0 while the patch has not slid.
    slid: f32,
}

impl PointMemory {
    /// Torques \[N m\] at which the patch turned back, oldest first, as far as they still matter.
    pub fn turning_torques(&self) -> impl Iterator<Item = f32> {
        self.twist.turning_loads().map(|load| load.x)
    }
}

/// Exponent of the limit surface: within 0.9 % of the exact surface for Hertz pressure.
pub const LIMIT_EXPONENT: f32 = 1.725;

/// Utilisation above which a patch counts as sliding as a whole. Twist reaches 1 only asymptotically.
const GROSS_SLIP: f32 = 0.99;

/// Advances the patch by `hold.wanted`.
pub fn advance(hold: &Hold, patch: &mut Patch) {
    if hold.load <= 0.0 || hold.radius <= 0.0 {
        return let_go(patch);
    }
    let mu = friction(hold, patch.point.slid);
    if mu * hold.load <= f32::MIN_POSITIVE {
        return slide_freely(hold, patch);
    }
    let (drag, twist) = (Curve::drag(hold, mu), Curve::twist(hold, mu));
    let kept = 1.0 - rolled_away(patch.motion.rolled, hold.radius);
    let (force, torque) = (held(&drag, patch.grip.force * kept), held(&twist, Vec2::new(patch.grip.torque * kept, 0.0)));
    patch.point.drag.rebuild(&drag, force);
    patch.point.twist.rebuild(&twist, torque);

    // what the patch lost by rolling and by a smaller load, the body springs back by
    let sprung =
        Shift { drag: (patch.grip.force - force) * hold.body.drag, twist: (patch.grip.torque - torque.x) * hold.body.twist };
    let wanted = hold.wanted + sprung;
    let dragged = pull(&drag, &mut patch.point.drag, force, wanted.drag, hold.body.drag);
    let turned = pull(&twist, &mut patch.point.twist, torque, Vec2::new(wanted.twist, 0.0), hold.body.twist);
    let stick = patch.point.drag.stick(&drag) * patch.point.twist.stick(&twist);
    let slipping = 1.0 - 0.5 * (patch.grip.stick + stick);
    let worn = worn(&drag, &twist, slipping, &dragged, &turned);
    let (force, torque) = share_budget(&drag, &twist, worn);
    // the body springs back by what the two have taken from each other, and the contact takes that up in the next tick
    let sprung = Shift { drag: (dragged.load - force) * hold.body.drag, twist: (turned.load.x - torque) * hold.body.twist };
    patch.pending = carried(hold, Shift { drag: dragged.pending, twist: turned.pending.x } + sprung);
    // none of it is needed, nor its roots, where static friction is dynamic friction
    if hold.mu_s > hold.mu_d {
        let slid = length(dragged.step) / drag.slope_reach() + length(turned.step) / twist.slope_reach();
        note_sliding(hold, patch, force.length() / drag.full(), torque.abs() / twist.full(), slid);
    }
    patch.grip = Grip { force, torque, stick };
}

fn let_go(patch: &mut Patch) {
    patch.point = PointMemory::default();
    patch.pending = Shift::default();
    patch.grip = Grip::default();
}

/// Static friction has broken and dynamic friction is nothing: free until the patch stops.
fn slide_freely(hold: &Hold, patch: &mut Patch) {
    let slid = if hold.wanted.is_zero() { 0.0 } else { patch.point.slid };
    let_go(patch);
    patch.point.slid = slid;
}

fn friction(hold: &Hold, slid: f32) -> f32 {
    hold.mu_s - (hold.mu_s - hold.mu_d) * slid
}

/// Steps of the search for the contact's share of a shift. The residual is nearly a line over one tick, and what two secants leave of it
/// is carried on to the next tick.
const SERIES_STEPS: usize = 1;

/// Answer of [`pull`].
struct Pulled {
    before: Vec2,
    load: Vec2,
    /// What the contact itself took.
    step: Vec2,
    /// What is left for the next tick.
    pending: Vec2,
}

/// Shifts contact and body together by `wanted`, from the load `now`: contact's step + C (change of load) = wanted. The curve gives the change
/// of load only, so that what its inverse rounds away never adds up.
fn pull(curve: &Curve, memory: &mut Memory, now: Vec2, wanted: Vec2, compliance: f32) -> Pulled {
    if wanted == Vec2::ZERO {
        return Pulled { before: now, load: now, step: Vec2::ZERO, pending: Vec2::ZERO };
    }
    let before = memory.load(curve);
    let share = if compliance > 0.0 { contact_share(curve, memory, before, wanted, compliance) } else { 1.0 };
    let step = wanted * share;
    let load = held(curve, now + (memory.advance(curve, before, step) - before));
    Pulled { before: now, load, step, pending: wanted - step - (load - now) * compliance }
}

/// Share of `wanted` that the contact takes, by regula falsi (Illinois) on a monotone residual.
fn contact_share(curve: &Curve, memory: &Memory, before: Vec2, wanted: Vec2, compliance: f32) -> f32 {
    let size2 = wanted.length_squared();
    if size2 <= 0.0 {
        return 1.0;
    }
    let residual = |share: f32| {
        let load = memory.load_after(curve, before, wanted * share);
        (share - 1.0) + compliance * (load - before).dot(wanted) / size2
    };
    let (mut low, mut high) = (0.0, 1.0);
    let (mut at_low, mut at_high) = (-1.0, max(residual(1.0), 0.0));
    for _ in 0..SERIES_STEPS {
        let share = secant((low, at_low), (high, at_high));
        let here = residual(share);
        if here <= 0.0 {
            (low, at_low, at_high) = (share, here, 0.5 * at_high);
        } else {
            (high, at_high, at_low) = (share, here, 0.5 * at_low);
        }
    }
    secant((low, at_low), (high, at_high))
}

/// Where the line through two points of opposite sign crosses zero; `high` where there is no line.
fn secant((low, at_low): (f32, f32), (high, at_high): (f32, f32)) -> f32 {
    let span = at_high - at_low;
    if span > f32::MIN_POSITIVE { clamp(low - at_low * (high - low) / span, low, high) } else { high }
}

/// Share of the torque that a drag by the full-slip shift takes where all slips, and of the force that a twist by T_max/K_theta takes: what slips turns
/// the way it slips. Fitted on the mixed paths of the reference.
const WORN_BY_DRAG: f32 = 1.25;
/// See [`WORN_BY_DRAG`].
const WORN_BY_TWIST: f32 = 0.1;

/// Force and torque after each has worn the other where the patch slips, by `slipping` of its area (equation 6.3a).
fn worn(drag: &Curve, twist: &Curve, slipping: f32, dragged: &Pulled, turned: &Pulled) -> (Vec2, f32) {
    // a pure motion has nothing to take
    if turned.load.x == 0.0 || dragged.load == Vec2::ZERO {
        return (dragged.load, turned.load.x);
    }
    // half before the load grows and half after, so that a steady state does not hang on the length of the steps
    let left = |pulled: &Pulled, half: f32| {
        let half = slipping * half;
        (pulled.before * max(1.0 - half, 0.0) + (pulled.load - pulled.before)) * (1.0 / (1.0 + half))
    };
    let by_drag = 0.5 * WORN_BY_DRAG * length(dragged.step) / drag.reach();
    let by_twist = 0.5 * WORN_BY_TWIST * turned.step.x.abs() / twist.slope_reach();
    (left(dragged, by_twist), left(turned, by_drag).x)
}

/// One friction budget for sliding and spinning: what lies beyond the limit surface goes back to it against the motion that slips there, which is along the
/// surface's normal, by the stiffness that is left at these loads (equation 6.3b).
fn share_budget(drag: &Curve, twist: &Curve, (force, torque): (Vec2, f32)) -> (Vec2, f32) {
    let (pulled, turned) = (length(force) / drag.full(), torque.abs() / twist.full());
    // inside the straight line between the two limits nothing needs a power
    if pulled + turned <= 1.0 || pulled <= 0.0 || turned <= 0.0 {
        return (force, torque);
    }
    let powers = (pow(pulled, LIMIT_EXPONENT), pow(turned, LIMIT_EXPONENT));
    let beyond = powers.0 + powers.1 - 1.0;
    if beyond <= 0.0 {
        return (force, torque);
    }
    let normal = (powers.0 / pulled, powers.1 / turned);
    let stiffer = (drag.full() / twist.full()) * (drag.slope_reach() / twist.slope_reach());
    let back = ((1.0 - DRAG_SOFTENS * powers.0) * normal.0, (LEAST_LEFT + 1.0 - turned) * stiffer * normal.1);
    let step = beyond / (LIMIT_EXPONENT * (back.0 * normal.0 + back.1 * normal.1));
    let (pulled_back, turned_back) = (max(pulled - step * back.0, 0.0), max(turned - step * back.1, 0.0));
    // what one step leaves goes evenly: (1 + x/m)^m >= 1 + x, so that nothing stays outside
    let left = pow(pulled_back, LIMIT_EXPONENT) + pow(turned_back, LIMIT_EXPONENT) - 1.0;
    let even = 1.0 / (1.0 + max(left, 0.0) / LIMIT_EXPONENT);
    (force * (even * pulled_back / pulled), torque * (even * turned_back / turned))
}

/// Share of the stuck stiffness that drag has lost at its limit, in proportion to (Q/mu P)^1.725 on the way: within 0.07 of c/a of Cattaneo's curve up to 0.97 mu P.
const DRAG_SOFTENS: f32 = 0.65;

/// What twist keeps of its stuck stiffness at its limit; before, it keeps 1 - T/T_max more, within 0.05 of (c/a)^3 of Lubkin's curve.
const LEAST_LEFT: f32 = 0.01;

fn length(v: Vec2) -> f32 {
    root(v.length_squared())
}

/// Follows the change from static to dynamic friction: at once when sharp, over one elastic reach when smooth, back when it sticks.
fn note_sliding(hold: &Hold, patch: &mut Patch, drag_used: f32, twist_used: f32, slid: f32) {
    let used = pow(drag_used, LIMIT_EXPONENT) + pow(twist_used, LIMIT_EXPONENT);
    patch.point.slid = if used < GROSS_SLIP {
        if used < 0.9 * GROSS_SLIP { 0.0 } else { patch.point.slid }
    } else if hold.sharp {
        1.0
    } else {
        min(patch.point.slid + slid, 1.0)
    };
}

//! Tier `point`: closed-form curves, one number per direction, constant cost.
//!
//! Drag follows Cattaneo's curve, twist Lubkin's, both with Masing's rule on reversal and return-point memory; the two are
//! joined by the limit surface (Q/muP)^1.725 + (T/T_max)^1.725 <= 1 (theory.md, section 6.1).

pub mod curve;
pub mod memory;

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
    patch.pending = carried(hold, Shift { drag: dragged.pending, twist: turned.pending.x });

    let (force, torque) = share_budget(&drag, &twist, patch, dragged.load, turned.load);
    // none of it is needed, nor its roots, where static friction is dynamic friction
    if hold.mu_s > hold.mu_d {
        let slid = length(dragged.step) / drag.slope_reach() + length(turned.step) / twist.slope_reach();
        note_sliding(hold, patch, force.length() / drag.full(), torque.abs() / twist.full(), slid);
    }
    let stick = patch.point.drag.stick(&drag) * patch.point.twist.stick(&twist);
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
        return Pulled { load: now, step: Vec2::ZERO, pending: Vec2::ZERO };
    }
    let before = memory.load(curve);
    let share = if compliance > 0.0 { contact_share(curve, memory, before, wanted, compliance) } else { 1.0 };
    let step = wanted * share;
    memory.advance(curve, step);
    let load = held(curve, now + (memory.load(curve) - before));
    Pulled { load, step, pending: wanted - step - (load - now) * compliance }
}

/// Share of `wanted` that the contact takes, by regula falsi (Illinois) on a monotone residual.
fn contact_share(curve: &Curve, memory: &Memory, before: Vec2, wanted: Vec2, compliance: f32) -> f32 {
    let size2 = wanted.length_squared();
    if size2 <= 0.0 {
        return 1.0;
    }
    let residual = |share: f32| {
        let load = memory.load_after(curve, wanted * share);
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

/// One friction budget for sliding and spinning: beyond the limit surface both are scaled back, and the memories with them.
fn share_budget(drag: &Curve, twist: &Curve, patch: &mut Patch, force: Vec2, torque: Vec2) -> (Vec2, f32) {
    let (pulled, turned) = (force.length() / drag.full(), torque.x.abs() / twist.full());
    // inside the straight line between the two limits nothing needs a power
    if pulled + turned <= 1.0 {
        return (force, torque.x);
    }
    let used = pow(pulled, LIMIT_EXPONENT) + pow(turned, LIMIT_EXPONENT);
    if used <= 1.0 {
        return (force, torque.x);
    }
    let scale = pow(used, -1.0 / LIMIT_EXPONENT);
    let (force, torque) = (force * scale, torque * scale);
    patch.point.drag.rebuild(drag, force);
    patch.point.twist.rebuild(twist, torque);
    (force, torque.x)
}

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

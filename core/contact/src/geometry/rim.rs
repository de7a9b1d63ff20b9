//! The deepest point of a part under the rim of a cylinder, where the end and the round side share the depth.
//!
//! As under an edge of a box ([`under_edge`](crate::geometry::faces::under_edge)), by the weights of the two; the shares t_i = w_i^(4/5) are halved on the sign of the slope,
//! 5/4 t_i^(1/4) s_i, and the round side is a face for every direction across the axis.

use glam::Vec3;

use crate::geometry::deepest::Deepest;
use crate::geometry::faces::{FARTHEST, MISSED, SETTLED, between};
use crate::geometry::gap::Gap;
use crate::math::{direction, max, root};

/// A cylinder about its centre: the sign of the near end, and the way out to the point that was found.
struct Rim<F> {
    radius: f32,
    half_height: f32,
    sign: f32,
    out: Vec3,
    support: F,
}

/// Halvings of the share of the side: to 1e-5, with which a flat of 40 mm leans by less than a micrometre.
const SIDE_STEPS: usize = 17;

/// Halvings of the direction across the axis, within [`WIDEST_TURN`] of the one found.
const TURN_STEPS: usize = 12;

/// Tangent of the largest turn about the axis away from the point that was found.
const WIDEST_TURN: f32 = 1.0;

/// The deepest point under the rim of an upright cylinder, as [`under_edge`](crate::geometry::faces::under_edge). The round side is a face for every direction across the axis; of these
/// the least is the one that points at its own support point.
pub fn under_rim(radius: f32, height: f32, at: &Deepest, reach: f32, support: impl Fn(Vec3) -> Vec3) -> Option<Deepest> {
    let centre = Vec3::Z * (0.5 * height);
    let place = at.point - centre;
    let out = direction(Vec3::new(place.x, place.y, 0.0), Vec3::X);
    let sign = if place.z < 0.0 { -1.0 } else { 1.0 };
    let rim = Rim { radius, half_height: 0.5 * height, sign, out, support: |d: Vec3| support(d) - centre };
    let (side, end) = (radius - place.dot(out), rim.half_height - sign * place.z);
    let depth = -at.gap.distance;
    let far = if depth > 0.0 { FARTHEST * depth } else { MISSED * reach };
    if max(side, end) >= far && (depth <= 0.0 || rim.bound(side, end, depth) <= (1.0 + SETTLED) * depth) {
        return None;
    }
    let (depth, normal, point) = rim.best(depth <= 0.0)?;
    Some(Deepest { point: point + centre, gap: Gap { distance: -depth, normal: direction(normal, Vec3::Z) } })
}

impl<F: Fn(Vec3) -> Vec3> Rim<F> {
    /// What the weights of a point's slacks say of the depth from above.
    fn bound(&self, side: f32, end: f32, depth: f32) -> f32 {
        let weight = |s: f32| {
            let share = depth / s;
            share * share * share * share * share
        };
        let (side, end) = (weight(side), weight(end));
        let (to_side, to_end) = self.slacks(self.out, self.point(side, end, self.out));
        side * to_side + end * to_end
    }

    /// The part's support point against the weights.
    fn point(&self, side: f32, end: f32, out: Vec3) -> Vec3 {
        (self.support)(-(out * side + Vec3::Z * (self.sign * end)))
    }

    /// Slacks of side and end at a point.
    fn slacks(&self, out: Vec3, point: Vec3) -> (f32, f32) {
        (self.radius - out.dot(point), self.half_height - self.sign * point.z)
    }

    /// Depth, normal (of any length) and point at the side's share whose slope is the end's; `None` where descent `missed` and a trial proves a gap.
    fn best(&self, missed: bool) -> Option<(f32, Vec3, Vec3)> {
        let (mut low, mut high) = (0.0, 1.0);
        let (mut before, mut after) = (None, None);
        let lead = |share: f32, out: Vec3, point: Vec3| {
            let (to_side, to_end) = self.slacks(out, point);
            root(root(share)) * to_side - root(root(1.0 - share)) * to_end
        };
        for _ in 0..SIDE_STEPS {
            let share = 0.5 * (low + high);
            let (out, point) = self.turned(share);
            if missed && self.found(share, out, point).0 < 0.0 {
                return None;
            }
            if lead(share, out, point) > 0.0 {
                (high, after) = (share, Some(point));
            } else {
                (low, before) = (share, Some(point));
            }
        }
        let share = 0.5 * (low + high);
        let (out, mut point) = self.turned(share);
        if let (Some(before), Some(after)) = (before, after) {
            point = between(before, lead(share, out, before), after, lead(share, out, after));
        }
        Some(self.found(share, out, point))
    }

    /// What the weights of a share say of the depth from above at their support point, their normal, and the point.
    fn found(&self, share: f32, out: Vec3, point: Vec3) -> (f32, Vec3, Vec3) {
        let (side, end) = (weight_of(share), weight_of(1.0 - share));
        let (to_side, to_end) = self.slacks(out, point);
        (side * to_side + end * to_end, out * side + Vec3::Z * (self.sign * end), point)
    }

    /// The direction across the axis that points at its own support point, and that point.
    fn turned(&self, share: f32) -> (Vec3, Vec3) {
        let (side, end) = (weight_of(share), weight_of(1.0 - share));
        let across = Vec3::Z.cross(self.out);
        let along = |turn: f32| direction(self.out + across * turn, self.out);
        let off = |out: Vec3, point: Vec3| Vec3::Z.cross(out).dot(point);
        let (mut low, mut high) = (-WIDEST_TURN, WIDEST_TURN);
        let (mut before, mut after) = (None, None);
        for _ in 0..TURN_STEPS {
            let turn = 0.5 * (low + high);
            let out = along(turn);
            let point = self.point(side, end, out);
            if off(out, point) > 0.0 { (low, before) = (turn, Some(point)) } else { (high, after) = (turn, Some(point)) }
        }
        let out = along(0.5 * (low + high));
        match (before, after) {
            (Some(before), Some(after)) => (out, between(after, off(out, after), before, off(out, before))),
            _ => (out, self.point(side, end, out)),
        }
    }
}

/// Weight of a share.
fn weight_of(share: f32) -> f32 {
    share * root(root(share))
}

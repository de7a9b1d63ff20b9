//! The deepest point of a part under an edge or a corner of a box, where the faces share the depth.
//!
//! The depth (sum s_i^-4)^(-1/4) of the slacks s_i is the least of sum w_i s_i over the weights with sum w_i^(4/5) = 1. The deepest point of a
//! convex part is therefore the least, over the weights, of sum w_i h_i + (the part's support against sum w_i n_i): a search over one share at an
//! edge and two at a corner instead of over the part, which finds the normal on flats too (theory.md, equation 2.6). With t_i = w_i^(4/5) the shares
//! sum to 1, and the slope along t_i is 5/4 t_i^(1/4) s_i, s_i the slack of the support point.

use glam::Vec3;

use crate::geometry::deepest::Deepest;
use crate::geometry::gap::Gap;
use crate::math::{direction, max, root};

/// Halvings of a share: to 1e-6, below which a flat counts as level.
const EDGE_STEPS: usize = 18;

/// Halvings of the third share at a corner.
const CORNER_STEPS: usize = 16;

/// A face farther than this many depths has a weight below 1e-3: descent finds such points, and the bound proves it.
const FARTHEST: f32 = 4.0;

/// How near an edge, in reaches of the part, a descent that found no overlap is not believed.
const MISSED: f32 = 0.25;

/// Share of its depth by which a point may miss the deepest.
const SETTLED: f32 = 1.0e-3;

/// A box about its centre, the signs of the three faces that are near, and the support of the part in the box's frame.
struct Search<F> {
    half: Vec3,
    sign: Vec3,
    support: F,
}

/// One trial: the weights and the support point against them.
#[derive(Clone, Copy)]
struct Trial {
    shares: Vec3,
    weights: Vec3,
    point: Vec3,
    slack: Vec3,
}

/// The deepest point, from one found by descent: `at` is its gap, `centre` the box's, `support` the part's farthest point along a direction, in world.
/// `reach` is the radius of the ball that holds the part \[m\]. `None` where the one given is right: away from edges, with a bound on its depth that proves it.
pub fn under_edge(half: Vec3, centre: Vec3, at: &Deepest, reach: f32, support: impl Fn(Vec3) -> Vec3) -> Option<Deepest> {
    let place = at.point - centre;
    let sign = place.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
    let search = Search { half, sign, support: |d: Vec3| support(d) - centre };
    let (slack, depth) = (half - sign * place, -at.gap.distance);
    if search.is_settled(slack, depth, reach) {
        return None;
    }
    let found = search.over();
    let normal = direction(found.weights * sign, Vec3::Z);
    Some(Deepest { point: found.point + centre, gap: Gap { distance: -found.weights.dot(found.slack), normal } })
}

impl<F: Fn(Vec3) -> Vec3> Search<F> {
    /// True when only one face is near and the depth found there meets the bound that its weights give from above.
    fn is_settled(&self, slack: Vec3, depth: f32, reach: f32) -> bool {
        // a descent that found no overlap may have missed a shallow one by an edge
        let far = if depth > 0.0 { FARTHEST * depth } else { MISSED * reach };
        if slack.to_array().into_iter().filter(|&s| s < far).count() > 1 {
            return false;
        }
        if depth <= 0.0 {
            return true;
        }
        let share = Vec3::splat(depth) / slack;
        let weights = share * share * share * share * share;
        let bound = weights.dot(self.half - self.sign * (self.support)(-(weights * self.sign)));
        bound - depth <= SETTLED * depth
    }

    /// Over all shares: the third by its slope against the best split of the rest.
    fn over(&self) -> Trial {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..CORNER_STEPS {
            let up = 0.5 * (low + high);
            let trial = self.split(Vec3::X, Vec3::Y, 1.0 - up, Vec3::Z * up);
            let slope = trial.slopes();
            let level = (slope.x * trial.shares.x + slope.y * trial.shares.y) / (1.0 - up);
            if slope.z > level { high = up } else { low = up }
        }
        let up = 0.5 * (low + high);
        self.split(Vec3::X, Vec3::Y, 1.0 - up, Vec3::Z * up)
    }

    /// Best split of the share `whole` between two faces, the rest being given.
    fn split(&self, first: Vec3, second: Vec3, whole: f32, rest: Vec3) -> Trial {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..EDGE_STEPS {
            let share = 0.5 * (low + high);
            let slope = self.trial(rest + (first * share + second * (1.0 - share)) * whole).slopes();
            if slope.dot(first) > slope.dot(second) { high = share } else { low = share }
        }
        let share = 0.5 * (low + high);
        self.trial(rest + (first * share + second * (1.0 - share)) * whole)
    }

    fn trial(&self, shares: Vec3) -> Trial {
        let weights = shares * shares.map(|t| root(root(t)));
        let point = (self.support)(-(weights * self.sign));
        Trial { shares, weights, point, slack: self.half - self.sign * point }
    }
}

/// A cylinder about its centre: the sign of the near end, and the way out to the point that was found.
struct Rim<F> {
    radius: f32,
    half_height: f32,
    sign: f32,
    out: Vec3,
    support: F,
}

/// Halvings of the direction across the axis, within [`WIDEST_TURN`] of the one found.
const TURN_STEPS: usize = 16;

/// Tangent of the largest turn about the axis away from the point that was found.
const WIDEST_TURN: f32 = 1.0;

/// The deepest point under the rim of an upright cylinder, as [`under_edge`]. The round side is a face for every direction across the axis; of these
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
    let (depth, normal, point) = rim.least_turn(rim.best_share());
    Some(Deepest { point: point + centre, gap: Gap { distance: -depth, normal: direction(normal, Vec3::Z) } })
}

impl<F: Fn(Vec3) -> Vec3> Rim<F> {
    /// What the weights of a point's slacks say of the depth from above.
    fn bound(&self, side: f32, end: f32, depth: f32) -> f32 {
        let weight = |s: f32| {
            let share = depth / s;
            share * share * share * share * share
        };
        self.trial(weight(side), weight(end), self.out).0
    }

    /// Depth bound, slacks of side and end, and the support point for given weights.
    fn trial(&self, side: f32, end: f32, out: Vec3) -> (f32, f32, f32, Vec3) {
        let point = (self.support)(-(out * side + Vec3::Z * (self.sign * end)));
        let (to_side, to_end) = (self.radius - out.dot(point), self.half_height - self.sign * point.z);
        (side * to_side + end * to_end, to_side, to_end, point)
    }

    /// The side's share at which its slope is the end's.
    fn best_share(&self) -> f32 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..EDGE_STEPS {
            let share = 0.5 * (low + high);
            let (_, to_side, to_end, _) = self.trial(weight_of(share), weight_of(1.0 - share), self.turned(share));
            let (side, end) = (root(root(share)) * to_side, root(root(1.0 - share)) * to_end);
            if side > end { high = share } else { low = share }
        }
        0.5 * (low + high)
    }

    /// The direction across the axis that points at its own support point.
    fn turned(&self, share: f32) -> Vec3 {
        let across = Vec3::Z.cross(self.out);
        let along = |turn: f32| direction(self.out + across * turn, self.out);
        let (mut low, mut high) = (-WIDEST_TURN, WIDEST_TURN);
        for _ in 0..TURN_STEPS {
            let turn = 0.5 * (low + high);
            let out = along(turn);
            let (_, _, _, point) = self.trial(weight_of(share), weight_of(1.0 - share), out);
            if Vec3::Z.cross(out).dot(point) > 0.0 { low = turn } else { high = turn }
        }
        along(0.5 * (low + high))
    }

    /// Depth, normal (of any length) and deepest point at a share.
    fn least_turn(&self, share: f32) -> (f32, Vec3, Vec3) {
        let out = self.turned(share);
        let (side, end) = (weight_of(share), weight_of(1.0 - share));
        let (depth, _, _, point) = self.trial(side, end, out);
        (depth, out * side + Vec3::Z * (self.sign * end), point)
    }
}

/// Weight of a share.
fn weight_of(share: f32) -> f32 {
    share * root(root(share))
}

impl Trial {
    /// Slopes along the shares, over 5/4.
    fn slopes(&self) -> Vec3 {
        self.shares.map(|t| root(root(max(t, 0.0)))) * self.slack
    }
}

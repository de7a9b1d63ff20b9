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

/// A face farther than this many depths has no part in the blend: its weight is below 3e-5.
const FARTHEST: f32 = 8.0;

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
/// `None` where the one given is right: away from edges, with a bound on its depth that proves it.
pub fn under_edge(half: Vec3, centre: Vec3, at: &Deepest, support: impl Fn(Vec3) -> Vec3) -> Option<Deepest> {
    let place = at.point - centre;
    let sign = place.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
    let search = Search { half, sign, support: |d: Vec3| support(d) - centre };
    let (slack, depth) = (half - sign * place, -at.gap.distance);
    if search.is_settled(slack, depth) {
        return None;
    }
    let found = search.over();
    let normal = direction(found.weights * sign, Vec3::Z);
    Some(Deepest { point: found.point + centre, gap: Gap { distance: -found.weights.dot(found.slack), normal } })
}

impl<F: Fn(Vec3) -> Vec3> Search<F> {
    /// True when only one face is near and the depth found there meets the bound that its weights give from above.
    fn is_settled(&self, slack: Vec3, depth: f32) -> bool {
        let far = FARTHEST * depth;
        if depth <= 0.0 || slack.to_array().into_iter().filter(|&s| s < far).count() > 1 {
            return false;
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

impl Trial {
    /// Slopes along the shares, over 5/4.
    fn slopes(&self) -> Vec3 {
        self.shares.map(|t| root(root(max(t, 0.0)))) * self.slack
    }
}

//! A trial of the search over the faces of a box: weights, and the support point against them (theory.md, equations 2.6 and 2.7).

use glam::{Mat2, Vec2, Vec3};

use crate::math::{min, root};

/// Share of itself that a root may lose in a step.
const MOST_FALL: f32 = 0.5;

/// One trial: the roots of the weights and the support point against them.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Roots of the weights, whose sum is 1.
    pub roots: Vec3,
    /// The support point against the weights \[m\].
    pub point: Vec3,
    /// Its slacks to the faces \[m\].
    pub slack: Vec3,
}

impl Trial {
    /// The moments: even at the deepest point.
    pub fn moments(&self) -> Vec3 {
        self.roots * self.slack
    }

    /// The weights, with their norm: what they say of the slacks is no less than the depth anywhere in the part.
    pub fn weights(&self) -> Vec3 {
        let squares = self.roots * self.roots;
        let whole = (squares * squares).element_sum();
        fifth(self.roots) / (whole * root(root(whole)))
    }

    /// How far the moments of the first two faces lead that of the third.
    pub fn leads(&self) -> Vec2 {
        let moments = self.moments();
        Vec2::new(moments.x - moments.z, moments.y - moments.z)
    }

    /// How the leads grow with the first two roots, on a part that is a ball of radius `round` about the point, or a corner.
    pub fn slopes(&self, round: f32) -> Mat2 {
        let (roots, squares) = (self.roots, self.roots * self.roots);
        let fourth = squares * squares;
        let weights = fourth * roots;
        let length = root(weights.length_squared());
        let out = weights / length;
        // the point turns about the ball's centre as the weights do
        let turn = fourth * (5.0 * round / length);
        let moved = |i: Vec3| i * (self.slack + roots * turn) - roots * out * (out * turn).dot(i);
        let (x, y, z) = (moved(Vec3::X), moved(Vec3::Y), moved(Vec3::Z));
        let (x, y) = (x - z, y - z);
        Mat2::from_cols(Vec2::new(x.x - x.z, x.y - x.z), Vec2::new(y.x - y.z, y.y - y.z))
    }

    /// A step of the first two roots, cut so that each root keeps at least a share of itself.
    pub fn kept_inside(&self, step: Vec2) -> Vec2 {
        let fall = |root: f32, step: f32| if step < 0.0 { -MOST_FALL * root / step } else { 1.0 };
        let third = fall(self.roots.z, -step.x - step.y);
        step * min(1.0, min(third, min(fall(self.roots.x, step.x), fall(self.roots.y, step.y))))
    }
}

/// Fifth powers: the weights, without their norm.
pub fn fifth(roots: Vec3) -> Vec3 {
    let squares = roots * roots;
    squares * squares * roots
}

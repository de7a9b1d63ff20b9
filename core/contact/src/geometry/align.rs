//! Where two smooth convex bodies are deepest in each other: the place where their normals oppose.
//!
//! Over the overlap the sum S = phi_o + phi_p of the two signed distances is convex, and at its least, minus the depth, the gradients
//! cancel (theory.md, equation 2.5). Its second derivatives across the normal are the sum of the two curvatures, so that a Newton step
//! of S turns the two normals into each other. Both distances are [`Field`]s in one frame. Lengths \[m\].

use glam::Vec3;

use crate::geometry::field::{Field, form};
use crate::math::{direction, max, min, perpendicular, root};

/// Newton steps. From a sample within a tenth of the body five settle to f32 on smooth bodies; the rest is for trust regions that
/// must first shrink, at edges.
const STEPS: usize = 8;

/// Rounding of S as a share of the body's size.
const ROUNDING: f32 = 1.0e-6;

/// The body's size times this stiffness keeps a step finite where both bodies are flat: normals that differ by rounding move nothing.
const FLAT: f32 = 1.0e-2;

/// Point on the surface of `part` where it is deepest in `object`, searched from `start`; `size` is the part's reach \[m\].
pub fn align(object: impl Fn(Vec3) -> Field, part: impl Fn(Vec3) -> Field, start: Vec3, size: f32) -> Vec3 {
    let look = |point: Vec3| Pair { point, object: object(point), part: part(point) };
    let mut here = look(start);
    let mut trust = 0.5 * size;
    for _ in 0..STEPS {
        let next = look(here.point + here.step(trust, size));
        if next.sum() <= here.sum() + ROUNDING * size {
            here = next;
            trust = min(2.0 * trust, size);
        } else {
            trust *= 0.25;
        }
    }
    here.point - direction(here.part.gradient, Vec3::Z) * here.part.value
}

/// Both distances at one point.
struct Pair {
    point: Vec3,
    object: Field,
    part: Field,
}

impl Pair {
    fn sum(&self) -> f32 {
        self.object.value + self.part.value
    }

    /// Newton's step along the surfaces, at most `trust` long, and back onto the part's surface.
    fn step(&self, trust: f32, size: f32) -> Vec3 {
        let n = direction(self.part.gradient, Vec3::Z);
        let (e1, e2) = tangents(direction(self.object.gradient - self.part.gradient, -n));
        let slope = self.object.gradient + self.part.gradient;
        let (g1, g2) = (slope.dot(e1), slope.dot(e2));
        let bend = form(&self.object, e1, e2).plus(form(&self.part, e1, e2));
        let steep = root(g1 * g1 + g2 * g2) / trust;
        let lift = steep + FLAT / size + max(-bend.principal().1, 0.0);
        let (k11, k12, k22) = (bend.k11 + lift, bend.k12, bend.k22 + lift);
        let determinant = k11 * k22 - k12 * k12;
        let along = e1 * (k22 * g1 - k12 * g2) + e2 * (k11 * g2 - k12 * g1);
        let step = along * (-1.0 / determinant) - n * self.part.value;
        if step.is_finite() { step } else { Vec3::ZERO }
    }
}

/// Two unit tangents of the unit vector `n`.
fn tangents(n: Vec3) -> (Vec3, Vec3) {
    let e1 = perpendicular(n);
    (e1, n.cross(e1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::field::ball;
    use glam::Mat3;

    #[test]
    fn two_balls_meet_on_the_line_of_their_centres() {
        let (a, b) = (Vec3::new(0.0, 0.0, -0.05), Vec3::new(0.01, 0.02, 0.018));
        let n = (b - a).normalize();
        for start in [Vec3::new(0.02, 0.0, 0.01), Vec3::new(-0.01, 0.03, 0.0), b - 0.02 * Vec3::Z] {
            let found = align(|q| ball(a, 0.05, q), |q| ball(b, 0.02, q), start, 0.02);
            assert!((found - (b - n * 0.02)).length() < 1.0e-7, "{start}: {found}");
        }
    }

    #[test]
    fn two_flats_stay_where_they_started() {
        let plane = |n: Vec3, h: f32| move |q: Vec3| Field { value: n.dot(q) - h, gradient: n, hessian: Mat3::ZERO };
        let found = align(plane(Vec3::Z, 0.001), plane(-Vec3::Z, 0.0), Vec3::new(0.003, 0.004, 0.0), 0.02);
        assert!((found - Vec3::new(0.003, 0.004, 0.0)).length() < 1.0e-7, "{found}");
    }
}

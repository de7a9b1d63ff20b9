//! How far rays from a point inside a part run in it: one both ways in closed form, and a round of them in a plane, four side by side where the part is a capsule.
//!
//! Frame of the part, SI units; what a ray runs is in lengths of the ray's vector.

use glam::{Vec2, Vec3};

use crate::geometry::outline::{DIRECTIONS, RAYS};
use crate::geometry::ring::Ring;
use crate::lanes::Lanes;
use crate::math::{max, min, root};
use crate::model::ProbeShape;

/// The rays of half a round: the others are their opposites.
const HALF_ROUND: [Vec2; RAYS / 2] = {
    let [a, b, c, d, e, f, ..] = DIRECTIONS;
    [a, b, c, d, e, f]
};

/// All rays, side by side.
const ROUND: Ring = Ring::new(DIRECTIONS);

/// Least square of a ray's width across an axis: one along the axis runs far, and not for ever.
const LEAST_WIDTH: Lanes = Lanes::splat(f32::MIN_POSITIVE);

/// A round of rays from a point inside a part, in the plane of two tangents.
#[derive(Clone, Copy, Debug)]
pub struct Fan {
    /// The inner point \[m\].
    pub start: Vec3,
    /// Unit tangents.
    pub tangents: [Vec3; 2],
    /// What the axes of the round are stretched to, along the tangents.
    pub axes: [Vec2; 2],
}

impl Fan {
    /// Where the rays leave the shape, along the tangents from the inner point \[m\].
    pub fn ends(&self, shape: &ProbeShape<'_>) -> Ring {
        match *shape {
            ProbeShape::Capsule { radius, height } => Ring(ROUND.0.map(|rays| self.in_capsule(radius, 0.5 * height, rays))),
            _ => self.one_by_one(shape),
        }
    }

    /// One after the other, each with its opposite.
    fn one_by_one(&self, shape: &ProbeShape<'_>) -> Ring {
        let [e1, e2] = self.tangents;
        let ends = HALF_ROUND.map(|ray| {
            let ray = self.axes[0] * ray.x + self.axes[1] * ray.y;
            let [ahead, behind] = exits(shape, self.start, e1 * ray.x + e2 * ray.y);
            [ray * ahead, ray * -behind]
        });
        let [[a, g], [b, h], [c, i], [d, j], [e, k], [f, l]] = ends;
        Ring::new([a, b, c, d, e, f, g, h, i, j, k, l])
    }

    fn in_capsule(&self, radius: f32, half: f32, [x, y]: [Lanes; 2]) -> [Lanes; 2] {
        let ([e1, e2], [u, v]) = (self.tangents, self.axes);
        let (x, y) = (x * u.x + y * v.x, x * u.y + y * v.y);
        let rays = [x * e1.x + y * e2.x, x * e1.y + y * e2.y, x * e1.z + y * e2.z];
        let out = of_capsule(self.start, rays, radius, half);
        [x * out, y * out]
    }
}

/// How far rays along `e` and against it run in the shape from the inner point `q`, in lengths of `e`.
pub fn exits(shape: &ProbeShape<'_>, q: Vec3, e: Vec3) -> [f32; 2] {
    match *shape {
        ProbeShape::Sphere { radius } => of_ball(q, e, radius),
        ProbeShape::Ellipsoid { semi_axes } => {
            let (q, e) = (q / semi_axes, e / semi_axes);
            first_roots(-e.length_squared(), -2.0 * e.dot(q), 1.0 - q.length_squared())
        }
        ProbeShape::Box { size } => {
            let half = 0.5 * size;
            nearer(slab(q.x, e.x, half.x), nearer(slab(q.y, e.y, half.y), slab(q.z, e.z, half.z)))
        }
        ProbeShape::Cylinder { radius, height } => nearer(of_tube(q, e, radius), slab(q.z, e.z, 0.5 * height)),
        ProbeShape::Capsule { radius, height } => {
            let both = |x: f32| Lanes([x, -x, x, -x]);
            let Lanes([ahead, behind, ..]) = of_capsule(q, [both(e.x), both(e.y), both(e.z)], radius, 0.5 * height);
            [ahead, behind]
        }
        ProbeShape::Cone { radius, height } => {
            let (slope, above) = (radius / height, q.z + 0.75 * height);
            let (er, qr) = (Vec2::new(e.x, e.y), Vec2::new(q.x, q.y));
            let (a, b) = (slope * slope * e.z * e.z - er.length_squared(), 2.0 * (slope * slope * above * e.z - qr.dot(er)));
            let side = first_roots(a, b, slope * slope * above * above - qr.length_squared());
            let base = max(0.25 * height - q.z, 0.0);
            nearer(side, [e.z, -e.z].map(|up| if up > 0.0 { base / up } else { f32::MAX }))
        }
        ProbeShape::Mesh(mesh) => [mesh.reach(); 2],
    }
}

fn nearer(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [min(a[0], b[0]), min(a[1], b[1])]
}

fn slab(q: f32, e: f32, half: f32) -> [f32; 2] {
    if e == 0.0 {
        return [f32::MAX; 2];
    }
    let (ahead, behind) = ((half - q) / e, (-half - q) / e);
    if e > 0.0 { [max(ahead, 0.0), max(-behind, 0.0)] } else { [max(behind, 0.0), max(-ahead, 0.0)] }
}

fn of_tube(q: Vec3, e: Vec3, radius: f32) -> [f32; 2] {
    let (q, e) = (Vec2::new(q.x, q.y), Vec2::new(e.x, e.y));
    first_roots(-e.length_squared(), -2.0 * q.dot(e), radius * radius - q.length_squared())
}

/// Four rays leave a capsule of half the height `half` where they leave its tube, or where that lies beyond an end the ball there.
fn of_capsule(q: Vec3, [ex, ey, ez]: [Lanes; 3], radius: f32, half: f32) -> Lanes {
    let room = radius * radius - q.x * q.x - q.y * q.y;
    let (wide2, outward) = ((ex * ex + ey * ey).larger(LEAST_WIDTH), ex * q.x + ey * q.y);
    // (root - b)/a and c/(root + b) are the same zero of a t^2 + 2 b t - c; the first cancels where b > 0
    let inside = Lanes::splat(max(room, 0.0));
    let far = (outward * outward + wide2 * inside).root();
    let tube = outward.if_positive(inside, far - outward) / outward.if_positive(far + outward, wide2);
    let up = ez * tube + Lanes::splat(q.z);
    let from_end = Lanes::splat(q.z) - up.if_positive(Lanes::splat(half), Lanes::splat(-half));
    let (long2, outward) = (wide2 + ez * ez, outward + from_end * ez);
    let far = (outward * outward + long2 * (Lanes::splat(room) - from_end * from_end)).root();
    let ball = (far - outward) / long2;
    (up.size() - Lanes::splat(half)).if_positive(ball, tube).larger(Lanes::splat(0.0))
}

/// Where rays leave a ball for good, in lengths of `e`; 0 where they miss it.
pub fn of_ball(q: Vec3, e: Vec3, radius: f32) -> [f32; 2] {
    let (a, b, c) = (e.length_squared(), q.dot(e), q.length_squared() - radius * radius);
    let rest = b * b - a * c;
    if rest <= 0.0 {
        return [0.0; 2];
    }
    let far = root(rest);
    [max((far - b) / a, 0.0), max((far + b) / a, 0.0)]
}

/// First zeros at t >= 0 of a t^2 + b t + c and of a t^2 - b t + c, which are not negative at 0.
fn first_roots(a: f32, b: f32, c: f32) -> [f32; 2] {
    let c = max(c, 0.0);
    let rest = b * b - 4.0 * a * c;
    if rest <= 0.0 && a > 0.0 {
        return [f32::MAX; 2];
    }
    // 2 c/(root - b) and (-b - root)/(2 a) are the same zero; the first cancels where b > 0
    let sum = root(rest) + b.abs();
    let [falling, rising] = [2.0 * c / sum, -sum / (2.0 * a)].map(|t| if t >= 0.0 && t.is_finite() { t } else { f32::MAX });
    [if b <= 0.0 { falling } else { rising }, if b >= 0.0 { falling } else { rising }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::support::tests::SHAPES;
    use crate::geometry::support::{closest, reach, support};
    use crate::math::{direction, perpendicular};

    #[test]
    fn rays_end_on_the_surface() {
        for shape in SHAPES {
            for i in 0..200 {
                let f = i as f32;
                let q = Vec3::new(libm::sinf(f), libm::sinf(2.3 * f), libm::cosf(0.7 * f)) * 0.003;
                let e = direction(Vec3::new(libm::cosf(3.1 * f), libm::sinf(1.7 * f), libm::cosf(f)), Vec3::X);
                for (e, t) in [e, -e].into_iter().zip(exits(&shape, q, e)) {
                    let off = |t: f32| (closest(&shape, q + e * t) - (q + e * t)).length();
                    assert!(t < 2.0 * reach(&shape) && off(t) < 1.0e-6 && off(t + 1.0e-4) > 1.0e-7, "{shape:?} {q} {e}: {t}");
                }
            }
        }
    }

    /// A round of rays in a capsule ends on its surface too: in one that lies, leans or stands, hardly longer than a ball or slender, from points all over it.
    #[test]
    fn rounds_in_capsules_end_on_the_surface() {
        for (radius, height) in [(0.006, 1.0e-4), (0.006, 0.02), (0.001, 0.03)] {
            let shape = ProbeShape::Capsule { radius, height };
            for i in 0..2000 {
                let f = i as f32;
                let tilted = direction(Vec3::new(libm::sinf(1.3 * f), libm::cosf(0.9 * f), libm::sinf(f)), Vec3::X);
                let n = [tilted, Vec3::X, Vec3::Z][i % 3];
                let e1 = perpendicular(n);
                let d = direction(Vec3::new(libm::sinf(2.1 * f), libm::cosf(1.9 * f), libm::sinf(0.3 * f)), Vec3::X);
                let start = support(&shape, d) * (0.95 * libm::fabsf(libm::sinf(0.7 * f)));
                let axes = [Vec2::X * (if i % 2 == 0 { 1.0 } else { 1.0 + 0.01 * f }), Vec2::Y];
                let fan = Fan { start, tangents: [e1, n.cross(e1)], axes };
                for at in fan.ends(&shape).corners() {
                    let off = |s: f32| {
                        let p = start + (e1 * at.x + n.cross(e1) * at.y) * s;
                        (closest(&shape, p) - p).length()
                    };
                    let away = 1.0 + 1.0e-4 / root(at.length_squared());
                    assert!(
                        off(1.0) < 2.0e-6 * reach(&shape).max(0.01) && off(away) > 1.0e-8,
                        "{shape:?} {fan:?}: {at} {} {}",
                        off(1.0),
                        off(away)
                    );
                }
            }
        }
    }
}

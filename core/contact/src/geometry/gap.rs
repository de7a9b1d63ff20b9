//! Signed distance from a point to the object's surface, and the surface's normal there.
//!
//! The distance to a convex set is a convex function of the point; negative inside. All objects here are convex.

use glam::Vec3;

use crate::geometry::ellipsoid;
use crate::math::{direction, max, min, root};
use crate::model::ObjectShape;

/// Gap at a point: signed distance and the unit normal out of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Signed distance \[m\]; negative = penetration.
    pub distance: f32,
    /// Unit outward normal of the closest surface point, in world.
    pub normal: Vec3,
}

/// Signed distance, and the normal's way before its length is made 1, which who only compares distances does without.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Signed distance \[m\]; negative = penetration.
    pub distance: f32,
    /// Along the normal, of any length.
    way: Vec3,
    /// Unit normal where that has no direction.
    fallback: Vec3,
}

impl Slope {
    /// With the unit normal.
    pub fn gap(&self) -> Gap {
        Gap { distance: self.distance, normal: direction(self.way, self.fallback) }
    }
}

/// Gap of the world point `p_wq` \[m\] to the object.
pub fn gap(object: &ObjectShape<'_>, p_wq: Vec3) -> Gap {
    slope(object, p_wq).gap()
}

/// The same before the normal has its length.
pub fn slope(object: &ObjectShape<'_>, p_wq: Vec3) -> Slope {
    match *object {
        ObjectShape::HalfSpace => Slope { distance: p_wq.z, way: Vec3::Z, fallback: Vec3::Z },
        ObjectShape::Box { size } => of_box(0.5 * size, p_wq - Vec3::Z * (0.5 * size.z)),
        ObjectShape::Sphere { radius } => of_sphere(radius, p_wq - Vec3::Z * radius),
        ObjectShape::Ellipsoid { semi_axes } => of_ellipsoid(semi_axes, p_wq - Vec3::Z * semi_axes.z),
        ObjectShape::Cylinder { radius, height } => of_cylinder(radius, 0.5 * height, p_wq - Vec3::Z * (0.5 * height)),
        ObjectShape::Mesh(mesh) => {
            let (distance, way) = mesh.grid().slope(p_wq);
            Slope { distance, way, fallback: Vec3::Z }
        }
    }
}

/// The object's centre \[m\], world.
pub fn centre(object: &ObjectShape<'_>) -> Vec3 {
    match *object {
        ObjectShape::HalfSpace => Vec3::ZERO,
        ObjectShape::Box { .. } | ObjectShape::Sphere { .. } | ObjectShape::Ellipsoid { .. } | ObjectShape::Cylinder { .. } => {
            Vec3::Z * (0.5 * object.height())
        }
        ObjectShape::Mesh(mesh) => {
            let (low, high) = mesh.bounds();
            0.5 * (low + high)
        }
    }
}

/// How far the object reaches along the unit vector `n` from its centre \[m\]; without end where that is not known.
pub fn extent(object: &ObjectShape<'_>, n: Vec3) -> f32 {
    match *object {
        ObjectShape::HalfSpace | ObjectShape::Mesh(_) => f32::MAX,
        ObjectShape::Box { size } => (0.5 * size).dot(n.abs()),
        ObjectShape::Sphere { radius } => radius,
        ObjectShape::Ellipsoid { semi_axes } => root((semi_axes * n).length_squared()),
        ObjectShape::Cylinder { radius, height } => radius * root(n.x * n.x + n.y * n.y) + 0.5 * height * n.z.abs(),
    }
}

fn of_sphere(radius: f32, q: Vec3) -> Slope {
    Slope { distance: root(q.length_squared()) - radius, way: q, fallback: Vec3::Z }
}

/// Of the point `q` to a box of half edges `half` about the origin \[m\].
pub fn of_box(half: Vec3, q: Vec3) -> Slope {
    let beyond = q.abs() - half;
    let outside = Vec3::new(max(beyond.x, 0.0), max(beyond.y, 0.0), max(beyond.z, 0.0));
    let sign = Vec3::new(side(q.x), side(q.y), side(q.z));
    if outside == Vec3::ZERO {
        let (depth, weights) = blend(-beyond, half + q.abs());
        return Slope { distance: -depth, way: weights * sign, fallback: Vec3::Z };
    }
    Slope { distance: root(outside.length_squared()), way: outside * sign, fallback: Vec3::Z }
}

/// Inside, the faces share the depth: d = (sum s_i^-4)^(-1/4) of the slacks s_i to them, and the normal is the gradient, weights s_i^-5 (theory.md,
/// equation 2.3). Convex, zero on the surface, off by (d/s)^4/4 under a face, and its normal turns continuously over an edge, where the
/// nearest face alone would make it jump; and in the middle, where the near face of a pair becomes the far one.
fn blend(near: Vec3, far: Vec3) -> (f32, Vec3) {
    let least = min(near.x, min(near.y, near.z));
    if least <= 0.0 {
        let touched = |s: f32| if s <= 0.0 { 1.0 } else { 0.0 };
        return (0.0, Vec3::new(touched(near.x), touched(near.y), touched(near.z)));
    }
    let (near, far) = (Vec3::splat(least) / near, Vec3::splat(least) / far);
    let fourths = |share: Vec3| (share * share) * (share * share);
    let (nears, fars) = (fourths(near), fourths(far));
    (least / root(root((nears + fars).element_sum())), nears * near - fars * far)
}

fn side(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

fn of_cylinder(radius: f32, half_height: f32, q: Vec3) -> Slope {
    let planar = Vec3::new(q.x, q.y, 0.0);
    let radial = direction(planar, Vec3::X);
    let beyond_side = root(planar.length_squared()) - radius;
    let beyond_end = q.z.abs() - half_height;
    let axial = Vec3::Z * side(q.z);
    if beyond_side <= 0.0 && beyond_end <= 0.0 {
        let far = Vec3::new(beyond_side + 2.0 * radius, half_height + q.z.abs(), f32::MAX);
        let (depth, weights) = blend(Vec3::new(-beyond_side, -beyond_end, f32::MAX), far);
        return Slope { distance: -depth, way: radial * weights.x + axial * weights.y, fallback: axial };
    }
    let outside = radial * max(beyond_side, 0.0) + axial * max(beyond_end, 0.0);
    Slope { distance: root(outside.length_squared()), way: outside, fallback: axial }
}

fn of_ellipsoid(semi_axes: Vec3, q: Vec3) -> Slope {
    let foot = ellipsoid::closest_point(semi_axes, q);
    let offset = q - foot;
    let inside = (q / semi_axes).length_squared() < 1.0;
    let distance = root(offset.length_squared());
    let distance = if inside { -distance } else { distance };
    Slope { distance, way: ellipsoid::gradient(semi_axes, foot), fallback: Vec3::Z }
}

/// Largest depth for which the object's figures mean anything: half its smallest extent \[m\].
pub fn deepest_meaningful(object: &ObjectShape<'_>) -> f32 {
    match *object {
        ObjectShape::HalfSpace => f32::MAX,
        ObjectShape::Box { size } => 0.5 * min(size.x, min(size.y, size.z)),
        ObjectShape::Sphere { radius } => radius,
        ObjectShape::Ellipsoid { semi_axes } => min(semi_axes.x, min(semi_axes.y, semi_axes.z)),
        ObjectShape::Cylinder { radius, height } => min(radius, 0.5 * height),
        ObjectShape::Mesh(mesh) => mesh.grid().inmost(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_distances() {
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let cases = [
            (ObjectShape::HalfSpace, Vec3::new(3.0, 1.0, -0.5), -0.5, Vec3::Z),
            (cube, Vec3::new(0.0, 0.0, 0.11), 0.01, Vec3::Z),
            (cube, Vec3::new(0.01, 0.0, 0.099), -0.001, Vec3::Z),
            (cube, Vec3::new(0.06, 0.0, 0.05), 0.01, Vec3::X),
            (ObjectShape::Sphere { radius: 0.05 }, Vec3::new(0.0, 0.0, 0.12), 0.02, Vec3::Z),
            (ObjectShape::Cylinder { radius: 0.02, height: 0.1 }, Vec3::new(0.0, 0.03, 0.05), 0.01, Vec3::Y),
            (ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) }, Vec3::new(0.0, 0.0, 0.09), 0.01, Vec3::Z),
            (ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) }, Vec3::new(0.059, 0.0, 0.04), -0.001, Vec3::X),
        ];
        for (object, point, distance, normal) in cases {
            let found = gap(&object, point);
            assert!((found.distance - distance).abs() < 1.0e-6, "{object:?} {point} {found:?}");
            assert!((found.normal - normal).length() < 1.0e-4, "{object:?} {point} {found:?}");
        }
    }

    /// A wide flat pressed on a small box rests on the middle of its top: there the normal is the top's, and turns through it without a jump.
    #[test]
    fn the_normal_is_level_over_the_middle_of_a_small_face() {
        let small = ObjectShape::Box { size: Vec3::new(1.0e-3, 1.2e-3, 0.9e-3) };
        let can = ObjectShape::Cylinder { radius: 0.6e-3, height: 0.9e-3 };
        for object in [small, can] {
            for x in [-1.0e-7, 0.0, 1.0e-7] {
                let normal = gap(&object, Vec3::new(x, 0.0, 0.65e-3)).normal;
                assert!((normal - Vec3::Z).length() < 1.0e-3, "{object:?} {x}: {normal}");
            }
        }
    }
}

//! Signed distances with their first and second derivatives: of a ball, and of every object.
//!
//! Across the normal the second derivatives of a distance are the curvature of the surface; under an edge of a box or a cylinder they are
//! those of the blend of its faces (theory.md, equation 2.3).

use glam::{Mat3, Vec3};

use crate::geometry::curvature::{self, Curvature};
use crate::geometry::gap::{self, Gap, gap};
use crate::math::{direction, max, perpendicular, root};
use crate::model::ObjectShape;

/// A distance and its derivatives at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Signed distance \[m\]; negative inside.
    pub value: f32,
    /// Gradient; of length 1 where the distance is smooth, shorter on creases.
    pub gradient: Vec3,
    /// Second derivatives \[1/m\]: on a smooth surface its curvature in the tangent plane.
    pub hessian: Mat3,
}

impl Field {
    /// A half space with outward unit normal `n` whose surface holds `foot` \[m\].
    pub fn flat(foot: Vec3, n: Vec3, q: Vec3) -> Self {
        Self { value: (q - foot).dot(n), gradient: n, hessian: Mat3::ZERO }
    }
}

/// Second derivatives of a distance along two unit vectors.
pub fn form(field: &Field, e1: Vec3, e2: Vec3) -> Curvature {
    let (h1, h2) = (field.hessian * e1, field.hessian * e2);
    Curvature { k11: h1.dot(e1), k12: h1.dot(e2), k22: h2.dot(e2) }
}

/// Distance to the ball of `radius` \[m\] about `centre` \[m\].
pub fn ball(centre: Vec3, radius: f32, q: Vec3) -> Field {
    let off = q - centre;
    let distance = root(off.length_squared());
    let n = direction(off, Vec3::Z);
    // at the centre every direction is the nearest
    let bend = 1.0 / max(distance, SMALLEST_DISTANCE);
    Field { value: distance - radius, gradient: n, hessian: (Mat3::IDENTITY - outer(n, n)) * bend }
}

/// Keeps the curvature at a centre finite \[m\]: a thousandth of the smallest length of a scene.
const SMALLEST_DISTANCE: f32 = 1.0e-9;

/// Distance from the world point `p_wq` \[m\] to the object.
pub fn of_object(object: &ObjectShape<'_>, p_wq: Vec3) -> Field {
    if let ObjectShape::Mesh(mesh) = object {
        return mesh.grid().field(p_wq);
    }
    let Gap { distance, normal } = gap(object, p_wq);
    let hessian = match *object {
        ObjectShape::Box { size } => blended(0.5 * size - (p_wq - gap::centre(object)).abs(), normal),
        ObjectShape::Cylinder { radius, height } => of_cylinder(radius, 0.5 * height, p_wq - gap::centre(object), normal),
        _ => spread(&curvature::of_object(object, p_wq, normal, tangent(normal), normal.cross(tangent(normal))), normal),
    };
    Field { value: distance, gradient: normal, hessian }
}

fn tangent(n: Vec3) -> Vec3 {
    perpendicular(n)
}

/// The symmetric map of a curvature in the tangent plane of `n`.
fn spread(k: &Curvature, n: Vec3) -> Mat3 {
    let e1 = tangent(n);
    let e2 = n.cross(e1);
    outer(e1, e1 * k.k11 + e2 * k.k12) + outer(e2, e1 * k.k12 + e2 * k.k22)
}

/// A cylinder inside: the blend of end and side, and the side's own curvature by its share. Outside, the side's or none.
fn of_cylinder(radius: f32, half_height: f32, q: Vec3, normal: Vec3) -> Mat3 {
    let planar = Vec3::new(q.x, q.y, 0.0);
    let (out, r) = (direction(planar, Vec3::X), root(planar.length_squared()));
    let hoop = out.cross(Vec3::Z);
    let bent = outer(hoop, hoop) * (out.dot(normal) / max(r, SMALLEST_DISTANCE));
    let (side, end) = (radius - r, half_height - q.z.abs());
    if side <= 0.0 || end <= 0.0 {
        return bent;
    }
    // the blend of two faces, in the plane of the axis
    let turned = blended(Vec3::new(side, f32::MAX, end), Vec3::new(1.0, 1.0, normal.z));
    let (xx, xz, zz) = (turned.x_axis.x, turned.x_axis.z, turned.z_axis.z);
    bent + outer(out, out * xx + Vec3::Z * xz) + outer(Vec3::Z, out * xz + Vec3::Z * zz)
}

/// Second derivatives of -(sum s_i^-4)^(-1/4) for the slacks `s` to the faces of a box: 5 [diag(w_i/s_i) - w w/d] across the faces.
fn blended(s: Vec3, normal: Vec3) -> Mat3 {
    if s.min_element() <= 0.0 {
        return Mat3::ZERO;
    }
    let inverse = Vec3::ONE / s;
    let squares = inverse * inverse;
    let depth = 1.0 / root(root((squares * squares).element_sum()));
    let share = inverse * depth;
    let w = share * share * share * share * share;
    let signed = Vec3::new(sign(normal.x), sign(normal.y), sign(normal.z)) * w;
    (Mat3::from_diagonal(w * inverse) - outer(signed, signed) * (1.0 / depth)) * 5.0
}

fn sign(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// The matrix u v^T.
fn outer(u: Vec3, v: Vec3) -> Mat3 {
    Mat3::from_cols(u * v.x, u * v.y, u * v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_derivatives_are_differences_of_the_gap() {
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let ball = ObjectShape::Sphere { radius: 0.05 };
        let cases = [
            (cube, Vec3::new(0.045, 0.01, 0.096)),
            (cube, Vec3::new(-0.044, 0.043, 0.094)),
            (ball, Vec3::new(0.02, 0.01, 0.095)),
        ];
        for (object, q) in cases {
            let here = of_object(&object, q);
            for e in [Vec3::X, Vec3::Y, Vec3::Z] {
                let h = 1.0e-4;
                let [ahead, behind] = [q + e * h, q - e * h].map(|q| {
                    // the blend's gradient before it is made a unit vector
                    let d = |e: Vec3| (gap(&object, q + e * h).distance - gap(&object, q - e * h).distance) / (2.0 * h);
                    Vec3::new(d(Vec3::X), d(Vec3::Y), d(Vec3::Z))
                });
                let expected = (ahead - behind) / (2.0 * h);
                assert!((here.hessian * e - expected).length() < 5.0, "{object:?} {q} {e}: {} {expected}", here.hessian * e);
            }
        }
    }
}

//! Curvature of smooth surfaces, as a symmetric form on the tangent plane.

use glam::Vec3;

use crate::geometry::distance_grid::DistanceGrid;
use crate::math::{max, root};
use crate::model::ObjectShape;

/// Second fundamental form in a tangent basis (e1, e2) \[1/m\]; positive = convex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curvature {
    /// Along e1.
    pub k11: f32,
    /// Mixed.
    pub k12: f32,
    /// Along e2.
    pub k22: f32,
}

impl Curvature {
    /// The same in every direction.
    pub const fn isotropic(k: f32) -> Self {
        Self { k11: k, k12: 0.0, k22: k }
    }

    /// Sum of two bodies' curvatures: what the contact feels.
    pub fn plus(self, other: Self) -> Self {
        Self { k11: self.k11 + other.k11, k12: self.k12 + other.k12, k22: self.k22 + other.k22 }
    }

    /// Mean of the two principal curvatures \[1/m\].
    pub fn mean(self) -> f32 {
        0.5 * (self.k11 + self.k22)
    }

    /// The same form with hollow directions made flat.
    pub fn convex(self) -> Self {
        let (large, small) = self.principal();
        if small >= 0.0 {
            return self;
        }
        // hollow all round, perhaps alike in every direction: no direction is left to scale
        if large <= 0.0 {
            return Self::default();
        }
        // the form less its mean, scaled and lifted so that the principal values become large and 0
        let scale = large / (large - small);
        let mean = self.mean();
        let lifted = |k: f32| 0.5 * large + (k - mean) * scale;
        Self { k11: lifted(self.k11), k12: self.k12 * scale, k22: lifted(self.k22) }
    }

    /// Principal curvatures, larger first \[1/m\].
    pub fn principal(self) -> (f32, f32) {
        let half_difference = 0.5 * (self.k11 - self.k22);
        let spread = root(half_difference * half_difference + self.k12 * self.k12);
        (self.mean() + spread, self.mean() - spread)
    }
}

/// Curvature of an ellipsoid of `semi_axes` where its outward normal is `n`, in the basis (e1, e2); all in the ellipsoid's frame.
///
/// The surface is F(x) = sum (x_i/a_i)^2 = 1, so that the form is u . diag(1/a^2) . v / |grad F / 2| (theory.md, section 2).
pub fn of_ellipsoid(semi_axes: Vec3, n: Vec3, e1: Vec3, e2: Vec3) -> Curvature {
    let squares = semi_axes * semi_axes;
    // the point with normal n is a_i^2 n_i / h with the support width h = sqrt(sum a_i^2 n_i^2); |grad F / 2| = 1 / h
    let width = root((squares * n * n).element_sum());
    let form = |u: Vec3, v: Vec3| width * (u * v / squares).element_sum();
    Curvature { k11: form(e1, e1), k12: form(e1, e2), k22: form(e2, e2) }
}

/// Curvature of the object's surface where its outward normal is `n`, closest to the world point `p_wq`.
pub fn of_object(object: &ObjectShape<'_>, p_wq: Vec3, n: Vec3, e1: Vec3, e2: Vec3) -> Curvature {
    match *object {
        ObjectShape::HalfSpace | ObjectShape::Box { .. } => Curvature::default(),
        ObjectShape::Sphere { radius } => Curvature::isotropic(1.0 / radius),
        ObjectShape::Ellipsoid { semi_axes } => of_ellipsoid(semi_axes, n, e1, e2),
        ObjectShape::Cylinder { radius, .. } => of_cylinder(radius, n, e1, e2),
        ObjectShape::Mesh(mesh) => of_mesh(mesh.grid(), p_wq, n, e1, e2),
    }
}

/// Shortest and usual distance over which a mesh's normals are compared: in spacings of its grid, and in radii of the contact that the depth
/// makes on a ball as thick as the object. Below it facets and rounded edges would count as curvature, above it edges would be felt too early.
const SHORTEST_REACH: f32 = 1.5;
const CONTACT_SHARE: f32 = 0.5;

/// Curvature of a distance's surface about `q`: how the normals turn across the contact. Convex, or none: a hollow is felt as flat.
fn of_mesh(grid: &DistanceGrid<'_>, q: Vec3, n: Vec3, e1: Vec3, e2: Vec3) -> Curvature {
    let (value, _) = grid.slope(q);
    let reach = max(SHORTEST_REACH * grid.spacing(), CONTACT_SHARE * root(grid.inmost() * max(-value, 0.0)));
    let middle = q - n * value;
    let turn = |e: Vec3| (grid.slope(middle + e * reach).1 - grid.slope(middle - e * reach).1) / (2.0 * reach);
    let (along, across) = (turn(e1), turn(e2));
    Curvature { k11: along.dot(e1), k12: 0.5 * (along.dot(e2) + across.dot(e1)), k22: across.dot(e2) }.convex()
}

/// Curvature of an upright cylinder where its outward normal is `n`: that of the hoop (Meusnier), all of it on the side, none on an end, and between the two at the rim.
fn of_cylinder(radius: f32, n: Vec3, e1: Vec3, e2: Vec3) -> Curvature {
    let hoop = Vec3::new(-n.y, n.x, 0.0);
    let level = root(hoop.length_squared());
    if level <= END {
        return Curvature::default();
    }
    // the form takes the hoop's length twice, the curvature goes with its length once
    let k = (level - END) / (level * level * radius);
    let (c1, c2) = (hoop.dot(e1), hoop.dot(e2));
    Curvature { k11: k * c1 * c1, k12: k * c1 * c2, k22: k * c2 * c2 }
}

/// Sine of a normal's angle with the axis below which it is an end's.
const END: f32 = 1.0e-3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hollows_are_flat() {
        let hollow = |k11, k12, k22| Curvature { k11, k12, k22 }.convex();
        assert_eq!(hollow(-3.0, 0.0, -3.0), Curvature::default());
        assert_eq!(hollow(-3.0, 1.0, -2.0), Curvature::default());
        assert_eq!(hollow(4.0, 0.0, -2.0), Curvature { k11: 4.0, k12: 0.0, k22: 0.0 });
    }

    #[test]
    fn ellipsoid_top_and_flank() {
        let a = Vec3::new(0.06, 0.05, 0.04);
        let top = of_ellipsoid(a, Vec3::Z, Vec3::X, Vec3::Y);
        assert!((1.0 / top.k11 - 0.09).abs() < 1.0e-6 && (1.0 / top.k22 - 0.0625).abs() < 1.0e-6);
        let flank = of_ellipsoid(a, Vec3::X, Vec3::Y, Vec3::Z);
        assert!((1.0 / flank.k11 - 0.0025 / 0.06).abs() < 1.0e-6);
    }

    #[test]
    fn principal_curvatures_do_not_depend_on_the_basis() {
        let a = Vec3::new(0.06, 0.05, 0.04);
        let n = Vec3::new(0.48, 0.6, 0.64);
        let e1 = crate::math::perpendicular(n);
        let e2 = n.cross(e1);
        let turned = of_ellipsoid(a, n, e1 * 0.6 + e2 * 0.8, e2 * 0.6 - e1 * 0.8).principal();
        let straight = of_ellipsoid(a, n, e1, e2).principal();
        assert!((turned.0 - straight.0).abs() < 1.0e-3 && (turned.1 - straight.1).abs() < 1.0e-3);
    }

    /// Both ends are flat, whatever the rounding of their normals; from the side to an end the curvature falls without a step.
    #[test]
    fn a_cylinder_is_curved_about_its_side_only() {
        let can = ObjectShape::Cylinder { radius: 0.02, height: 0.03 };
        let steepest = |n: Vec3, z: f32| {
            let e1 = crate::math::perpendicular(n);
            of_object(&can, Vec3::new(0.015, 0.0, z), n, e1, n.cross(e1)).principal().0
        };
        for lean in [0.0, 1.0e-23, 1.0e-7] {
            assert_eq!(steepest(Vec3::new(lean, lean, -1.0), 0.0), 0.0, "{lean}");
            assert_eq!(steepest(Vec3::new(lean, lean, 1.0), 0.03), 0.0, "{lean}");
        }
        let mut last = 1.0 / 0.02;
        for i in 0..=1570 {
            let (sin, cos) = (libm::sinf(i as f32 * 1.0e-3), libm::cosf(i as f32 * 1.0e-3));
            let k = steepest(Vec3::new(cos, 0.0, sin), 0.03);
            assert!((k - last).abs() < 0.1, "{i}: {last} {k}");
            last = k;
        }
    }
}

//! Volume, mass centre and inertia of the solid that a mesh encloses.
//!
//! Divergence theorem, triangle by triangle: each triangle and the origin span a tetrahedron of signed volume
//! v = det(a, b, c) / 6, whose second moments about the origin are v/20 (s s^T + a a^T + b b^T + c c^T) with s = a + b + c
//! (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor", 2004). The sums are taken about the middle of the
//! bounds, so that a mesh far from the origin loses no digits.

use glam::{DMat3, DVec3};

use crate::mesh::Mesh;

/// What a homogeneous solid weighs and how it resists turning, for density 1 kg/m^3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Properties {
    /// Volume \[m^3\]; multiply by the density for the mass.
    pub volume: f64,
    /// Mass centre \[m\].
    pub centre: DVec3,
    /// Inertia about the mass centre, axes of the mesh \[m^5\]; multiply by the density for kg m^2.
    pub inertia: DMat3,
}

/// Properties of a closed mesh; `None` when it encloses no volume.
pub fn properties(mesh: &Mesh) -> Option<Properties> {
    let (low, high) = mesh.bounds()?;
    let origin = (low + high) / 2.0;
    let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for &triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - origin);
        let (v, s) = (tetrahedron(a, b, c), a + b + c);
        volume += v;
        first += v / 4.0 * s;
        second += (outer(s) + outer(a) + outer(b) + outer(c)) * (v / 20.0);
    }
    // a flat or open patch leaves rounding noise: less than one part in 1e12 of its bounds is no volume
    if volume.abs() <= 1.0e-12 * (high - low).length().powi(3) {
        return None;
    }
    let centre = first / volume;
    let central = second - outer(centre) * volume;
    let inertia = DMat3::from_diagonal(DVec3::splat(trace(central))) - central;
    Some(Properties { volume, centre: centre + origin, inertia })
}

/// Signed volume of the tetrahedron that a triangle spans with the origin \[m^3\].
pub(crate) fn tetrahedron(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    a.dot(b.cross(c)) / 6.0
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

fn trace(m: DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::tessellate;

    #[test]
    fn a_box_far_away_gives_its_closed_forms() {
        let (size, place) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(700.0, -50.0, 3.0));
        let found = properties(&tessellate::cuboid(size).mapped(|v| v + place)).unwrap();
        let volume = size.x * size.y * size.z;
        assert!((found.volume / volume - 1.0).abs() < 1e-9);
        assert!(found.centre.distance(place) < 1e-9);
        let expected = volume / 12.0 * (size.y * size.y + size.z * size.z);
        assert!((found.inertia.x_axis.x / expected - 1.0).abs() < 1e-9);
        assert!(found.inertia.x_axis.y.abs() < 1e-9 * expected);
    }

    #[test]
    fn a_fine_ball_comes_near_its_closed_forms() {
        let found = properties(&tessellate::ellipsoid(DVec3::splat(0.02), 96)).unwrap();
        let volume = 4.0 / 3.0 * PI * 0.02_f64.powi(3);
        assert!((found.volume / volume - 1.0).abs() < 2e-3);
        assert!((found.inertia.z_axis.z / (0.4 * volume * 4e-4) - 1.0).abs() < 4e-3);
    }

    #[test]
    fn a_cone_has_its_centre_three_quarters_above_the_tip() {
        let found = properties(&tessellate::cone(0.01, 0.04, 64)).unwrap();
        assert!(found.centre.length() < 1e-9, "{}", found.centre);
    }

    #[test]
    fn nothing_encloses_nothing() {
        assert_eq!(properties(&Mesh::default()), None);
        let flat = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]] };
        assert_eq!(properties(&flat), None);
    }
}

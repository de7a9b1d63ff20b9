//! Triangles for the primitives of a scene, closed and outside out, about the same origins as in the scene file.
//!
//! Round bodies are turned from a profile: rings of points (radius, height), first and last on the axis. `sides` is the number
//! of points on each ring.

use std::f64::consts::PI;

use glam::DVec3;

use crate::mesh::Mesh;

/// Fewest sides of a ring: below it a turned body has no inside.
pub const MIN_SIDES: u32 = 3;

/// Box of edges `size` \[m\] about the origin.
pub fn cuboid(size: DVec3) -> Mesh {
    let corner = |k: u32| {
        let sign = |bit: u32| if k >> bit & 1 == 1 { 0.5 } else { -0.5 };
        DVec3::new(sign(0), sign(1), sign(2)) * size
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// Ellipsoid of the given semi-axes \[m\] about the origin; a ball when they are equal.
pub fn ellipsoid(semi_axes: DVec3, sides: u32) -> Mesh {
    let rings = (sides / 2).max(2);
    let angles = (0..=rings).map(|k| PI * f64::from(k) / f64::from(rings));
    let profile: Vec<_> = angles.map(|angle| (angle.sin(), -angle.cos())).collect();
    turned(&profile, sides).mapped(|v| v * semi_axes)
}

/// Cylinder about the origin, axis z \[m\].
pub fn cylinder(radius: f64, height: f64, sides: u32) -> Mesh {
    let (low, high) = (-height / 2.0, height / 2.0);
    turned(&[(0.0, low), (radius, low), (radius, high), (0.0, high)], sides)
}

/// Cone with its tip towards -z; the origin is its mass centre, 3/4 of the height above the tip \[m\].
pub fn cone(radius: f64, height: f64, sides: u32) -> Mesh {
    let top = height / 4.0;
    turned(&[(0.0, top - height), (radius, top), (0.0, top)], sides)
}

/// Capsule about the origin, axis z; `height` is the straight part's \[m\].
pub fn capsule(radius: f64, height: f64, sides: u32) -> Mesh {
    let rings = (sides / 4).max(2);
    let arc = |from: f64, middle: f64| {
        (0..=rings).map(move |k| {
            let angle = from + PI / 2.0 * f64::from(k) / f64::from(rings);
            (radius * angle.cos(), middle + radius * angle.sin())
        })
    };
    let profile: Vec<_> = arc(-PI / 2.0, -height / 2.0).chain(arc(0.0, height / 2.0)).collect();
    turned(&profile, sides)
}

/// Turns a profile of (radius, height), from the lowest point up, about z; first and last are poles.
fn turned(profile: &[(f64, f64)], sides: u32) -> Mesh {
    let sides = sides.max(MIN_SIDES);
    let Some(last) = (profile.len() as u32).checked_sub(1) else { return Mesh::default() };
    loft(last, sides, |ring, side| {
        let (radius, z) = profile[ring as usize];
        let angle = 2.0 * PI * f64::from(side) / f64::from(sides);
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    })
}

/// Joins rings 0 to `last` of `sides` points each, at least [`MIN_SIDES`], counter-clockwise seen from beyond the last; the first and the last ring are poles of one
/// point. Fewer than two steps enclose nothing.
pub(crate) fn loft(last: u32, sides: u32, point: impl Fn(u32, u32) -> DVec3) -> Mesh {
    if last < 2 {
        return Mesh::default();
    }
    let point = &point;
    let mut vertices: Vec<_> = (1..last).flat_map(|ring| (0..sides).map(move |side| point(ring, side))).collect();
    let (bottom, top) = (vertices.len() as u32, vertices.len() as u32 + 1);
    vertices.extend([point(0, 0), point(last, 0)]);
    let mut triangles = Vec::new();
    let highest = (last - 2) * sides;
    for k in 0..sides {
        let next = (k + 1) % sides;
        triangles.push([bottom, next, k]);
        triangles.push([top, highest + k, highest + next]);
        for ring in (0..highest).step_by(sides as usize) {
            let (a, b, c, d) = (ring + k, ring + next, ring + sides + next, ring + sides + k);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{check, properties};

    #[test]
    fn every_primitive_is_a_solid_of_about_its_volume() {
        let (r, h) = (0.02_f64, 0.05_f64);
        let ball = 4.0 / 3.0 * PI * r.powi(3);
        let table = [
            ("box", cuboid(DVec3::new(0.1, 0.2, 0.3)), 0.006),
            ("ball", ellipsoid(DVec3::splat(r), 64), ball),
            ("ellipsoid", ellipsoid(DVec3::new(r, 2.0 * r, 3.0 * r), 64), 6.0 * ball),
            ("cylinder", cylinder(r, h, 64), PI * r * r * h),
            ("cone", cone(r, h, 64), PI * r * r * h / 3.0),
            ("capsule", capsule(r, h, 64), PI * r * r * h + ball),
        ];
        for (name, mesh, volume) in table {
            let findings = check(&mesh);
            assert!(findings.is_solid() && findings.pieces == 1, "{name}: {findings:?}");
            let found = properties(&mesh).unwrap();
            assert!((found.volume / volume - 1.0).abs() < 0.01, "{name}: {} m^3, closed form {volume}", found.volume);
            assert!(found.centre.length() < 1e-9, "{name}: centre {}", found.centre);
        }
    }

    #[test]
    fn too_few_sides_still_make_a_solid() {
        assert!(check(&cylinder(1.0, 1.0, 0)).is_solid());
        assert!(check(&ellipsoid(DVec3::ONE, 0)).is_solid());
    }
}

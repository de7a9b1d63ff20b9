//! The farthest point of a convex probe part in a direction, and the closest point of a part to a point.
//!
//! Both work in the part's own frame.

use glam::Vec3;

use crate::geometry::align::align;
use crate::geometry::ellipsoid;
use crate::geometry::field::{Field, ball};
use crate::math::{clamp, clamp_to_box, direction, min, root};
use crate::mesh_shape::MeshShape;
use crate::model::ProbeShape;

/// Farthest point of the shape along `d` (any length) \[m\].
pub fn support(shape: &ProbeShape<'_>, d: Vec3) -> Vec3 {
    match *shape {
        ProbeShape::Sphere { radius } => direction(d, Vec3::Z) * radius,
        ProbeShape::Box { size } => 0.5 * size * signs(d),
        ProbeShape::Ellipsoid { semi_axes } => {
            let scaled = semi_axes * d;
            semi_axes * direction(scaled, Vec3::Z)
        }
        ProbeShape::Cylinder { radius, height } => rim(d, radius) + Vec3::Z * (0.5 * height * side(d.z)),
        ProbeShape::Capsule { radius, height } => direction(d, Vec3::Z) * radius + Vec3::Z * (0.5 * height * side(d.z)),
        ProbeShape::Cone { radius, height } => {
            let tip = Vec3::Z * (-0.75 * height);
            let base = rim(d, radius) + Vec3::Z * (0.25 * height);
            if tip.dot(d) >= base.dot(d) { tip } else { base }
        }
        ProbeShape::Mesh(mesh) => support_of_mesh(&mesh, d),
    }
}

/// Samples that are asked for the farthest: a sixteenth of a ball's radius apart, near enough for the refinement to start.
pub(crate) const ASKED_SAMPLES: usize = 256;

/// Farthest of a prefix of the samples along `d` \[m\].
pub fn farthest_sample(mesh: &MeshShape<'_>, d: Vec3) -> Vec3 {
    let mut best = (f32::MIN, Vec3::ZERO);
    for sample in mesh.samples().iter().take(ASKED_SAMPLES) {
        let along = sample.position.dot(d);
        if along > best.0 {
            best = (along, sample.position);
        }
    }
    best.1
}

fn support_of_mesh(mesh: &MeshShape<'_>, d: Vec3) -> Vec3 {
    let n = direction(d, Vec3::Z);
    let start = farthest_sample(mesh, n);
    align(|q| Field::flat(Vec3::ZERO, -n, q), |q| mesh.grid().field(q), start, mesh.reach())
}

/// Closest point of a mesh to an outer point: where the normal points at it.
fn closest_of_mesh(mesh: &MeshShape<'_>, q: Vec3) -> Vec3 {
    if mesh.grid().slope(q).0 <= 0.0 {
        return q;
    }
    let start = farthest_sample(mesh, q);
    align(|p| ball(q, 0.0, p), |p| mesh.grid().field(p), start, mesh.reach())
}

fn rim(d: Vec3, radius: f32) -> Vec3 {
    direction(Vec3::new(d.x, d.y, 0.0), Vec3::ZERO) * radius
}

fn side(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

fn signs(d: Vec3) -> Vec3 {
    Vec3::new(side(d.x), side(d.y), side(d.z))
}

/// Closest point of the solid shape to `q`; `q` itself when it lies inside.
pub fn closest(shape: &ProbeShape<'_>, q: Vec3) -> Vec3 {
    match *shape {
        ProbeShape::Sphere { radius } => within(q, radius),
        ProbeShape::Box { size } => clamp_to_box(q, 0.5 * size),
        ProbeShape::Ellipsoid { semi_axes } => {
            if (q / semi_axes).length_squared() <= 1.0 {
                q
            } else {
                ellipsoid::closest_point(semi_axes, q)
            }
        }
        ProbeShape::Cylinder { radius, height } => {
            let planar = within(Vec3::new(q.x, q.y, 0.0), radius);
            planar + Vec3::Z * clamp(q.z, -0.5 * height, 0.5 * height)
        }
        ProbeShape::Capsule { radius, height } => {
            let axis = Vec3::Z * clamp(q.z, -0.5 * height, 0.5 * height);
            axis + within(q - axis, radius)
        }
        ProbeShape::Cone { radius, height } => closest_cone(q, radius, height),
        ProbeShape::Mesh(mesh) => closest_of_mesh(&mesh, q),
    }
}

fn within(q: Vec3, radius: f32) -> Vec3 {
    let length = root(q.length_squared());
    if length <= radius { q } else { q * (radius / length) }
}

/// Closest point of the solid cone, in its meridian half plane: the triangle tip, base centre, base rim.
fn closest_cone(q: Vec3, radius: f32, height: f32) -> Vec3 {
    let planar = Vec3::new(q.x, q.y, 0.0);
    let out = direction(planar, Vec3::X);
    let r = root(planar.length_squared());
    let above_tip = q.z + 0.75 * height;
    let allowed = clamp(above_tip, 0.0, height) * radius / height;
    if r <= allowed && above_tip >= 0.0 {
        return out * r + Vec3::Z * (clamp(above_tip, 0.0, height) - 0.75 * height);
    }
    // above the base the base disc is nearest unless the point lies beyond the rim's normal wedge
    if above_tip >= height && r <= radius {
        return out * r + Vec3::Z * (0.25 * height);
    }
    let slant2 = radius * radius + height * height;
    let along = clamp((r * radius + above_tip * height) / slant2, 0.0, 1.0);
    out * (along * radius) + Vec3::Z * (along * height - 0.75 * height)
}

/// Radius of a ball about the part's origin that holds the shape \[m\].
pub fn reach(shape: &ProbeShape<'_>) -> f32 {
    match *shape {
        ProbeShape::Sphere { radius } => radius,
        ProbeShape::Box { size } => 0.5 * root(size.length_squared()),
        ProbeShape::Ellipsoid { semi_axes } => semi_axes.max_element(),
        ProbeShape::Cylinder { radius, height } => root(radius * radius + 0.25 * height * height),
        ProbeShape::Capsule { radius, height } => radius + 0.5 * height,
        ProbeShape::Cone { radius, height } => {
            let base = root(radius * radius + 0.0625 * height * height);
            if base > 0.75 * height { base } else { 0.75 * height }
        }
        ProbeShape::Mesh(mesh) => mesh.reach(),
    }
}

/// Half the smallest extent of the shape: depths beyond it mean nothing \[m\].
pub fn half_thickness(shape: &ProbeShape<'_>) -> f32 {
    match *shape {
        ProbeShape::Sphere { radius } | ProbeShape::Capsule { radius, .. } => radius,
        ProbeShape::Box { size } => 0.5 * size.min_element(),
        ProbeShape::Ellipsoid { semi_axes } => semi_axes.min_element(),
        ProbeShape::Cylinder { radius, height } | ProbeShape::Cone { radius, height } => min(radius, 0.5 * height),
        ProbeShape::Mesh(mesh) => mesh.grid().inmost(),
    }
}

/// Radius of the widest disc a contact of the shape can cover \[m\].
pub fn widest_disc(shape: &ProbeShape<'_>) -> f32 {
    match *shape {
        ProbeShape::Sphere { radius } => radius,
        ProbeShape::Ellipsoid { semi_axes: a } => root(a.x * a.y * a.z / a.min_element()),
        ProbeShape::Box { .. } | ProbeShape::Cylinder { .. } | ProbeShape::Cone { .. } | ProbeShape::Capsule { .. } => {
            reach(shape)
        }
        ProbeShape::Mesh(mesh) => mesh.widest_disc(),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One of every primitive.
    pub(in crate::geometry) const SHAPES: [ProbeShape<'_>; 6] = [
        ProbeShape::Sphere { radius: 0.02 },
        ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.01) },
        ProbeShape::Cylinder { radius: 0.01, height: 0.04 },
        ProbeShape::Cone { radius: 0.01, height: 0.03 },
        ProbeShape::Capsule { radius: 0.005, height: 0.03 },
        ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.01, 0.02, 0.03) },
    ];

    fn directions() -> impl Iterator<Item = Vec3> {
        (0..60).map(|i| {
            let f = i as f32;
            Vec3::new(libm::sinf(f * 1.1), libm::sinf(f * 2.3), libm::cosf(f * 0.7))
        })
    }

    #[test]
    fn support_points_are_farthest_and_inside() {
        for shape in SHAPES {
            for d in directions() {
                let s = support(&shape, d);
                assert!((closest(&shape, s) - s).length() < 1.0e-6, "{shape:?} {d} {s}");
                for other in directions() {
                    assert!(support(&shape, other).dot(d) <= s.dot(d) + 1.0e-6, "{shape:?} {d}");
                }
                assert!(s.length() <= reach(&shape) * 1.0001);
            }
        }
    }

    #[test]
    fn closest_points_obey_the_variational_inequality() {
        for shape in SHAPES {
            for d in directions() {
                let q = d * 0.08;
                let c = closest(&shape, q);
                let n = q - c;
                assert!(support(&shape, n).dot(n) <= c.dot(n) + 1.0e-7, "{shape:?} {q} {c}");
            }
        }
    }
}

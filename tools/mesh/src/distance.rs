//! Exact signed distance from a point to a closed mesh.
//!
//! The nearest point is found in a tree of boxes; the sign is that of the way to the point on the nearest feature's pseudo-normal: a
//! triangle's own, for an edge the sum of its two triangles', for a vertex the sum weighted by the angles (J. A. Baerentzen, H. Aanaes,
//! Signed distance computation using the angle weighted pseudonormal, 2005). Right for every closed, oriented mesh.

use std::collections::HashMap;

use glam::DVec3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TrianglePointLocation};

use crate::mesh::{Mesh, twice_area};

/// A mesh that can be asked for distances.
pub struct Distance {
    tree: TriMesh,
    triangles: Vec<[u32; 3]>,
    faces: Vec<DVec3>,
    edges: HashMap<(u32, u32), DVec3>,
    vertices: Vec<DVec3>,
}

impl std::fmt::Debug for Distance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Distance").field("triangles", &self.triangles.len()).finish_non_exhaustive()
    }
}

/// Nearest point of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The point \[m\].
    pub point: DVec3,
    /// Signed distance to it \[m\]; negative inside.
    pub distance: f64,
    /// Unit pseudo-normal there, outwards.
    pub normal: DVec3,
}

impl Distance {
    /// Prepares a closed, oriented mesh ([`crate::Findings::is_solid`]); `None` for one without triangles.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let points = mesh.vertices.iter().map(|&v| to_tree(v)).collect();
        let tree = TriMesh::new(points, mesh.triangles.clone()).ok()?;
        let faces: Vec<DVec3> = mesh.triangles.iter().map(|&t| twice_area(mesh.corners(t)).normalize_or_zero()).collect();
        let mut edges = HashMap::new();
        let mut vertices = vec![DVec3::ZERO; mesh.vertices.len()];
        for (&triangle, &normal) in mesh.triangles.iter().zip(&faces) {
            let corners = mesh.corners(triangle);
            for i in 0..3 {
                let (here, next, last) = (triangle[i], triangle[(i + 1) % 3], corners[(i + 2) % 3]);
                *edges.entry(key(here, next)).or_insert(DVec3::ZERO) += normal;
                let angle = (corners[(i + 1) % 3] - corners[i]).angle_between(last - corners[i]);
                // a sliver without a normal has no angle either
                vertices[here as usize] += if angle.is_finite() { normal * angle } else { DVec3::ZERO };
            }
        }
        Some(Self { tree, triangles: mesh.triangles.clone(), faces, edges, vertices })
    }

    /// Nearest point of the surface to `q` \[m\].
    pub fn nearest(&self, q: DVec3) -> Nearest {
        let (projection, (triangle, location)) = self.tree.project_local_point_and_get_location(to_tree(q), false);
        let point = DVec3::new(projection.point.x, projection.point.y, projection.point.z);
        let corners = self.triangles[triangle as usize];
        let normal = match location {
            TrianglePointLocation::OnVertex(i) => self.vertices[corners[i as usize] as usize],
            // 0 is the edge from the first corner to the second, 1 second to third, 2 first to third
            TrianglePointLocation::OnEdge(i, _) => {
                let i = i as usize;
                self.edges[&key(corners[i], corners[(i + 1) % 3])]
            }
            TrianglePointLocation::OnFace(..) | TrianglePointLocation::OnSolid => self.faces[triangle as usize],
        };
        let off = q - point;
        let distance = if off.dot(normal) < 0.0 { -off.length() } else { off.length() };
        Nearest { point, distance, normal: normal.normalize_or_zero() }
    }

    /// Signed distance of `q` \[m\].
    pub fn signed(&self, q: DVec3) -> f64 {
        self.nearest(q).distance
    }

    /// Pseudo-normal of a vertex, outwards.
    pub fn vertex_normal(&self, vertex: u32) -> DVec3 {
        self.vertices[vertex as usize].normalize_or_zero()
    }
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

pub(crate) fn to_tree(v: DVec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate;

    #[test]
    fn a_boxs_distances_are_its_closed_forms() {
        let half = DVec3::new(0.05, 0.1, 0.15);
        let distance = Distance::new(&tessellate::cuboid(2.0 * half)).unwrap();
        for i in 0..3000 {
            let f = f64::from(i);
            let q = DVec3::new((f * 0.7).sin(), (f * 1.3).sin(), (f * 2.1).sin()) * 0.25;
            let beyond = q.abs() - half;
            let expected = beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0);
            let found = distance.signed(q);
            assert!((found - expected).abs() < 1e-12, "{q}: {found} {expected}");
        }
        // on the corners' and edges' own rays, where the nearest feature decides the sign
        for direction in [DVec3::ONE, DVec3::new(1.0, -1.0, 1.0), DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, -1.0, -1.0)] {
            assert!(
                distance.signed(direction * half * 1.01) > 0.0 && distance.signed(direction * half * 0.99) < 0.0,
                "{direction}"
            );
        }
    }

    #[test]
    fn a_hollow_corner_keeps_its_signs() {
        // two boxes that share a wall make an L: the inner edge is hollow
        let distance = Distance::new(&crate::convex::ell()).unwrap();
        for (q, inside) in [
            (DVec3::new(0.5, 0.5, 0.5), true),
            (DVec3::new(1.5, 0.5, 0.5), true),
            (DVec3::new(0.5, 1.5, 0.5), true),
            (DVec3::new(1.01, 1.01, 0.5), false),
            (DVec3::new(0.99, 0.99, 0.5), true),
            (DVec3::new(1.5, 1.5, 0.5), false),
        ] {
            assert_eq!(distance.signed(q) < 0.0, inside, "{q}");
        }
    }
}

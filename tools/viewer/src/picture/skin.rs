//! A mesh made ready to be drawn: vertices split along its edges, so that round parts are shaded smooth and edges stay edges.

use glam::Vec3;
use haptor_mesh::Mesh;

use super::batch::{Batch, Colour, Paint};

/// Cosine of the angle between two faces from which on their common edge is seen: 30 degrees.
const EDGE: f64 = 0.866;

/// A mesh as drawn vertices over its own.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Own vertex of each drawn one.
    pub sources: Vec<u32>,
    /// Drawn vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Own vertices at rest \[m\].
    pub rest: Vec<Vec3>,
}

impl Skin {
    /// Prepares a mesh; triangles with a corner that does not exist or is not finite are left out and counted.
    pub fn new(mesh: &Mesh) -> (Self, u32) {
        let rest: Vec<Vec3> = mesh.vertices.iter().map(|v| v.as_vec3()).collect();
        let good = |&&triangle: &&[u32; 3]| {
            triangle.iter().all(|&corner| rest.get(corner as usize).is_some_and(|vertex| vertex.is_finite()))
        };
        let own: Vec<[u32; 3]> = mesh.triangles.iter().filter(good).copied().collect();
        let refused = (mesh.triangles.len() - own.len()) as u32;
        let normals: Vec<_> = own
            .iter()
            .map(|&triangle| {
                let [a, b, c] = mesh.corners(triangle);
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        let mut skin = Self { sources: Vec::new(), triangles: own.clone(), rest };
        for (vertex, around) in corners_around(&own, skin.rest.len()).iter().enumerate() {
            let smooth = |a: usize, b: usize| {
                let (a, b) = (around[a].0, around[b].0);
                normals[a].dot(normals[b]) > EDGE && share_an_edge(own[a], own[b])
            };
            for group in groups(around.len(), smooth) {
                let drawn = skin.sources.len() as u32;
                skin.sources.push(vertex as u32);
                group.iter().for_each(|&k| skin.triangles[around[k].0][around[k].1] = drawn);
            }
        }
        (skin, refused)
    }

    /// The mesh at rest in one colour.
    pub fn batch(&self, colour: Colour, paint: Paint) -> Batch {
        let mut batch = Batch::new(paint);
        batch.triangles.clone_from(&self.triangles);
        batch.positions.extend(self.sources.iter().map(|&source| self.rest[source as usize]));
        batch.colours.resize(self.sources.len(), colour);
        shade(&mut batch);
        batch.touch();
        batch
    }

    /// Puts the vertices of this skin's batch where they have moved to; one whose displacement is not finite stays at rest.
    pub fn place(&self, batch: &mut Batch, moved: Option<&[Vec3]>) {
        let at = |source: usize| match moved.map(|moved| moved[source]) {
            Some(moved) if moved.is_finite() => self.rest[source] + moved,
            _ => self.rest[source],
        };
        batch.positions.iter_mut().zip(&self.sources).for_each(|(position, &source)| *position = at(source as usize));
    }
}

/// Normals of a batch from its triangles, each weighted by its area.
pub fn shade(batch: &mut Batch) {
    batch.normals.clear();
    batch.normals.resize(batch.positions.len(), Vec3::ZERO);
    for &[a, b, c] in &batch.triangles {
        let [p, q, r] = [a, b, c].map(|corner| batch.positions[corner as usize]);
        let normal = (q - p).cross(r - p);
        for corner in [a, b, c] {
            batch.normals[corner as usize] += normal;
        }
    }
    batch.normals.iter_mut().for_each(|normal| *normal = normal.normalize_or(Vec3::Z));
}

/// For each vertex the triangles that meet there, and as which of their corners.
fn corners_around(triangles: &[[u32; 3]], vertices: usize) -> Vec<Vec<(usize, usize)>> {
    let mut around = vec![Vec::new(); vertices];
    for (number, triangle) in triangles.iter().enumerate() {
        triangle.iter().enumerate().for_each(|(corner, &vertex)| around[vertex as usize].push((number, corner)));
    }
    around
}

/// Two corners in common.
fn share_an_edge(a: [u32; 3], b: [u32; 3]) -> bool {
    a.iter().filter(|corner| b.contains(corner)).count() >= 2
}

/// The members 0 to `count`, those that `joined` connects in one group, also by way of others.
fn groups(count: usize, joined: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..count).collect();
    let mut groups = Vec::new();
    while let Some(seed) = left.pop() {
        let mut group = vec![seed];
        let mut next = 0;
        while next < group.len() {
            let member = group[next];
            let (mut near, far) = left.into_iter().partition(|&other| joined(member, other));
            group.append(&mut near);
            left = far;
            next += 1;
        }
        groups.push(group);
    }
    groups
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use haptor_mesh::tessellate;

    use super::*;

    #[test]
    fn edges_stay_edges_and_round_bodies_are_smooth() {
        let table = [
            ("box", tessellate::cuboid(DVec3::ONE), 24),
            ("ball", tessellate::ellipsoid(DVec3::ONE, 32), 15 * 32 + 2),
            // two rims, each of the wall and of a lid, and two middles
            ("cylinder", tessellate::cylinder(1.0, 1.0, 32), 4 * 32 + 2),
        ];
        for (name, mesh, drawn) in table {
            let (skin, refused) = Skin::new(&mesh);
            assert_eq!((skin.sources.len(), skin.triangles.len(), refused), (drawn, mesh.triangles.len(), 0), "{name}");
            let batch = skin.batch([0; 4], Paint::default());
            assert!(batch.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1.0e-5), "{name}");
            if name != "cylinder" {
                let outward = batch.positions.iter().zip(&batch.normals).all(|(p, n)| p.dot(*n) > 0.3);
                assert!(outward, "{name}: normals point out");
            }
        }
    }

    #[test]
    fn broken_triangles_are_left_out_and_counted() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::splat(f64::NAN)];
        let mesh = Mesh { vertices, triangles: vec![[0, 1, 2], [0, 1, 3], [0, 1, 9]] };
        let (skin, refused) = Skin::new(&mesh);
        assert_eq!((skin.triangles.len(), skin.sources.len(), refused), (1, 3, 2));
        assert_eq!(Skin::new(&Mesh::default()).0.triangles.len(), 0);
    }
}

//! Is the mesh the skin of a solid? Counts of what is wrong, so that a message can say how much.

use std::collections::BTreeMap;

use crate::mesh::{Mesh, twice_area};
use crate::properties::signed_volume;

/// Smallest area of a triangle as a share of its longest edge's square: below it the normal is rounding noise in f32.
const SLIVER: f64 = 1.0e-6;

/// What is wrong with a mesh, and its pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// Edges of one triangle only: holes.
    pub boundary_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Edges whose two triangles disagree about which side is outside.
    pub flipped_edges: usize,
    /// Triangles without a usable normal.
    pub slivers: usize,
    /// The triangles agree with each other and enclose a negative volume.
    pub inside_out: bool,
    /// Pieces that share no vertex.
    pub pieces: usize,
}

impl Findings {
    /// No hole, no edge of three, no disagreement, no sliver, outside out.
    pub fn is_solid(&self) -> bool {
        *self == Self { pieces: self.pieces, ..Self::default() }
    }

    /// Closed: every edge has two triangles.
    pub fn is_watertight(&self) -> bool {
        self.boundary_edges == 0 && self.non_manifold_edges == 0
    }

    /// One line for each thing that is wrong, with what to do about it.
    pub fn problems(&self) -> Vec<String> {
        let counted = [
            (self.boundary_edges, "boundary edges: the mesh has holes; close them"),
            (self.non_manifold_edges, "edges of more than two triangles: split the solid there"),
            (self.flipped_edges, "edges whose triangles disagree about the outside: recompute the normals"),
            (self.slivers, "triangles without a usable normal: merge their corners"),
        ];
        let lines = counted.iter().filter(|(count, _)| *count > 0).map(|(count, text)| format!("{count} {text}"));
        let inside_out = self.inside_out.then(|| "the mesh is inside out: flip the normals".to_owned());
        lines.chain(inside_out).collect()
    }
}

/// Checks a mesh whose vertices have been joined ([`crate::weld()`]).
pub fn check(mesh: &Mesh) -> Findings {
    let mut findings = Findings { pieces: pieces(mesh), ..Findings::default() };
    for &(forward, backward) in edges(mesh).values() {
        match (forward, backward) {
            (1, 1) => {}
            (1, 0) | (0, 1) => findings.boundary_edges += 1,
            (2, 0) | (0, 2) => findings.flipped_edges += 1,
            _ => findings.non_manifold_edges += 1,
        }
    }
    findings.slivers = mesh.triangles.iter().filter(|&&triangle| is_sliver(mesh, triangle)).count();
    findings.inside_out = findings.is_watertight() && findings.flipped_edges == 0 && signed_volume(mesh) < 0.0;
    findings
}

/// How often each edge is run from its lower to its higher vertex, and back.
fn edges(mesh: &Mesh) -> BTreeMap<(u32, u32), (usize, usize)> {
    let mut edges = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (forward, backward) = edges.entry((from.min(to), from.max(to))).or_insert((0, 0));
            *(if from < to { forward } else { backward }) += 1;
        }
    }
    edges
}

fn is_sliver(mesh: &Mesh, triangle: [u32; 3]) -> bool {
    let [a, b, c] = mesh.corners(triangle);
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    // written so that a triangle of no length counts as one
    twice_area([a, b, c]).length() <= SLIVER * longest
}

/// Pieces by joining the vertices of each triangle.
fn pieces(mesh: &Mesh) -> usize {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        join(&mut parent, a, b);
        join(&mut parent, b, c);
    }
    let mut roots: Vec<u32> = mesh.triangles.iter().map(|triangle| root(&mut parent, triangle[0])).collect();
    roots.sort_unstable();
    roots.dedup();
    roots.len()
}

fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        // halving the path keeps the walk short
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::tessellate;

    fn cube() -> Mesh {
        tessellate::cuboid(DVec3::ONE)
    }

    #[test]
    fn each_fault_is_counted_by_its_name() {
        let hole = Mesh { triangles: cube().triangles[1..].to_vec(), ..cube() };
        let mut flipped = cube();
        flipped.triangles[0].swap(0, 1);
        let mut inside_out = cube();
        inside_out.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        let mut doubled = cube();
        doubled.triangles.extend_from_within(..2);
        let table = [
            ("cube", cube(), Findings { pieces: 1, ..Findings::default() }),
            ("hole", hole, Findings { boundary_edges: 3, pieces: 1, ..Findings::default() }),
            ("flipped", flipped, Findings { flipped_edges: 3, pieces: 1, ..Findings::default() }),
            ("inside out", inside_out, Findings { inside_out: true, pieces: 1, ..Findings::default() }),
            ("doubled face", doubled, Findings { non_manifold_edges: 5, pieces: 1, ..Findings::default() }),
        ];
        for (name, mesh, expected) in table {
            assert_eq!(check(&mesh), expected, "{name}");
            assert_eq!(expected.is_solid(), expected.problems().is_empty(), "{name}");
        }
    }

    #[test]
    fn a_sliver_is_found_and_two_bodies_are_two_pieces() {
        let sliver = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-9, 0.0)], triangles: vec![[0, 1, 2]] };
        assert_eq!(check(&sliver).slivers, 1);
        let other = cube().mapped(|v| v + 3.0 * DVec3::X);
        let shifted = other.triangles.iter().map(|t| t.map(|index| index + cube().vertices.len() as u32));
        let both = Mesh {
            vertices: [cube().vertices, other.vertices.clone()].concat(),
            triangles: cube().triangles.into_iter().chain(shifted).collect(),
        };
        assert_eq!(check(&both).pieces, 2);
        assert!(check(&both).is_solid());
    }
}

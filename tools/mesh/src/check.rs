//! Is the mesh the skin of a solid? Counts of what is wrong, so that a message can say how much.

use glam::DVec3;

use crate::mesh::{Mesh, twice_area};
use crate::pieces::{self, edges, sides};

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
    /// Pieces whose triangles agree with each other, but not about where the outside is.
    pub inside_out: usize,
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
            (self.inside_out, "pieces are inside out: flip their normals"),
        ];
        counted.iter().filter(|(count, _)| *count > 0).map(|(count, text)| format!("{count} {text}")).collect()
    }
}

/// Checks a mesh whose vertices have been joined ([`crate::weld()`]).
pub fn check(mesh: &Mesh) -> Findings {
    let (labels, pieces) = pieces::label(mesh);
    let mut findings = Findings { pieces, ..Findings::default() };
    let mut sound = vec![true; pieces];
    for edge in edges(&sides(&mesh.triangles)) {
        let forward = edge.iter().filter(|side| side.forward).count();
        match (forward, edge.len() - forward) {
            (1, 1) => continue,
            (1, 0) | (0, 1) => findings.boundary_edges += 1,
            (2, 0) | (0, 2) => findings.flipped_edges += 1,
            _ => findings.non_manifold_edges += 1,
        }
        sound[labels[edge[0].triangle as usize] as usize] = false;
    }
    findings.slivers = mesh.triangles.iter().filter(|&&triangle| is_sliver(mesh, triangle)).count();
    findings.inside_out = pieces::wrong_way(mesh, &labels, &sound).iter().filter(|&&wrong| wrong).count();
    findings
}

pub(crate) fn is_sliver(mesh: &Mesh, triangle: [u32; 3]) -> bool {
    flat(mesh.corners(triangle))
}

/// Has a triangle no usable normal?
pub(crate) fn flat([a, b, c]: [DVec3; 3]) -> bool {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    // written so that a triangle of no length counts as one
    twice_area([a, b, c]).length() <= SLIVER * longest
}

/// Two meshes in one.
#[cfg(test)]
pub(crate) fn joined(one: &Mesh, other: &Mesh) -> Mesh {
    let shifted = other.triangles.iter().map(|t| t.map(|index| index + one.vertices.len() as u32));
    Mesh {
        vertices: [one.vertices.clone(), other.vertices.clone()].concat(),
        triangles: one.triangles.iter().copied().chain(shifted).collect(),
    }
}

#[cfg(test)]
mod tests {
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
            ("inside out", inside_out, Findings { inside_out: 1, pieces: 1, ..Findings::default() }),
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
        let both = joined(&cube(), &other);
        assert_eq!(check(&both).pieces, 2);
        assert!(check(&both).is_solid());
    }

    #[test]
    fn each_piece_faces_its_own_way() {
        let turned = |mesh: Mesh| mesh.mapped(|v| -v);
        let small = cube().mapped(|v| 0.5 * v);
        let aside = cube().mapped(|v| v + 3.0 * DVec3::X);
        let table =
            [("a hollow cube", small.clone(), turned(small.clone()), 1, 0), ("two cubes", aside.clone(), turned(aside), 0, 1)];
        for (name, outwards, inwards, wrong_outwards, wrong_inwards) in table {
            assert_eq!(check(&joined(&cube(), &outwards)).inside_out, wrong_outwards, "{name}");
            assert_eq!(check(&joined(&cube(), &inwards)).inside_out, wrong_inwards, "{name}");
        }
    }
}

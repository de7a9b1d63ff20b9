//! Joins vertices that lie within a tolerance of each other and drops the triangles that this collapses.
//!
//! STL files name each corner anew, so neighbours agree only up to rounding, and -0 differs from 0 bit by bit. Cells of a grid, some
//! tolerances wide, hold the vertices kept so far; a vertex joins the first kept one found in its own cell or in those that its tolerance reaches.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::{DVec3, I64Vec3};

use crate::mesh::Mesh;

/// Tolerance that [`weld`] uses when none is given, as a share of the mesh's diagonal: some ten roundings of an f32 coordinate.
pub const DEFAULT_TOLERANCE: f64 = 1.0e-6;

/// Width of a cell in tolerances: few vertices lie so near a wall that the next cell must be asked too.
const WIDTH: f64 = 16.0;

/// Joins vertices closer than `tolerance` \[m\]; `None` takes [`DEFAULT_TOLERANCE`] of the diagonal. Vertices of no triangle are dropped.
#[must_use]
pub fn weld(mesh: &Mesh, tolerance: Option<f64>) -> Mesh {
    let Some((low, high)) = mesh.bounds() else {
        return Mesh::default();
    };
    let tolerance = tolerance.unwrap_or((high - low).length() * DEFAULT_TOLERANCE).max(f64::MIN_POSITIVE);
    let mut grid = Grid { tolerance, low, newest: HashMap::default(), older: Vec::new(), kept: Vec::new() };
    let mut joined = vec![NONE; mesh.vertices.len()];
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    for triangle in &mesh.triangles {
        for &corner in triangle {
            if joined[corner as usize] == NONE {
                joined[corner as usize] = grid.place(mesh.vertices[corner as usize]);
            }
        }
        let [a, b, c] = triangle.map(|corner| joined[corner as usize]);
        if a != b && b != c && c != a {
            triangles.push([a, b, c]);
        }
    }
    Mesh { vertices: grid.kept, triangles }
}

/// No vertex: the limits of [`mod@crate::load`] keep indices far below.
const NONE: u32 = u32::MAX;

struct Grid {
    tolerance: f64,
    low: DVec3,
    /// The vertex kept last of those whose cell has this number; different cells may share one, which costs time only.
    newest: HashMap<u64, u32, BuildHasherDefault<Mixed>>,
    /// For each kept vertex the one kept before it in its cell, or [`NONE`].
    older: Vec<u32>,
    kept: Vec<DVec3>,
}

impl Grid {
    /// Index of the kept vertex that `vertex` joins, or of itself, now kept.
    fn place(&mut self, vertex: DVec3) -> u32 {
        let place = (vertex - self.low) / (WIDTH * self.tolerance);
        // `as` saturates: a mesh of 1 km at the smallest tolerance crowds the outermost cells, slower and still right
        let cell = place.floor().as_i64vec3();
        if let Some(index) = self.near(cell, place, vertex) {
            return index;
        }
        let index = self.kept.len() as u32;
        self.kept.push(vertex);
        let older = self.newest.insert(number(cell), index);
        self.older.push(older.unwrap_or(NONE));
        index
    }

    fn near(&self, cell: I64Vec3, place: DVec3, vertex: DVec3) -> Option<u32> {
        let reach = |sign: f64| (place + sign / WIDTH).floor().as_i64vec3();
        let (first, last) = (reach(-1.0).min(cell), reach(1.0).max(cell));
        // of the home cell first: there nearly every vertex is found
        self.within(cell, vertex).or_else(|| {
            let span = |a: i64, b: i64| a..=b.min(a.saturating_add(2));
            let cells = span(first.x, last.x).flat_map(move |x| {
                span(first.y, last.y).flat_map(move |y| span(first.z, last.z).map(move |z| I64Vec3::new(x, y, z)))
            });
            cells.filter(|&other| other != cell).find_map(|other| self.within(other, vertex))
        })
    }

    fn within(&self, cell: I64Vec3, vertex: DVec3) -> Option<u32> {
        let mut index = self.newest.get(&number(cell)).copied().unwrap_or(NONE);
        while index != NONE && self.kept[index as usize].distance(vertex) > self.tolerance {
            index = self.older[index as usize];
        }
        (index != NONE).then_some(index)
    }
}

/// Takes a cell's number, which is mixed already, as it is: a second hash would take most of the time.
#[derive(Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.0 = self.0.rotate_left(8) ^ u64::from(byte));
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = number;
    }
}

/// A number for a cell; neighbours get different ones.
fn number(cell: I64Vec3) -> u64 {
    // odd numbers near 2^64 over the golden section and its like, so that the three coordinates do not cancel
    let mixed = [(cell.x, 0x9e37_79b9_7f4a_7c15_u64), (cell.y, 0xc2b2_ae3d_27d4_eb4f), (cell.z, 0x1656_67b1_9e37_79f9)];
    let sum = mixed.iter().fold(0, |sum, &(value, odd)| sum ^ (value as u64).wrapping_mul(odd).rotate_left(21));
    // the highest bits and the lowest both choose a place in the table
    (sum ^ (sum >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_within_the_tolerance_join_and_others_do_not() {
        let apart = |gap: f64| Mesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(-0.0, gap, 0.0), DVec3::X, DVec3::new(0.5, -1.0, 0.0)],
            triangles: vec![[0, 1, 2], [4, 3, 5]],
        };
        assert_eq!(weld(&apart(0.5e-9), Some(1e-9)).vertices.len(), 4);
        assert_eq!(weld(&apart(0.5e-8), Some(1e-9)).vertices.len(), 5);
    }

    #[test]
    fn a_collapsed_triangle_is_dropped() {
        let sliver = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::X * (1.0 + 1e-12)], triangles: vec![[0, 1, 2]] };
        assert!(weld(&sliver, Some(1e-9)).triangles.is_empty());
    }

    #[test]
    fn corners_join_across_the_walls_of_cells() {
        let tolerance = 1.0e-3;
        for k in 0..400 {
            // a second point just within the tolerance, at places that step through a cell and over its walls
            let at = DVec3::new(f64::from(k) * 0.7e-4, f64::from(k) * 1.3e-4, f64::from(k) * 0.4e-4);
            let direction = DVec3::new((f64::from(k)).sin(), (f64::from(k) * 2.0).cos(), (f64::from(k) * 3.0).sin()).normalize();
            for (share, expected) in [(0.99, 4), (1.01, 5)] {
                let second = at + direction * tolerance * share;
                let vertices = vec![DVec3::ZERO, DVec3::X, at, DVec3::Y, second];
                let mesh = Mesh { vertices, triangles: vec![[0, 1, 2], [1, 3, 4], [0, 1, 3]] };
                let found = weld(&mesh, Some(tolerance)).vertices.len();
                // near the origin the points join that too
                assert!(found == expected || at.length() < 3.0 * tolerance, "{k} {share}: {found}");
            }
        }
    }
}

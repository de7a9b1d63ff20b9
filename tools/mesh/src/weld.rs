//! Joins vertices that lie within a tolerance of each other and drops the triangles that this collapses.
//!
//! STL files name each corner anew, so neighbours agree only up to rounding, and -0 differs from 0 bit by bit. Cells of a grid as
//! wide as the tolerance hold the vertices kept so far; a vertex joins the first kept one found in its own or a neighbouring cell.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use crate::mesh::Mesh;

/// Tolerance that [`weld`] uses when none is given, as a share of the mesh's diagonal: some ten roundings of an f32 coordinate.
pub const DEFAULT_TOLERANCE: f64 = 1.0e-6;

/// Joins vertices closer than `tolerance` \[m\]; `None` takes [`DEFAULT_TOLERANCE`] of the diagonal.
#[must_use]
pub fn weld(mesh: &Mesh, tolerance: Option<f64>) -> Mesh {
    let Some((low, high)) = mesh.bounds() else {
        return Mesh::default();
    };
    let tolerance = tolerance.unwrap_or((high - low).length() * DEFAULT_TOLERANCE).max(f64::MIN_POSITIVE);
    let mut grid = Grid { tolerance, low, cells: HashMap::new(), kept: Vec::new() };
    let joined: Vec<u32> = mesh.vertices.iter().map(|&vertex| grid.place(vertex)).collect();
    let moved = mesh.triangles.iter().map(|triangle| triangle.map(|index| joined[index as usize]));
    let triangles = moved.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    Mesh { vertices: grid.kept, triangles }
}

struct Grid {
    tolerance: f64,
    low: DVec3,
    cells: HashMap<I64Vec3, Vec<u32>>,
    kept: Vec<DVec3>,
}

impl Grid {
    /// Index of the kept vertex that `vertex` joins, or of itself, now kept.
    fn place(&mut self, vertex: DVec3) -> u32 {
        // `as` saturates: a mesh of 1 km at the smallest tolerance crowds the outermost cells, slower and still right
        let cell = ((vertex - self.low) / self.tolerance).floor().as_i64vec3();
        if let Some(index) = self.near(cell, vertex) {
            return index;
        }
        let index = self.kept.len() as u32;
        self.kept.push(vertex);
        self.cells.entry(cell).or_default().push(index);
        index
    }

    fn near(&self, cell: I64Vec3, vertex: DVec3) -> Option<u32> {
        (0..27).find_map(|k| {
            let offset = I64Vec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
            let indices = self.cells.get(&cell.saturating_add(offset))?;
            indices.iter().copied().find(|&index| self.kept[index as usize].distance(vertex) <= self.tolerance)
        })
    }
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
}

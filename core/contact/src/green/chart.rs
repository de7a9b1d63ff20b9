//! Places on the surface of a convex body, numbered, and how to read a table between them.
//!
//! A direction from the body's middle, counted in the body's half extents, meets the surface once, and meets a cube once. The cube's faces carry a
//! lattice of `per_edge` x `per_edge` nodes, shared along edges and corners; between the nodes a table is read by quadratic polynomials over cells of
//! three by three nodes, which makes every reading continuous over the whole surface.

use glam::Vec3;

use crate::error::{Invalid, require};

/// Nodes along an edge of the cube at least: one cell.
pub const MIN_PER_EDGE: usize = 3;

/// Nodes along an edge of the cube at most: at 9 the table has 9.5 MB and what is read between nodes is within 0.3 % of smooth functions.
pub const MAX_PER_EDGE: usize = 9;

/// Nodes of the largest chart.
pub const MAX_PLACES: usize = 6 * MAX_PER_EDGE * MAX_PER_EDGE - 12 * MAX_PER_EDGE + 8;

/// Nodes of a cell.
pub const CELL: usize = 9;

/// The chart of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// Middle of the body above its held plane, in world \[m\].
    pub centre: Vec3,
    /// Half extents of that body \[m\].
    pub half_size: Vec3,
    /// Nodes along an edge of the cube: odd, 3 to 9.
    pub per_edge: usize,
}

/// Nodes around a place, and their weights, which sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Numbers of the nodes.
    pub place: [usize; CELL],
    /// Their weights.
    pub weight: [f32; CELL],
}

impl Cell {
    /// No nodes.
    pub const NONE: Self = Self { place: [0; CELL], weight: [0.0; CELL] };
}

impl Chart {
    /// Nodes of the whole chart: 6 n^2 - 12 n + 8.
    pub const fn places(&self) -> usize {
        let n = self.per_edge;
        2 * n * n + (n - 2) * 4 * (n - 1)
    }

    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let n = self.per_edge;
        let known = (MIN_PER_EDGE..=MAX_PER_EDGE).contains(&n) && n % 2 == 1;
        require(known, "green.per_edge", n as f32, "3, 5, 7 or 9 nodes")?;
        require(self.centre.is_finite(), "green.centre", self.centre.x, "finite, m")?;
        require(self.half_size.min_element() > 0.0, "green.half_size", self.half_size.min_element(), "above 0 m")
    }

    /// Direction of a node from the centre, in half extents: the largest component is 1. Numbers beyond the last give the last.
    pub fn direction(&self, place: usize) -> Vec3 {
        let (n, ring) = (self.per_edge, 4 * (self.per_edge - 1));
        let (last, place) = (n - 1, if place < self.places() { place } else { self.places() - 1 });
        let (i, j, k) = if place < n * n {
            (place % n, place / n, 0)
        } else if place < n * n + (n - 2) * ring {
            let (layer, at) = ((place - n * n) / ring, (place - n * n) % ring);
            let (side, along) = (at / last, at % last);
            let (i, j) = match side {
                0 => (along, 0),
                1 => (last, along),
                2 => (last - along, last),
                _ => (0, last - along),
            };
            (i, j, layer + 1)
        } else {
            let at = place - n * n - (n - 2) * ring;
            (at % n, at / n, last)
        };
        let coordinate = |index: usize| 2.0 * index as f32 / last as f32 - 1.0;
        Vec3::new(coordinate(i), coordinate(j), coordinate(k))
    }

    /// Number of the lattice node (i, j, k), which lies on the cube's surface.
    fn number(&self, node: [usize; 3]) -> usize {
        let (n, last) = (self.per_edge, self.per_edge - 1);
        let [i, j, k] = node;
        let ring = 4 * last;
        if k == 0 {
            return j * n + i;
        }
        if k == last {
            return n * n + (n - 2) * ring + j * n + i;
        }
        let around = if j == 0 && i < last {
            i
        } else if i == last && j < last {
            last + j
        } else if j == last && i > 0 {
            2 * last + (last - i)
        } else {
            3 * last + (last - j)
        };
        n * n + (k - 1) * ring + around
    }

    /// The nodes around the world point `p_w`, which lies on or near the surface.
    pub fn cell(&self, p_w: Vec3) -> Cell {
        let d = (p_w - self.centre) / self.half_size;
        let size = d.abs();
        let last = self.per_edge - 1;
        // the axis of the cube's face, and the two along it
        let (axis, u, v) = if size.z >= size.x && size.z >= size.y {
            (2, 0, 1)
        } else if size.x >= size.y {
            (0, 1, 2)
        } else {
            (1, 0, 2)
        };
        let (d, size) = (d.to_array(), size.to_array());
        let reach = if size[axis] > 0.0 { size[axis] } else { 1.0 };
        let mut node = [0; 3];
        node[axis] = if d[axis] > 0.0 { last } else { 0 };
        let (first_u, along_u) = quadratic(d[u] / reach, last);
        let (first_v, along_v) = quadratic(d[v] / reach, last);
        let mut cell = Cell { place: [0; CELL], weight: [0.0; CELL] };
        for (index, (place, weight)) in cell.place.iter_mut().zip(&mut cell.weight).enumerate() {
            let (i, j) = (index % 3, index / 3);
            (node[u], node[v]) = (first_u + i, first_v + j);
            (*place, *weight) = (self.number(node), along_u[i] * along_v[j]);
        }
        cell
    }
}

/// First node of the cell along one coordinate of -1 to 1, and the weights of its three.
fn quadratic(coordinate: f32, last: usize) -> (usize, [f32; 3]) {
    let s = 0.5 * (coordinate + 1.0) * last as f32;
    let s = crate::math::clamp(s, 0.0, last as f32);
    let half = (0.5 * s) as usize;
    let first = 2 * if half < last / 2 { half } else { last / 2 - 1 };
    let t = s - first as f32;
    (first, [0.5 * (t - 1.0) * (t - 2.0), t * (2.0 - t), 0.5 * t * (t - 1.0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: Chart = Chart { centre: Vec3::new(0.0, 0.0, 0.05), half_size: Vec3::new(0.05, 0.06, 0.05), per_edge: 5 };

    #[test]
    fn every_node_is_found_where_it_lies() {
        for per_edge in [3, 5, 7, 9] {
            let chart = Chart { per_edge, ..CHART };
            for place in 0..chart.places() {
                let p_w = chart.centre + chart.half_size * chart.direction(place) * 0.999;
                let cell = chart.cell(p_w);
                let found: f32 = cell.place.iter().zip(cell.weight).filter(|(p, _)| **p == place).map(|(_, w)| w).sum();
                assert!((found - 1.0).abs() < 1.0e-4, "{per_edge} {place} {cell:?}");
            }
        }
    }

    #[test]
    fn readings_are_continuous_across_edges_and_exact_for_constants() {
        let value = |p: Vec3| {
            let cell = CHART.cell(p);
            cell.place.iter().zip(cell.weight).map(|(&p, w)| w * CHART.direction(p).dot(Vec3::new(1.0, 2.0, 3.0))).sum::<f32>()
        };
        for i in 0..50 {
            let along = (i as f32 / 25.0 - 1.0) * 0.059;
            let edge = Vec3::new(0.05, along, 0.1);
            let (before, after) = (value(edge + Vec3::new(-1.0e-6, 0.0, 0.0)), value(edge + Vec3::new(0.0, 0.0, -1.0e-6)));
            assert!((before - after).abs() < 1.0e-3, "{along}: {before} {after}");
            assert!((CHART.cell(edge).weight.iter().sum::<f32>() - 1.0).abs() < 1.0e-6);
        }
    }
}

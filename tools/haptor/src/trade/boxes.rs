//! The triangles of a mesh in a tree of boxes, so that a line asks only those it comes near.

use haptor_mesh::{DVec3, Mesh};

/// Most triangles of a leaf: testing them costs about as much as two more boxes.
const LEAF: usize = 4;

/// The tree. Boxes lie in depth-first order: the first child follows its parent.
pub struct Boxes {
    nodes: Vec<Node>,
    /// Corners, those of a leaf side by side.
    triangles: Vec<[DVec3; 3]>,
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// The box to go on with when the line misses this one, or when this one is done.
    after: usize,
    /// Triangles of a leaf; none in others.
    leaf: std::ops::Range<usize>,
}

impl Boxes {
    /// The tree of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let mut tree = Self { nodes: Vec::new(), triangles: mesh.triangles.iter().map(|&t| mesh.corners(t)).collect() };
        tree.grow(0..tree.triangles.len());
        tree
    }

    /// The box of some triangles, and those of its halves along its longest side.
    fn grow(&mut self, range: std::ops::Range<usize>) {
        let of = &mut self.triangles[range.clone()];
        let corners = || of.iter().flatten();
        let low = corners().fold(DVec3::INFINITY, |low, &v| low.min(v));
        let high = corners().fold(DVec3::NEG_INFINITY, |high, &v| high.max(v));
        let place = self.nodes.len();
        let leaf = if range.len() <= LEAF { range.clone() } else { 0..0 };
        self.nodes.push(Node { low, high, after: 0, leaf });
        if range.len() > LEAF {
            let size = high - low;
            let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
            let middle = |t: &[DVec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
            of.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
            let half = range.start + range.len() / 2;
            self.grow(range.start..half);
            self.grow(half..range.end);
        }
        self.nodes[place].after = self.nodes.len();
    }

    /// Every triangle that the line `o` + t `d` may go through.
    pub fn near(&self, o: DVec3, d: DVec3) -> impl Iterator<Item = [DVec3; 3]> {
        let mut next = 0;
        let leaves = std::iter::from_fn(move || {
            while let Some(node) = self.nodes.get(next) {
                let met = node.meets(o, d);
                next = if met { next + 1 } else { node.after };
                if met && !node.leaf.is_empty() {
                    return Some(node.leaf.clone());
                }
            }
            None
        });
        leaves.flat_map(|leaf| self.triangles[leaf].iter().copied())
    }
}

impl Node {
    /// Whether the line comes through the box; a line in a face of it does.
    fn meets(&self, o: DVec3, d: DVec3) -> bool {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            if d[axis] == 0.0 {
                if o[axis] < self.low[axis] || o[axis] > self.high[axis] {
                    return false;
                }
                continue;
            }
            let (a, b) = ((self.low[axis] - o[axis]) / d[axis], (self.high[axis] - o[axis]) / d[axis]);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        // what division rounds off must not lose a flat box
        from <= to + 1.0e-9 * (1.0 + to.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line finds every triangle that it goes through, and asks few others.
    #[test]
    fn a_line_finds_what_it_goes_through() {
        let ball = haptor_mesh::tessellate::ellipsoid(DVec3::new(3.0, 2.0, 1.0), 60);
        let tree = Boxes::new(&ball);
        let all = ball.triangles.len();
        // the line 0 lies in the plane of a row of edges
        for i in 1..50 {
            let d = DVec3::new(f64::from(i).cos(), (0.7 * f64::from(i)).sin(), (1.3 * f64::from(i)).cos());
            let o = DVec3::new(0.2, -0.1, 0.05) * (f64::from(i) / 50.0) - d;
            let through = |t: &[DVec3; 3]| {
                let plane = (t[1] - t[0]).cross(t[2] - t[0]);
                let p = o + d * (plane.dot(t[0] - o) / plane.dot(d));
                (0..3).all(|k| plane.dot((t[(k + 1) % 3] - t[k]).cross(p - t[k])) >= 0.0)
            };
            let asked: Vec<_> = tree.near(o, d).collect();
            let found = asked.iter().filter(|t| through(t)).count();
            let there = ball.triangles.iter().filter(|&&t| through(&ball.corners(t))).count();
            assert!(there >= 2 && found == there, "line {i}: {found} of {there}");
            assert!(asked.len() < all / 20, "line {i}: {} of {all}", asked.len());
        }
    }
}

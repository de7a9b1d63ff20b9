//! Makes triangles agree about the outside, and pieces face the right way.
//!
//! Two triangles at an edge must run along it in opposite directions. Triangles are sets of a forest, each with its turn against its parent's; an edge of two
//! joins their sets. In each set the fewer are turned.

use crate::mesh::Mesh;
use crate::pieces::{edges, number, sides, wrong_way};

/// Turns triangles over until neighbours agree, where that can be; how many.
pub(super) fn agree(mesh: &mut Mesh) -> usize {
    let mut forest = Forest::new(mesh.triangles.len());
    for edge in edges(&sides(&mesh.triangles)) {
        if let [one, other] = edge {
            forest.join(one.triangle, other.triangle, one.forward == other.forward);
        }
    }
    let found: Vec<(u32, bool)> = (0..mesh.triangles.len() as u32).map(|triangle| forest.root(triangle)).collect();
    // those against their set's root, less those with it
    let mut balance = vec![0_i64; mesh.triangles.len()];
    found.iter().for_each(|&(root, against)| balance[root as usize] += if against { 1 } else { -1 });
    let mut turned = 0;
    for (triangle, &(root, against)) in mesh.triangles.iter_mut().zip(&found) {
        if against == (balance[root as usize] <= 0) {
            triangle.swap(1, 2);
            turned += 1;
        }
    }
    turned
}

/// Turns over the closed pieces that face the wrong way; how many triangles.
pub(super) fn face_outwards(mesh: &mut Mesh) -> usize {
    let all = sides(&mesh.triangles);
    let mut forest = Forest::new(mesh.triangles.len());
    for edge in edges(&all) {
        edge.windows(2).for_each(|pair| forest.join(pair[0].triangle, pair[1].triangle, false));
    }
    let roots: Vec<u32> = (0..mesh.triangles.len() as u32).map(|triangle| forest.root(triangle).0).collect();
    let (labels, pieces) = number(roots.into_iter(), mesh.triangles.len());
    let mut sound = vec![true; pieces];
    for edge in edges(&all) {
        let agrees = matches!(edge, [one, other] if one.forward != other.forward);
        sound[labels[edge[0].triangle as usize] as usize] &= agrees;
    }
    let wrong = wrong_way(mesh, &labels, &sound);
    let mut turned = 0;
    for (triangle, &label) in mesh.triangles.iter_mut().zip(&labels) {
        if wrong[label as usize] {
            triangle.swap(1, 2);
            turned += 1;
        }
    }
    turned
}

/// Sets of triangles, each with its turn against its parent.
struct Forest {
    parent: Vec<u32>,
    against: Vec<bool>,
}

impl Forest {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect(), against: vec![false; count] }
    }

    /// The root of a set and whether `member` is turned against it.
    fn root(&mut self, member: u32) -> (u32, bool) {
        let (mut root, mut turned) = (member, false);
        while self.parent[root as usize] != root {
            turned ^= self.against[root as usize];
            root = self.parent[root as usize];
        }
        // everyone on the way now hangs on the root
        let (mut at, mut rest) = (member, turned);
        while at != root {
            let next = self.parent[at as usize];
            self.parent[at as usize] = root;
            rest ^= std::mem::replace(&mut self.against[at as usize], rest);
            at = next;
        }
        (root, turned)
    }

    /// Joins the sets of two triangles, unless they are one; `against`: one of them is to be turned.
    fn join(&mut self, a: u32, b: u32, against: bool) {
        let ((a, turned_a), (b, turned_b)) = (self.root(a), self.root(b));
        if a != b {
            self.parent[a.max(b) as usize] = a.min(b);
            self.against[a.max(b) as usize] = turned_a ^ turned_b ^ against;
        }
    }
}

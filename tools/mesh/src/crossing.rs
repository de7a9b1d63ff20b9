//! A hint whether a mesh runs through itself: pairs of triangles that cross.
//!
//! Two triangles cross where an edge of one pierces the other; those that share a vertex are asked about the edges opposite to it, those that
//! share an edge whether one is folded onto the other. Pairs come from a tree of boxes. Triangles that overlap in one plane without a common edge are
//! not seen, hence a hint.

use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

use crate::distance::to_tree;
use crate::mesh::Mesh;

/// Most pairs that are asked: thirty seconds at worst; a mesh of a million triangles has some ten million of neighbours.
const MAX_ASKED: usize = 100_000_000;

/// Most crossing pairs that are counted: beyond it the mesh is broken anyway.
const MAX_COUNTED: usize = 100_000;

/// Sine of the angle below which two triangles at an edge lie on each other.
const FOLDED: f64 = 1.0e-6;

/// Volume below which four points lie in a plane, as a share of the cube of their extent: rounding.
const FLAT: f64 = 1.0e-12;

/// Pairs of triangles that cross.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crossings {
    /// How many were found.
    pub pairs: usize,
    /// All pairs were asked; else there may be more.
    pub complete: bool,
}

/// Counts the pairs of triangles that cross.
pub fn crossings(mesh: &Mesh) -> Crossings {
    let boxes = mesh.triangles.iter().map(|&triangle| {
        let corners = mesh.corners(triangle);
        let (low, high) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        Aabb::new(to_tree(low), to_tree(high))
    });
    let boxes: Vec<Aabb> = boxes.collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let (mut asked, mut pairs) = (0, 0);
    for (one, aabb) in boxes.iter().enumerate() {
        for other in tree.intersect_aabb(aabb).filter(|&other| (other as usize) > one) {
            asked += 1;
            pairs += usize::from(cross(mesh, mesh.triangles[one], mesh.triangles[other as usize]));
        }
        if asked > MAX_ASKED || pairs > MAX_COUNTED {
            return Crossings { pairs, complete: false };
        }
    }
    Crossings { pairs, complete: true }
}

fn cross(mesh: &Mesh, one: [u32; 3], other: [u32; 3]) -> bool {
    // turned so that a shared vertex comes first
    let shared = (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).filter(|&(i, j)| one[i] == other[j]);
    let shared: Vec<(usize, usize)> = shared.collect();
    let turned = |triangle: [u32; 3], by: usize| mesh.corners([triangle[by], triangle[(by + 1) % 3], triangle[(by + 2) % 3]]);
    match *shared {
        [] => {
            let (a, b) = (mesh.corners(one), mesh.corners(other));
            (0..3).any(|i| pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a))
        }
        [(i, j)] => {
            let (a, b) = (turned(one, i), turned(other, j));
            pierces(a[1], a[2], b) || pierces(b[1], b[2], a)
        }
        [(i, j), (k, l)] => {
            let corner = |triangle: [u32; 3], index: usize| mesh.vertices[triangle[index] as usize];
            let (from, to) = (corner(one, i), corner(one, k));
            let along = (to - from).normalize_or_zero();
            // away from the edge, in each triangle's plane
            let away = |third: DVec3| (third - from).reject_from_normalized(along).normalize_or_zero();
            let (a, b) = (away(corner(one, 3 - i - k)), away(corner(other, 3 - j - l)));
            a.dot(b) > 0.0 && a.cross(b).length() < FOLDED
        }
        _ => true,
    }
}

/// Does the segment from `p` to `q` run through the inside of a triangle?
fn pierces(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let extent = (p.max(q).max(a).max(b).max(c) - p.min(q).min(a).min(b).min(c)).max_element();
    let flat = FLAT * extent.powi(3);
    let (above, below) = (volume(a, b, c, p), volume(a, b, c, q));
    // an end in the plane counts as below, so that a body whose vertices all lie there is seen
    if (above > flat) == (below > flat) {
        return false;
    }
    let around = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    around.iter().all(|&v| v > flat) || around.iter().all(|&v| v < -flat)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate;

    #[test]
    fn sound_meshes_do_not_cross_and_bodies_through_each_other_do() {
        let cube = tessellate::cuboid(DVec3::ONE);
        let ball = tessellate::ellipsoid(DVec3::new(0.3, 0.2, 0.1), 64);
        for mesh in [&cube, &ball, &crate::convex::ell(), &tessellate::cone(1.0, 2.0, 32)] {
            assert_eq!(crossings(mesh), Crossings { pairs: 0, complete: true });
        }
        // the ball's middle in a face of the cube
        let through = crate::check::joined(&cube, &ball.mapped(|v| v + DVec3::new(0.5, 0.1, 0.03)));
        let found = crossings(&through);
        assert!(found.complete && found.pairs > 60, "{found:?}");
        // a fin folded onto a face
        let mut folded = cube;
        let [a, b, c] = folded.triangles[0];
        folded.vertices.push(folded.corners([a, b, c]).iter().sum::<DVec3>() / 3.0);
        folded.triangles.push([b, a, 8]);
        assert_eq!(crossings(&folded).pairs, 1);
    }
}

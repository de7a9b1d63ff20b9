//! The sides of edges and the pieces of a mesh: which triangles hang together, and which way each piece should face.
//!
//! A **side** is an edge as one triangle runs it. A **piece** is what hangs together by shared vertices. A closed piece faces outwards, one that
//! lies within an odd number of others (the wall of a hollow) inwards.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::properties::tetrahedron;

/// Most closed pieces for which it is asked what lies within what, a question of every two; with more, all face outwards.
const MAX_NESTED: usize = 64;

/// An edge as one triangle runs it; sorted, the sides of an edge are neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// Lower vertex of the edge.
    pub low: u32,
    /// Higher vertex.
    pub high: u32,
    /// The triangle.
    pub triangle: u32,
    /// It runs from the lower vertex to the higher.
    pub forward: bool,
}

impl Side {
    /// The edge: lower vertex, higher vertex.
    pub fn edge(&self) -> (u32, u32) {
        (self.low, self.high)
    }
}

/// The sides of all triangles, those of an edge next to each other.
pub(crate) fn sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let side = |triangle: usize, from: u32, to: u32| Side {
        low: from.min(to),
        high: from.max(to),
        triangle: triangle as u32,
        forward: from < to,
    };
    let of = |(i, &[a, b, c]): (usize, &[u32; 3])| [side(i, a, b), side(i, b, c), side(i, c, a)];
    let mut sides: Vec<Side> = triangles.iter().enumerate().flat_map(of).collect();
    sides.sort_unstable();
    sides
}

/// The sides of each edge.
pub(crate) fn edges(sides: &[Side]) -> impl Iterator<Item = &[Side]> {
    sides.chunk_by(|a, b| a.edge() == b.edge())
}

/// The piece of each triangle, numbered from 0 in the order of the triangles, and how many there are.
pub(crate) fn label(mesh: &Mesh) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        join(&mut parent, a, b);
        join(&mut parent, b, c);
    }
    number(mesh.triangles.iter().map(|triangle| root(&mut parent, triangle[0])), mesh.vertices.len())
}

/// Numbers things by the order in which their roots, below `most`, first appear.
pub(crate) fn number(roots: impl Iterator<Item = u32>, most: usize) -> (Vec<u32>, usize) {
    let mut numbers = vec![u32::MAX; most];
    let mut count = 0;
    let labels = roots.map(|root| {
        let number = &mut numbers[root as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        *number
    });
    let labels = labels.collect();
    (labels, count as usize)
}

/// Joins two sets of a forest.
pub(crate) fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

/// The lowest member of a set of a forest.
pub(crate) fn root(parent: &mut [u32], mut member: u32) -> u32 {
    while parent[member as usize] != member {
        // halving the path keeps the walk short
        parent[member as usize] = parent[parent[member as usize] as usize];
        member = parent[member as usize];
    }
    member
}

/// Which of the pieces `labels` face the wrong way; only those that are `sound` (closed, and in agreement with themselves) can.
pub(crate) fn wrong_way(mesh: &Mesh, labels: &[u32], sound: &[bool]) -> Vec<bool> {
    let mut volumes = vec![0.0; sound.len()];
    let origin = mesh.vertices.first().copied().unwrap_or_default();
    for (&triangle, &label) in mesh.triangles.iter().zip(labels) {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - origin);
        volumes[label as usize] += tetrahedron(a, b, c);
    }
    let within = depths(mesh, labels, sound);
    let wrong = |piece: usize| sound[piece] && (volumes[piece] < 0.0) != (within[piece] % 2 == 1);
    (0..sound.len()).map(wrong).collect()
}

/// How many other sound pieces each sound piece lies within.
fn depths(mesh: &Mesh, labels: &[u32], sound: &[bool]) -> Vec<usize> {
    let closed: Vec<usize> = (0..sound.len()).filter(|&piece| sound[piece]).collect();
    let mut depths = vec![0; sound.len()];
    if !(2..=MAX_NESTED).contains(&closed.len()) {
        return depths;
    }
    let mut members = vec![Vec::new(); sound.len()];
    for (&triangle, &label) in mesh.triangles.iter().zip(labels) {
        members[label as usize].push(triangle);
    }
    let bounds: Vec<_> = members.iter().map(|triangles| bounds(mesh, triangles)).collect();
    for &inner in &closed {
        let point = mesh.corners(members[inner][0]).iter().sum::<DVec3>() / 3.0;
        let holds = |outer: usize| {
            let ((low, high), (from, to)) = (bounds[outer], bounds[inner]);
            outer != inner && low.cmple(from).all() && high.cmpge(to).all() && turns(mesh, &members[outer], point).abs() > 0.5
        };
        depths[inner] = closed.iter().filter(|&&outer| holds(outer)).count();
    }
    depths
}

fn bounds(mesh: &Mesh, triangles: &[[u32; 3]]) -> (DVec3, DVec3) {
    let empty = (DVec3::splat(f64::MAX), DVec3::splat(f64::MIN));
    triangles.iter().flat_map(|&triangle| mesh.corners(triangle)).fold(empty, |(low, high), v| (low.min(v), high.max(v)))
}

/// How often the triangles wind around a point: the sum of their solid angles over that of a sphere
/// (A. van Oosterom, J. Strackee, The solid angle of a plane triangle, 1983).
fn turns(mesh: &Mesh, triangles: &[[u32; 3]], point: DVec3) -> f64 {
    let half_angle = |&triangle: &[u32; 3]| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
    };
    triangles.iter().map(half_angle).sum::<f64>() / std::f64::consts::TAU
}

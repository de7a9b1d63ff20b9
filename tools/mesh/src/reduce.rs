//! Fewer triangles for the same surface: edges collapse, the cheapest first (M. Garland, P. S. Heckbert, Surface simplification using quadric
//! error metrics, 1997).
//!
//! A **quadric** sums the squared distances from the planes of triangles, weighted by their areas; an edge costs what the sum of its two ends' quadrics
//! is worth at the best place for the one vertex that it becomes. An edge collapses only where the mesh stays the skin of what it was: its ends share
//! exactly the two neighbours opposite to it, no triangle turns over or becomes a sliver, the rim of an open mesh stays where it is. What libraries
//! offer does not hold that promise (meshoptimizer leaves edges of three triangles in thin bodies), so this is our own. Ties go by vertex number: the
//! same mesh gives the same result everywhere.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use glam::{DMat3, DVec3};

use crate::check::flat;
use crate::mesh::{Mesh, twice_area};
use crate::pieces::{edges, sides};

/// Triangles that a contact mesh needs at most: the grid that it is baked to resolves no more, and the window draws its 10,000 vertices at full rate.
pub const CAPACITY: usize = 20_000;

/// Fewest triangles of a solid.
pub const FEWEST: usize = 4;

/// Cosine of the largest turn of a triangle's normal in one collapse: beyond it a fold would begin.
const TURN: f64 = 0.2;

/// Share by which a quadric pulls a vertex to the middle of its edge, so that on flats, where every place is as good, triangles stay round.
const PULL: f64 = 1.0e-6;

/// Triangles from one word of progress to the next.
const TOLD: usize = 4096;

/// A mesh of at most `triangles` triangles, or as few as can be without harm. `progress` is told the share done, 0 to 1.
#[must_use]
pub fn reduce(mesh: &Mesh, triangles: usize, progress: &mut dyn FnMut(f64)) -> Mesh {
    let mut work = Work::new(mesh);
    let start = work.alive;
    let goal = triangles.max(FEWEST);
    let mut told = |work: &Work| progress((start - work.alive) as f64 / (start - goal).max(1) as f64);
    // edges that had to stay are asked again once others have gone, until none goes
    loop {
        let before = work.alive;
        work.collapse_cheapest(goal, &mut told);
        if work.alive <= goal || work.alive == before {
            break;
        }
    }
    work.mesh()
}

/// Squared distance from planes, weighted: x A x - 2 b x + c.
#[derive(Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    const ZERO: Self = Self { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0 };

    fn of_plane(normal: DVec3, through: DVec3, weight: f64) -> Self {
        let offset = normal.dot(through);
        let a = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z) * weight;
        Self { a, b: normal * (offset * weight), c: offset * offset * weight }
    }

    fn plus(&self, other: &Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    fn at(&self, x: DVec3) -> f64 {
        (x.dot(self.a * x) - 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// The place of least value, drawn to `middle` where it would run away.
    fn best(&self, middle: DVec3) -> DVec3 {
        let pull = PULL * (self.a.x_axis.x + self.a.y_axis.y + self.a.z_axis.z);
        let a = self.a + DMat3::from_diagonal(DVec3::splat(pull));
        let found = a.inverse() * (self.b + middle * pull);
        if found.is_finite() { found } else { middle }
    }
}

/// An edge in the queue: what it costs, its ends, and how often they had changed when it was put there.
#[derive(Clone, Copy, PartialEq)]
struct Edge {
    cost: f64,
    keep: u32,
    drop: u32,
    changes: [u32; 2],
}

impl Eq for Edge {}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then((self.keep, self.drop).cmp(&(other.keep, other.drop)))
    }
}

/// A triangle that is no more.
const GONE: [u32; 3] = [u32::MAX; 3];

/// The mesh as it shrinks, about the middle of its bounds, so that far meshes lose no digits.
struct Work {
    origin: DVec3,
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    alive: usize,
    /// Triangles of each vertex.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    changes: Vec<u32>,
    /// On a rim, or on an edge that is not of two triangles: stays where it is.
    held: Vec<bool>,
}

impl Work {
    fn new(mesh: &Mesh) -> Self {
        let origin = mesh.bounds().map_or(DVec3::ZERO, |(low, high)| (low + high) / 2.0);
        let count = mesh.vertices.len();
        let mut work = Self {
            origin,
            vertices: mesh.vertices.iter().map(|&v| v - origin).collect(),
            triangles: mesh.triangles.clone(),
            alive: mesh.triangles.len(),
            around: vec![Vec::new(); count],
            quadrics: vec![Quadric::ZERO; count],
            changes: vec![0; count],
            held: vec![false; count],
        };
        for (index, &triangle) in mesh.triangles.iter().enumerate() {
            let corners = work.corners(triangle);
            let cross = twice_area(corners);
            let quadric = Quadric::of_plane(cross.normalize_or_zero(), corners[0], cross.length());
            for corner in triangle.map(|corner| corner as usize) {
                work.around[corner].push(index as u32);
                work.quadrics[corner] = work.quadrics[corner].plus(&quadric);
            }
        }
        for edge in edges(&sides(&mesh.triangles)).filter(|edge| edge.len() != 2) {
            let (a, b) = edge[0].edge();
            (work.held[a as usize], work.held[b as usize]) = (true, true);
        }
        work
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|corner| self.vertices[corner as usize])
    }

    /// Collapses edges, the cheapest first, until `goal` triangles are left or no edge may go.
    fn collapse_cheapest(&mut self, goal: usize, told: &mut dyn FnMut(&Self)) {
        let mut queue = self.queue();
        while self.alive > goal
            && let Some(Reverse(next)) = queue.pop()
        {
            if !self.is_current(&next) || !self.is_linked(&next) {
                continue;
            }
            let Some(place) = self.place(&next) else { continue };
            self.collapse(&next, place);
            queue.extend(self.edges_of(next.keep).into_iter().map(Reverse));
            if self.alive % TOLD < 2 {
                told(self);
            }
            // the queue outgrows the mesh many times otherwise; an edge and a half a triangle are current
            if queue.len() > 4 * self.alive + TOLD {
                queue.retain(|Reverse(edge)| self.is_current(edge));
            }
        }
    }

    fn queue(&self) -> BinaryHeap<Reverse<Edge>> {
        let all = sides(&self.triangles);
        let alive = edges(&all).filter(|edge| edge[0].high != u32::MAX);
        alive.map(|edge| Reverse(self.edge(edge[0].low, edge[0].high))).collect()
    }

    /// An edge as it is now.
    fn edge(&self, a: u32, b: u32) -> Edge {
        let (keep, drop) = (a.min(b), a.max(b));
        let [i, j] = [keep as usize, drop as usize];
        let both = self.quadrics[i].plus(&self.quadrics[j]);
        let cost = both.at(self.best(&both, i, j));
        Edge { cost, keep, drop, changes: [self.changes[i], self.changes[j]] }
    }

    /// The place of least cost for what an edge becomes: near it, and where a held end is.
    fn best(&self, both: &Quadric, i: usize, j: usize) -> DVec3 {
        let (one, other) = (self.vertices[i], self.vertices[j]);
        match (self.held[i], self.held[j]) {
            (true, _) => one,
            (false, true) => other,
            (false, false) => {
                let middle = (one + other) / 2.0;
                let found = both.best(middle);
                if found.distance(middle) <= one.distance(other) {
                    return found;
                }
                let ends = [middle, one, other];
                ends.into_iter().min_by(|a, b| both.at(*a).total_cmp(&both.at(*b))).unwrap_or(middle)
            }
        }
    }

    fn is_current(&self, edge: &Edge) -> bool {
        [edge.keep, edge.drop].map(|vertex| self.changes[vertex as usize]) == edge.changes
    }

    /// Where the vertex goes that an edge becomes; `None` where it must stay.
    fn place(&self, edge: &Edge) -> Option<DVec3> {
        let [i, j] = [edge.keep as usize, edge.drop as usize];
        if self.held[i] && self.held[j] {
            return None;
        }
        let place = self.best(&self.quadrics[i].plus(&self.quadrics[j]), i, j);
        self.is_harmless(edge, place).then_some(place)
    }

    /// The ends share exactly the neighbours opposite to the edge, and those of no triangle of three.
    fn is_linked(&self, edge: &Edge) -> bool {
        let shared = self.around[edge.keep as usize].iter().filter(|&&index| self.triangles[index as usize].contains(&edge.drop));
        let triangles = shared.count();
        let (one, other) = (self.neighbours(edge.keep), self.neighbours(edge.drop));
        let common = one.iter().filter(|vertex| other.binary_search(vertex).is_ok()).count();
        // three neighbours in all: a tetrahedron, which would collapse to two faces
        triangles == 2 && common == 2 && one.len() + other.len() > 6
    }

    /// Other ends of the edges at a vertex, sorted.
    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let triangles = self.around[vertex as usize].iter().map(|&index| self.triangles[index as usize]);
        let mut found: Vec<u32> = triangles.flatten().filter(|&other| other != vertex).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// No triangle that stays turns over or becomes flat.
    fn is_harmless(&self, edge: &Edge, place: DVec3) -> bool {
        let both = [edge.keep, edge.drop];
        both.iter().all(|&vertex| {
            self.around[vertex as usize].iter().all(|&index| {
                let triangle = self.triangles[index as usize];
                if both.iter().all(|end| triangle.contains(end)) {
                    return true;
                }
                let before = self.corners(triangle);
                let after = [0, 1, 2].map(|i| if triangle[i] == vertex { place } else { before[i] });
                let (old, new) = (twice_area(before).normalize_or_zero(), twice_area(after).normalize_or_zero());
                !flat(after) && (old == DVec3::ZERO || old.dot(new) > TURN)
            })
        })
    }

    fn collapse(&mut self, edge: &Edge, place: DVec3) {
        let [i, j] = [edge.keep as usize, edge.drop as usize];
        self.vertices[i] = place;
        self.quadrics[i] = self.quadrics[i].plus(&self.quadrics[j]);
        self.held[i] |= self.held[j];
        for index in std::mem::take(&mut self.around[j]) {
            let triangle = &mut self.triangles[index as usize];
            if !triangle.contains(&edge.keep) {
                triangle.iter_mut().filter(|corner| **corner == edge.drop).for_each(|corner| *corner = edge.keep);
                self.around[i].push(index);
                continue;
            }
            for corner in std::mem::replace(triangle, GONE).into_iter().filter(|&corner| corner != edge.drop) {
                self.around[corner as usize].retain(|&other| other != index);
            }
            self.alive -= 1;
        }
        self.changes[i] += 1;
        self.changes[j] += 1;
    }

    /// The edges at a vertex as they are now.
    fn edges_of(&self, vertex: u32) -> Vec<Edge> {
        self.neighbours(vertex).into_iter().map(|other| self.edge(vertex, other)).collect()
    }

    fn mesh(self) -> Mesh {
        let mut moved = vec![u32::MAX; self.vertices.len()];
        let mut mesh = Mesh::default();
        for triangle in self.triangles.iter().filter(|&&triangle| triangle != GONE) {
            mesh.triangles.push(triangle.map(|corner| {
                let to = &mut moved[corner as usize];
                if *to == u32::MAX {
                    *to = mesh.vertices.len() as u32;
                    mesh.vertices.push(self.vertices[corner as usize] + self.origin);
                }
                *to
            }));
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Findings, check, convex, deviation::deviation, properties, tessellate};

    /// Every triangle in four.
    fn finer(mesh: &Mesh) -> Mesh {
        let mut finer = Mesh::default();
        for &triangle in &mesh.triangles {
            let [a, b, c] = mesh.corners(triangle);
            let first = finer.vertices.len() as u32;
            finer.vertices.extend([a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0]);
            let inner = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
            finer.triangles.extend(inner.map(|triangle| triangle.map(|corner| first + corner)));
        }
        crate::weld(&finer, None)
    }

    #[test]
    fn a_body_of_flats_keeps_its_corners() {
        let fine = (0..4).fold(convex::ell(), |mesh, _| finer(&mesh));
        // twice what the corners alone would need
        let least = 2 * convex::ell().triangles.len();
        let few = reduce(&fine, least, &mut |_| {});
        assert!(check(&few).is_solid() && few.triangles.len() <= least, "{} {:?}", few.triangles.len(), check(&few));
        let off = deviation(&fine, &few).unwrap();
        // a hundredth of a thousandth of its size
        assert!(off.max < 3e-5, "{off:?}");
    }

    #[test]
    fn every_shape_stays_a_solid_whatever_the_number() {
        let ball = tessellate::ellipsoid(DVec3::splat(0.05), 96);
        let thin = ball.mapped(|v| DVec3::new(v.x, v.y, 0.01 * v.z + 4.0 * v.x * v.x));
        let bumpy = ball.mapped(|v| v + v * 0.05 * ((v.x * 700.0).sin() * (v.y * 900.0).cos() * (v.z * 500.0).sin()));
        let far = ball.mapped(|v| v + DVec3::splat(900.0));
        for (name, mesh) in [("ball", ball), ("thin", thin), ("bumpy", bumpy), ("far", far)] {
            for triangles in [5000, 1000, 200, 50, 8] {
                let few = reduce(&mesh, triangles, &mut |_| {});
                // a leaf of few triangles may enclose nothing
                let sound = Findings { inside_out: 0, ..check(&few) };
                assert!(sound.is_solid(), "{name} {triangles}: {sound:?}");
                assert!(few.triangles.len() <= triangles || name == "thin", "{name} {triangles}: {}", few.triangles.len());
            }
        }
    }

    #[test]
    fn a_reduced_ball_keeps_its_size_and_says_how_far_it_is_off() {
        let ball = tessellate::ellipsoid(DVec3::splat(0.02), 128);
        let mut told = Vec::new();
        let few = reduce(&ball, 2000, &mut |share| told.push(share));
        let off = deviation(&ball, &few).unwrap();
        assert!(few.triangles.len() <= 2000 && off.max < 1.0e-4 && off.rms < 3.0e-5, "{off:?}");
        let shrunk = properties(&few).unwrap().volume / properties(&ball).unwrap().volume;
        assert!((shrunk - 1.0).abs() < 2.0e-3, "{shrunk}");
        assert!(told.windows(2).all(|pair| pair[0] <= pair[1]) && !told.is_empty());
        assert_eq!(few, reduce(&ball, 2000, &mut |_| {}));
    }

    #[test]
    fn the_rim_of_an_open_mesh_stays() {
        let mut bowl = tessellate::ellipsoid(DVec3::splat(0.02), 48);
        bowl.triangles.retain(|&triangle| bowl.vertices[triangle[0] as usize].z < 0.005);
        let bowl = crate::weld(&bowl, None);
        let few = reduce(&bowl, 200, &mut |_| {});
        assert_eq!(check(&few).boundary_edges, check(&bowl).boundary_edges);
        assert!(few.triangles.len() <= 200 && check(&few).non_manifold_edges == 0);
    }
}

//! Finds the rims of holes and closes those of few edges.
//!
//! A **rim** is a closed run of edges that have one triangle each, against those triangles' direction. It is closed with the triangles of least area
//! that use no edge the mesh has already (G. Barequet, M. Sharir, Filling gaps in the boundary of a polyhedron, 1995).

use std::collections::{HashMap, HashSet};

use crate::mesh::{Mesh, twice_area};
use crate::pieces::{Side, edges, sides};

/// What became of the rims.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Closed {
    pub closed: usize,
    /// Triangles added.
    pub added: usize,
    /// Rims left open.
    pub left: usize,
    /// Edges of the longest of them.
    pub longest: usize,
}

/// Closes rims of up to `most` edges.
pub(super) fn close(mesh: &mut Mesh, most: usize) -> Closed {
    let all = sides(&mesh.triangles);
    let open: Vec<Side> = edges(&all).filter(|edge| edge.len() == 1).map(|edge| edge[0]).collect();
    let mut taken: HashSet<(u32, u32)> = HashSet::new();
    if !open.is_empty() {
        taken.extend(edges(&all).map(|edge| edge[0].edge()));
    }
    drop(all);
    let mut result = Closed::default();
    for rim in rims(&open) {
        match fill(mesh, &rim, most, &taken).filter(|_| !is_lone(&rim, &open)) {
            Some(triangles) => {
                taken.extend(sides(&triangles).iter().map(Side::edge));
                result.closed += 1;
                result.added += triangles.len();
                mesh.triangles.extend(triangles);
            }
            None => {
                result.left += 1;
                result.longest = result.longest.max(rim.len());
            }
        }
    }
    result
}

/// Is the rim that of a lone triangle? Its other face would enclose nothing.
fn is_lone(rim: &[u32], open: &[Side]) -> bool {
    let [a, b, c] = *rim else { return false };
    let owner = |a: u32, b: u32| {
        let found = open.binary_search_by_key(&(a.min(b), a.max(b)), Side::edge);
        found.ok().map(|index| open[index].triangle)
    };
    owner(a, b) == owner(b, c) && owner(b, c) == owner(c, a)
}

/// Closed runs of open edges against their triangles' direction, each through no vertex twice.
fn rims(open: &[Side]) -> Vec<Vec<u32>> {
    let step = |side: &Side| if side.forward { (side.high, side.low) } else { (side.low, side.high) };
    let mut steps: Vec<(u32, u32)> = open.iter().map(step).collect();
    steps.sort_unstable();
    // at a vertex's first step: how many of its steps have been taken
    let mut taken = vec![0; steps.len()];
    let mut next = |from: u32| {
        let first = steps.partition_point(|step| step.0 < from);
        let &(_, to) = steps.get(first + *taken.get(first)?).filter(|step| step.0 == from)?;
        taken[first] += 1;
        Some(to)
    };
    let mut found = Vec::new();
    let mut place: HashMap<u32, usize> = HashMap::new();
    for &(start, _) in &steps {
        let mut path = vec![start];
        place.clear();
        place.insert(start, 0);
        while let Some(to) = path.last().and_then(|&last| next(last)) {
            if let Some(&at) = place.get(&to) {
                // the run has closed: what came before it goes on
                let rim = path.split_off(at);
                for vertex in &rim {
                    place.remove(vertex);
                }
                found.push(rim);
            }
            place.insert(to, path.len());
            path.push(to);
        }
    }
    found
}

/// The triangles of least area that close a rim; `None` where it is too long or cannot be closed.
fn fill(mesh: &Mesh, rim: &[u32], most: usize, taken: &HashSet<(u32, u32)>) -> Option<Vec<[u32; 3]>> {
    let count = rim.len();
    if !(3..=most).contains(&count) {
        return None;
    }
    let allowed = |i: usize, k: usize| {
        let (a, b) = (rim[i], rim[k]);
        k - i == 1 || (i == 0 && k == count - 1) || !taken.contains(&(a.min(b), a.max(b)))
    };
    // least area of the run from i to k, and the corner that takes it
    let mut least = vec![(0.0_f64, 0_usize); count * count];
    for span in 2..count {
        for i in 0..count - span {
            let k = i + span;
            let area = |j: usize| twice_area(mesh.corners([rim[i], rim[j], rim[k]])).length();
            let cost = |j: usize| (least[i * count + j].0 + least[j * count + k].0 + area(j), j);
            let best = (i + 1..k).map(cost).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0));
            least[i * count + k] = if allowed(i, k) { best } else { (f64::INFINITY, 0) };
        }
    }
    if !least[count - 1].0.is_finite() {
        return None;
    }
    let (mut triangles, mut open) = (Vec::new(), vec![(0, count - 1)]);
    while let Some((i, k)) = open.pop() {
        if k - i > 1 {
            let j = least[i * count + k].1;
            triangles.push([rim[i], rim[j], rim[k]]);
            open.extend([(i, j), (j, k)]);
        }
    }
    Some(triangles)
}

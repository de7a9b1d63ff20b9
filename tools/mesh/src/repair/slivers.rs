//! Triangles without a usable normal give up their long edge: it is swapped for the other diagonal of the quadrangle with the neighbour there.

use crate::check::is_sliver;
use crate::mesh::Mesh;
use crate::pieces::{Side, sides};

/// Rounds of swaps: slivers beside slivers take one each.
const ROUNDS: usize = 8;

/// Swaps long edges of slivers where that leaves none; how many.
pub(super) fn swap(mesh: &mut Mesh) -> usize {
    let mut swapped = 0;
    for _ in 0..ROUNDS {
        let before = swapped;
        swapped += round(mesh);
        if swapped == before {
            break;
        }
    }
    swapped
}

fn round(mesh: &mut Mesh) -> usize {
    let flat: Vec<usize> = (0..mesh.triangles.len()).filter(|&index| is_sliver(mesh, mesh.triangles[index])).collect();
    if flat.is_empty() {
        return 0;
    }
    let all = sides(&mesh.triangles);
    let mut touched = vec![false; mesh.triangles.len()];
    let mut swapped = 0;
    for index in flat {
        let Some((other, pair)) = other_diagonal(mesh, &all, index) else { continue };
        // edges around what this round has changed are not those in the list
        let around = [index, other].iter().any(|&triangle| touched[triangle]);
        if around || pair.iter().any(|&triangle| is_sliver(mesh, triangle)) {
            continue;
        }
        [mesh.triangles[index], mesh.triangles[other]] = pair;
        (touched[index], touched[other]) = (true, true);
        swapped += 1;
    }
    swapped
}

/// The neighbour at a triangle's longest edge, and both triangles with the other diagonal; `None` where there are not two, or the diagonal is there already.
fn other_diagonal(mesh: &Mesh, all: &[Side], index: usize) -> Option<(usize, [[u32; 3]; 2])> {
    let triangle = mesh.triangles[index];
    let length = |i: usize| mesh.vertices[triangle[i] as usize].distance(mesh.vertices[triangle[(i + 1) % 3] as usize]);
    let longest = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j)))?;
    let [a, b, c] = [triangle[longest], triangle[(longest + 1) % 3], triangle[(longest + 2) % 3]];
    let [one, other] = of_edge(all, a, b) else { return None };
    let other = if one.triangle as usize == index { other } else { one }.triangle as usize;
    let d = *mesh.triangles[other].iter().find(|&&corner| corner != a && corner != b)?;
    (d != c && of_edge(all, c, d).is_empty()).then_some((other, [[c, a, d], [d, b, c]]))
}

fn of_edge(all: &[Side], a: u32, b: u32) -> &[Side] {
    let edge = (a.min(b), a.max(b));
    let first = all.partition_point(|side| side.edge() < edge);
    let count = all[first..].iter().take_while(|side| side.edge() == edge).count();
    &all[first..first + count]
}

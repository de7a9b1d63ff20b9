//! Points spread over a mesh's surface, in progressive order: every prefix is spread as evenly as its number allows.
//!
//! Candidates are the vertices (where a part may be deepest) and points spread over the triangles by area, each with an equal share of it.
//! First come the farthest along the eight diagonals of a cube and its axes, so that the corners of a block are there; then the next sample is always the candidate farthest from all samples so far
//! (T. F. Gonzalez, 1985; at most twice the best spacing). Areas belong to the full set: a candidate's share goes to its nearest sample. For a prefix
//! the areas must be shared out anew, or scaled by total over sum.

use glam::DVec3;

use crate::distance::Distance;
use crate::mesh::{Mesh, twice_area};

/// Most candidates that are vertices, and number of those spread by area: sixteen for each of the 2048 samples a core takes.
const CANDIDATES: usize = 32_768;

/// A sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position \[m\].
    pub position: DVec3,
    /// Unit outward normal; on vertices and edges the pseudo-normal.
    pub normal: DVec3,
    /// Area nearest to it in the full set \[m^2\].
    pub area: f64,
}

#[derive(Clone, Copy)]
struct Candidate {
    position: DVec3,
    normal: DVec3,
    area: f64,
    /// Squared distance to the nearest sample so far, and its index.
    off: f64,
    nearest: usize,
}

/// At most `count` samples of a mesh, progressive about `centre` \[m\]; fewer where the mesh has no more places. `progress` is told the share done.
pub fn samples(mesh: &Mesh, distance: &Distance, centre: DVec3, count: usize, progress: &mut dyn FnMut(f64)) -> Vec<Sample> {
    let mut candidates = vertices(mesh, distance);
    candidates.extend(spread(mesh));
    let mut chosen: Vec<Sample> = Vec::new();
    let outermost = directions().into_iter().filter_map(|d| farthest(candidates.iter().map(|c| (c.position - centre).dot(d))));
    let mut first: Vec<usize> = outermost.map(|(index, _)| index).rev().collect();
    while chosen.len() < count {
        let asked_for = first.pop();
        let next = asked_for.or_else(|| farthest(candidates.iter().map(|c| c.off)).map(|(index, _)| index));
        let Some(Candidate { position, normal, off, .. }) = next.and_then(|index| candidates.get(index)).copied() else { break };
        if off > 0.0 {
            for candidate in &mut candidates {
                let off = candidate.position.distance_squared(position);
                if off < candidate.off {
                    (candidate.off, candidate.nearest) = (off, chosen.len());
                }
            }
            chosen.push(Sample { position, normal, area: 0.0 });
        } else if asked_for.is_none() {
            // the farthest is a sample already: no place is left
            break;
        }
        progress(chosen.len() as f64 / count as f64);
    }
    for candidate in &candidates {
        if let Some(sample) = chosen.get_mut(candidate.nearest) {
            sample.area += candidate.area;
        }
    }
    chosen
}

/// Diagonals of a cube, then its axes.
fn directions() -> Vec<DVec3> {
    let diagonals = (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * 2.0 - DVec3::ONE);
    diagonals.chain([DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis])).collect()
}

fn farthest(offs: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    offs.enumerate().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
}

/// Vertices, evenly thinned where there are too many.
fn vertices(mesh: &Mesh, distance: &Distance) -> Vec<Candidate> {
    let stride = mesh.vertices.len().div_ceil(CANDIDATES).max(1);
    let of = |(index, &position): (usize, &DVec3)| Candidate {
        position,
        normal: distance.vertex_normal(index as u32),
        area: 0.0,
        off: f64::MAX,
        nearest: 0,
    };
    // a vertex of no triangle has no normal
    mesh.vertices.iter().enumerate().step_by(stride).map(of).filter(|candidate| candidate.normal != DVec3::ZERO).collect()
}

fn spread(mesh: &Mesh) -> Vec<Candidate> {
    let share = mesh.area() / CANDIDATES as f64;
    let of = |(position, normal)| Candidate { position, normal, area: share, off: f64::MAX, nearest: 0 };
    by_area(mesh, CANDIDATES).map(of).collect()
}

/// Points of the surface, about `count`, each for an equal area.
pub fn places_by_area(mesh: &Mesh, count: usize) -> impl Iterator<Item = DVec3> {
    by_area(mesh, count).map(|(place, _)| place)
}

/// Points and normals at equal steps of area along the list of triangles, spread in each by a sequence of low discrepancy.
fn by_area(mesh: &Mesh, count: usize) -> impl Iterator<Item = (DVec3, DVec3)> {
    // the plastic number's powers: the two-dimensional counterpart of the golden section (M. Roberts, 2018)
    const STEP: (f64, f64) = (0.754_877_666_246_693, 0.569_840_290_998_053_3);
    let share = mesh.area() / count as f64;
    let (mut passed, mut found) = (0.0, Vec::with_capacity(count));
    for &triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(triangle);
        let cross = twice_area([a, b, c]);
        passed += cross.length() / 2.0;
        while (found.len() as f64 + 0.5) * share < passed {
            let k = found.len() as f64;
            let (u, v) = ((k * STEP.0).fract(), (k * STEP.1).fract());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let position = a + (b - a) * u + (c - a) * v;
            found.push((position, cross.normalize()));
        }
    }
    found.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate;

    #[test]
    fn prefixes_are_spread_evenly_and_areas_add_up() {
        let ball = tessellate::ellipsoid(DVec3::splat(0.02), 64);
        let found = samples(&ball, &Distance::new(&ball).unwrap(), DVec3::ZERO, 512, &mut |_| {});
        assert_eq!(found.len(), 512);
        let area: f64 = found.iter().map(|s| s.area).sum();
        assert!((area / ball.area() - 1.0).abs() < 1e-3, "{area}");
        for prefix in [16, 64, 256] {
            let nearest = |s: &Sample| {
                let others = found[..prefix].iter().filter(|o| o.position != s.position);
                others.map(|o| o.position.distance(s.position)).fold(f64::MAX, f64::min)
            };
            let gaps: Vec<f64> = found[..prefix].iter().map(nearest).collect();
            let (least, most) = gaps.iter().fold((f64::MAX, 0.0_f64), |(l, m), &g| (l.min(g), m.max(g)));
            assert!(most < 2.1 * least, "{prefix}: {least} to {most}");
        }
        assert!(found.iter().all(|s| (s.normal.length() - 1.0).abs() < 1e-9 && s.normal.dot(s.position.normalize()) > 0.99));
    }

    #[test]
    fn a_direction_that_finds_a_sample_again_does_not_end_the_search() {
        // four corners are the outermost along all fourteen directions, whichever comes last
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let tetrahedron = Mesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] };
        let found = samples(&tetrahedron, &Distance::new(&tetrahedron).unwrap(), DVec3::splat(0.25), 64, &mut |_| {});
        assert_eq!(found.len(), 64);
    }

    #[test]
    fn corners_come_first() {
        let cube = tessellate::cuboid(DVec3::new(0.02, 0.03, 0.04));
        let found = samples(&cube, &Distance::new(&cube).unwrap(), DVec3::ZERO, 64, &mut |_| {});
        let corner = DVec3::new(0.01, 0.015, 0.02);
        let reached = |sign: DVec3| found[..8].iter().any(|s| s.position.distance(corner * sign) < 1e-9);
        for k in 0..8 {
            let sign = |bit: u32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
            assert!(reached(DVec3::new(sign(0), sign(1), sign(2))), "corner {k}");
        }
    }
}

//! Polygons into triangles: a fan where every corner turns the same way, ears (`earcut`) where one does not.

use earcut::Earcut;
use glam::DVec3;

use crate::mesh::Mesh;

/// Most corners of a polygon that is cut by ears, whose time grows with their square; one of more corners is fanned.
const MAX_EARS: usize = 1024;

/// Adds a polygon of vertices of `mesh`; one of fewer than three corners adds nothing.
pub(super) fn append(mesh: &mut Mesh, corners: &[u32]) {
    match *corners {
        [] | [_] | [_, _] => {}
        [a, b, c] => mesh.triangles.push([a, b, c]),
        [first, ref others @ ..] => {
            let places: Vec<DVec3> = corners.iter().map(|&corner| mesh.vertices[corner as usize]).collect();
            let ears = if is_convex(&places) { None } else { ears(&places) };
            match ears {
                Some(ears) => mesh.triangles.extend(ears.iter().map(|ear| ear.map(|index| corners[index as usize]))),
                None => mesh.triangles.extend(others.windows(2).map(|pair| [first, pair[0], pair[1]])),
            }
        }
    }
}

/// Normal of a polygon, twice as long as its area (Newell).
fn normal(places: &[DVec3]) -> DVec3 {
    let origin = places[0];
    let next = places.iter().cycle().skip(1);
    places.iter().zip(next).map(|(&a, &b)| (a - origin).cross(b - origin)).sum()
}

fn is_convex(places: &[DVec3]) -> bool {
    let (normal, count) = (normal(places), places.len());
    let turn = |i: usize| {
        let (last, here, next) = (places[i], places[(i + 1) % count], places[(i + 2) % count]);
        (here - last).cross(next - here).dot(normal)
    };
    (0..count).all(|i| turn(i) >= 0.0)
}

/// Triangles as indices of `places`, turned as the polygon is; `None` where there is no telling.
fn ears(places: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let normal = normal(places).normalize_or_zero();
    if places.len() > MAX_EARS || normal == DVec3::ZERO || !normal.is_finite() {
        return None;
    }
    let (x, y) = normal.any_orthonormal_pair();
    let flat: Vec<[f64; 2]> = places.iter().map(|place| [place.dot(x), place.dot(y)]).collect();
    let mut found: Vec<u32> = Vec::new();
    Earcut::new().earcut_slice::<u32>(&flat, &[], &mut found);
    let mut triangles: Vec<[u32; 3]> = found.chunks_exact(3).map(|three| [three[0], three[1], three[2]]).collect();
    let area = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|index| places[index as usize]);
        (b - a).cross(c - a).dot(normal)
    };
    if triangles.iter().map(area).sum::<f64>() < 0.0 {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    put_back(&mut triangles, places.len() as u32);
    // a polygon of n corners has n - 2 triangles; fewer would leave a gap
    (triangles.len() == places.len() - 2).then_some(triangles)
}

/// Puts back the corners that `earcut` left out because they lie on a straight edge: they split the triangle at that edge.
fn put_back(triangles: &mut Vec<[u32; 3]>, count: u32) {
    let mut used = vec![false; count as usize];
    triangles.iter().flatten().for_each(|&corner| used[corner as usize] = true);
    for corner in (0..count).filter(|&corner| !used[corner as usize]) {
        let before = (corner + count - 1) % count;
        let after = (1..count).map(|step| (corner + step) % count).find(|&other| used[other as usize] || other < corner);
        let at = |triangle: &[u32; 3]| (0..3).find(|&i| triangle[i] == before && Some(triangle[(i + 1) % 3]) == after);
        let Some((index, i)) = triangles.iter().enumerate().find_map(|(index, triangle)| Some((index, at(triangle)?))) else {
            return;
        };
        let [a, b, c] = [triangles[index][i], triangles[index][(i + 1) % 3], triangles[index][(i + 2) % 3]];
        triangles[index] = [a, corner, c];
        triangles.push([corner, b, c]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hollow_polygon_keeps_its_area_and_its_turn() {
        // an arrow head in the plane x = 1, hollow at its second corner
        let outline = [(0.0, 0.0), (0.4, 0.5), (0.0, 1.0), (2.0, 0.5)];
        let vertices = outline.iter().map(|&(y, z)| DVec3::new(1.0, y, z)).collect();
        let mut mesh = Mesh { vertices, triangles: Vec::new() };
        append(&mut mesh, &[0, 1, 2, 3]);
        append(&mut mesh, &[3, 2, 1, 0]);
        let areas: Vec<f64> = mesh.triangles.iter().map(|&t| crate::mesh::twice_area(mesh.corners(t)).x / 2.0).collect();
        assert_eq!(areas.len(), 4);
        assert!(areas[..2].iter().all(|&a| a < 0.0) && areas[2..].iter().all(|&a| a > 0.0), "{areas:?}");
        assert!((areas[..2].iter().sum::<f64>() + 0.8).abs() < 1e-12, "{areas:?}");
    }

    #[test]
    fn a_corner_on_a_straight_edge_is_kept() {
        // an L whose longest edges carry one and two corners more, first of all its corner 0
        let outline =
            [(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0), (0.0, 1.5), (0.0, 0.5), (0.0, 0.0)];
        let vertices: Vec<_> = outline.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect();
        let mut mesh = Mesh { vertices, triangles: Vec::new() };
        append(&mut mesh, &[0, 1, 2, 3, 4, 5, 6, 7, 8]);
        let areas: Vec<f64> = mesh.triangles.iter().map(|&t| crate::mesh::twice_area(mesh.corners(t)).z / 2.0).collect();
        assert!(areas.len() == 7 && areas.iter().all(|&a| a > 1e-9), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 3.0).abs() < 1e-12, "{areas:?}");
    }
}

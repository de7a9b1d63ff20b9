//! Mends what is usually wrong with a mesh: equal corners, triangles without area or twice there, disagreeing turns, small holes, inside out.
//!
//! In this order, because each step needs the one before: corners join, so that edges meet; triangles that collapsed or are there twice go; neighbours
//! agree about the outside, so that the rims of holes run one way; holes are closed; flat triangles, also those that closed a crack, give up
//! their long edge; each closed piece faces outwards (the wall of a hollow inwards). What stays wrong is told.
//!
//! | module | what it does |
//! |---|---|
//! | `turns` | makes triangles agree about the outside |
//! | `holes` | finds rims and closes the small ones |
//! | `slivers` | swaps the long edges of triangles without a usable normal |

mod holes;
mod slivers;
mod turns;

use crate::check::{Findings, check};
use crate::mesh::Mesh;
use crate::weld::weld;

/// Most edges of a rim that is closed when nothing else is asked for: a scanner's missing patch, not an open bowl.
pub const HOLE_EDGES: usize = 64;

/// Most edges of a rim that can be asked for: the time to close one grows with their cube, one second at this number.
pub const MAX_HOLE_EDGES: usize = 1024;

/// How far mending may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MendSpec {
    /// Distance within which corners join \[m\]; `None` takes [`crate::weld::DEFAULT_TOLERANCE`] of the diagonal.
    pub tolerance: Option<f64>,
    /// Most edges of a rim that is closed, up to [`MAX_HOLE_EDGES`]; 0 closes none.
    pub hole_edges: usize,
}

impl Default for MendSpec {
    fn default() -> Self {
        Self { tolerance: None, hole_edges: HOLE_EDGES }
    }
}

/// What was mended, in counts, and what is still wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Vertices that were joined with others, or belonged to no triangle.
    pub vertices: usize,
    /// Triangles that had no three corners left.
    pub collapsed: usize,
    /// Triangles that were there already.
    pub doubled: usize,
    /// Triangles that were turned over.
    pub turned: usize,
    /// Holes that were closed, and the triangles that this took.
    pub holes: usize,
    /// Triangles that close holes.
    pub added: usize,
    /// Flat triangles whose long edge was swapped.
    pub swapped: usize,
    /// Rims of more edges than were to be closed, or that cannot be closed.
    pub rims_left: usize,
    /// Edges of the longest rim left.
    pub longest_rim: usize,
    /// What is still wrong.
    pub left: Findings,
}

impl Mended {
    /// Nothing had to be done but to join corners.
    pub fn is_untouched(&self) -> bool {
        let Self { collapsed, doubled, turned, holes, swapped, .. } = *self;
        [collapsed, doubled, turned, holes, swapped] == [0; 5]
    }

    /// One line for each thing that was done.
    pub fn done(&self) -> Vec<String> {
        let counted = [
            (self.vertices, "vertices joined with others or dropped"),
            (self.collapsed, "triangles without three corners removed"),
            (self.doubled, "triangles removed that were there twice"),
            (self.turned, "triangles turned over"),
            (self.holes, "holes closed"),
            (self.added, "triangles added in them"),
            (self.swapped, "flat triangles mended"),
        ];
        counted.iter().filter(|(count, _)| *count > 0).map(|(count, text)| format!("{count} {text}")).collect()
    }

    /// One line for each thing that is still wrong.
    pub fn undone(&self) -> Vec<String> {
        let rims = (self.rims_left > 0).then(|| {
            format!(
                "{} rims not closed, the longest of {} edges: allow more edges or close them",
                self.rims_left, self.longest_rim
            )
        });
        self.left.problems().into_iter().chain(rims).collect()
    }
}

/// Mends a mesh.
pub fn mend(mesh: &Mesh, spec: &MendSpec) -> (Mesh, Mended) {
    let mut mended = Mended::default();
    let mut whole = weld(mesh, spec.tolerance);
    mended.vertices = mesh.vertices.len() - whole.vertices.len();
    mended.collapsed = mesh.triangles.len() - whole.triangles.len();
    mended.doubled = drop_doubled(&mut whole);
    mended.turned = turns::agree(&mut whole);
    let holes = holes::close(&mut whole, spec.hole_edges.min(MAX_HOLE_EDGES));
    (mended.holes, mended.added) = (holes.closed, holes.added);
    (mended.rims_left, mended.longest_rim) = (holes.left, holes.longest);
    mended.swapped = slivers::swap(&mut whole);
    mended.turned += turns::face_outwards(&mut whole);
    mended.left = check(&whole);
    (whole, mended)
}

/// Keeps the first of the triangles that have the same corners; how many went.
fn drop_doubled(mesh: &mut Mesh) -> usize {
    let corners = |index: u32| {
        let mut corners = mesh.triangles[index as usize];
        corners.sort_unstable();
        corners
    };
    let mut order: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    order.sort_by_key(|&index| (corners(index), index));
    let mut stays = vec![true; mesh.triangles.len()];
    for pair in order.windows(2) {
        stays[pair[1] as usize] = corners(pair[0]) != corners(pair[1]);
    }
    let before = mesh.triangles.len();
    let mut stays = stays.iter();
    mesh.triangles.retain(|_| stays.next().copied().unwrap_or(true));
    before - mesh.triangles.len()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::check::joined;
    use crate::{properties, tessellate};

    fn ball() -> Mesh {
        tessellate::ellipsoid(DVec3::new(0.03, 0.02, 0.02), 32)
    }

    fn without(mesh: &Mesh, from: usize, count: usize) -> Mesh {
        let mut open = mesh.clone();
        open.triangles.drain(from..from + count);
        open
    }

    #[test]
    fn what_was_broken_is_mended_and_counted() {
        let cube = tessellate::cuboid(DVec3::ONE);
        let mut turned = ball();
        (0..100).for_each(|i| turned.triangles[7 * i].swap(0, 1));
        let mut soup = Mesh::default();
        for &triangle in &ball().triangles {
            let first = soup.vertices.len() as u32;
            soup.vertices.extend(ball().corners(triangle));
            soup.triangles.push([first, first + 1, first + 2]);
        }
        let mut doubled = ball();
        doubled.triangles.extend_from_within(5..9);
        doubled.triangles.push([3, 3, 4]);
        let all = cube.triangles.len();
        let table = [
            ("a soup", soup, Mended { vertices: 3 * 960 - 482, ..Mended::default() }),
            ("turned", turned, Mended { turned: 100, ..Mended::default() }),
            ("doubled", doubled, Mended { doubled: 4, collapsed: 1, ..Mended::default() }),
            ("inside out", cube.mapped(|v| -v), Mended { turned: all, ..Mended::default() }),
            ("a hole", without(&ball(), 100, 1), Mended { holes: 1, added: 1, ..Mended::default() }),
            ("a larger hole", without(&ball(), 100, 12), Mended { holes: 1, added: 12, ..Mended::default() }),
            ("two holes", without(&without(&ball(), 100, 2), 700, 2), Mended { holes: 2, added: 4, ..Mended::default() }),
            (
                "a hollow cube, both outwards",
                joined(&cube, &cube.mapped(|v| 0.5 * v)),
                Mended { turned: all, ..Mended::default() },
            ),
        ];
        for (name, broken, mut expected) in table {
            let (whole, found) = mend(&broken, &MendSpec::default());
            expected.left.pieces = found.left.pieces;
            assert!(check(&whole).is_solid(), "{name}: {found:?}");
            assert_eq!(found, expected, "{name}");
            assert!(found.undone().is_empty(), "{name}");
            let volume = properties(&whole).unwrap().volume;
            let truth = if broken.vertices.len() < 20 {
                if name.contains("hollow") { 0.875 } else { 1.0 }
            } else {
                properties(&ball()).unwrap().volume
            };
            assert!((volume / truth - 1.0).abs() < 0.01, "{name}: {volume}");
        }
    }

    #[test]
    fn a_crack_beside_a_vertex_of_one_side_only_is_closed_without_a_flat_triangle() {
        // one edge of the cube carries a vertex that the other side's triangle does not know
        let mut cube = tessellate::cuboid(DVec3::ONE);
        let [a, b, c] = cube.triangles[0];
        cube.vertices.push((cube.vertices[a as usize] + cube.vertices[b as usize]) / 2.0);
        cube.triangles[0] = [a, 8, c];
        cube.triangles.push([8, b, c]);
        assert!(!check(&cube).is_solid());
        let (whole, found) = mend(&cube, &MendSpec::default());
        assert!(check(&whole).is_solid() && found.holes == 1 && found.swapped == 1, "{found:?}");
        assert!((properties(&whole).unwrap().volume - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_mended_is_told() {
        let open = without(&ball(), 100, 12);
        let (whole, found) = mend(&open, &MendSpec { hole_edges: 8, ..MendSpec::default() });
        assert_eq!((found.holes, found.rims_left, whole.triangles.len()), (0, 1, open.triangles.len()));
        assert!(found.undone().iter().any(|line| line.contains("1 rims not closed, the longest of ")), "{:?}", found.undone());
        // a strip with half a turn has one side
        let around = |k: u32| std::f64::consts::TAU * f64::from(k % 12) / 12.0;
        let vertices = (0..24).map(|k| {
            let (angle, side) = (around(k / 2), if k % 2 == 0 { -0.2 } else { 0.2 });
            let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
            out + (out * (angle / 2.0).cos() + DVec3::Z * (angle / 2.0).sin()) * side
        });
        let strip = (0..12_u32).flat_map(|k| {
            let (a, b) = (2 * k, 2 * k + 1);
            let (c, d) = if k == 11 { (1, 0) } else { (a + 2, b + 2) };
            [[a, b, c], [b, d, c]]
        });
        let (_, found) = mend(&Mesh { vertices: vertices.collect(), triangles: strip.collect() }, &MendSpec::default());
        assert!(found.left.flipped_edges > 0 && !found.undone().is_empty(), "{found:?}");
        // nothing at all
        assert_eq!(mend(&Mesh::default(), &MendSpec::default()), (Mesh::default(), Mended::default()));
    }
}

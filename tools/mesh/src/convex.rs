//! How far a mesh is from convex, and cutting it into convex parts.
//!
//! The core makes at most one contact per part, which is the whole truth for convex parts only. A probe whose **concavity** (depth of the
//! surface's deepest point inside the convex hull, over the diagonal of the bounds; vertices and points spread by area are asked, because the
//! vertices of a prism's hollow all lie on its hull) exceeds a tolerance is cut (approximate convex decomposition on
//! voxels; K. Mamou, Volumetric hierarchical approximate convex decomposition, 2016), and every part is replaced by its convex hull.

use glam::DVec3;
use parry3d_f64::transformation::{try_convex_hull, vhacd};

use crate::check::flat;
use crate::distance::{Distance, to_tree};
use crate::mesh::{Mesh, twice_area};
use crate::repair::{MendSpec, mend};
use crate::samples::places_by_area;

/// Concavity below which a mesh is taken as convex: facets and rounding of a file, not a hollow.
pub const CONVEX: f64 = 2.0e-3;

/// How fine a mesh is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutSpec {
    /// Most parts; the core takes 16.
    pub parts: usize,
    /// Voxels along the longest side.
    pub voxels: u32,
    /// Concavity at which a part is left whole, as a share of the whole's.
    pub concavity: f64,
}

impl Default for CutSpec {
    fn default() -> Self {
        Self { parts: 16, voxels: 96, concavity: 0.02 }
    }
}

/// Convex hull; `None` where the points span no volume.
///
/// Many points in one plane make the hull's maker err; it is asked again with points moved by ever more of a hair's breadth until all of them lie within.
///
/// Of more than 65,536 vertices only the outermost in each of 24,576 directions from the middle are taken: the hull is then up to 2e-4 of its size too small.
pub fn hull(mesh: &Mesh) -> Option<Mesh> {
    let (low, high) = mesh.bounds()?;
    let size = (high - low).length();
    let outermost = outermost(&mesh.vertices, (low + high) / 2.0);
    let tries = STIRS.iter().filter_map(|stir| {
        let points: Vec<_> = outermost.iter().enumerate().map(|(i, &v)| to_tree(v + stirred(i as u32) * (stir * size))).collect();
        let (vertices, triangles) = try_convex_hull(&points).ok()?;
        let hull = Mesh { vertices: vertices.iter().map(|v| DVec3::new(v.x, v.y, v.z)).collect(), triangles };
        let beyond = beyond(&hull, &outermost) / size;
        Some((hull, beyond))
    });
    let mut best: Option<(Mesh, f64)> = None;
    for (hull, beyond) in tries {
        if best.as_ref().is_none_or(|(_, least)| beyond < *least) {
            best = Some((hull, beyond));
        }
        if beyond < WITHIN {
            break;
        }
    }
    best.map(|(hull, _)| hull)
}

/// Most points that a hull is made of as they are: a second's work.
const MAX_POINTS: usize = 65_536;

/// Directions along an edge of the cube around the middle, where there are more.
const DIRECTIONS: usize = 64;

/// The points that lie farthest from `middle` in each direction; all where they are few.
fn outermost(points: &[DVec3], middle: DVec3) -> Vec<DVec3> {
    if points.len() <= MAX_POINTS {
        return points.to_vec();
    }
    let mut farthest = vec![None; 6 * DIRECTIONS * DIRECTIONS];
    for &point in points {
        let off = point - middle;
        let axis = off.abs().max_position();
        let towards = off[axis];
        let step = |along: f64| ((along / towards.abs() + 1.0) * 0.5 * (DIRECTIONS - 1) as f64).round() as usize;
        let face = 2 * axis + usize::from(towards < 0.0);
        // the middle itself has no direction; `as` takes its NaN to the first
        let index = (face * DIRECTIONS + step(off[(axis + 1) % 3])) * DIRECTIONS + step(off[(axis + 2) % 3]);
        let kept: &mut Option<DVec3> = &mut farthest[index];
        if kept.is_none_or(|kept| kept.distance_squared(middle) < off.length_squared()) {
            *kept = Some(point);
        }
    }
    farthest.into_iter().flatten().collect()
}

/// How far points are moved, as shares of the diagonal: none at first, then up to what joining of corners forgives.
const STIRS: [f64; 4] = [0.0, 1.0e-9, 1.0e-8, 1.0e-7];

/// Farthest that a point may lie outside of a good hull, as a share of the diagonal: ten times the largest move.
const WITHIN: f64 = 1.0e-6;

/// Most questions of a point and a face, the points evenly thinned where there are more: a tenth of a second.
const QUESTIONS: usize = 50_000_000;

/// A direction of its own for each point, at most 1 long: three steps of the plastic number's kin.
fn stirred(index: u32) -> DVec3 {
    const STEPS: DVec3 = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);
    ((STEPS * f64::from(index)).fract() - DVec3::splat(0.5)) / 3.0_f64.sqrt() * 2.0
}

/// How far the farthest of `points` lies outside of the plane of a hull's face \[m\].
fn beyond(hull: &Mesh, points: &[DVec3]) -> f64 {
    let stride = (hull.triangles.len() * points.len()).div_ceil(QUESTIONS).max(1);
    let faces = hull.triangles.iter().map(|&triangle| hull.corners(triangle)).filter(|&corners| !flat(corners));
    let over = |corners: [DVec3; 3]| {
        let normal = twice_area(corners).normalize_or_zero();
        points.iter().step_by(stride).map(|&point| normal.dot(point - corners[0])).fold(0.0, f64::max)
    };
    faces.map(over).fold(0.0, f64::max)
}

/// How far a mesh is from convex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hollow {
    /// Depth of the surface's deepest point under the hull \[m\].
    pub depth: f64,
    /// The same over the diagonal of the bounds.
    pub share: f64,
}

impl Hollow {
    /// Facets and rounding at most.
    pub fn is_convex(&self) -> bool {
        self.share <= CONVEX
    }
}

/// How far a mesh is from convex; `None` where there is no hull.
pub fn hollow(mesh: &Mesh) -> Option<Hollow> {
    let hull = Distance::new(&hull(mesh)?)?;
    let (low, high) = mesh.bounds()?;
    let stride = mesh.vertices.len().div_ceil(ASKED_VERTICES).max(1);
    let points = mesh.vertices.iter().copied().step_by(stride).chain(places_by_area(mesh, ASKED));
    // every point lies in the hull or on it, so no sign is needed, which a sliver of the hull might get wrong
    let depth = points.map(|p| hull.signed(p).abs()).fold(0.0, f64::max);
    Some(Hollow { depth, share: depth / (high - low).length() })
}

/// Points of the surface that are asked for their depth: fifty along a side of a cube.
const ASKED: usize = 16_384;

/// Most vertices that are asked, evenly thinned where there are more: a second's work.
const ASKED_VERTICES: usize = 262_144;

/// A hull without flat triangles, which its maker leaves where many points lie in a plane.
fn sound_hull(mesh: &Mesh) -> Option<Mesh> {
    hull(mesh).map(|hull| mend(&hull, &MendSpec::default()).0)
}

/// Cuts a solid mesh into convex parts, each closed and outside out; a convex one stays whole. Empty where it has no volume.
pub fn cut(mesh: &Mesh, spec: &CutSpec) -> Vec<Mesh> {
    if hollow(mesh).is_some_and(|found| found.is_convex()) {
        return sound_hull(mesh).into_iter().collect();
    }
    let points: Vec<_> = mesh.vertices.iter().map(|&v| to_tree(v)).collect();
    let parameters = vhacd::VHACDParameters {
        resolution: spec.voxels,
        concavity: spec.concavity,
        plane_downsampling: 2,
        convex_hull_downsampling: 2,
        max_convex_hulls: spec.parts as u32,
        ..vhacd::VHACDParameters::default()
    };
    let parts = vhacd::VHACD::decompose(&parameters, &points, &mesh.triangles, true);
    let as_mesh = |(vertices, _): (Vec<parry3d_f64::math::Vector>, Vec<[u32; 3]>)| {
        sound_hull(&Mesh { vertices: vertices.iter().map(|v| DVec3::new(v.x, v.y, v.z)).collect(), triangles: Vec::new() })
    };
    parts.compute_exact_convex_hulls(&points, &mesh.triangles).into_iter().filter_map(as_mesh).collect()
}

/// An L of two unit cubes' width: the union of [0, 2] x [0, 1] x [0, 1] and [0, 1] x [0, 2] x [0, 1].
#[cfg(test)]
pub(crate) fn ell() -> Mesh {
    let outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
    let vertices = [0.0, 1.0].iter().flat_map(|&z| outline.iter().map(move |&(x, y)| DVec3::new(x, y, z))).collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for k in 0..6 {
        let next = (k + 1) % 6;
        triangles.extend([[k, next, next + 6], [k, next + 6, k + 6]]);
    }
    // the cap is a fan about the hollow corner, which sees every other
    for k in [4, 5, 0, 1] {
        let next = (k + 1) % 6;
        triangles.extend([[3, next, k], [9, k + 6, next + 6]]);
    }
    Mesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{check, properties, tessellate};

    #[test]
    fn convex_meshes_have_no_concavity_and_a_hollow_has_its_depth() {
        for mesh in
            [tessellate::cuboid(DVec3::ONE), tessellate::ellipsoid(DVec3::new(1.0, 2.0, 3.0), 32), tessellate::cone(1.0, 2.0, 32)]
        {
            assert!(hollow(&mesh).unwrap().share < 1e-9, "{:?}", hollow(&mesh));
        }
        // half way up, the hollow edge lies 1/2 under the caps and 1/sqrt(2) under the plane from (2, 1) to (1, 2)
        let found = hollow(&ell()).unwrap();
        assert!((found.share - 0.5 / 3.0).abs() < 4e-3 && (found.depth - 0.5).abs() < 0.012, "{found:?}");
    }

    #[test]
    fn an_l_is_cut_into_few_solid_convex_parts_that_fill_it() {
        assert!(check(&ell()).is_solid());
        let parts = cut(&ell(), &CutSpec::default());
        assert!((2..=16).contains(&parts.len()), "{} parts", parts.len());
        let mut volume = 0.0;
        for part in &parts {
            assert!(check(part).is_watertight() && check(part).inside_out == 0, "{:?}", check(part));
            assert!(hollow(part).unwrap().share < 1e-6);
            volume += properties(part).unwrap().volume;
        }
        assert!((volume / 3.0 - 1.0).abs() < 0.03, "{} parts of {volume} m^3 in sum", parts.len());
    }
}

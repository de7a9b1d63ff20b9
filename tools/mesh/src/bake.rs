//! Bakes a mesh for the core: distance grid, samples and numbers, with the errors they have.
//!
//! The grid's spacing is the longest extent over the cells asked for; four nodes of margin on every side keep the solid clear of the
//! border. The splines follow the exact distances ([`crate::spline`]); they round edges over a spacing and smooth facets smaller than one. What is off is measured at the mesh's own vertices and face centres, where the distance should be zero.

use glam::DVec3;
use haptor_contact::geometry::distance_grid::MAX_NODES;
use haptor_contact::{DistanceGrid, Invalid, MAX_SURFACE_SAMPLES, MeshShape, MeshSpec, SurfaceSample, Vec3};
use thiserror::Error;

use crate::distance::Distance;
use crate::mesh::Mesh;
use crate::properties::properties;
use crate::samples::samples;
use crate::{check, spline};

/// Nodes between the solid and the border of the grid.
const MARGIN: usize = 4;

/// How fine a mesh is baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeSpec {
    /// Cells along the longest extent, 8 to 120.
    pub cells: usize,
    /// Surface samples, 1 to 2048.
    pub samples: usize,
}

impl Default for BakeSpec {
    fn default() -> Self {
        Self { cells: 56, samples: 1024 }
    }
}

/// Why a mesh cannot be baked.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BakeError {
    /// The mesh encloses no solid.
    #[error("the mesh is no solid: {0}")]
    NotSolid(String),
    /// A number of the spec is out of range.
    #[error("{name} is {value}, allowed is {allowed}")]
    Spec {
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: usize,
        /// The range in words.
        allowed: &'static str,
    },
    /// The core refuses what came out.
    #[error("{0}")]
    Refused(#[from] Invalid),
}

/// How far the baked distance is off at the mesh's own vertices and face centres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DistanceError {
    /// Largest \[m\].
    pub max: f64,
    /// Root of the mean square \[m\].
    pub rms: f64,
}

/// A baked mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// First node \[m\].
    pub origin: Vec3,
    /// Distance between nodes \[m\].
    pub spacing: f32,
    /// Nodes along x, y, z.
    pub counts: [usize; 3],
    /// Coefficients, x fastest \[m\].
    pub coefficients: Vec<f32>,
    /// Samples in progressive order.
    pub samples: Vec<SurfaceSample>,
    /// Smallest coordinates of the mesh \[m\].
    pub low: Vec3,
    /// Largest coordinates of the mesh \[m\].
    pub high: Vec3,
    /// Volume \[m^3\].
    pub volume: f32,
    /// Largest distance of a vertex from the origin \[m\].
    pub reach: f32,
    /// Error of the baked distance.
    pub error: DistanceError,
    /// Longest edge of the mesh \[m\]: facets longer than a spacing are felt as facets.
    pub longest_edge: f64,
}

impl Baked {
    /// The shape that the core takes; borrows the grid and the samples.
    ///
    /// # Errors
    /// [`Invalid`] names what the core refuses.
    pub fn shape(&self) -> Result<MeshShape<'_>, Invalid> {
        let grid = DistanceGrid::new(self.origin, self.spacing, self.counts, &self.coefficients)?;
        let Self { low, high, volume, reach, .. } = *self;
        MeshShape::new(&MeshSpec { grid, samples: &self.samples, low, high, volume, reach })
    }

    /// Volume where the baked distance is negative \[m^3\], each node standing for a cell that the surface cuts at its distance; `None` where the core
    /// refuses the grid.
    pub fn field_volume(&self) -> Option<f64> {
        let grid = DistanceGrid::new(self.origin, self.spacing, self.counts, &self.coefficients).ok()?;
        let [nx, ny, nz] = self.counts;
        let nodes = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        let inside = nodes.map(|node| {
            let place = self.origin + Vec3::from_array(node.map(|index| index as f32)) * self.spacing;
            f64::from((0.5 - grid.slope(place).0 / self.spacing).clamp(0.0, 1.0))
        });
        Some(inside.sum::<f64>() * f64::from(self.spacing).powi(3))
    }
}

/// The mesh moved so that its mass centre is the origin, and where that was \[m\]: the frame of a probe. `None` without volume.
pub fn about_mass_centre(mesh: &Mesh) -> Option<(Mesh, DVec3)> {
    let centre = properties(mesh)?.centre;
    Some((mesh.mapped(|v| v - centre), centre))
}

/// The mesh moved so that the centre of its bounds' base is the origin, and where that was \[m\]: the frame of an object. `None` without vertices.
pub fn on_its_base(mesh: &Mesh) -> Option<(Mesh, DVec3)> {
    let (low, high) = mesh.bounds()?;
    let middle = (low + high) / 2.0;
    let base = DVec3::new(middle.x, middle.y, low.z);
    Some((mesh.mapped(|v| v - base), base))
}

/// Bakes a solid mesh in its own frame. `progress` is told the share done, 0 to 1.
///
/// # Errors
/// [`BakeError`] says what is wrong with the mesh or the spec.
pub fn bake(mesh: &Mesh, spec: &BakeSpec, progress: &mut dyn FnMut(f64)) -> Result<Baked, BakeError> {
    check_spec(spec)?;
    let findings = check(mesh);
    if !findings.is_solid() {
        return Err(BakeError::NotSolid(findings.problems().join("; ")));
    }
    let nothing = || BakeError::NotSolid("it encloses no volume".to_owned());
    let (low, high) = mesh.bounds().ok_or_else(nothing)?;
    let solid = properties(mesh).ok_or_else(nothing)?;
    let distance = Distance::new(mesh).ok_or_else(nothing)?;
    let place = Place::about(low, high, spec.cells);
    let values = place.distances(&distance, &mut |share| progress(0.7 * share));
    let coefficients = spline::coefficients(&values, place.counts);
    let found = samples(mesh, &distance, solid.centre, spec.samples, &mut |share| progress(0.7 + 0.3 * share));
    let mut baked = Baked {
        origin: place.origin.as_vec3(),
        spacing: place.spacing as f32,
        counts: place.counts,
        coefficients: coefficients.iter().map(|&c| c as f32).collect(),
        samples: found
            .iter()
            .map(|s| SurfaceSample { position: s.position.as_vec3(), normal: s.normal.as_vec3(), area: s.area as f32 })
            .collect(),
        low: low.as_vec3(),
        high: high.as_vec3(),
        volume: solid.volume as f32,
        reach: mesh.vertices.iter().map(|v| v.length()).fold(0.0, f64::max) as f32,
        error: DistanceError::default(),
        longest_edge: longest_edge(mesh),
    };
    baked.error = error(mesh, &baked)?;
    Ok(baked)
}

fn check_spec(spec: &BakeSpec) -> Result<(), BakeError> {
    let most = MAX_NODES - 2 * MARGIN;
    if !(8..=most).contains(&spec.cells) {
        return Err(BakeError::Spec { name: "cells", value: spec.cells, allowed: "8 to 120" });
    }
    if !(1..=MAX_SURFACE_SAMPLES).contains(&spec.samples) {
        return Err(BakeError::Spec { name: "samples", value: spec.samples, allowed: "1 to 2048" });
    }
    Ok(())
}

/// Where the nodes of a grid stand.
struct Place {
    origin: DVec3,
    spacing: f64,
    counts: [usize; 3],
}

impl Place {
    fn about(low: DVec3, high: DVec3, cells: usize) -> Self {
        // rounded to f32, so that the core's nodes are the ones that were measured
        let spacing = f64::from(((high - low).max_element() / cells as f64) as f32);
        let counts = (high - low).to_array().map(|extent| (extent / spacing).ceil() as usize + 1 + 2 * MARGIN);
        let counts = counts.map(|n| n.min(MAX_NODES));
        let span = DVec3::from_array(counts.map(|n| (n - 1) as f64)) * spacing;
        let origin = ((low + high - span) / 2.0).as_vec3().as_dvec3();
        Self { origin, spacing, counts }
    }

    fn distances(&self, distance: &Distance, progress: &mut dyn FnMut(f64)) -> Vec<f64> {
        let [nx, ny, nz] = self.counts;
        let mut values = Vec::with_capacity(nx * ny * nz);
        for k in 0..nz {
            for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
                let node = DVec3::new(i as f64, j as f64, k as f64);
                values.push(distance.signed(self.origin + node * self.spacing));
            }
            progress((k + 1) as f64 / nz as f64);
        }
        values
    }
}

fn error(mesh: &Mesh, baked: &Baked) -> Result<DistanceError, Invalid> {
    let shape = baked.shape()?;
    let off = |p: DVec3| f64::from(shape.grid().slope(p.as_vec3()).0);
    let centres = mesh.triangles.iter().map(|&t| mesh.corners(t).iter().sum::<DVec3>() / 3.0);
    let (mut max, mut squares, mut count) = (0.0_f64, 0.0, 0);
    for value in mesh.vertices.iter().copied().chain(centres).map(off) {
        (max, squares, count) = (max.max(value.abs()), squares + value * value, count + 1);
    }
    Ok(DistanceError { max, rms: (squares / f64::from(count.max(1))).sqrt() })
}

fn longest_edge(mesh: &Mesh) -> f64 {
    let edges = mesh.triangles.iter().flat_map(|&t| {
        let [a, b, c] = mesh.corners(t);
        [a.distance(b), b.distance(c), c.distance(a)]
    });
    edges.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate;

    #[test]
    fn a_ball_is_baked_to_microns() {
        let mesh = tessellate::ellipsoid(DVec3::splat(0.02), 128);
        let mut shares = Vec::new();
        let baked = bake(&mesh, &BakeSpec { cells: 40, samples: 256 }, &mut |share| shares.push(share)).unwrap();
        assert!(baked.error.max < 1.5e-5, "{:?}", baked.error);
        assert!(shares.windows(2).all(|pair| pair[0] <= pair[1]) && (shares.last().unwrap() - 1.0).abs() < 1e-9);
        let shape = baked.shape().unwrap();
        let (value, gradient) = shape.grid().slope(Vec3::new(0.012, 0.0, 0.012));
        assert!((value - (0.012 * 2.0_f32.sqrt() - 0.02)).abs() < 1.5e-5, "{value}");
        assert!((gradient - Vec3::new(1.0, 0.0, 1.0).normalize()).length() < 5.0e-3, "{gradient}");
    }

    #[test]
    fn what_cannot_be_baked_is_refused_with_the_reason() {
        let cube = tessellate::cuboid(DVec3::splat(0.1));
        let open = Mesh { triangles: cube.triangles[1..].to_vec(), ..cube.clone() };
        let refused = |mesh: &Mesh, spec: &BakeSpec| bake(mesh, spec, &mut |_| {}).unwrap_err().to_string();
        assert!(refused(&open, &BakeSpec::default()).contains("holes"));
        assert!(refused(&cube, &BakeSpec { cells: 500, ..BakeSpec::default() }).contains("cells is 500"));
        assert!(refused(&cube, &BakeSpec { samples: 0, ..BakeSpec::default() }).contains("samples is 0"));
    }
}

//! A body given by a mesh: its distance grid, samples of its surface and a few numbers.
//!
//! As a part of the probe it stands in the part's frame; as the object its base's centre is the origin and +z is up. A part must be
//! convex (others are cut into convex parts when they are baked); an object that is not convex is felt where the search for the deepest
//! point ends, one patch per part.

use glam::Vec3;

use crate::error::{Invalid, require};
use crate::geometry::distance_grid::DistanceGrid;
use crate::limits::{MAX_DISTANCE, MAX_SURFACE_SAMPLES};
use crate::math::{PI, max, min, root};
use crate::model::ObjectShape;

/// A point of a mesh's surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceSample {
    /// Position \[m\].
    pub position: Vec3,
    /// Unit outward normal.
    pub normal: Vec3,
    /// Area the sample stands for in the full set \[m^2\].
    pub area: f32,
}

/// What a [`MeshShape`] is made from.
#[derive(Clone, Copy, Debug)]
pub struct MeshSpec<'a> {
    /// Signed distance.
    pub grid: DistanceGrid<'a>,
    /// Samples in progressive order: any prefix is a good coarser sampling. 1 to [`MAX_SURFACE_SAMPLES`].
    pub samples: &'a [SurfaceSample],
    /// Smallest coordinates of the mesh \[m\].
    pub low: Vec3,
    /// Largest coordinates of the mesh \[m\].
    pub high: Vec3,
    /// Volume \[m^3\].
    pub volume: f32,
    /// Largest distance of a vertex from the origin \[m\].
    pub reach: f32,
}

/// A validated mesh body; borrows grid and samples.
#[derive(Clone, Copy, PartialEq)]
pub struct MeshShape<'a> {
    grid: DistanceGrid<'a>,
    samples: &'a [SurfaceSample],
    low: Vec3,
    high: Vec3,
    volume: f32,
    reach: f32,
    area: f32,
}

impl core::fmt::Debug for MeshShape<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { grid, low, high, .. } = self;
        f.debug_struct("MeshShape").field("grid", grid).field("low", low).field("high", high).finish_non_exhaustive()
    }
}

/// How far normals may be from unit length.
const NORMAL_TOLERANCE: f32 = 1.0e-3;

impl<'a> MeshShape<'a> {
    /// Validates the spec.
    ///
    /// # Errors
    /// [`Invalid`] names the first value out of range.
    pub fn new(spec: &MeshSpec<'a>) -> Result<Self, Invalid> {
        let MeshSpec { grid, samples, low, high, volume, reach } = *spec;
        let count = samples.len();
        require((1..=MAX_SURFACE_SAMPLES).contains(&count), "mesh.samples (count)", count as f32, "1 to 2048")?;
        let extent = (high - low).min_element();
        require(extent > 0.0, "mesh.high (least extent)", extent, "above 0 m on every axis")?;
        let hull = extents_product(high - low);
        require(volume > 0.0 && volume <= 1.001 * hull, "mesh.volume", volume, "above 0 to the volume of its bounds, m^3")?;
        let corner = low.abs().max(high.abs()).length();
        require(reach > 0.0 && reach <= 1.001 * corner, "mesh.reach", reach, "above 0 to the farthest corner of its bounds, m")?;
        require(corner <= MAX_DISTANCE, "mesh.high (farthest corner)", corner, "within 1e3 m")?;
        let mut area = 0.0;
        for sample in samples {
            check_sample(sample, reach)?;
            area += sample.area;
        }
        require(area > 0.0, "mesh.samples (area)", area, "above 0 m^2 in sum")?;
        Ok(Self { grid, samples, low, high, volume, reach, area })
    }

    /// Signed distance.
    pub fn grid(&self) -> &DistanceGrid<'a> {
        &self.grid
    }

    /// Samples in progressive order.
    pub fn samples(&self) -> &'a [SurfaceSample] {
        self.samples
    }

    /// The same body with a prefix of its samples, at least one.
    pub(crate) fn coarser(&self, samples: usize) -> Self {
        let most = self.samples.len().min(samples.max(1));
        Self { samples: self.samples.get(..most).unwrap_or(self.samples), ..*self }
    }

    /// Smallest and largest coordinates \[m\].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.low, self.high)
    }

    /// Radius of the ball about the origin that holds the mesh \[m\].
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// Radius of the widest disc a contact can cover \[m\]: no plane section of a convex solid has more than half its surface.
    pub fn widest_disc(&self) -> f32 {
        root(0.5 * self.area / PI)
    }

    /// Volume \[m^3\].
    pub fn volume(&self) -> f32 {
        self.volume
    }

    /// The primitive of equal extents that fills its bounds most alike: box (all of them), upright cylinder (pi/4), ellipsoid (pi/6). It lends
    /// the mesh the figures that have closed forms for primitives only: body compliance, section, the height below which it is held.
    pub fn stand_in(&self) -> ObjectShape<'static> {
        let size = self.high - self.low;
        let filled = self.volume / extents_product(size);
        let round = max(size.x, size.y) <= ROUND * min(size.x, size.y);
        if filled > BOX_SHARE || (filled > CYLINDER_SHARE && !round) {
            ObjectShape::Box { size }
        } else if filled > CYLINDER_SHARE {
            ObjectShape::Cylinder { radius: 0.5 * root(size.x * size.y), height: size.z }
        } else if size.max_element() <= ROUND_BALL * size.min_element() {
            ObjectShape::Sphere { radius: 0.5 * size.z }
        } else {
            ObjectShape::Ellipsoid { semi_axes: 0.5 * size }
        }
    }
}

/// Shares of the bounds halfway between box (1), cylinder (0.785) and ellipsoid (0.524).
const BOX_SHARE: f32 = 0.893;
const CYLINDER_SHARE: f32 = 0.654;

/// Sides of a base within this ratio count as round.
const ROUND: f32 = 1.25;

/// Extents within this ratio count as a ball's.
const ROUND_BALL: f32 = 1.01;

fn extents_product(size: Vec3) -> f32 {
    size.x * size.y * size.z
}

fn check_sample(sample: &SurfaceSample, reach: f32) -> Result<(), Invalid> {
    let distance = sample.position.length();
    let sound = sample.position.is_finite() && distance <= 1.001 * reach;
    require(sound, "mesh.samples (distance from the origin)", distance, "within the mesh's reach, m")?;
    let length = sample.normal.length();
    require((length - 1.0).abs() <= NORMAL_TOLERANCE, "mesh.samples (length of a normal)", length, "1, within 1e-3")?;
    require(sample.area >= 0.0, "mesh.samples (area)", sample.area, "0 m^2 or more")
}

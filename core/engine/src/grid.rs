//! Meshes as a file carries them: distance grid and samples, read from a section and borrowed by the core.

use haptor_contact::{DistanceGrid, Invalid, MeshShape, MeshSpec, SurfaceSample, Vec3};
use haptor_wire::sections;

use crate::error::SceneError;

/// Numbers of a section before the coefficients.
const HEAD: usize = 16;

/// Numbers of a sample.
const SAMPLE: usize = 7;

/// A mesh: made before the real-time thread starts, and locked in memory with the rest.
#[derive(Clone, Debug)]
pub struct Grid {
    origin: Vec3,
    spacing: f32,
    counts: [usize; 3],
    coefficients: Vec<f32>,
    samples: Vec<SurfaceSample>,
    low: Vec3,
    high: Vec3,
    volume: f32,
    reach: f32,
}

impl Grid {
    /// Reads the contents of a section.
    ///
    /// # Errors
    /// [`SceneError::Section`] when its length is not what its head says, [`SceneError::Value`] when the core refuses a number.
    pub fn new(contents: &[u8]) -> Result<Self, SceneError> {
        let wrong = |what| SceneError::Section { kind: sections::GRID, what };
        let numbers: Vec<f32> = sections::numbers(contents).ok_or_else(|| wrong("its length is no multiple of four"))?.collect();
        let (head, rest) = numbers.split_first_chunk::<HEAD>().ok_or_else(|| wrong("it ends within its head"))?;
        let [x, y, z, spacing, nx, ny, nz, lx, ly, lz, hx, hy, hz, volume, reach, samples] = *head;
        // `as` takes what is no count to 0 or the largest one: the core refuses both
        let counts = [nx, ny, nz].map(|n| n as usize);
        let nodes = counts.iter().fold(1_usize, |product, &n| product.saturating_mul(n));
        let (coefficients, rest) = rest.split_at_checked(nodes).ok_or_else(|| wrong("it ends within the coefficients"))?;
        let (each, left) = rest.as_chunks::<SAMPLE>();
        if !left.is_empty() || each.len() as f32 != samples {
            return Err(wrong("another number of samples than it says"));
        }
        let grid = Self {
            origin: Vec3::new(x, y, z),
            spacing,
            counts,
            coefficients: coefficients.to_vec(),
            samples: each.iter().map(sample).collect(),
            low: Vec3::new(lx, ly, lz),
            high: Vec3::new(hx, hy, hz),
            volume,
            reach,
        };
        grid.shape()?;
        Ok(grid)
    }

    /// What the core takes; borrows coefficients and samples.
    ///
    /// # Errors
    /// [`Invalid`], which [`Self::new`] has ruled out.
    pub fn shape(&self) -> Result<MeshShape<'_>, Invalid> {
        let grid = DistanceGrid::new(self.origin, self.spacing, self.counts, &self.coefficients)?;
        let Self { low, high, volume, reach, .. } = *self;
        MeshShape::new(&MeshSpec { grid, samples: &self.samples, low, high, volume, reach })
    }
}

fn sample(&[x, y, z, nx, ny, nz, area]: &[f32; SAMPLE]) -> SurfaceSample {
    SurfaceSample { position: Vec3::new(x, y, z), normal: Vec3::new(nx, ny, nz), area }
}

//! The body's own Green's function, computed for the core (feature `fem`).
//!
//! [`GreenTable::compute`] loads every place of the core's chart with three forces and a torque, by finite elements
//! ([`crate::fem`], `anywhere`), takes the core's closed forms away and keeps the smooth rest.
//!
//! | module | what it does |
//! |---|---|
//! | `places` | the chart's nodes as places that can be loaded |
//! | `table` | unit loads, moves, closed forms taken away |
//! | `file` | the table as bytes |
//! | [`cache`] | tables kept in the user's cache folder |

pub mod cache;
mod file;
mod places;
mod table;

use haptor_contact::green::{Chart, GreenSpec};
use haptor_contact::{Invalid, Material, ObjectShape};
use sha2::{Digest, Sha256};

use crate::fem::FemError;
use crate::kept::Key;

/// Radius of the loaded discs, as a share of the smallest half extent: smaller than the distance that places keep from edges.
pub(crate) const RADIUS: f64 = 0.1;

/// The same for the own moves of round bodies: what their curvature adds grows towards small discs, and bricks must still show it.
pub(crate) const WIDE: f64 = 0.3;

/// Share of a twisted disc's half-space stiffness that a convex surface takes away, per radius over radius of curvature: the core's (theory.md,
/// section 7), which `own` therefore leaves out.
pub(crate) const CONVEX: f64 = 0.735;

/// How a table is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GreenOptions {
    /// Nodes along an edge of the chart: 3, 5, 7 or 9.
    pub per_edge: usize,
    /// Bricks along half the body's mean edge, 3 to 8.
    pub fineness: usize,
}

impl Default for GreenOptions {
    fn default() -> Self {
        Self { per_edge: 7, fineness: 6 }
    }
}

/// Everything a table depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GreenInputs {
    /// The body.
    pub shape: ObjectShape<'static>,
    /// Its material; the density plays no part.
    pub material: Material,
    /// Height at and below which it is held \[m\].
    pub fixed_below: f32,
    /// How the table is computed.
    pub options: GreenOptions,
}

/// Version of the method and of the core's closed forms: tables of another version are computed anew.
pub const METHOD: u32 = 1;

impl GreenInputs {
    /// Digest of the inputs and of [`METHOD`]: tables with the same key are the same.
    pub fn key(&self) -> Key {
        let (kind, [a, b, c]) = match self.shape {
            ObjectShape::HalfSpace => (0_u32, [0.0; 3]),
            ObjectShape::Box { size } => (1, size.to_array()),
            ObjectShape::Sphere { radius } => (2, [radius; 3]),
            ObjectShape::Ellipsoid { semi_axes } => (3, semi_axes.to_array()),
            ObjectShape::Cylinder { radius, height } => (4, [radius, height, 0.0]),
            ObjectShape::Mesh(mesh) => return Self { shape: mesh.stand_in(), ..*self }.key(),
        };
        let Material { young_modulus, poisson_ratio, .. } = self.material;
        let mut digest = Sha256::new();
        for number in [METHOD, kind, self.options.per_edge as u32, self.options.fineness as u32] {
            digest.update(number.to_le_bytes());
        }
        for number in [a, b, c, young_modulus, poisson_ratio, self.fixed_below] {
            digest.update(number.to_le_bytes());
        }
        Key(digest.finalize().into())
    }
}

/// Why there is no table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GreenError {
    /// The half space has no body.
    #[error("object.kind = \"half_space\": has no body to compute; choose another tier or object")]
    NoBody,
    /// An option is out of range.
    #[error("{name} = {value}: {expected}")]
    Option {
        /// The option.
        name: &'static str,
        /// Its value.
        value: usize,
        /// What it may be.
        expected: &'static str,
    },
    /// Too long for its bricks.
    #[error("longest over shortest edge = {found:.3}, at most {limit}: choose another tier or a less slender body")]
    Slender {
        /// Ratio found.
        found: f64,
        /// Largest that is computed.
        limit: f64,
    },
    /// The core refuses the body.
    #[error(transparent)]
    Model(#[from] Invalid),
    /// The finite elements cannot be made or solved.
    #[error(transparent)]
    Fem(#[from] FemError),
}

/// A body's table, owned. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct GreenTable {
    chart: Chart,
    patch_radius: f32,
    own: Vec<f32>,
    table: Vec<f32>,
}

impl GreenTable {
    /// Computes the table. `progress` is told (done, of).
    ///
    /// # Errors
    /// [`GreenError`] names what cannot be computed.
    pub fn compute(inputs: &GreenInputs, progress: &mut dyn FnMut(usize, usize)) -> Result<Self, GreenError> {
        table::compute(inputs, progress)
    }

    /// What the core borrows.
    pub fn spec(&self) -> GreenSpec<'_> {
        GreenSpec { chart: self.chart, patch_radius: self.patch_radius, own: &self.own, table: &self.table }
    }
}

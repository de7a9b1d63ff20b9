//! Compliance constants of an elastic body beyond the half space, by a small finite-element run.
//!
//! A rigid patch on an elastic body is softer than on the half space, because the whole body shears, bends and twists down to its
//! held base: 1/K = 1/K_half_space + C. This module computes C for a force along the normal, for drag along two directions and
//! for twist about the normal. A **place** is a contact: a point of the surface, the outward normal there and the patch's radius.
//!
//! | module | what it does |
//! |---|---|
//! | `element` | the brick of 27 nodes, which does not lock |
//! | `half_space` | Boussinesq and Cerruti: displacement and stress below a point force |
//! | `bricks` | meshes of bricks for the primitives |
//! | `system` | assembly and the sparse Cholesky factor |
//! | `remainder` | flat contacts: only what the half space leaves is meshed |
//! | `patch` | curved contacts: the bonded patch itself is meshed |
//! | `bodies` | which mesh and method a body and a place take |
//! | `solid`, `whole` | a convex body above its held plane, and a mesh of all of it |
//! | `disc`, `anywhere` | loads anywhere on it, and what they move everywhere: for [`crate::green`] |
//!
//! Lengths are scaled by the body's size and moduli by its shear modulus before anything is solved. The sparse factor chooses its
//! kernels by the processor: results agree between machines to about 1e-10, not bit by bit.

pub(crate) mod anywhere;
mod bodies;
mod bricks;
pub(crate) mod disc;
mod element;
mod half_space;
mod patch;
mod remainder;
pub(crate) mod solid;
mod system;
pub(crate) mod whole;

use glam::DVec3;

pub use bodies::body_constants;
use bricks::Bricks;

/// An elastic body in its own frame: z up, base at z = 0, middle on the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// Edges \[m\]; held on its bottom face.
    Box {
        /// Edges along x, y, z \[m\].
        size: DVec3,
    },
    /// Upright; held on its bottom face.
    Cylinder {
        /// \[m\].
        radius: f64,
        /// \[m\].
        height: f64,
    },
    /// Cut and held at the height `held_below`, as if everything below were rigid. A sphere has three equal semi-axes.
    Ellipsoid {
        /// Semi-axes along x, y, z \[m\].
        semi_axes: DVec3,
        /// Height of the held plane over the lowest point \[m\]; 0.02 to 1 times the height semi-axis.
        held_below: f64,
    },
}

/// Isotropic linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Shear modulus \[Pa\], above 0.
    pub shear_modulus: f64,
    /// 0 to 0.5; above [`MAX_POISSON`] that value is used.
    pub poisson_ratio: f64,
}

/// Largest Poisson's ratio that is solved: at 0.5 exactly the volumetric stiffness is infinite. Costs below 0.1 % of C.
pub const MAX_POISSON: f64 = 0.4999;

/// A contact on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Point of the surface \[m\].
    pub point: DVec3,
    /// Outward unit normal there.
    pub normal: DVec3,
    /// Radius of the patch \[m\].
    pub radius: f64,
}

/// How fine the mesh is; the error estimate always uses the next coarser one as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fineness {
    /// A flat contact takes about a second in a release build, a curved one some ten.
    Coarse,
    /// Some seconds; a curved contact up to a minute.
    Medium,
    /// Up to some minutes.
    Fine,
}

/// Compliances beyond the half space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyConstants {
    /// Along the normal \[m/N\].
    pub normal: f64,
    /// Along the two tangents \[m/N\]: on a top x and y, on a side the horizontal one and z.
    pub drag: [f64; 2],
    /// About the normal \[rad/(N m)\].
    pub twist: f64,
}

/// What a run found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The finer mesh's answer.
    pub constants: BodyConstants,
    /// Distance to the coarser mesh's answer, each 0 or more: a measure of the error, not a bound.
    pub error: BodyConstants,
    /// Unknowns of the finer mesh.
    pub unknowns: usize,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FemError {
    /// A parameter is out of its range.
    #[error("{name} = {value}: {expected}")]
    Range {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// The place is not one that can be computed.
    #[error("a contact at {point} with normal {normal} is not supported: {expected}")]
    NoPlace {
        /// Point asked for.
        point: DVec3,
        /// Normal asked for.
        normal: DVec3,
        /// What is.
        expected: &'static str,
    },
    /// The mesh would be too large.
    #[error("{unknowns} unknowns, at most {limit}: choose a lower fineness or a less slender body")]
    TooFine {
        /// Unknowns asked for.
        unknowns: usize,
        /// Most allowed.
        limit: usize,
    },
    /// A brick is inside out.
    #[error("the body cannot be meshed: a brick is folded; choose a smaller patch or a rounder body")]
    Folded,
    /// A loaded point was not found in the mesh.
    #[error("a loaded point lies outside the mesh: choose a smaller patch")]
    Outside,
    /// The factorisation failed.
    #[error("the stiffness matrix is not positive definite: choose a rounder body or a larger base")]
    Unstable,
}

/// What a load or a motion of the patch does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Normal,
    DragX,
    DragY,
    Twist,
}

impl Direction {
    const ALL: [Self; 4] = [Self::Normal, Self::DragX, Self::DragY, Self::Twist];

    /// Displacement of a point of the patch under a unit of motion.
    fn rigid(self, at: DVec3) -> DVec3 {
        match self {
            Self::Normal => DVec3::Z,
            Self::DragX => DVec3::X,
            Self::DragY => DVec3::Y,
            Self::Twist => DVec3::new(-at.y, at.x, 0.0),
        }
    }
}

/// Nodes this close to a mirror, in units of the body, lie on it.
const ON_MIRROR: f64 = 1.0e-9;

/// The unknowns that the mirrors x = 0 and y = 0 of a quarter body hold at zero; none on a whole body.
fn mirrors(mesh: &Bricks, direction: Direction) -> Vec<bool> {
    let mut held = vec![false; 3 * mesh.nodes.len()];
    if !mesh.quarter {
        return held;
    }
    // a mirror that a motion is odd in holds both components in its plane, one that it is even in the component across
    let (x_odd, y_odd) = match direction {
        Direction::Normal => (false, false),
        Direction::DragX => (true, false),
        Direction::DragY => (false, true),
        Direction::Twist => (true, true),
    };
    for (node, at) in mesh.nodes.iter().enumerate() {
        if at.x.abs() < ON_MIRROR {
            held[3 * node] |= !x_odd;
            held[3 * node + 1] |= x_odd;
            held[3 * node + 2] |= x_odd;
        }
        if at.y.abs() < ON_MIRROR {
            held[3 * node] |= y_odd;
            held[3 * node + 1] |= !y_odd;
            held[3 * node + 2] |= y_odd;
        }
    }
    held
}

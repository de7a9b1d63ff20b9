//! Meshes on the host's side: load, check, measure, tessellate, bake.
//!
//! Words: a **mesh** is a list of vertices \[m\] and of triangles whose corners run counter-clockwise seen from outside; a
//! **boundary edge** belongs to one triangle, a **non-manifold edge** to more than two, a **flipped edge** to two that run along
//! it in the same direction. A mesh with none of the three encloses a solid. Everything is f64 and SI; no clock, no randomness:
//! the same file gives the same numbers. None of it runs in a tick.
//!
//! | module | what it does |
//! |---|---|
//! | `fem` | compliance of a body beyond the half space, by finite elements (feature `fem`) |
//! | `green` | the body's own Green's function for the core (feature `fem`) |
//! | [`mod@bake`] | grid and samples as the core reads them, with the errors they have |
//! | [`body`] | from a file to what a scene needs, kept by digest |
//! | [`convex`] | how far a mesh is from convex; cutting it into convex parts |
//! | [`crossing`] | triangles that run through each other |
//! | [`deviation`] | how far two surfaces are from each other |
//! | [`distance`] | exact signed distance to a mesh |
//! | [`kept`] | results kept in the user's cache folder |
//! | [`mod@load`] | bounded reading of STL, OBJ and PLY files |
//! | [`weld()`] | joins vertices that lie within a tolerance |
//! | [`check()`] | watertight, manifold, oriented, free of slivers |
//! | [`models`] | a mallet, a compass, an organ |
//! | `pieces` | edges, what hangs together, which way it faces |
//! | [`properties()`] | volume, mass centre, inertia |
//! | [`reduce`] | fewer triangles for the same surface |
//! | [`repair`] | mends what is usually wrong |
//! | [`samples`] | points spread over the surface, in progressive order |
//! | [`save`] | STL, PLY and OBJ |
//! | [`spline`] | coefficients with which cubic B-splines follow values on a grid |
//! | [`tessellate`] | triangles for the primitives of a scene |
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod bake;
pub mod body;
pub mod check;
pub mod convex;
pub mod crossing;
pub mod deviation;
pub mod distance;
#[cfg(feature = "fem")]
pub mod fem;
#[cfg(feature = "fem")]
pub mod green;
pub mod kept;
pub mod load;
pub mod mesh;
pub mod models;
mod pieces;
pub mod properties;
pub mod reduce;
pub mod repair;
pub mod samples;
pub mod save;
pub mod spline;
pub mod tessellate;
pub mod weld;

pub use bake::{BakeError, BakeSpec, Baked, DistanceError, bake};
pub use check::{Findings, check};
pub use crossing::{Crossings, crossings};
pub use glam::{DMat3, DVec3};
pub use load::{LoadError, load_mesh, read_mesh};
pub use mesh::Mesh;
pub use properties::{Properties, properties};
pub use repair::{MendSpec, Mended, mend};
pub use save::{save_as, write_stl};
pub use weld::weld;

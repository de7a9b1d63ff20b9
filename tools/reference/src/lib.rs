//! Reference answers for pressure, stick, slip and spin, from a method that shares nothing with the core.
//!
//! The core advances calibrated bristles, once per tick, in `f32`. This library solves the same contact as an elastic
//! half space in `f64`: the patch is cut into square cells of uniform pressure and traction, every cell feels every other
//! through the kernels of Boussinesq and Cerruti, and the laws of contact and of Coulomb are iterated to convergence at each step. It is thousands of
//! times slower and has no fitted constant, which is what makes it a reference.
//!
//! Words: **patch** a place where probe and object touch; **cell** a square of it; **slip** rigid
//! motion minus elastic displacement; **path** a list of poses (shift and angle) of the probe; **ground** what the rest of the world adds to the half
//! space under a patch: the body's own compliance, other patches.
//!
//! [`contact`] takes any consistent units, any gap, any Poisson's ratio; [`led`], [`paths`], [`pressed`] and [`table`] lead one circular patch in its own
//! units and write the committed tables (`tests/truth/*_paths.json`).
//!
//! Limits: plane half space under each patch, small strain, one friction coefficient. The body's compliance is given, not found.
//!
//! Own error, measured by `tests/checks.rs` with grids of 8, 16 and 32 cells over the patch and [`estimate::richardson`]: see the table in
//! `README.md` beside this crate.
//!
//! References: K. L. Johnson, Contact Mechanics, 1985, chapters 3, 4 and 7 (kernels, Hertz, Cattaneo and Mindlin); J. L. Lubkin,
//! J. Appl. Mech. 18, 1951 (torsion with slip); E. Reissner, H. F. Sagoci, 1944 (stuck torsion); R. D. Mindlin, H. Deresiewicz, 1953 (reversal);
//! D. A. Spence, 1968 (bonded punch).
#![forbid(unsafe_code)]

pub mod contact;
pub mod estimate;
pub mod kernel;
pub mod lattice;
pub mod led;
pub mod paths;
pub mod pressed;
pub mod profile;
pub mod table;

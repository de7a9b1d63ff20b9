//! Reference answers for stick, slip and spin, from a method that shares nothing with the core.
//!
//! The core advances calibrated bristles, once per tick, in `f32`. This module solves the same contact as an elastic
//! half space in `f64`: the patch is cut into square cells of uniform traction, every cell feels every other
//! through the Cerruti kernel, and Coulomb's law is iterated to convergence at each step. It is thousands of times slower
//! and has no fitted constant, which is what makes it a reference.
//!
//! Words: **patch** the unit disc that stands for the contact circle; **cell** a square of it; **slip** rigid
//! motion minus elastic displacement; **path** a list of poses (shift and angle) of the probe.
//!
//! Units are those of the problem itself: contact radius a = 1, shear modulus G = 1, friction limit mu P = 1. A shift is told
//! in multiples of s0 = 3 mu P (2 - nu) / (16 a G), where a sphere's drag reaches full slip; an angle in multiples of
//! phi0 = T_max / K_theta, with T_max = (3 pi / 16) mu P a and K_theta = (16/3) G a^3. Forces come in mu P, torques in
//! the profile's own T_max.
//!
//! Limits: a plane half space, a circular patch (of fixed radius and load, but for the histories of [`pressed`]), Poisson's ratio 0.5 (so that friction
//! does not disturb the pressure), one friction coefficient.
//!
//! Convergence: 448 cells (the committed tables) against 1020 differ by at most 0.3 % of mu P and 0.5 % of T_max;
//! 960 steps per path against 240 by 2.8 % of mu P where the direction turns fastest, and in proportion to the step.
//! Against Lubkin 0.3 %, against Cattaneo 0.2 %. A flat punch's edge, where pressure is singular, costs 1 % of drag
//! stiffness and 2 % of twist stiffness.
//!
//! References: K. L. Johnson, Contact Mechanics, 1985, chapters 3 and 7 (kernels, Cattaneo and Mindlin); J. L. Lubkin,
//! J. Appl. Mech. 18, 1951 (torsion with slip).

pub mod coulomb;
pub mod half_space;
pub mod paths;
pub mod pressed;
pub mod profile;
pub mod table;

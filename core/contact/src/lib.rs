//! # haptor-contact: what a hand feels
//!
//! Computes the wrench on a rigid **probe** that presses, slides and twists on an elastic **object**, in up to
//! [`MAX_REGIONS`] contact regions at once. `no_std`, no allocation, no clock, no I/O, no `unsafe`; every loop is
//! bounded by a capacity in a type; the same inputs give the same bits on every build.
//!
//! ```text
//!             Model   constant, borrowed   \
//!             Params  between ticks         |   step   -> Output { wrench, contact, report }
//!  Input ->   State   survives the tick     |
//!             Scratch this tick only       /
//!
//!  1 detect   2 regions   3 force   4 torque   5 deform   6 wrench   7 guard
//! ```
//!
//! The pose in [`Input`] is the handle's. With [`CouplingSpec::Direct`] it is the probe's too; with [`CouplingSpec::Virtual`] the probe is first moved on its spring
//! and damper, the stages run at the probe's pose ([`State::probe_pose`]), and the device gets the coupling's wrench.
//!
//! Letters of frames: `w` world (base centre of the object, +z up), `p` probe (origin at its mass centre), `c` contact
//! (origin at the patch centre, z along the normal that points out of the object). `p_wq` is the position of q in w,
//! `f_w` a force expressed in w. Units are SI. A [`Wrench`] is always **on the probe, about its mass centre**.
//!
//! Knobs are fields, shapes of memory are type parameters, order is a list of calls. The mathematics, with numbered
//! equations, is in `theory.md` beside this file.
//!
//! ```
//! use haptor_contact::*;
//!
//! let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
//! let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
//! let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, rubber, &ball))?;
//! let params = Params::new(&ParamsSpec::default())?;
//! let (mut state, mut scratch) = (State::<10, 64>::new(), Scratch::<16>::new());
//!
//! let pressed_1_mm = Pose::new(Vec3::new(0.0, 0.0, 0.019), Quat::IDENTITY);
//! let output = step(&model, &params, &mut state, &mut scratch, Input { pose: pressed_1_mm, dt: 1.0e-3 });
//! assert!((output.contact.force.z - 23.73).abs() < 0.1); // Hertz, newtons
//! # Ok::<(), Invalid>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod body;
pub mod budget;
mod coupling;
mod error;
mod footprint;
mod frames;
pub mod green;
mod guard;
mod limits;
mod math;
mod mesh_shape;
mod model;
mod overlap;
mod params;
mod patch;
mod report;
mod scratch;
mod state;
mod step;
mod wrench;

pub mod geometry;
pub mod lanes;
pub mod profile;
mod stage;
pub mod surface;
pub mod tier;

#[doc = include_str!("theory.md")]
pub mod theory {}

#[doc = include_str!("bounds.md")]
pub mod bounds {}

pub use budget::Rung;
pub use coupling::inertia::Inertia;
pub use coupling::passivity::{MAX_DELAY, Passivity};
pub use coupling::{CouplingSpec, VirtualCoupling};
pub use error::Invalid;
pub use footprint::Footprint;
pub use frames::{Pose, ProbeFrame, World};
pub use geometry::distance_grid::DistanceGrid;
pub use glam::{Quat, Vec2, Vec3};
pub use green::{Chart, Green, GreenSpec};
pub use guard::GuardSpec;
pub use limits::*;
pub use mesh_shape::{MeshShape, MeshSpec, SurfaceSample};
pub use model::{Compliance, Material, Model, ModelSpec, ObjectShape, ProbePart, ProbeShape};
pub use params::{Breakaway, ForceLaw, Params, ParamsSpec, Tier, check_work};
pub use patch::{Grip, Motion, Patch, Shift};
pub use report::{Flags, PatchReport, Report};
pub use scratch::Scratch;
pub use stage::deform::{Look, deform};
pub use state::State;
pub use step::{Input, Output, patch_report, step};
pub use wrench::Wrench;

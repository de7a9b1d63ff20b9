//! Pictures of a scene, drawn by a rasteriser that needs no display, no graphics driver and no font: the same input gives the
//! same bytes on every machine.
//!
//! A [`Shot`] says what is to be seen: a baked scene, where the probe is, the wrench on it and its contact regions. [`draw`]
//! turns it into an [`Image`], [`Image::png`] into a file. Colours: object sand, probe blue-grey, force red, torque violet,
//! region blue where it sticks and orange where it slips. World frame, +z up, SI.
//!
//! ```text
//! Shot -> [model] triangles in world -> [camera] pixels and depth -> [raster] shaded, z-buffered -> Image -> PNG
//! ```
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod camera;
mod image;
mod model;
mod raster;
mod shot;

pub use glam::{DQuat, DVec3};
pub use image::{Image, MAX_SIDE, MIN_SIDE};
pub use shot::{Pose, Region, Shot, draw};

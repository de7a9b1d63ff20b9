//! Pictures of a scene, drawn by a rasteriser that needs no display, no graphics driver and no font of the machine's: the same input
//! gives the same bytes on every machine.
//!
//! A [`Shot`] says what is to be seen: a baked scene, where the probe is, the wrench on it and its contact regions. [`draw`]
//! turns it into an [`Image`], [`Image::png`] into a file. Colours: object sand and, where its surface moved, green; probe blue-grey, force
//! red, torque violet, region blue where it sticks and orange where it slips; a legend says so with figures. World frame, +z up, SI.
//!
//! ```text
//! Shot -> [model] triangles in world -> [camera] pixels and depth -> [raster] shaded, z-buffered -> Image -> [legend] -> PNG
//! ```
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod camera;
mod image;
mod legend;
mod model;
mod raster;
mod shot;
mod text;

pub use glam::{DQuat, DVec3};
pub use haptor_mesh::Mesh;
pub use image::{Image, MAX_SIDE, MIN_SIDE};
pub use shot::{Pose, Region, Shot, Surface, draw};

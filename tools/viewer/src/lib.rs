//! Pictures of a scene: a window to look through, and a rasteriser that needs no display, no graphics driver and no font of the machine's.
//!
//! [`feed`] is what there is to look at: a stage, moments of it, a source that delivers them. [`picture`] makes triangles, colours and a legend of a
//! moment. Two things draw these: [`draw`] into an [`Image`], the same bytes on every machine, [`Image::png`] into a file; and, with feature
//! `window`, the window on OpenGL. World frame, +z up, SI.
//!
//! ```text
//! Source -> Stage, Frame -> [picture] triangles, colours, legend -+-> [camera] [raster] z-buffered -> [caption] -> Image -> PNG
//!                                                                 +-> [window] OpenGL, panels, plots
//! ```
#![cfg_attr(not(feature = "window"), forbid(unsafe_code))]
#![deny(missing_docs, unsafe_code)]

mod bodies;
mod camera;
mod caption;
pub mod feed;
mod image;
pub mod picture;
mod raster;
mod shot;
mod text;
#[cfg(feature = "window")]
pub mod window;

pub use bodies::stage;
pub use camera::{Camera, Orbit};
pub use glam::{DQuat, DVec3, Vec3};
pub use haptor_mesh::Mesh;
pub use image::{Image, MAX_SIDE, MIN_SIDE};
pub use shot::{Shot, View, draw};

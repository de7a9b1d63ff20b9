//! What reads bytes from outside, fed with bytes nobody would send: the targets of [`targets`], and what the tool reads scenes with.
//!
//! The tool is a program and no library, so the files of its reader are part of this crate too.
#![forbid(unsafe_code)]

pub mod targets;

#[path = "../../../tools/haptor/src/failure.rs"]
#[allow(dead_code, missing_docs)]
mod failure;
#[path = "../../../tools/haptor/src/progress.rs"]
mod progress;
#[path = "../../../tools/haptor/src/scene/mod.rs"]
#[allow(dead_code, unused_imports)]
mod scene;
pub mod scene_toml;
pub mod seeds;
#[path = "../../../tools/haptor/src/text.rs"]
mod text;
#[path = "../../../host/src/viewer/uploads.rs"]
#[allow(dead_code)]
mod uploads;

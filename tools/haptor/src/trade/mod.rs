//! `haptor trade`: what each tier, number of samples, sweeps and rate costs on a scene, and how far it is from the truth.
//!
//! [`stage`] makes the scene ready, [`motions`] says how the probe is led, [`truth`] and [`answers`] what it should feel, [`errors`] how far the core is
//! from that, [`cost`] what it takes, [`point`] holds both, [`advice`] says which setting to take, [`picture`] and [`report`] show it, [`scene_file`] writes it down.

pub mod advice;
pub mod answers;
mod bodies;
mod boxes;
pub mod cost;
pub mod errors;
mod motions;
pub mod picture;
pub mod point;
mod rays;
pub mod report;
pub mod scene_file;
pub mod settings;
pub mod stage;
mod truth;

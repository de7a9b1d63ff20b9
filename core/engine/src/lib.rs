//! From a baked scene to a core that steps: the one place that knows both the wire and the contact core.
//!
//! ```text
//! BakedScene ──► Setup ───────────────┐
//! sections   ──► Data ──► Bodies ─────┴─► Engine { Model, Params, State, Scratch }       once, may fail with the parameter's name
//! PoseReport ──► x_dh ──► x_wp = x_wd * x_dh ──► step ──► wrench in w ──► wrench in d ──► WrenchCommand      every tick
//! ```
//! Wire types may hold anything; what goes into the core has been checked here. A pose that is not finite, or whose quaternion is
//! off unit length by more than [`haptor_contact::QUATERNION_TOLERANCE`], is refused and a loop goes on as if none had come.
//!
//! | module | what it is |
//! |---|---|
//! | [`frames`] | the frames `d` and `h`: where the device stands, what the hand holds |
//! | [`setup`] | a baked scene, checked: parameters, limits, the device's place |
//! | [`bodies`] | object and probe as the core takes them |
//! | `scene` | a scene with the meshes and tables that its file carries, and engines that own one (feature `std`) |
//! | [`engine`] | the running core: fitted to a device, stepped once a tick |
//! | [`tuned`] | what changes an engine between two ticks |
//! | [`work`] | the work budget, which may change between them too |
//! | `look` | what can be seen of an engine, and the surface that follows |
//! | [`replay`] | recordings computed again |
//! | [`link`] | poses and wrenches of the device link |
//!
//! The real-time host runs one; the tool replays recordings with one; both get the same bits. Without the feature `std` there is no heap, and
//! scenes of shapes without meshes and tables run on a bare machine.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod bodies;
pub mod engine;
mod error;
pub mod frames;
pub mod link;
mod look;
pub mod replay;
pub mod settings;
pub mod setup;
pub mod tuned;
pub mod work;

#[cfg(feature = "std")]
mod data;
#[cfg(feature = "std")]
mod grid;
#[cfg(feature = "std")]
mod scene;
#[cfg(feature = "std")]
mod table;

#[cfg(all(test, feature = "std"))]
mod tests;

pub use bodies::Bodies;
pub use engine::{Engine, Felt, Kept, SAMPLES};
pub use error::SceneError;
pub use frames::{DeviceBase, Handle};
pub use link::{command, handle_pose};
#[cfg(feature = "std")]
pub use scene::{OwnedEngine, Scene};
pub use setup::Setup;
pub use tuned::{Placed, Tuned};
pub use work::Limit;

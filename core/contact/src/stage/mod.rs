//! The stages of a tick, in the order `step` calls them.

pub mod carry;
pub mod deform;
pub mod detect;
pub mod force;
pub mod ground;
pub mod regions;
pub mod torque;
pub mod wrench;

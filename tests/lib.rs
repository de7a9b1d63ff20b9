//! What several proofs share: independent reference answers, and how far the core is from them.

#[path = "accuracy/mod.rs"]
pub mod accuracy;

/// Green's tables of the reference bodies.
#[path = "bodies/mod.rs"]
pub mod bodies;

#[path = "stability/mod.rs"]
pub mod stability;

#[path = "extremes/mod.rs"]
pub mod extremes;

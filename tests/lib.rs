//! What several proofs share: independent reference answers, and how far the core is from them.

#[path = "reference/mod.rs"]
pub mod reference;

#[path = "accuracy/mod.rs"]
pub mod accuracy;

#[path = "stability/mod.rs"]
pub mod stability;

//! What several proofs share: independent reference answers.

#[path = "reference/mod.rs"]
pub mod reference;

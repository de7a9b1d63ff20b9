//! Links around links.

mod fault;

pub use fault::{FaultLink, Plan};

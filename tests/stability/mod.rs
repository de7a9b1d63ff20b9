//! The stability map: which loops of hand, device, link and core hold still, over stiffness, rate, delay and device.
//!
//! `cargo run --release -p haptor-tests --bin stability -- -o tests/bench/STABILITY.md` writes the tables and, beside them, `stability.png`. Nothing in it depends on the
//! machine or the time; two threads share the work by index.

pub mod map;
pub mod plot;
pub mod rig;
pub mod words;

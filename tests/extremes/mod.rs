//! What the core does at the ends of its stated ranges and beyond: axis by axis against references, and in random corners of the whole box against laws that hold in all of it.
//!
//! **Words.** *Axis*: one quantity, walked through decades while the rest stays in the middle. *Case*: a random scene and what is done to it, made from a seed alone. *Twin*: the same
//! case with every length and modulus multiplied by powers of two into the middle of the box: the same digits, so that whatever differs is a threshold told in SI units or the range
//! of an f32. *Law*: what must hold in every case, with a bound. *Worst*: the largest measured figure of a law, with the seed that makes it again.
//!
//! `cargo xtask extremes` runs it; the short version is in `tests/it/corners.rs`. Nothing in it depends on machine or time but the line that says so.

pub mod axes;
pub mod bodies;
pub mod cases;
pub mod laws;
pub mod plot;
pub mod rig;
pub mod run;
pub mod session;
pub mod words;

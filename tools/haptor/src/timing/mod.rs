//! What a tick costs at worst: inputs that make it dear, counted and timed.
//!
//! **Words.** *History*: poses of some tens of ticks from rest. *Level*: a tier and its samples. *Dearest*: the history that holds the dearest tick, in
//! instructions, or in time where nothing counts them.
//!
//! ```text
//! start ──► motion ──┐
//!   └─────► search ──┴─► history ──► recording ──► haptor-measure ──► instructions (callgrind), times (SCHED_FIFO)
//!                                        └── answered by the engine ──► what was exercised
//! ```

pub mod callgrind;
pub mod cover;
pub mod history;
pub mod judge;
pub mod level;
pub mod measure;
pub mod motions;
pub mod mutate;
pub mod picture;
pub mod report;
pub mod search;
pub mod stages;
pub mod start;
pub mod units;

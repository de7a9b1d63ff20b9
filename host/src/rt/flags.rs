//! What the host has to say about a tick, as bits above the core's.
//!
//! The core's flags use bits 0 to 23 of a record's `flags`, these 24 to 31. Like the core's they never change meaning.

/// No fresh pose came in this tick: the core did not run, its figures are those of the last tick that did.
pub const NO_POSE: u32 = 1 << 24;
/// The stale rule repeated the last wrench or faded it.
pub const HELD: u32 = 1 << 25;
/// The output is closed by a fault and the wrench sent was zero, whatever the core said.
pub const CLOSED: u32 = 1 << 26;
/// The tick ended after its period.
pub const LATE: u32 = 1 << 27;
/// The device was not in a mode that takes a wrench, or the link did not take it: none was sent.
pub const NOT_SENT: u32 = 1 << 28;
/// A pose came that was refused: not finite, no unit quaternion, or one that the core does not believe.
pub const POSE_REFUSED: u32 = 1 << 29;

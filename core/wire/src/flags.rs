//! What the host has to say about a tick, as bits of [`TickRecord::flags`](crate::TickRecord::flags) above the core's.
//!
//! | bit | name | set when |
//! |---|---|---|
//! | 0 to 23 | the core's (`haptor_contact::Flags`) | the core has run in this tick and had something to say |
//! | 24 | [`NO_POSE`] | no fresh pose came: the core did not run, pose and contact are those of the last tick in which it did |
//! | 25 | [`HELD`] | the stale rule repeated the last wrench or faded it |
//! | 26 | [`CLOSED`] | a fault keeps the output closed: the wrench sent was zero, whatever the contact |
//! | 27 | [`LATE`] | the command left after the tick's period, or not at all |
//! | 28 | [`NOT_SENT`] | the device was in no mode that takes a wrench, or the link did not take it |
//! | 29 | [`POSE_REFUSED`] | a pose came that was none: not finite, no unit quaternion, or not believed by the core |
//! | 30, 31 | | never |
//!
//! Like the core's these bits never change meaning. All zero is a clean tick.

/// No fresh pose came in this tick: the core did not run, its figures are those of the last tick that did.
pub const NO_POSE: u32 = 1 << 24;
/// The stale rule repeated the last wrench or faded it.
pub const HELD: u32 = 1 << 25;
/// The output is closed by a fault and the wrench sent was zero, whatever the core said.
pub const CLOSED: u32 = 1 << 26;
/// The command left after the tick's period, or not at all.
pub const LATE: u32 = 1 << 27;
/// The device was not in a mode that takes a wrench, or the link did not take it: none was sent.
pub const NOT_SENT: u32 = 1 << 28;
/// A pose came that was refused: not finite, no unit quaternion, or one that the core does not believe.
pub const POSE_REFUSED: u32 = 1 << 29;

/// Any of these, and the tick's contact is not what the hand felt: see [`TickRecord::was_felt`](crate::TickRecord::was_felt).
pub(crate) const NOT_FELT: u32 = NO_POSE | HELD | CLOSED | NOT_SENT | POSE_REFUSED;

/// Names of the host's bits, from bit 24 up.
pub const NAMES: [&str; 6] = ["no pose", "held", "closed", "late", "not sent", "pose refused"];

//! Recordings computed again: an engine driven by records instead of a device, and its results held against what was recorded.
//!
//! ```text
//! records ──► Follower ──► engine ──► Felt ──► compare ──► equal to the bit, or the first tick and field that is not
//!    └─ Scene chunks ──► Gather ──► Scene ──► engine                                     (feature std)
//! ```
//! The rules of what can be computed again are those of [`haptor_wire::recording`]. A tick is **sure** where the file tells everything that its core remembered:
//! from a `Rest` on, up to the next damage. A tick that is not sure is computed too, for whoever looks, but proves nothing.
//!
//! Nothing here allocates per tick.

mod author;
mod compare;
mod follow;
#[cfg(feature = "std")]
mod gather;
#[cfg(feature = "std")]
mod verify;

#[cfg(all(test, feature = "std"))]
mod tests;

pub use author::answered;
pub use compare::{Difference, Value, add_to_digest, compare};
pub use follow::{Follower, Step, Unsure};
#[cfg(feature = "std")]
pub use gather::{Gather, NoScene};
#[cfg(feature = "std")]
pub use verify::{Counts, Verdict, Verifier, verify};

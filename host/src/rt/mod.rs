//! The real-time thread: what it does, what it promises, and what would break the promise.
//!
//! ```text
//!  pace ─► line ─► handshake ─► core (convert) ─► stale rule ─► line ─► account
//!  when    poses    modes,       step, guard       hold, fade,   wrench   record, figures,
//!          in order faults                         zero, re-arm           black box, news
//!                     └─ orders of viewers, between ticks ([`desk`])         └─ looks for them
//! ```
//! A **tick** is one turn of this; its **period** is the time between two. **In time** = its command left before its period ended.
//! A **fresh** pose is a report newer than all before it. **Closed** = the output is zero because of a fault; **latched** = the
//! session's fault stays its fault.
//!
//! Promised after start-up: the thread allocates nothing, takes no lock, builds no text, and asks the system for nothing but the
//! time, sleep, and its link (poll, read, write). Everything else, files, terminals, opening ports, lives on ordinary threads
//! behind bounded queues ([`account`], [`blackbox`], [`mod@line`], [`desk`]) that drop and count. A test holds the first of these with a counting
//! allocator; libusb's own allocations in C on a USB link are outside it ([`crate::link`]).
//!
//! A tick cannot fail. What goes wrong becomes a fault: the wrench goes to zero, at once or by the stale rule ([`stale`]), the
//! cause is latched ([`faults`]) and the last second of ticks is handed over ([`blackbox`]). The loop goes on: it closes and reopens the
//! link, resets the device, and lets forces return only from a small one.

pub mod account;
pub mod blackbox;
pub mod budget;
pub mod clock;
pub mod control;
pub mod desk;
pub mod faults;
pub mod flags;
pub mod handshake;
pub mod histogram;
pub mod line;
mod orders;
pub mod pace;
pub mod parts;
pub mod policy;
pub mod roundtrip;
pub mod scale;
pub mod stale;
pub mod tracker;

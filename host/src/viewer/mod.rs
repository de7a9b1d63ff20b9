//! The server of the viewer link ([`haptor_wire::viewer`], `core/wire/VIEWER.md`): programs that look at the session and may steer it.
//!
//! ```text
//!  viewer ─┐                          ┌─ orders, emergency stop ─► real-time thread
//!  viewer ─┼─ sockets ─ viewers' thread ◄─ notes, looks ──────────────┘
//!  viewer ─┘              │  ▲  │
//!                    jobs ▼  │  └─ taps of the recorder
//!                      workshop: scenes built, tunings checked, budgets measured, surfaces computed, old engines dropped
//! ```
//! Two ordinary threads. The viewers' thread does nothing that takes long, so that an emergency stop of one viewer never waits for
//! what another asked; what takes long is the workshop's. The real-time thread sees neither: it looks at flags and queues whose
//! memory is there from the start ([`crate::rt::desk`]).
//!
//! Whatever a viewer does, it costs itself: one that reads too slowly loses snapshots, which are counted; one that floods is read more slowly;
//! one that sends nonsense, nothing, or reads nothing for long is closed, and told why. What it may send and keep is bounded by named constants.
//!
//! | file | what it is |
//! |---|---|
//! | [`entrance`] | opens where viewers come in, starts the threads |
//! | [`listen`] | addresses, sockets |
//! | [`token`] | who may come in |
//! | [`server`] | the viewers' thread: one turn of it is a list of calls |
//! | [`answers`] | what the loop and the workshop hand back, passed on |
//! | [`requests`] | what viewers ask, and who waits for which answer |
//! | [`peer`] | one viewer: what came, what it wants, what it is owed |
//! | [`outbox`] | bytes on their way to a viewer |
//! | [`uploads`] | models that viewers sent |
//! | [`streams`] | files on their way to a viewer: a recording, the scene |
//! | [`workshop`] | the other thread |
//! | [`surfaces`] | what it computes for who watches a surface, in passes |
//! | [`figures`] | the session in figures while it runs |

pub mod answers;
pub mod entrance;
pub mod figures;
pub mod listen;
pub mod outbox;
pub mod peer;
pub mod requests;
pub mod server;
pub mod streams;
pub mod surfaces;
pub mod token;
pub mod uploads;
pub mod workshop;

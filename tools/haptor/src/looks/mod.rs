//! What a window shows: a stage from a baked file, moments from a running host or from a recording.
//!
//! ```text
//! baked file ──► stage
//! viewer link ──► live ─────┐
//! recording ──► playback ───┴──► haptor_viewer::feed::Source ──► the window
//! ```

pub mod live;
pub mod playback;
mod stage;
mod words;

pub use stage::stage;

//! What there is to look at, whoever delivers it: a running host, a recording, a table of moments.
//!
//! A [`Stage`] stays the same while a scene is active, a [`Frame`] is one moment of it, a [`Sample`] one tick of the plots. A [`Source`]
//! delivers them and takes [`Command`]s; it never blocks whoever draws. Nothing here knows a window, a graphics driver or a wire.
//! World frame `w`, SI; force and torque act on the probe, the torque about the probe's mass centre.

mod frame;
mod history;
mod script;
mod source;
mod stage;

pub use frame::{Displacement, Fault, Frame, Mode, Playback, Pose, Pressure, Region, Timing, Wrench};
pub use history::{CAPACITY, Channel, History, Sample};
pub use script::Script;
pub use source::{Command, Event, News, Severity, Source};
pub use stage::Stage;

//! Where pictures come from and commands go: the one border between whoever draws and whoever runs.

use std::sync::Arc;
use std::time::Duration;

use super::{Frame, Sample, Stage};

/// A session to look at: live, recorded or scripted.
///
/// Both calls come from the thread that draws, about sixty times a second. They return at once: a source that talks to a socket or
/// reads a file does so elsewhere and hands over what has come.
pub trait Source {
    /// What is new since the last call. `now` is the time since the window opened: the only clock a source needs to read.
    fn poll(&mut self, now: Duration) -> News;

    /// Asks for something. What came of it shows in later news: in [`Frame::mode`], in [`Frame::recording`], as an [`Event`]; a command
    /// that this kind of source has no use for, such as a seek in a live session, changes nothing.
    fn send(&mut self, command: Command);
}

/// What is new.
#[derive(Clone, Debug, Default)]
pub struct News {
    /// Another scene has become active; comes before the first frame of it. The plots begin anew.
    pub stage: Option<Arc<Stage>>,
    /// The newest moment; those between are left out.
    pub frame: Option<Arc<Frame>>,
    /// Ticks for the plots, in the order of time. One earlier than the last begins the plots anew: a recording was wound back.
    pub samples: Vec<Sample>,
    /// Things a person should read, oldest first.
    pub events: Vec<Event>,
}

/// A line for a person.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, in the session's time \[s\].
    pub time: f64,
    /// How bad it is.
    pub severity: Severity,
    /// What happened.
    pub words: String,
}

/// How bad an event is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// For information.
    Info,
    /// Something was late, lost or clamped; the session goes on.
    Warning,
    /// The device feels nothing any more.
    Fault,
}

/// What a person at the window may ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Begin or end a recording.
    Record(bool),
    /// Fade the force to zero and let contact and picture stand, or go on.
    Freeze(bool),
    /// Place the device so that the probe stands where the scene starts it; without contact only.
    Tare,
    /// Release the device to its brake at once.
    EStop,
    /// End the brake and let forces through again, as soon as the host finds them small.
    Rearm,
    /// Show the recording at this time from its begin \[s\].
    Seek(f64),
    /// Let the recording run, or hold it.
    Play(bool),
    /// Seconds of recording a second, above 0.
    Speed(f64),
}

//! What viewers ask for, and why it is not done. See [`crate::viewer`].

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::device::{ENUM, U32};
use crate::tuning::Tuning;
use crate::viewer::{LENGTH, WORDS_BYTES, Words};

/// A request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ask {
    /// Its number, of the viewer's choosing; the answer carries it.
    pub number: u32,
    /// What is asked for.
    pub what: Wish,
}

impl Ask {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U32 + Wish::MAX_ENCODED;
}

/// What a viewer can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Wish {
    /// Run the uploaded model of this digest from now on. The output fades, closes, and opens again when the wrench is small.
    Activate(u64),
    /// Take over these parameters from the next tick on.
    Tune(Tuning),
    /// True: fade the wrench to zero and let the core stand. False: go on, with forces back when they are small.
    Freeze(bool),
    /// Place the device so that the probe stands where the scene starts it. Without contact only.
    Tare,
    /// Zero wrench at once, the device brakes; until it is re-armed.
    EStop,
    /// Back from an emergency stop: the device is reset and forces come back when they are small.
    Rearm,
    /// True: send a recording from now on. False: end it.
    Record(bool),
    /// Send the file of the scene that runs.
    Download,
    /// From the next tick on the work of a tick is limited so, in the scene that runs and in every one after it.
    Budget(WorkBudget),
}

impl Wish {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM + Tuning::MAX_ENCODED;
}

/// What says how much work a tick may spend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum WorkBudget {
    /// The scene.
    Scene,
    /// The machine: what it does within a share of the period, measured for each scene.
    Auto,
    /// Nobody: there is no limit.
    Off,
    /// Whoever asks: so many instructions of the core's x86-64 release build.
    Work(u32),
}

impl WorkBudget {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM + U32;
}

impl fmt::Display for WorkBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene => f.write_str("scene"),
            Self::Auto => f.write_str("auto"),
            Self::Off => f.write_str("off"),
            Self::Work(work) => write!(f, "{work}"),
        }
    }
}

/// A request that was not carried out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Denied {
    /// The request's number.
    pub number: u32,
    /// Why.
    pub why: Denial,
    /// What exactly, where there is more to say.
    pub words: Words,
}

impl Denied {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U32 + Denial::MAX_ENCODED + LENGTH + WORDS_BYTES;
}

impl fmt::Display for Denied {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.why.name())?;
        match core::str::from_utf8(&self.words) {
            Ok("") => Ok(()),
            Ok(words) => write!(f, ": {words}"),
            Err(_) => f.write_str(": (what exactly is not text)"),
        }
    }
}

/// Why a request was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Denial {
    /// No whole model of this digest has been uploaded.
    NoModel,
    /// The uploaded bytes do not have the digest they were announced with.
    Digest,
    /// The host cannot run the scene.
    Scene,
    /// A value is out of its range.
    Value,
    /// The probe touches the object.
    InContact,
    /// The device does not render forces yet.
    NoSession,
    /// An emergency stop holds.
    Stopped,
    /// No emergency stop holds.
    NotStopped,
    /// The core stands.
    Frozen,
    /// Too many requests wait, or one like it.
    Busy,
    /// Longer than the host takes.
    TooLarge,
    /// Other uploads take the room there is.
    NoRoom,
    /// Bytes or points that do not follow those there are.
    OutOfOrder,
    /// A recording goes out already.
    Recording,
    /// No recording goes out.
    NotRecording,
}

impl Denial {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM;

    /// Every denial, in the order of the wire.
    pub const ALL: [Self; 15] = [
        Self::NoModel,
        Self::Digest,
        Self::Scene,
        Self::Value,
        Self::InContact,
        Self::NoSession,
        Self::Stopped,
        Self::NotStopped,
        Self::Frozen,
        Self::Busy,
        Self::TooLarge,
        Self::NoRoom,
        Self::OutOfOrder,
        Self::Recording,
        Self::NotRecording,
    ];

    /// The denial in words, with what to do.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoModel => "no whole model of this digest is there; upload it first",
            Self::Digest => "the uploaded bytes do not have the digest they were announced with; upload them anew",
            Self::Scene => "the host cannot run the scene",
            Self::Value => "a value is out of its range",
            Self::InContact => "the probe touches the object; lift off first",
            Self::NoSession => "the device does not render forces yet; wait",
            Self::Stopped => "an emergency stop holds; re-arm first",
            Self::NotStopped => "no emergency stop holds",
            Self::Frozen => "the core stands; let it go on first",
            Self::Busy => "too many requests wait, or one like it; wait for its answer",
            Self::TooLarge => "longer than the host takes",
            Self::NoRoom => "other uploads take the room there is; try again later",
            Self::OutOfOrder => "what came does not follow what there is",
            Self::Recording => "a recording goes out already; end it first",
            Self::NotRecording => "no recording goes out",
        }
    }
}

//! What can go wrong outside the tick, with what was being done.
//!
//! A tick cannot fail: what goes wrong there becomes a [`haptor_wire::HostFault`], latched and counted.

use std::io;
use std::path::PathBuf;

use crate::rt::policy::MissingRight;
use haptor_engine::SceneError;

/// Why the host did not start, or could not keep what it promised outside the tick.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// A value on the command line is out of range.
    #[error("{name} is {value}; allowed is {allowed}")]
    Argument {
        /// The argument, as typed.
        name: &'static str,
        /// What was given.
        value: String,
        /// The range in words, with the unit.
        allowed: &'static str,
    },
    /// A file could not be read or written.
    #[error("cannot {doing} {path}: {reason}", path = path.display())]
    File {
        /// What was being done, e.g. `read the baked scene`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
    /// Nobody can come in where viewers were told to.
    #[error("viewers cannot come in at {address}: {reason}; choose another address with --viewer, or leave it out")]
    Listen {
        /// The address.
        address: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// The model file is not a baked scene, or not one this build can run.
    #[error("{path}: {reason}", path = path.display())]
    Scene {
        /// The model file.
        path: PathBuf,
        /// What is wrong with it.
        reason: SceneError,
    },
    /// A recording that cannot be run again.
    #[error("{path}: {reason}; record it anew (`haptor record`)", path = path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The device could not be opened.
    #[error("cannot open {device}: {reason}")]
    Open {
        /// The device's address.
        device: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// `--rt enforce` and the system refused.
    #[error(transparent)]
    Right(#[from] MissingRight),
    /// A thread could not be started.
    #[error("cannot start the {name} thread: {reason}")]
    Thread {
        /// The thread.
        name: &'static str,
        /// The system's reason.
        reason: io::Error,
    },
    /// A thread ended by a panic, which is a defect of this program.
    #[error("the {name} thread ended by a panic; this is a defect of haptor-host, please report it")]
    Panicked {
        /// The thread.
        name: &'static str,
    },
}

impl HostError {
    /// True when the command line or a file it names is at fault, false when the machine or the device is.
    #[must_use]
    pub const fn is_bad_input(&self) -> bool {
        matches!(self, Self::Argument { .. } | Self::Scene { .. } | Self::File { .. } | Self::Recording { .. })
    }
}

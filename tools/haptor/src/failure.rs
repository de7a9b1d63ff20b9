//! How a command ends when it does not end well: exit 2 for bad usage or bad input, exit 1 for a problem it found or met.

use std::fmt::Display;

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// What the user gave cannot be used; nothing was written. Exit 2.
    BadInput(anyhow::Error),
    /// The input was good and the outcome is not. Exit 1.
    Problem(anyhow::Error),
}

/// What a command returns.
pub type Outcome = Result<(), Failure>;

impl Failure {
    /// Bad input, in words.
    pub fn bad_input(message: impl Display) -> Self {
        Self::BadInput(anyhow::anyhow!("{message}"))
    }

    /// A problem, in words.
    pub fn problem(message: impl Display) -> Self {
        Self::Problem(anyhow::anyhow!("{message}"))
    }

    /// The process's exit code.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::BadInput(_) => 2,
            Self::Problem(_) => 1,
        }
    }

    /// What went wrong, with its causes.
    pub fn error(&self) -> &anyhow::Error {
        match self {
            Self::BadInput(error) | Self::Problem(error) => error,
        }
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Problem(error)
    }
}

//! Why a viewer sees nothing, or does not get what it asks for.

use std::io;

use haptor_wire::{Denial, Denied, Refusal, VersionMismatch};

/// Why a viewer sees nothing, or does not get what it asks for.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// Nobody listens there.
    #[error("no host at {address}: {reason}; start one with `haptor run SCENE --device ... --viewer {address}`")]
    Connect {
        /// Where.
        address: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// The host closed the connection and said why.
    #[error("the host closed the connection: {0}")]
    Refused(Refusal),
    /// The host speaks another version or table and did not notice.
    #[error("{0}; use programs of one build")]
    Version(VersionMismatch),
    /// The connection is gone.
    #[error("the connection to the host is gone")]
    Closed,
    /// What was asked for was not done.
    #[error("the host did not do it: {0}")]
    Denied(Box<Denied>),
    /// Bytes or points were not taken.
    #[error("the host did not take it: {}", .0.name())]
    NotTaken(Denial),
    /// The host said nothing that was waited for.
    #[error("the host did not answer within {0} s")]
    Silent(u64),
    /// What is to be sent is longer than the link can say.
    #[error("{0} is longer than the viewer link takes")]
    TooLong(&'static str),
    /// What was received does not fit together.
    #[error("{0} came damaged; try again")]
    Damaged(&'static str),
}

impl ClientError {
    /// Whether trying again later may help without anybody doing anything.
    pub fn is_lost_connection(&self) -> bool {
        matches!(self, Self::Connect { .. } | Self::Closed | Self::Silent(_))
    }
}

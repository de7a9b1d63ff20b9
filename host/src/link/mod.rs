//! What carries bytes between host and device, and what all carriers promise.
//!
//! A **link** moves bytes and knows nothing of messages; [`Messages`] puts frames on top. A link never blocks longer than it is
//! told to, and after it was opened neither sending nor receiving allocates (USB: see [`usb`]). Opening, which allocates and may
//! block for long, is [`open`]'s and never the real-time thread's.

mod address;
mod arrivals;
mod low_latency;
pub mod mem;
mod messages;
mod poll;
mod port;
pub mod serial;
pub mod tcp;
#[cfg(feature = "usb")]
pub mod usb;
pub mod wrap;

use std::fmt;
use std::time::Duration;

pub use address::{Address, open};
pub use messages::{Messages, Received};
pub use port::Port;

/// How a carrier marks where a message begins and ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Framing {
    /// A stream of bytes: COBS, CRC-32, a zero ([`haptor_wire::frame`]).
    Stream,
    /// Packets of 64 bytes, one message each ([`haptor_wire::packet`]).
    Packet,
}

/// Why a link did not carry bytes. No text is built: this is made on the real-time thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// The other end is gone; nothing will come any more.
    #[error("the link is closed")]
    Closed,
    /// The carrier has no room: the other end does not read. Nothing of these bytes, or only their beginning, was sent.
    #[error("the link is full: the device does not read")]
    Full,
    /// The system refused, by its error number.
    #[error("the link failed: {0}")]
    System(rustix::io::Errno),
}

/// A carrier of bytes to and from one device.
pub trait Link: Send {
    /// How messages are marked off.
    fn framing(&self) -> Framing {
        Framing::Stream
    }

    /// Sends all of `bytes` without waiting.
    ///
    /// # Errors
    /// [`LinkError::Full`] when not all went out; any other error is the end of this link.
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError>;

    /// Receives what is there, up to `into.len()` bytes, waiting up to `wait` for the first; 0 = nothing came.
    ///
    /// # Errors
    /// Any error is the end of this link.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError>;

    /// The link as messages name it, e.g. `tcp:127.0.0.1:4000`.
    fn name(&self) -> &str;
}

/// A link of whatever kind; moved between threads without being copied.
pub type AnyLink = Box<dyn Link>;

impl fmt::Debug for dyn Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Link({})", self.name())
    }
}

impl From<rustix::io::Errno> for LinkError {
    /// The error numbers with which Linux says that a tty or a socket is gone become [`LinkError::Closed`].
    fn from(errno: rustix::io::Errno) -> Self {
        use rustix::io::Errno;
        match errno {
            Errno::IO | Errno::PIPE | Errno::CONNRESET | Errno::NODEV | Errno::NXIO | Errno::BADF => Self::Closed,
            Errno::AGAIN => Self::Full,
            other => Self::System(other),
        }
    }
}

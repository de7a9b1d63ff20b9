//! A serial port or a pseudo-terminal.
//!
//! `serialport` opens, configures and locks the port. Bytes move through a second descriptor of the same port that does not
//! block: `serialport`'s own read answers "nothing came" with an error text, two allocations a time, and the real-time thread
//! allocates nothing.

use std::fs;
use std::os::fd::OwnedFd;
use std::path::Path;
use std::time::Duration;

use rustix::fs::{Mode, OFlags};
use serialport::TTYPort;

use super::{Link, LinkError, poll};

/// Bits a second. 1,000 reports and commands of some 60 bytes a second need 0.6 Mbit/s each way; this is what common USB-serial
/// chips reach. A pseudo-terminal and a USB CDC device ignore it.
pub const BAUD: u32 = 3_000_000;

/// Milliseconds after which a USB-serial chip passes on a packet that is not full; chips start at 16, which is 16 ticks.
const LATENCY_TIMER_MS: &str = "1";

/// An open serial port in raw mode.
#[derive(Debug)]
pub struct SerialLink {
    bytes: OwnedFd,
    /// Keeps the port's settings and its lock against other programs; closed after `bytes`.
    _port: TTYPort,
    name: String,
}

impl SerialLink {
    /// Opens, locks and configures a port: raw, 8 data bits, no parity, one stop bit, no flow control.
    ///
    /// # Errors
    /// The system's, e.g. no such port, no right to it, in use by another program.
    pub fn open(path: &Path) -> std::io::Result<Self> {
        // before the lock: once it is exclusive nobody but root can open it again
        let bytes = rustix::fs::open(path, OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?;
        let port = serialport::new(path.to_string_lossy(), BAUD).exclusive(true).open_native()?;
        shorten_latency_timer(path);
        rustix::termios::tcflush(&bytes, rustix::termios::QueueSelector::IOFlush)?;
        Ok(Self { bytes, _port: port, name: format!("serial:{}", path.display()) })
    }
}

/// Asks an FTDI-like chip to pass on short packets at once. Best effort: other ports have no such file, and a user without the
/// right to write it gets a slower but working link, which the round-trip figures show.
fn shorten_latency_timer(path: &Path) {
    let Some(port) = path.file_name() else { return };
    let file = Path::new("/sys/class/tty").join(port).join("device/latency_timer");
    if file.exists() {
        let _ = fs::write(file, LATENCY_TIMER_MS);
    }
}

impl Link for SerialLink {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        poll::send(&self.bytes, bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        poll::receive(&self.bytes, into, wait)
    }

    fn name(&self) -> &str {
        &self.name
    }
}

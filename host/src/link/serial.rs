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

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    /// The controlling end of a pseudo-terminal and a link on the other.
    fn pty() -> (OwnedFd, SerialLink) {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        let link = SerialLink::open(Path::new(&name)).unwrap();
        (master, link)
    }

    /// Long enough for bytes that are there; what passes does not depend on it.
    const WAIT: Duration = Duration::from_secs(5);

    #[test]
    fn every_byte_crosses_unchanged_both_ways() {
        let (master, mut link) = pty();
        let all: Vec<u8> = (0..=255).collect();
        link.send(&all).unwrap();
        let mut got = [0; 512];
        let mut n = 0;
        while n < all.len() {
            n += rustix::io::read(&master, &mut got[n..]).unwrap();
        }
        assert_eq!(got[..n], all);
        rustix::io::write(&master, &all).unwrap();
        let mut n = 0;
        while n < all.len() {
            n += link.receive(&mut got[n..], WAIT).unwrap();
        }
        assert_eq!(got[..n], all);
    }

    #[test]
    fn nothing_is_nothing_and_the_end_is_the_end() {
        let (master, mut link) = pty();
        let mut got = [0; 8];
        for wait in [Duration::ZERO, Duration::from_micros(500)] {
            assert_eq!(link.receive(&mut got, wait), Ok(0));
        }
        drop(master);
        assert_eq!(link.receive(&mut got, WAIT), Err(LinkError::Closed));
        assert_eq!(link.send(&[1]), Err(LinkError::Closed));
    }

    #[test]
    fn a_device_that_does_not_read_fills_the_line_and_blocks_nobody() {
        let (_master, mut link) = pty();
        assert!((0..10_000).any(|_| link.send(&[7; 60]) == Err(LinkError::Full)));
    }

    #[test]
    fn an_open_port_is_locked() {
        let (master, _link) = pty();
        let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        assert!(SerialLink::open(Path::new(&name)).is_err());
    }
}

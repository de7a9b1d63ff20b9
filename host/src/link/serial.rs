//! A serial port or a pseudo-terminal.
//!
//! `serialport` opens, configures and locks the port. Bytes move through a second descriptor of the same port that does not
//! block: `serialport`'s own read answers "nothing came" with an error text, two allocations a time, and the real-time thread
//! allocates nothing.

use std::fs;
use std::io;
use std::os::fd::OwnedFd;
use std::path::Path;
use std::time::Duration;

use rustix::fs::{Mode, OFlags};
use serialport::TTYPort;

use super::port::{Port, explain};
use super::{Link, LinkError, low_latency, poll};

/// Bits a second. 1,000 reports and commands of some 60 bytes a second need 0.6 Mbit/s each way; this is what common USB-serial
/// chips reach. A pseudo-terminal and a USB CDC device ignore it.
pub const BAUD: u32 = 3_000_000;

/// Milliseconds after which a USB-serial chip passes on a packet that is not full; chips start at 16, which is 16 ticks.
const LATENCY_TIMER_MS: &str = "1";

/// Where the kernel keeps what is known of terminals.
const SYSFS: &str = "/sys/class/tty";

/// An open serial port in raw mode.
#[derive(Debug)]
pub struct SerialLink {
    bytes: OwnedFd,
    /// Keeps the port's settings and its lock against other programs; closed after `bytes`.
    _port: TTYPort,
    name: String,
}

impl SerialLink {
    /// Opens, locks and configures a port, by its path or by the number that it has now: raw, 8 data bits, no parity, one stop bit, no flow control, nothing held back where the
    /// driver lets that be asked for.
    ///
    /// # Errors
    /// In words, with what to do: no such port, no right to it, in use by another program, no serial port at all.
    pub fn open(port: &Port) -> io::Result<Self> {
        // named as it was asked for: at the next opening a number is looked up again, wherever its port is by then
        Self::open_path(&port.path()?, format!("serial:{port}"))
    }

    fn open_path(path: &Path, name: String) -> io::Result<Self> {
        // before the lock: once it is exclusive nobody but root can open it again
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let bytes = rustix::fs::open(path, flags, Mode::empty()).map_err(|errno| explain(path, &errno.into()))?;
        if !rustix::termios::isatty(&bytes) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "this is no serial port"));
        }
        let port = serialport::new(path.to_string_lossy(), BAUD).exclusive(true).open_native();
        let port = port.map_err(|error| explain(path, &taken(error)))?;
        if !low_latency::set(&bytes) {
            shorten_latency_timer(Path::new(SYSFS), path);
        }
        rustix::termios::tcflush(&bytes, rustix::termios::QueueSelector::IOFlush)?;
        Ok(Self { bytes, _port: port, name })
    }
}

/// The port is there, it has just been opened: one that the library does not get is another's.
fn taken(error: serialport::Error) -> io::Error {
    match error.kind {
        serialport::ErrorKind::NoDevice => io::Error::new(io::ErrorKind::ResourceBusy, error),
        _ => error.into(),
    }
}

/// Asks an FTDI-like chip whose driver has no flag for it to pass on short packets at once. Best effort: other ports have no such file, and a user
/// without the right to write it gets a slower but working link, which the round-trip figures show and `haptor doctor` explains.
fn shorten_latency_timer(sysfs: &Path, path: &Path) {
    // a port may be named by a link, as those in /dev/serial/by-id are
    let Some(port) = fs::canonicalize(path).ok().and_then(|path| path.file_name().map(ToOwned::to_owned)) else { return };
    let file = sysfs.join(port).join("device/latency_timer");
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
    use crate::link::Address;
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    /// The controlling end of a pseudo-terminal and a link on the other.
    fn pty() -> (OwnedFd, SerialLink) {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        let link = SerialLink::open(&Port::Path(name.clone().into())).unwrap();
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
        let text = SerialLink::open(&Port::Path(name.clone().into())).unwrap_err().to_string();
        assert!(text.contains("in use by another program") && text.contains(&name), "{text}");
    }

    #[test]
    fn a_link_is_named_as_it_was_asked_for() {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        unlockpt(&master).unwrap();
        let path = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        let link = SerialLink::open_path(Path::new(&path), format!("serial:{}", Port::Number("A17".to_owned()))).unwrap();
        assert_eq!(link.name().parse(), Ok(Address::Serial(Port::Number("A17".to_owned()))));
        drop(link);
        assert_eq!(SerialLink::open(&Port::Path(path.clone().into())).unwrap().name(), format!("serial:{path}"));
    }

    #[test]
    fn what_is_no_port_is_told_apart() {
        for (path, named) in [("/dev/no-such-port", "haptor devices"), ("/dev/null", "no serial port")] {
            let text = SerialLink::open(&Port::Path(path.into())).unwrap_err().to_string();
            assert!(text.contains(named), "{path}: {text}");
        }
    }

    #[test]
    fn the_latency_timer_of_a_port_named_by_a_link_is_found() {
        let folder = std::env::temp_dir().join(format!("haptor-latency-{}", std::process::id()));
        let (timer, link) = (folder.join("sys/ttyUSB7/device/latency_timer"), folder.join("by-id"));
        fs::create_dir_all(timer.parent().unwrap()).unwrap();
        fs::write(&timer, "16").unwrap();
        fs::write(folder.join("ttyUSB7"), "").unwrap();
        std::os::unix::fs::symlink(folder.join("ttyUSB7"), &link).unwrap();
        shorten_latency_timer(&folder.join("sys"), &link);
        assert_eq!(fs::read_to_string(&timer).unwrap(), LATENCY_TIMER_MS);
        fs::remove_dir_all(folder).unwrap();
    }
}

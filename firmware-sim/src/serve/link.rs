//! The ways to be reached: a pseudo terminal, a TCP port, a USB cable. None ever waits.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::OwnedFd;

use anyhow::{Context, Result};
use haptor_wire::{FromDevice, encode_packet, encode_stream, stream_bound};
use rustix::fs::{Mode, OFlags, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::args::Place;
use super::usbip::Usb;

/// Bytes kept for a peer that does not read; beyond it frames are dropped whole.
const BACKLOG: usize = 4096;

/// A link and what it could not send yet.
#[derive(Debug)]
pub struct Link {
    port: Port,
    backlog: Vec<u8>,
    taken: u64,
    dropped: u64,
}

#[derive(Debug)]
enum Port {
    Pty(Pty),
    Tcp(Tcp),
    Usb(Usb),
}

impl Link {
    /// Opens the place to serve at; on USB the serial number is asked for before any message.
    pub fn open(place: Place, serial: &str) -> Result<Self> {
        let port = match place {
            Place::Pty => Port::Pty(Pty::open()?),
            Place::Tcp(address) => Port::Tcp(Tcp::open(address).with_context(|| format!("cannot listen at {address}"))?),
            Place::Usb(way) => Port::Usb(Usb::open(way, serial)?),
        };
        Ok(Self { port, backlog: Vec::with_capacity(BACKLOG), taken: 0, dropped: 0 })
    }

    /// Where a host finds it, as `pty PATH`, `tcp ADDRESS`, `usbip ADDRESS` or `vhci port N`.
    pub fn place(&self) -> Result<String> {
        Ok(match &self.port {
            Port::Pty(pty) => format!("pty {}", pty.path),
            Port::Tcp(tcp) => format!("tcp {}", tcp.listener.local_addr()?),
            Port::Usb(usb) => usb.place().to_owned(),
        })
    }

    /// Frames dropped because the peer did not read, or had gone.
    pub fn dropped(&self) -> u64 {
        match &self.port {
            Port::Usb(usb) => usb.lost().0,
            Port::Pty(_) | Port::Tcp(_) => self.dropped,
        }
    }

    /// Packets that were no messages; in a stream the device counts them itself.
    pub fn bad_packets(&self) -> u64 {
        match &self.port {
            Port::Usb(usb) => usb.lost().1,
            Port::Pty(_) | Port::Tcp(_) => 0,
        }
    }

    /// The USB cable, where there is one.
    pub fn usb(&mut self) -> Option<&mut Usb> {
        match &mut self.port {
            Port::Usb(usb) => Some(usb),
            Port::Pty(_) | Port::Tcp(_) => None,
        }
    }

    /// A message as this link carries it.
    pub fn frame(&self, message: &FromDevice) -> Vec<u8> {
        if let Port::Usb(_) = self.port {
            return encode_packet(message).map(Vec::from).unwrap_or_default();
        }
        let mut frame = [0; stream_bound(FromDevice::MAX_ENCODED)];
        // the buffer has the longest message's bound
        let length = encode_stream(message, &mut frame).unwrap_or_default();
        frame[..length].to_vec()
    }

    /// Frames that have left.
    pub fn sent(&self) -> u64 {
        self.taken - self.dropped() - frames_in(&self.backlog)
    }

    /// Whether the link has changed hands since last asked; what was meant for the host before is forgotten.
    pub fn changed_hands(&mut self) -> Result<bool> {
        let changed = match &mut self.port {
            Port::Pty(pty) => std::mem::take(&mut pty.left),
            Port::Tcp(tcp) => tcp.newly_opened()?,
            Port::Usb(usb) => usb.newly_attached(),
        };
        if changed {
            self.drop_backlog();
        }
        Ok(changed)
    }

    /// What has come, at most a buffer full; nothing when nobody is there.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match &mut self.port {
            Port::Pty(pty) => pty.read(buffer),
            Port::Tcp(tcp) => Ok(tcp.read(buffer)),
            Port::Usb(usb) => Ok(usb.read(buffer)),
        }
    }

    /// Sends a whole frame, or drops it when the peer is behind.
    pub fn write(&mut self, frame: &[u8]) {
        if let Port::Usb(usb) = &mut self.port {
            self.taken += 1;
            return usb.write(frame);
        }
        self.taken += frames_in(frame);
        if self.backlog.len() + frame.len() > BACKLOG {
            self.dropped += frames_in(frame);
        } else {
            self.backlog.extend_from_slice(frame);
        }
        self.flush();
    }

    /// Sends what waits, as far as the peer takes it.
    pub fn flush(&mut self) {
        while !self.backlog.is_empty() {
            let sent = match &mut self.port {
                Port::Pty(pty) => pty.master.write(&self.backlog),
                Port::Tcp(tcp) => tcp.write(&self.backlog),
                Port::Usb(_) => return,
            };
            match sent {
                Ok(n) if n > 0 => drop(self.backlog.drain(..n)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                // nobody there
                _ => self.drop_backlog(),
            }
        }
    }

    fn drop_backlog(&mut self) {
        self.dropped += frames_in(&self.backlog);
        self.backlog.clear();
    }
}

/// A zero ends a frame.
fn frames_in(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|&&byte| byte == 0).count() as u64
}

/// A pseudo terminal, raw from the start.
///
/// Its far side is held open until a host speaks, so that the settings last and nothing is lost; then it is let go, so that the
/// host's leaving shows as an error, and held again.
#[derive(Debug)]
struct Pty {
    master: File,
    path: String,
    held: Option<OwnedFd>,
    /// A host has left.
    left: bool,
}

impl Pty {
    fn open() -> Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let master = openpt(flags).context("cannot open a pseudo terminal")?;
        grantpt(&master)?;
        unlockpt(&master)?;
        fcntl_setfl(&master, OFlags::RDWR | OFlags::NONBLOCK)?;
        let path = ptsname(&master, Vec::new())?.into_string()?;
        let mut pty = Self { master: File::from(master), path, held: None, left: false };
        pty.hold()?;
        Ok(pty)
    }

    fn hold(&mut self) -> Result<()> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave =
            rustix::fs::open(self.path.as_str(), flags, Mode::empty()).with_context(|| format!("cannot open {}", self.path))?;
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        self.held = Some(slave);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match self.master.read(buffer) {
            Ok(n) => {
                if n > 0 {
                    self.held = None;
                }
                Ok(n)
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
            // the host has closed its side
            Err(_) if self.held.is_none() => {
                self.left = true;
                self.hold().map(|()| 0)
            }
            Err(error) => Err(error).context("the pseudo terminal failed"),
        }
    }
}

/// A TCP port with one host at a time; a second one waits until the first has gone.
#[derive(Debug)]
struct Tcp {
    listener: TcpListener,
    stream: Option<TcpStream>,
}

impl Tcp {
    fn open(address: std::net::SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, stream: None })
    }

    fn newly_opened(&mut self) -> io::Result<bool> {
        if self.stream.is_some() {
            return Ok(false);
        }
        match self.listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(true)?;
                // a frame a millisecond: never wait to fill a segment
                stream.set_nodelay(true)?;
                self.stream = Some(stream);
                Ok(true)
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(false),
            // a host that left between knocking and entering
            Err(error) if error.kind() == ErrorKind::ConnectionAborted => Ok(false),
            Err(error) => Err(error),
        }
    }

    fn read(&mut self, buffer: &mut [u8]) -> usize {
        let Some(stream) = &mut self.stream else {
            return 0;
        };
        match stream.read(buffer) {
            Ok(n) if n > 0 => n,
            Err(error) if error.kind() == ErrorKind::WouldBlock => 0,
            // closed or broken
            _ => {
                self.stream = None;
                0
            }
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.stream {
            Some(stream) => stream.write(bytes),
            None => Err(ErrorKind::NotConnected.into()),
        }
    }
}

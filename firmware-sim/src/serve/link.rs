//! The two ways to be reached: a pseudo terminal and a TCP port. Neither ever waits.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::OwnedFd;

use anyhow::{Context, Result};
use rustix::fs::{Mode, OFlags, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::args::Place;

/// Bytes kept for a peer that does not read; beyond it frames are dropped whole.
const BACKLOG: usize = 4096;

/// A link and what it could not send yet.
#[derive(Debug)]
pub struct Link {
    port: Port,
    backlog: Vec<u8>,
    dropped: u64,
}

#[derive(Debug)]
enum Port {
    Pty(Pty),
    Tcp(Tcp),
}

impl Link {
    /// Opens the place to serve at.
    pub fn open(place: Place) -> Result<Self> {
        let port = match place {
            Place::Pty => Port::Pty(Pty::open()?),
            Place::Tcp(address) => Port::Tcp(Tcp::open(address).with_context(|| format!("cannot listen at {address}"))?),
        };
        Ok(Self { port, backlog: Vec::with_capacity(BACKLOG), dropped: 0 })
    }

    /// Where a host finds it, as `pty PATH` or `tcp ADDRESS`.
    pub fn place(&self) -> Result<String> {
        Ok(match &self.port {
            Port::Pty(pty) => format!("pty {}", pty.path),
            Port::Tcp(tcp) => format!("tcp {}", tcp.listener.local_addr()?),
        })
    }

    /// Writes dropped because the peer did not read.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Whether the link has changed hands since last asked; what was meant for the host before is forgotten.
    pub fn changed_hands(&mut self) -> Result<bool> {
        let changed = match &mut self.port {
            Port::Pty(pty) => std::mem::take(&mut pty.left),
            Port::Tcp(tcp) => tcp.newly_opened()?,
        };
        if changed {
            self.backlog.clear();
        }
        Ok(changed)
    }

    /// What has come, at most a buffer full; nothing when nobody is there.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match &mut self.port {
            Port::Pty(pty) => pty.read(buffer),
            Port::Tcp(tcp) => Ok(tcp.read(buffer)),
        }
    }

    /// Sends whole frames, or drops them all when the peer is behind.
    pub fn write(&mut self, frames: &[u8]) {
        if self.backlog.len() + frames.len() > BACKLOG {
            self.dropped += 1;
        } else {
            self.backlog.extend_from_slice(frames);
        }
        while !self.backlog.is_empty() {
            let sent = match &mut self.port {
                Port::Pty(pty) => pty.master.write(&self.backlog),
                Port::Tcp(tcp) => tcp.write(&self.backlog),
            };
            match sent {
                Ok(n) if n > 0 => drop(self.backlog.drain(..n)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                // nobody there
                _ => self.backlog.clear(),
            }
        }
    }
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

//! Where viewers come in: a TCP port, on this machine unless told otherwise, or a Unix socket that only the same user may open.

use std::fmt;
use std::fs::{self, Permissions};
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::error::HostError;

/// Where viewers come in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ViewerAddress {
    /// `HOST:PORT`; port 0 = one that is free.
    Tcp(SocketAddr),
    /// `unix:PATH`.
    Unix(PathBuf),
}

impl ViewerAddress {
    /// Whether only programs of this machine can reach it.
    #[must_use]
    pub fn is_local(&self) -> bool {
        match self {
            Self::Tcp(address) => address.ip().is_loopback(),
            Self::Unix(_) => true,
        }
    }
}

impl FromStr for ViewerAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const ALLOWED: &str = "allowed: HOST:PORT (e.g. 127.0.0.1:21278), unix:PATH";
        match text.split_once(':') {
            Some(("unix", "")) | None => Err(format!("`{text}` is no address; {ALLOWED}")),
            Some(("unix", path)) => Ok(Self::Unix(path.into())),
            Some(_) => {
                let mut found = text.to_socket_addrs().map_err(|e| format!("`{text}` is no address and port: {e}; {ALLOWED}"))?;
                found.next().map(Self::Tcp).ok_or_else(|| format!("`{text}` names no machine"))
            }
        }
    }
}

impl fmt::Display for ViewerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => address.fmt(f),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

/// An open ear; never blocks.
#[derive(Debug)]
pub enum Listener {
    /// On a port.
    Tcp(TcpListener),
    /// On a path, which is removed in the end.
    Unix(UnixListener, PathBuf),
}

impl Listener {
    /// Begins to listen.
    ///
    /// # Errors
    /// [`HostError::Listen`] with the address and the system's reason.
    pub fn open(address: &ViewerAddress) -> Result<Self, HostError> {
        let opened = match address {
            ViewerAddress::Tcp(address) => TcpListener::bind(address).map(Self::Tcp),
            ViewerAddress::Unix(path) => listen_at(path).map(|ear| Self::Unix(ear, path.clone())),
        };
        let ready = opened.and_then(|ear| ear.never_block().map(|()| ear));
        ready.map_err(|reason| HostError::Listen { address: address.to_string(), reason })
    }

    fn never_block(&self) -> io::Result<()> {
        match self {
            Self::Tcp(ear) => ear.set_nonblocking(true),
            Self::Unix(ear, _) => ear.set_nonblocking(true),
        }
    }

    /// Where it listens, with the port that it got.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn address(&self) -> io::Result<ViewerAddress> {
        match self {
            Self::Tcp(ear) => ear.local_addr().map(ViewerAddress::Tcp),
            Self::Unix(_, path) => Ok(ViewerAddress::Unix(path.clone())),
        }
    }

    /// A viewer that has come, if any.
    #[must_use]
    pub fn accept(&self) -> Option<Socket> {
        // an error is that of the one who came and has gone again
        match self {
            Self::Tcp(ear) => {
                let (socket, _) = ear.accept().ok()?;
                socket.set_nonblocking(true).and_then(|()| socket.set_nodelay(true)).ok()?;
                Some(Socket::Tcp(socket))
            }
            Self::Unix(ear, _) => {
                let (socket, _) = ear.accept().ok()?;
                socket.set_nonblocking(true).ok()?;
                Some(Socket::Unix(socket))
            }
        }
    }
}

impl AsFd for Listener {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(ear) => ear.as_fd(),
            Self::Unix(ear, _) => ear.as_fd(),
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Self::Unix(_, path) = self {
            // whoever took it away meanwhile has done our work
            let _ = fs::remove_file(path);
        }
    }
}

/// A socket that a host left behind when it was killed gives way; one that somebody listens at, or a file, does not.
fn listen_at(path: &Path) -> io::Result<UnixListener> {
    let is_socket = fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_socket());
    if is_socket && UnixStream::connect(path).is_err_and(|e| e.kind() == io::ErrorKind::ConnectionRefused) {
        fs::remove_file(path)?;
    }
    let ear = UnixListener::bind(path)?;
    fs::set_permissions(path, Permissions::from_mode(0o600))?;
    Ok(ear)
}

/// A connection; never blocks.
#[derive(Debug)]
pub enum Socket {
    /// TCP without delay.
    Tcp(TcpStream),
    /// Unix.
    Unix(UnixStream),
}

impl AsFd for Socket {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(socket) => socket.as_fd(),
            Self::Unix(socket) => socket.as_fd(),
        }
    }
}

impl Read for Socket {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(socket) => socket.read(into),
            Self::Unix(socket) => socket.read(into),
        }
    }
}

impl Write for Socket {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(socket) => socket.write(bytes),
            Self::Unix(socket) => socket.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_read_as_they_print_and_know_whether_they_are_local() {
        for (text, local) in
            [("127.0.0.1:21278", true), ("[::1]:1", true), ("unix:/tmp/a", true), ("0.0.0.0:1", false), ("10.0.0.7:1", false)]
        {
            let address: ViewerAddress = text.parse().unwrap();
            assert_eq!((address.to_string(), address.is_local()), (text.to_owned(), local));
        }
        for text in ["", "unix:", "21278", "localhost", "127.0.0.1:99999"] {
            let error = text.parse::<ViewerAddress>().unwrap_err();
            assert!(error.contains("unix:PATH"), "{text}: {error}");
        }
    }

    #[test]
    fn a_unix_socket_is_the_user_s_own_and_goes_with_its_listener() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("viewer");
        let address = ViewerAddress::Unix(path.clone());
        let ear = Listener::open(&address).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        let mut viewer = UnixStream::connect(&path).unwrap();
        let mut socket = ear.accept().unwrap();
        viewer.write_all(&[7]).unwrap();
        let mut got = [0; 4];
        assert_eq!((socket.read(&mut got).unwrap(), got[0]), (1, 7));
        assert!(matches!(Listener::open(&address), Err(HostError::Listen { .. })), "somebody listens there");
        drop(ear);
        assert!(!path.exists());
        // a listener that was killed leaves its socket behind
        drop(UnixListener::bind(&path).unwrap());
        drop(Listener::open(&address).unwrap());
        fs::write(&path, "a file").unwrap();
        assert!(matches!(Listener::open(&address), Err(HostError::Listen { .. })), "a file stays");
    }

    #[test]
    fn a_port_that_is_taken_is_named() {
        let address = ViewerAddress::Tcp(([127, 0, 0, 1], 0).into());
        let ear = Listener::open(&address).unwrap();
        let taken = ear.address().unwrap();
        let error = Listener::open(&taken).unwrap_err().to_string();
        assert!(error.contains(&taken.to_string()), "{error}");
        assert!(ear.accept().is_none());
    }
}

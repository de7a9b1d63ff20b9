//! Where a host is, and the token that lets one in.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use haptor_wire::viewer::{DEFAULT_ADDRESS, NO_TOKEN, TOKEN_BYTES, token_from_hex};

use crate::failure::Failure;

/// The variable of the environment that holds a token; the host reads the same.
const TOKEN_VARIABLE: &str = "HAPTOR_TOKEN";

/// Longest wait for a host to take a connection: across a network that is farther away no hand is steered.
const CONNECT_WITHIN: Duration = Duration::from_secs(3);

/// How long a read waits before the thread looks whether it is still wanted.
const READ_FOR: Duration = Duration::from_millis(200);

/// Longest wait for a host to take bytes; one that does not is gone.
const WRITE_WITHIN: Duration = Duration::from_secs(5);

/// What lets a viewer in; [`NO_TOKEN`] where none is asked for.
pub type Token = [u8; TOKEN_BYTES];

/// Where a host is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `HOST:PORT`.
    Tcp(String),
    /// `unix:PATH`.
    Unix(PathBuf),
}

impl Default for Address {
    fn default() -> Self {
        Self::Tcp(DEFAULT_ADDRESS.to_owned())
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.rsplit_once(':') {
            Some(("unix", path)) if !path.is_empty() => Ok(Self::Unix(path.into())),
            Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok() => Ok(Self::Tcp(text.to_owned())),
            _ => Err(format!("`{text}` is no address of a host; allowed: HOST:PORT (e.g. {DEFAULT_ADDRESS}), unix:PATH")),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => f.write_str(address),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

impl Address {
    /// Connects.
    pub(super) fn connect(&self) -> io::Result<Socket> {
        match self {
            Self::Tcp(address) => {
                let mut failed = io::Error::other("it names no machine");
                for place in address.to_socket_addrs()? {
                    match TcpStream::connect_timeout(&place, CONNECT_WITHIN) {
                        Ok(socket) => {
                            socket.set_nodelay(true)?;
                            socket.set_read_timeout(Some(READ_FOR))?;
                            socket.set_write_timeout(Some(WRITE_WITHIN))?;
                            return Ok(Socket::Tcp(socket));
                        }
                        Err(error) => failed = error,
                    }
                }
                Err(failed)
            }
            Self::Unix(path) => {
                let socket = UnixStream::connect(path)?;
                socket.set_read_timeout(Some(READ_FOR))?;
                socket.set_write_timeout(Some(WRITE_WITHIN))?;
                Ok(Socket::Unix(socket))
            }
        }
    }
}

/// The token of a file, else of the environment, else none.
///
/// # Errors
/// [`Failure::BadInput`] when the file cannot be read, or what is there is no token.
pub fn token(file: Option<&Path>) -> Result<Token, Failure> {
    let allowed = "a token is 64 hexadecimal digits, not all 0";
    if let Some(path) = file {
        let text = std::fs::read_to_string(path).map_err(|e| Failure::bad_input(format!("{}: {e}", path.display())))?;
        return token_from_hex(&text).ok_or_else(|| Failure::bad_input(format!("{}: {allowed}", path.display())));
    }
    match std::env::var(TOKEN_VARIABLE) {
        Ok(text) => token_from_hex(&text).ok_or_else(|| Failure::bad_input(format!("{TOKEN_VARIABLE}: {allowed}"))),
        Err(_) => Ok(NO_TOKEN),
    }
}

/// A connection of either kind; reads wait a moment, writes some seconds.
#[derive(Debug)]
pub enum Socket {
    /// TCP.
    Tcp(TcpStream),
    /// Unix.
    Unix(UnixStream),
}

impl Socket {
    /// A second handle to the same connection.
    pub fn again(&self) -> io::Result<Self> {
        match self {
            Self::Tcp(socket) => socket.try_clone().map(Self::Tcp),
            Self::Unix(socket) => socket.try_clone().map(Self::Unix),
        }
    }

    /// Closes it for every handle.
    pub fn close(&self) {
        // one that is gone needs no closing
        let _ = match self {
            Self::Tcp(socket) => socket.shutdown(Shutdown::Both),
            Self::Unix(socket) => socket.shutdown(Shutdown::Both),
        };
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
    fn addresses_read_as_they_print() {
        for text in ["127.0.0.1:21278", "localhost:1", "[::1]:21278", "unix:/run/haptor"] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
        assert_eq!(Address::default(), DEFAULT_ADDRESS.parse().unwrap());
        for text in ["", "localhost", ":1", "unix:", "host:port", "host:70000"] {
            let error = text.parse::<Address>().unwrap_err();
            assert!(error.contains("HOST:PORT") && error.contains("unix:PATH"), "{text}: {error}");
        }
    }
}

//! A TCP connection, on loopback as a rule: the simulated device, or a device behind a bridge.

use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use super::{Link, LinkError, poll};

/// How long connecting may take. Loopback answers at once; across a room a device that needs longer is not there.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);

/// A connected socket without delay (Nagle's algorithm off) that never blocks.
#[derive(Debug)]
pub struct TcpLink {
    socket: TcpStream,
    name: String,
}

impl TcpLink {
    /// Connects to a listening device.
    ///
    /// # Errors
    /// Whatever the system says; [`super::open`] adds what was being done.
    pub fn connect(address: SocketAddr) -> std::io::Result<Self> {
        let socket = TcpStream::connect_timeout(&address, CONNECT_TIMEOUT)?;
        socket.set_nodelay(true)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, name: format!("tcp:{address}") })
    }
}

impl Link for TcpLink {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        poll::send(&self.socket, bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        poll::receive(&self.socket, into, wait)
    }

    fn name(&self) -> &str {
        &self.name
    }
}

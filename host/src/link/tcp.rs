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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::TcpListener;

    fn connected() -> (TcpStream, TcpLink) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let link = TcpLink::connect(listener.local_addr().unwrap()).unwrap();
        (listener.accept().unwrap().0, link)
    }

    #[test]
    fn bytes_cross_both_ways_and_the_end_is_the_end() {
        let (mut device, mut link) = connected();
        link.send(&[1, 0, 2]).unwrap();
        let mut got = [0; 8];
        device.read_exact(&mut got[..3]).unwrap();
        assert_eq!(got[..3], [1, 0, 2]);
        assert_eq!(link.receive(&mut got, Duration::ZERO), Ok(0));
        device.write_all(&[9, 8]).unwrap();
        assert_eq!(link.receive(&mut got, Duration::from_secs(5)), Ok(2));
        drop(device);
        assert_eq!(link.receive(&mut got, Duration::from_secs(5)), Err(LinkError::Closed));
    }
}

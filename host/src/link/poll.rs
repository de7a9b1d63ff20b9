//! Reading and writing a descriptor that does not block, for sockets and ports alike.
//!
//! Terminals are asked less often: see [`super::arrivals`]. Straight on poll(2), read(2), write(2): three system calls a tick, no allocation, also when nothing comes. (A serial port's
//! or a socket's own time-out builds an error with text, which allocates.)

use std::os::fd::AsFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::io::Errno;

use super::LinkError;

/// Waits up to `wait` until `descriptor` has bytes or has hung up; true = it has.
pub(super) fn readable(descriptor: impl AsFd, wait: Duration) -> Result<bool, LinkError> {
    let timeout = Timespec { tv_sec: wait.as_secs() as i64, tv_nsec: i64::from(wait.subsec_nanos()) };
    let mut watched = [PollFd::new(&descriptor, PollFlags::IN)];
    match rustix::event::poll(&mut watched, Some(&timeout)) {
        Ok(ready) => Ok(ready > 0),
        // a signal cut the wait short: the caller's deadline decides what to do with the rest
        Err(Errno::INTR) => Ok(false),
        Err(errno) => Err(errno.into()),
    }
}

/// Receives into `into`, waiting up to `wait` for the first byte; 0 = nothing came.
pub(super) fn receive(descriptor: impl AsFd, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
    if !wait.is_zero() && !readable(&descriptor, wait)? {
        return Ok(0);
    }
    match rustix::io::read(&descriptor, into) {
        // readable and yet nothing: the end of a socket, a pty whose other end was closed
        Ok(0) => Err(LinkError::Closed),
        Ok(n) => Ok(n),
        Err(Errno::AGAIN | Errno::INTR) => Ok(0),
        Err(errno) => Err(errno.into()),
    }
}

/// Sends all of `bytes`; what the descriptor does not take at once is not sent.
pub(super) fn send(descriptor: impl AsFd, bytes: &[u8]) -> Result<(), LinkError> {
    match rustix::io::write(&descriptor, bytes) {
        Ok(n) if n == bytes.len() => Ok(()),
        Ok(_) | Err(Errno::INTR) => Err(LinkError::Full),
        Err(errno) => Err(errno.into()),
    }
}

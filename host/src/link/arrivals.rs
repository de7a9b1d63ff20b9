//! Whether bytes have come over a terminal, asked without waiting for the kernel's own work.
//!
//! What comes over a serial port or a pseudo-terminal is handed on by a worker thread of the kernel that has no priority. A read, or a poll, of a terminal with nothing
//! to read first waits until that worker is done (`tty_buffer_flush_work`), and on a busy machine that can be most of a second: the real-time thread would stand still
//! behind a thread of the lowest class, and with it the rule that takes a stale wrench to zero. An edge-triggered epoll does not ask the terminal at all. The worker
//! marks the arrival, and only then, with bytes there, is the terminal read.

use std::os::fd::{AsFd, OwnedFd};
use std::time::{Duration, Instant};

use rustix::event::Timespec;
use rustix::event::epoll::{CreateFlags, Event, EventData, EventFlags, add, create, wait};
use rustix::io::Errno;

use super::{LinkError, poll};

/// Not to wait.
const AT_ONCE: Timespec = Timespec { tv_sec: 0, tv_nsec: 0 };

/// Arrivals at one descriptor.
#[derive(Debug)]
pub(super) struct Arrivals {
    epoll: OwnedFd,
    /// The last read filled its buffer: more may be there that was marked with it.
    more: bool,
}

impl Arrivals {
    /// Watches a descriptor that does not block; what is there already counts as having come.
    pub fn of(descriptor: impl AsFd) -> Result<Self, Errno> {
        let epoll = create(CreateFlags::CLOEXEC)?;
        add(&epoll, descriptor, EventData::new_u64(0), EventFlags::IN | EventFlags::ET)?;
        Ok(Self { epoll, more: false })
    }

    /// Receives into `into` from the descriptor, waiting up to `wait` for the first byte; 0 = nothing came.
    pub fn receive(&mut self, descriptor: impl AsFd, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        let until = Instant::now() + wait;
        let mut left = wait;
        loop {
            if !self.more && !self.have_come(left)? {
                return Ok(0);
            }
            let n = poll::receive(&descriptor, into, Duration::ZERO)?;
            self.more = n == into.len();
            if n > 0 {
                return Ok(n);
            }
            // the buffer before held all there was
            left = until.saturating_duration_since(Instant::now());
        }
    }

    /// Whether something came since this was last asked, waiting for it. The wait is poll's, on the epoll: it takes less than milliseconds on every kernel.
    fn have_come(&self, for_at_most: Duration) -> Result<bool, LinkError> {
        if !for_at_most.is_zero() && !poll::readable(&self.epoll, for_at_most)? {
            return Ok(false);
        }
        let mut marks = [Event { flags: EventFlags::empty(), data: EventData::new_u64(0) }];
        match wait(&self.epoll, &mut marks, Some(&AT_ONCE)) {
            Ok(count) => Ok(count > 0),
            Err(Errno::INTR) => Ok(false),
            Err(errno) => Err(errno.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixStream;

    /// Long enough for bytes that are there; what passes does not depend on it.
    const WAIT: Duration = Duration::from_secs(5);

    #[test]
    fn a_buffer_that_is_just_filled_is_no_silence_and_nothing_marked_is_lost() {
        let (here, there) = UnixStream::pair().unwrap();
        there.set_nonblocking(true).unwrap();
        let mut arrivals = Arrivals::of(&there).unwrap();
        let mut buffer = [0; 4];
        for bytes in [&[1, 2, 3, 4][..], &[5], &[6, 7, 8, 9, 10, 11, 12, 13, 14], &[15, 16, 17, 18]] {
            rustix::io::write(&here, bytes).unwrap();
            let mut got = Vec::<u8>::new();
            while got.len() < bytes.len() {
                let n = arrivals.receive(&there, &mut buffer, WAIT).unwrap();
                assert!(n > 0, "{got:?} of {bytes:?}");
                got.extend(&buffer[..n]);
            }
            assert_eq!(got, bytes);
        }
        assert_eq!(arrivals.receive(&there, &mut buffer, Duration::ZERO), Ok(0));
        assert_eq!(arrivals.receive(&there, &mut buffer, Duration::from_micros(300)), Ok(0));
        drop(here);
        assert_eq!(arrivals.receive(&there, &mut buffer, WAIT), Err(LinkError::Closed));
    }

    #[test]
    fn what_was_there_before_the_watch_counts_as_having_come() {
        let (here, there) = UnixStream::pair().unwrap();
        there.set_nonblocking(true).unwrap();
        rustix::io::write(&here, &[1, 2]).unwrap();
        let mut buffer = [0; 4];
        assert_eq!(Arrivals::of(&there).unwrap().receive(&there, &mut buffer, Duration::ZERO), Ok(2));
    }
}

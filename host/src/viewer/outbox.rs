//! Bytes on their way to a viewer: bounded, written as far as the socket takes them, never waited for.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Write};
use std::time::{Duration, Instant};

use haptor_wire::{ToViewer, encode_stream, stream_bound};

/// Bytes waiting above which snapshots, surfaces and files wait or are left out: the largest surface, and a tenth of a second of a recording.
pub const ROOM: usize = 1 << 20;

/// Bytes waiting above which a viewer is given up: answers and events alone never come to that while somebody reads.
const MOST: usize = 2 * ROOM;

/// Time without a byte taken after which a viewer is given up: a program that is stopped in a debugger may come back within it.
const STUCK: Duration = Duration::from_secs(10);

/// Bytes that have not been taken yet.
#[derive(Debug)]
pub struct Outbox {
    bytes: VecDeque<u8>,
    /// When the viewer last took something, or there was nothing to take.
    taken: Instant,
}

impl Outbox {
    /// Empty.
    #[must_use]
    pub const fn new(now: Instant) -> Self {
        Self { bytes: VecDeque::new(), taken: now }
    }

    /// Adds a message, whatever waits already: answers and events.
    pub fn put(&mut self, message: &ToViewer) {
        let mut frame = [0; stream_bound(ToViewer::MAX_ENCODED)];
        // the buffer has the longest message's bound
        let length = encode_stream(message, &mut frame).unwrap_or(0);
        self.bytes.extend(&frame[..length]);
    }

    /// Adds frames unless too much waits already; whether it did.
    pub fn offer(&mut self, frames: &[u8]) -> bool {
        let room = self.bytes.is_empty() || self.bytes.len() + frames.len() <= ROOM;
        if room {
            self.bytes.extend(frames);
        }
        room
    }

    /// Adds a message unless too much waits already; whether it did.
    pub fn offer_message(&mut self, message: &ToViewer) -> bool {
        let room = self.has_room();
        if room {
            self.put(message);
        }
        room
    }

    /// Whether more than answers may be added.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.bytes.len() <= ROOM
    }

    /// True when nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Whether the viewer is to be given up.
    #[must_use]
    pub fn is_stuck(&self, now: Instant) -> bool {
        self.bytes.len() > MOST || (!self.is_empty() && now.duration_since(self.taken) > STUCK)
    }

    /// Writes as much as the socket takes.
    ///
    /// # Errors
    /// When the connection is gone.
    pub fn write_to(&mut self, socket: &mut impl Write, now: Instant) -> io::Result<()> {
        while !self.bytes.is_empty() {
            match socket.write(self.bytes.as_slices().0) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(n) => {
                    self.bytes.drain(..n);
                    self.taken = now;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.taken = now;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes so many bytes, then would block.
    struct Narrow(usize, Vec<u8>);

    impl Write for Narrow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let n = bytes.len().min(self.0);
            if n == 0 {
                return Err(ErrorKind::WouldBlock.into());
            }
            self.0 -= n;
            self.1.extend_from_slice(&bytes[..n]);
            Ok(n)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn what_is_offered_to_a_slow_reader_is_left_out_and_answers_are_not() {
        let now = Instant::now();
        let mut outbox = Outbox::new(now);
        assert!(outbox.offer(&vec![1; 2 * ROOM]), "an empty box takes the largest surface");
        assert!(!outbox.offer(&[2]) && !outbox.offer_message(&ToViewer::Pong(1)));
        outbox.put(&ToViewer::Done(7));
        assert!(outbox.is_stuck(now), "more than any answers");
        let mut socket = Narrow(2 * ROOM, Vec::new());
        outbox.write_to(&mut socket, now).unwrap();
        assert!(outbox.has_room() && !outbox.is_empty() && !outbox.is_stuck(now));
        assert!(outbox.is_stuck(now + STUCK + Duration::from_millis(1)));
        socket.0 = 100;
        outbox.write_to(&mut socket, now + STUCK).unwrap();
        assert!(outbox.is_empty() && !outbox.is_stuck(now + 10 * STUCK));
    }
}

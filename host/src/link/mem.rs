//! Two ends in one process, joined by two rings of bytes: what tests drive the host through.
//!
//! An end never waits, whatever it is told: where a virtual clock rules, nobody else runs while this end would sleep.

use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

use super::{Link, LinkError};

/// One end of a pair. Dropping it closes the link for the other end, once that has read what is left.
#[derive(Debug)]
pub struct MemLink {
    out: Producer<u8>,
    back: Consumer<u8>,
}

/// Two ends with room for `capacity` bytes each way.
#[must_use]
pub fn pair(capacity: usize) -> (MemLink, MemLink) {
    let (to_device, from_host) = RingBuffer::new(capacity);
    let (to_host, from_device) = RingBuffer::new(capacity);
    (MemLink { out: to_device, back: from_device }, MemLink { out: to_host, back: from_host })
}

impl Link for MemLink {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        if self.out.is_abandoned() {
            return Err(LinkError::Closed);
        }
        self.out.push_entire_slice(bytes).map_err(|_| LinkError::Full)
    }

    fn receive(&mut self, into: &mut [u8], _wait: Duration) -> Result<usize, LinkError> {
        // asked first: what the other end wrote before it went is then still seen
        let closed = self.back.is_abandoned();
        let (received, _) = self.back.pop_partial_slice(into);
        match received.len() {
            0 if closed => Err(LinkError::Closed),
            n => Ok(n),
        }
    }

    fn name(&self) -> &str {
        "mem"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_cross_in_order_and_a_full_ring_takes_all_or_nothing() {
        let (mut host, mut device) = pair(4);
        host.send(&[1, 2, 3]).unwrap();
        assert_eq!(host.send(&[4, 5]), Err(LinkError::Full));
        let mut got = [0; 8];
        assert_eq!(device.receive(&mut got, Duration::ZERO), Ok(3));
        assert_eq!(got[..3], [1, 2, 3]);
        assert_eq!(device.receive(&mut got, Duration::ZERO), Ok(0));
    }

    #[test]
    fn what_was_written_before_the_end_is_still_read() {
        let (mut host, mut device) = pair(4);
        device.send(&[9]).unwrap();
        drop(device);
        let mut got = [0; 4];
        assert_eq!(host.receive(&mut got, Duration::ZERO), Ok(1));
        assert_eq!(host.receive(&mut got, Duration::ZERO), Err(LinkError::Closed));
        assert_eq!(host.send(&[1]), Err(LinkError::Closed));
    }
}

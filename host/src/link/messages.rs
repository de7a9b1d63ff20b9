//! Messages over a link: frames out, frames in, damage counted.

use std::time::Duration;

use haptor_wire::device::{FromDevice, ToDevice};
use haptor_wire::frame::{encode_stream, stream_bound};
use haptor_wire::{PACKET_BYTES, StreamDecoder, decode_packet, encode_packet};

use super::{AnyLink, Framing, LinkError};

/// Bytes of the longest frame to a device, with the zero that may go before it.
const OUT_BYTES: usize = 1 + stream_bound(ToDevice::MAX_ENCODED);

/// Bytes of the longest frame from a device.
const IN_FRAME: usize = stream_bound(FromDevice::MAX_ENCODED);

/// Bytes read at once: some ten reports, so that a backlog after a stall is gone in a few reads.
const READ_BYTES: usize = 640;

/// Bytes without a message after which a line is not idle but talking nonsense: no frame is longer.
const NONSENSE_BYTES: u32 = IN_FRAME as u32;

/// What one look at the link brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Received {
    /// A whole message.
    Message(FromDevice),
    /// Bytes, but no whole message yet.
    Part,
    /// Nothing in the time given.
    Nothing,
}

/// A link, its decoder, and what went wrong on it.
#[derive(Debug)]
pub struct Messages {
    link: AnyLink,
    decoder: StreamDecoder<IN_FRAME>,
    buffer: [u8; READ_BYTES],
    unread: std::ops::Range<usize>,
    /// The last frame out was cut short: the next begins with a zero, which ends the broken one.
    cut_short: bool,
    bad_packets: u32,
    /// Bytes and frames dropped since the last whole message.
    bytes_since: u32,
    rejected_at_last: u32,
}

impl Messages {
    /// Begins on a freshly opened link.
    #[must_use]
    pub fn new(link: AnyLink) -> Self {
        Self {
            link,
            decoder: StreamDecoder::new(),
            buffer: [0; READ_BYTES],
            unread: 0..0,
            cut_short: true,
            bad_packets: 0,
            bytes_since: 0,
            rejected_at_last: 0,
        }
    }

    /// Gives the link back, to be closed elsewhere.
    #[must_use]
    pub fn into_link(self) -> AnyLink {
        self.link
    }

    /// Frames dropped since this link was opened: checksum, length or contents.
    #[must_use]
    pub fn rejected(&self) -> u32 {
        self.decoder.counts().rejected().saturating_add(self.bad_packets)
    }

    /// True when what came since the last message was not messages.
    #[must_use]
    pub fn is_nonsense(&self) -> bool {
        self.rejected() > self.rejected_at_last || self.bytes_since > NONSENSE_BYTES
    }

    /// Sends one message.
    ///
    /// # Errors
    /// As [`super::Link::send`].
    pub fn send(&mut self, message: &ToDevice) -> Result<(), LinkError> {
        let sent = match self.link.framing() {
            Framing::Packet => {
                // every message of the table fits a packet: a test of the table holds it
                let packet = encode_packet(message).unwrap_or([0; PACKET_BYTES]);
                self.link.send(&packet)
            }
            Framing::Stream => {
                let mut out = [0; OUT_BYTES];
                // the buffer has the longest message's bound
                let length = encode_stream(message, &mut out[1..]).unwrap_or(0);
                let from = usize::from(!self.cut_short);
                self.link.send(&out[from..=length])
            }
        };
        self.cut_short = sent.is_err();
        sent
    }

    /// Takes the next message, waiting up to `wait` for bytes when none are left over.
    ///
    /// # Errors
    /// As [`super::Link::receive`].
    pub fn receive(&mut self, wait: Duration) -> Result<Received, LinkError> {
        if self.unread.is_empty() {
            let n = self.link.receive(&mut self.buffer, wait)?;
            if n == 0 {
                return Ok(Received::Nothing);
            }
            self.unread = 0..n;
            self.bytes_since = self.bytes_since.saturating_add(n as u32);
        }
        let message = match self.link.framing() {
            Framing::Packet => self.next_packet(),
            Framing::Stream => self.next_frame(),
        };
        let Some(message) = message else { return Ok(Received::Part) };
        self.bytes_since = 0;
        self.rejected_at_last = self.rejected();
        Ok(Received::Message(message))
    }

    fn next_frame(&mut self) -> Option<FromDevice> {
        let decoder = &mut self.decoder;
        let buffer = &self.buffer;
        self.unread.by_ref().find_map(|at| decoder.push(buffer[at]))
    }

    /// A packet link hands over one packet a read.
    fn next_packet(&mut self) -> Option<FromDevice> {
        let message = decode_packet(&self.buffer[self.unread.clone()]).ok();
        self.bad_packets = self.bad_packets.saturating_add(u32::from(message.is_none()));
        self.unread = 0..0;
        message
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::{Link, mem};
    use haptor_wire::device::{DeviceFault, FaultCause, HostHello};

    const FAULT: FromDevice = FromDevice::Fault(DeviceFault { cause: FaultCause::Hardware, seq: 7, detail: -1 });

    fn frame(message: &FromDevice) -> Vec<u8> {
        let mut out = [0; IN_FRAME];
        let n = encode_stream(message, &mut out).unwrap();
        out[..n].to_vec()
    }

    #[test]
    fn messages_come_one_at_a_time_from_one_read() {
        let (host, mut device) = mem::pair(1024);
        let mut messages = Messages::new(Box::new(host));
        device.send(&[frame(&FAULT), frame(&FAULT)].concat()).unwrap();
        for _ in 0..2 {
            assert_eq!(messages.receive(Duration::ZERO), Ok(Received::Message(FAULT)));
        }
        assert_eq!(messages.receive(Duration::ZERO), Ok(Received::Nothing));
    }

    #[test]
    fn damage_is_counted_and_the_next_frame_is_read() {
        let (host, mut device) = mem::pair(1024);
        let mut messages = Messages::new(Box::new(host));
        let mut broken = frame(&FAULT);
        broken[2] ^= 0x40;
        device.send(&broken).unwrap();
        assert_eq!(messages.receive(Duration::ZERO), Ok(Received::Part));
        assert!(messages.is_nonsense());
        device.send(&frame(&FAULT)).unwrap();
        assert_eq!(messages.receive(Duration::ZERO), Ok(Received::Message(FAULT)));
        assert_eq!((messages.rejected(), messages.is_nonsense()), (1, false));
    }

    #[test]
    fn a_frame_after_one_that_was_cut_short_begins_with_a_zero() {
        let (host, mut device) = mem::pair(16);
        let mut messages = Messages::new(Box::new(host));
        let hello = ToDevice::Hello(HostHello { version: 1, schema: 2, period_us: 1000 });
        let mut got = [0; 64];
        for expected_zero in [true, false] {
            messages.send(&hello).unwrap();
            let n = device.receive(&mut got, Duration::ZERO).unwrap();
            assert_eq!((got[0] == 0, got[n - 1]), (expected_zero, 0));
        }
        messages.send(&hello).unwrap();
        assert_eq!(messages.send(&hello), Err(LinkError::Full));
        device.receive(&mut got, Duration::ZERO).unwrap();
        messages.send(&hello).unwrap();
        device.receive(&mut got, Duration::ZERO).unwrap();
        assert_eq!(got[0], 0);
    }
}

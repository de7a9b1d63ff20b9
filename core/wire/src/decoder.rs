//! From a stream of bytes, however it is cut, to messages.
//!
//! The decoder gathers bytes up to a zero, tries them as one frame and begins anew, so after any damage it is in step again at
//! the next zero. What it drops it counts, by reason. An empty frame (two zeros in a row) is idle line, not damage: a sender may
//! begin a frame with a zero to cut off whatever came before it.

use serde::de::DeserializeOwned;

use crate::frame::{FrameError, decode_stream};

/// What a decoder has seen; each count stops at its largest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecodeCounts {
    /// Messages yielded.
    pub accepted: u32,
    /// Frames whose checksum differed.
    pub checksum: u32,
    /// Frames longer than the decoder's buffer.
    pub too_long: u32,
    /// Frames that were not COBS, too short, or no message of the table.
    pub malformed: u32,
}

impl DecodeCounts {
    /// Frames dropped, for whatever reason.
    #[must_use]
    pub const fn rejected(&self) -> u32 {
        self.checksum.saturating_add(self.too_long).saturating_add(self.malformed)
    }
}

/// Gathers frames of up to `N` bytes, the final zero not counted.
///
/// `N` = [`crate::frame::stream_bound`] of the table's `MAX_ENCODED` takes every message of the table.
#[derive(Clone, Debug)]
pub struct StreamDecoder<const N: usize> {
    frame: heapless::Vec<u8, N>,
    overflow: bool,
    counts: DecodeCounts,
}

impl<const N: usize> Default for StreamDecoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> StreamDecoder<N> {
    /// An empty decoder: the next byte begins a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            frame: heapless::Vec::new(),
            overflow: false,
            counts: DecodeCounts { accepted: 0, checksum: 0, too_long: 0, malformed: 0 },
        }
    }

    /// What has been accepted and dropped so far.
    #[must_use]
    pub const fn counts(&self) -> DecodeCounts {
        self.counts
    }

    /// Bytes gathered of a frame that has not ended.
    #[must_use]
    pub fn pending(&self) -> usize {
        self.frame.len()
    }

    /// Forgets the frame begun and keeps the counts; for a link opened anew.
    pub fn restart(&mut self) {
        self.frame.clear();
        self.overflow = false;
    }

    /// Takes one byte; yields the message that it completes.
    pub fn push<T: DeserializeOwned>(&mut self, byte: u8) -> Option<T> {
        if byte != 0 {
            self.overflow |= self.frame.push(byte).is_err();
            return None;
        }
        let message = self.finish();
        self.restart();
        message
    }

    /// Takes bytes; hands each message that they complete to `sink`, in order.
    pub fn feed<T: DeserializeOwned>(&mut self, bytes: &[u8], mut sink: impl FnMut(T)) {
        for &byte in bytes {
            if let Some(message) = self.push(byte) {
                sink(message);
            }
        }
    }

    fn finish<T: DeserializeOwned>(&mut self) -> Option<T> {
        if self.overflow {
            bump(&mut self.counts.too_long);
            return None;
        }
        if self.frame.is_empty() {
            return None;
        }
        let result = decode_stream(&mut self.frame);
        bump(match &result {
            Ok(_) => &mut self.counts.accepted,
            Err(FrameError::Checksum { .. }) => &mut self.counts.checksum,
            Err(_) => &mut self.counts.malformed,
        });
        result.ok()
    }
}

fn bump(count: &mut u32) {
    *count = count.saturating_add(1);
}

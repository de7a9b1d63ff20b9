//! Frames in a stream: postcard, checksum, COBS, a zero.
//!
//! ```text
//! message --postcard--> bytes --append CRC-32, little endian--> bytes --COBS--> bytes without zeros --append--> 0x00
//! ```
//! The checksum is CRC-32/ISO-HDLC, the one of zlib, Ethernet and PNG: polynomial 0x04C11DB7, reflected, start and final
//! exclusive-or 0xFFFFFFFF, of "123456789" 0xCBF43926. It covers the postcard bytes and lies inside the COBS.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};
use postcard::ser_flavors::crc::CrcModifier;
use serde::{Deserialize, Serialize};

use crate::cobs::{self, CobsWriter};

/// The checksum of every frame, packet and file.
pub const CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of the checksum.
pub(crate) const CRC_BYTES: usize = 4;

/// Why bytes are not a message, or a message does not go into bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The buffer to write into is too small.
    BufferFull,
    /// Fewer bytes than the shortest message and its checksum, or than the frame says.
    Short,
    /// The stuffing is broken: this is not COBS.
    Stuffing,
    /// The checksum differs.
    Checksum {
        /// What the bytes give.
        computed: u32,
        /// What the frame says.
        received: u32,
    },
    /// The checksum agrees, but the bytes are no message of this table.
    Contents,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BufferFull => f.write_str("the buffer is too small for the frame"),
            Self::Short => f.write_str("the frame is too short"),
            Self::Stuffing => f.write_str("the frame's byte stuffing is broken"),
            Self::Checksum { computed, received } => {
                write!(f, "the frame's checksum is {received:08x}, its bytes give {computed:08x}")
            }
            Self::Contents => f.write_str("the frame's bytes are no message of this table"),
        }
    }
}

impl core::error::Error for FrameError {}

/// Bytes in a stream at most for a message of `encoded` postcard bytes, the final zero included.
#[must_use]
pub const fn stream_bound(encoded: usize) -> usize {
    cobs::bound(encoded + CRC_BYTES)
}

/// Writes `message` as one frame, final zero included, to the front of `out`; yields its length.
///
/// # Errors
/// [`FrameError::BufferFull`] when `out` is shorter than the frame; [`stream_bound`] of the message's `MAX_ENCODED` always fits.
pub fn encode_stream<T: Serialize>(message: &T, out: &mut [u8]) -> Result<usize, FrameError> {
    let writer = CrcModifier::new(CobsWriter::new(out), CRC32.digest());
    postcard::serialize_with_flavor(message, writer).map_err(|_| FrameError::BufferFull)
}

/// Reads one frame, without its final zero; the bytes are decoded onto themselves, and the message may borrow from them.
///
/// # Errors
/// Any [`FrameError`] but `BufferFull`; bytes left over after the message are [`FrameError::Contents`].
pub fn decode_stream<'a, T: Deserialize<'a>>(frame: &'a mut [u8]) -> Result<T, FrameError> {
    match decode_stream_head(frame)? {
        (value, 0) => Ok(value),
        _ => Err(FrameError::Contents),
    }
}

/// Reads the beginning of one frame, as [`decode_stream`]; yields how many bytes are left over too.
pub(crate) fn decode_stream_head<'a, T: Deserialize<'a>>(frame: &'a mut [u8]) -> Result<(T, usize), FrameError> {
    let plain = cobs::decode_in_place(frame).ok_or(FrameError::Stuffing)?;
    decode_checked_head(frame.get(..plain).ok_or(FrameError::Stuffing)?)
}

/// Reads postcard bytes followed by their checksum.
pub(crate) fn decode_checked<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, FrameError> {
    match decode_checked_head(bytes)? {
        (value, 0) => Ok(value),
        _ => Err(FrameError::Contents),
    }
}

fn decode_checked_head<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<(T, usize), FrameError> {
    let (message, crc) = bytes.split_last_chunk::<CRC_BYTES>().ok_or(FrameError::Short)?;
    let computed = CRC32.checksum(message);
    let received = u32::from_le_bytes(*crc);
    if computed != received {
        return Err(FrameError::Checksum { computed, received });
    }
    postcard::take_from_bytes(message).map(|(value, left)| (value, left.len())).map_err(|_| FrameError::Contents)
}

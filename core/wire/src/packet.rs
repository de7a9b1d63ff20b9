//! Packets on USB: one message in 64 bytes, the transfer that full-speed interrupt endpoints carry whole.
//!
//! ```text
//! [ n ][ postcard bytes, then CRC-32 little endian: n bytes ][ zeros up to 64 ]
//! ```
//! No stuffing: the bus marks where a packet begins. The checksum is that of [`crate::frame`].

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::frame::{CRC_BYTES, CRC32, FrameError, decode_checked};

/// Bytes of a packet.
pub const PACKET_BYTES: usize = 64;

/// Postcard bytes of a message at most, for it to go into a packet.
pub const PACKET_MESSAGE_MAX: usize = PACKET_BYTES - 1 - CRC_BYTES;

/// Writes `message` as one packet.
///
/// # Errors
/// [`FrameError::BufferFull`] when the message is longer than [`PACKET_MESSAGE_MAX`]; no message of the device link is.
pub fn encode_packet<T: Serialize>(message: &T) -> Result<[u8; PACKET_BYTES], FrameError> {
    let mut packet = [0; PACKET_BYTES];
    let [length, body @ ..] = &mut packet;
    let used = postcard::to_slice_crc32(message, body, CRC32.digest()).map_err(|_| FrameError::BufferFull)?.len();
    // at most 63
    *length = used as u8;
    Ok(packet)
}

/// Reads one packet. What follows the message is not looked at, so a packet cut after its checksum is good.
///
/// # Errors
/// Any [`FrameError`] but `BufferFull` and `Stuffing`.
pub fn decode_packet<T: DeserializeOwned>(packet: &[u8]) -> Result<T, FrameError> {
    let (&length, body) = packet.split_first().ok_or(FrameError::Short)?;
    decode_checked(body.get(..usize::from(length)).ok_or(FrameError::Short)?)
}

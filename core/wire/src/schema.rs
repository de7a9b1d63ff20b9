//! Version and fingerprint of the tables.
//!
//! Two builds understand each other when their version **and** the fingerprint of the table are equal. The version is for people,
//! raised by hand; the fingerprint is the CRC-32 of the canonical text below and catches the change that somebody forgot to
//! announce. A test prints every message type in the same notation, from the types themselves, and compares.
//!
//! Notation: `Name{field:type,...}`; `[type;n]` an array; `?type` an option; an enum's cases in order, parted by `|`, with what
//! each carries. Order is meaning: postcard writes fields in order and an enum's case by its place.

use core::fmt;

use crate::frame::CRC32;

/// Version of both links and both files; raised with every change to a table.
pub const PROTOCOL_VERSION: u16 = 1;

/// Fingerprint of the device link: CRC-32 of [`DEVICE_TABLE`].
pub const SCHEMA_HASH: u32 = CRC32.checksum(DEVICE_TABLE.as_bytes());

/// Fingerprint of the tool link and the files: CRC-32 of [`TOOL_TABLE`].
pub const TOOL_SCHEMA_HASH: u32 = CRC32.checksum(TOOL_TABLE.as_bytes());

/// The device link in canonical text.
pub const DEVICE_TABLE: &str = "";
/// The tool link and the files in canonical text.
pub const TOOL_TABLE: &str = "";

/// Host and device, or tool and host, were built from different tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VersionMismatch {
    /// Version of this side.
    pub our_version: u16,
    /// Version of the other side.
    pub their_version: u16,
    /// Fingerprint of this side.
    pub our_schema: u32,
    /// Fingerprint of the other side.
    pub their_schema: u32,
}

impl fmt::Display for VersionMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the other side speaks version {} (table {:08x}), this side version {} (table {:08x})",
            self.their_version, self.their_schema, self.our_version, self.our_schema
        )
    }
}

impl core::error::Error for VersionMismatch {}

/// Compares what the other end of the device link said in its hello.
///
/// # Errors
/// [`VersionMismatch`] with both versions and both fingerprints.
pub const fn check_device_version(version: u16, schema: u32) -> Result<(), VersionMismatch> {
    check(version, schema, SCHEMA_HASH)
}

/// Compares what the other end of the tool link, or a file, says.
///
/// # Errors
/// [`VersionMismatch`] with both versions and both fingerprints.
pub const fn check_tool_version(version: u16, schema: u32) -> Result<(), VersionMismatch> {
    check(version, schema, TOOL_SCHEMA_HASH)
}

const fn check(version: u16, schema: u32, ours: u32) -> Result<(), VersionMismatch> {
    if version == PROTOCOL_VERSION && schema == ours {
        return Ok(());
    }
    Err(VersionMismatch {
        our_version: PROTOCOL_VERSION,
        their_version: version,
        our_schema: ours,
        their_schema: schema,
    })
}

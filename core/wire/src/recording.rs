//! The recording: a session as a file that only grows.
//!
//! A file is a row of COBS + CRC32 frames, the same as on a serial link, so a file cut at any byte, by a crash or a full disk,
//! still reads up to its last whole frame, and damage in the middle costs the frames it touches and no more. The first frame is
//! the [`RecordHeader`], the last one of a session that ended in order the [`Summary`].

use serde::{Deserialize, Serialize};

use crate::device::{ENUM, F32, U16, U32, U64};
use crate::scene::Tier;
use crate::status::{FaultRecord, Summary};

/// One frame of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// What was recorded; first.
    Header(RecordHeader),
    /// One tick.
    Tick(TickRecord),
    /// A fault has latched.
    Fault(FaultRecord),
    /// The session ended in order; last.
    End(Summary),
}

impl Record {
    /// Postcard bytes at most, the byte that names the record included.
    pub const MAX_ENCODED: usize = 1 + Summary::MAX_ENCODED;
}

/// What was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordHeader {
    /// [`crate::PROTOCOL_VERSION`] of the writer.
    pub version: u16,
    /// [`crate::TOOL_SCHEMA_HASH`] of the writer.
    pub schema: u32,
    /// Ticks a second.
    pub rate_hz: u32,
    /// [`crate::scene::digest`] of the baked scene's file.
    pub scene_digest: u64,
    /// Start of the session [s since 1970-01-01 UTC].
    pub start_unix_s: u32,
}

impl RecordHeader {
    /// Postcard bytes at most, without the byte that names the record.
    pub const MAX_ENCODED: usize = U16 + U32 + U32 + U64 + U32;
}

/// One tick: what came in, what went out, what the contact was, how long it took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TickRecord {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// Time since the session began [us].
    pub t_us: u64,
    /// Position `p_dh` of the handle as received, in `d` [m].
    pub position: [f32; 3],
    /// Rotation `q_dh` of the handle as received, unit quaternion (w, x, y, z).
    pub rotation: [f32; 4],
    /// Force sent to the handle, after the guard, in `d` [N].
    pub force: [f32; 3],
    /// Torque sent to the handle about its origin, after the guard, in `d` [N m].
    pub torque: [f32; 3],
    /// Contact force on the probe, before the guard, in `w` [N].
    pub contact_force: [f32; 3],
    /// Contact torque on the probe about its mass centre, before the guard, in `w` [N m].
    pub contact_torque: [f32; 3],
    /// Number of regions.
    pub regions: u8,
    /// Largest depth [m].
    pub depth: f32,
    /// Contact radius of the deepest region [m].
    pub radius: f32,
    /// Stuck share of the deepest region's area, 0 to 1.
    pub stick: f32,
    /// Tier used.
    pub tier: Tier,
    /// What the core and the host had to say: 0 = clean.
    pub flags: u32,
    /// How late the thread woke [ns].
    pub wake_ns: u32,
    /// What the step of the core took [ns].
    pub step_ns: u32,
    /// From sending the previous wrench to the report that echoed it [ns]; 0 = none seen.
    pub round_trip_ns: u32,
}

impl TickRecord {
    /// Postcard bytes at most, without the byte that names the record.
    pub const MAX_ENCODED: usize = 2 * U64 + 19 * F32 + 1 + 3 * F32 + ENUM + 4 * U32;
}

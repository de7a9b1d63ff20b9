//! The recording: a session as a file that only grows.
//!
//! A file is a row of COBS + CRC32 frames, the same as on a serial link, so a file cut at any byte, by a crash or a full disk,
//! still reads up to its last whole frame, and damage in the middle costs the frames it touches and no more. In order:
//!
//! | record | when | what it means |
//! |---|---|---|
//! | [`RecordHeader`] | first | what was recorded; everything before it no longer holds, so files may be joined, and a session that goes to another scene goes on in the same file |
//! | `Schema` | behind the header | [`crate::schema::TOOL_TABLE`] in chunks: the types of all records in words that a reader in another language can follow |
//! | `Scene` | behind it | the file of the baked scene with its sections in chunks: the recording can be computed again without any other file |
//! | [`SessionHello`] | the device is known | guard and coupling were fitted to it |
//! | [`Tuning`] | the session begins, or somebody tunes | holds for all ticks after it; before the first, what the scene says |
//! | [`Place`] | the session begins, or somebody tares | where the device stands from here on; before the first, where the scene says |
//! | `Rest` | behind those three | the core was put at rest: from here on every tick can be computed again |
//! | [`TickRecord`] | once a tick | what came in, what went out |
//! | [`Event`], [`FaultRecord`] | as they happen | what was done, what went wrong |
//! | `Lost` | the recorder fell behind | so many records are missing here |
//! | [`Summary`] | the session ended in order | last |
//!
//! A black box holds the last ticks before a fault: it begins in the middle of a session, so it has no `Rest`, and its ticks cannot be computed again. It carries
//! `Schema` and the device, but only the digest of the scene.
//!
//! To compute the contact again, bit for bit: take the scene, a core fitted to the device of the hello (a virtual coupling takes from it what the scene leaves
//! out; without a hello the core's own limits hold), with the tuning and the place that hold, at rest where the file says so, and of the ticks those without
//! [`flags::NO_POSE`], in order. Each is one step of the core at the pose recorded, its quaternion normalised, with
//! ```text
//! dt = (tick - tick of the one before without NO_POSE) / rate_hz     in f64, then rounded to f32; the first after Rest has dt = 1 / rate_hz
//! ```
//! so ticks that the thread slept through count, and so do those in which no pose came. `contact_force` and `contact_torque` come
//! out again; `force` and `torque` too where no bit of the host's but [`flags::LATE`] is set: the guard has the limits of the device (full scale in 20 ms) and of
//! the tuning. After a damaged place, or `Lost`, nothing is known of the core's memory, nor of device, tuning and place, until all three have come anew and `Rest` follows.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::device::{ENUM, F32, U16, U32, U64};
use crate::flags;
use crate::frame::{FrameError, decode_stream, decode_stream_head, stream_bound};
use crate::scene::{Place, Tier};
use crate::status::{FaultRecord, SessionHello, Summary};
use crate::tuning::Tuning;

/// One frame of a recording. `'a` is the frame that chunks borrow from; all others carry their data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Record<'a> {
    /// What was recorded; first.
    Header(RecordHeader),
    /// A piece of the text of the tables.
    #[serde(borrow)]
    Schema(Chunk<'a>),
    /// A piece of the baked scene's file.
    #[serde(borrow)]
    Scene(Chunk<'a>),
    /// The device that was there; before the first tick.
    Device(SessionHello),
    /// What holds for the ticks after it.
    Tuning(Tuning),
    /// Where the device stands in the ticks after it.
    Place(Place),
    /// The core was put at rest before the next tick.
    Rest,
    /// One tick.
    Tick(TickRecord),
    /// Something was done.
    Event(Event),
    /// A fault has latched.
    Fault(FaultRecord),
    /// Records that are missing here: the recorder fell behind.
    Lost {
        /// How many.
        count: u64,
    },
    /// The session ended in order; last.
    End(Summary),
}

impl Record<'_> {
    /// Postcard bytes at most, the byte that names the record included.
    pub const MAX_ENCODED: usize = 1 + Chunk::MAX_ENCODED;
}

/// Bytes of a chunk at most: few enough for a small machine to hold a frame, many enough that a table of 10 MB is some ten thousand.
pub const CHUNK_BYTES: usize = 1024;

/// Bytes of the length before a chunk's bytes at most, as postcard writes it.
const CHUNK_LENGTH: usize = 2;

/// A piece of a text or a file that is longer than a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Chunk<'a> {
    /// Where it begins \[bytes from the start of the whole\].
    pub at: u32,
    /// The piece, at most [`CHUNK_BYTES`].
    pub bytes: &'a [u8],
}

impl Chunk<'_> {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = U32 + CHUNK_LENGTH + CHUNK_BYTES;

    /// The pieces of `whole`, in order; a whole beyond `u32::MAX` bytes has none.
    pub fn of(whole: &[u8]) -> impl Iterator<Item = Chunk<'_>> {
        let fits = u32::try_from(whole.len()).is_ok();
        let pieces = whole.chunks(CHUNK_BYTES).enumerate().take_while(move |_| fits);
        pieces.map(|(i, bytes)| Chunk { at: (i * CHUNK_BYTES) as u32, bytes })
    }
}

/// Something that was done, and the tick before which it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// The next tick.
    pub tick: u64,
    /// What was done.
    pub what: What,
}

impl Event {
    /// Postcard bytes at most, without the byte that names the record.
    pub const MAX_ENCODED: usize = U64 + ENUM;
}

/// What is done to a session from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum What {
    /// The output was held closed and the core stopped.
    Frozen,
    /// It goes on.
    Resumed,
    /// Somebody hit the emergency stop: the device was released to brake.
    EmergencyStop,
    /// The stop was taken back.
    Rearmed,
    /// The device's place was set anew so that the probe is where it is wanted.
    Tared,
    /// A recording was begun while the session ran.
    RecordingBegun,
    /// It was ended.
    RecordingEnded,
    /// Somebody marked this moment.
    Mark,
}

impl What {
    /// Everything that can be done, in the order of the wire.
    pub const ALL: [Self; 8] = [
        Self::Frozen,
        Self::Resumed,
        Self::EmergencyStop,
        Self::Rearmed,
        Self::Tared,
        Self::RecordingBegun,
        Self::RecordingEnded,
        Self::Mark,
    ];

    /// It in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frozen => "frozen",
            Self::Resumed => "resumed",
            Self::EmergencyStop => "emergency stop",
            Self::Rearmed => "rearmed",
            Self::Tared => "tared",
            Self::RecordingBegun => "recording begun",
            Self::RecordingEnded => "recording ended",
            Self::Mark => "mark",
        }
    }
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
    /// Start of the session \[s since 1970-01-01 UTC\].
    pub start_unix_s: u32,
    /// Length of the text of the tables \[bytes\]; 0 = not in this file.
    pub schema_bytes: u32,
    /// Length of the baked scene's file \[bytes\]; 0 = not in this file.
    pub scene_bytes: u32,
}

impl RecordHeader {
    /// Postcard bytes at most, without the byte that names the record.
    pub const MAX_ENCODED: usize = U16 + U32 + U32 + U64 + 3 * U32;
}

/// Version and fingerprint of whoever wrote a recording, also when its tables are others and nothing but this can be read: the first two fields of a header never
/// change. `None` when the file does not begin with a whole header.
#[must_use]
pub fn written_by(file: &[u8]) -> Option<(u16, u32)> {
    let mut frame = [0; FRAME_MAX];
    let first = file.split(|&byte| byte == 0).find(|frame| !frame.is_empty())?;
    let copy = frame.get_mut(..first.len())?;
    copy.iter_mut().zip(first).for_each(|(to, &byte)| *to = byte);
    let ((record, version, schema), _) = decode_stream_head::<(u8, u16, u32)>(copy).ok()?;
    (record == 0).then_some((version, schema))
}

/// One tick: what came in, what went out, what the contact was, how long it took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TickRecord {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// Time since the session began \[us\].
    pub t_us: u64,
    /// Position `p_dh` of the handle as received, in `d` \[m\].
    pub position: [f32; 3],
    /// Rotation `q_dh` of the handle as received, unit quaternion (w, x, y, z).
    pub rotation: [f32; 4],
    /// Force sent to the handle, after the guard, in `d` \[N\].
    pub force: [f32; 3],
    /// Torque sent to the handle about its origin, after the guard, in `d` \[N m\].
    pub torque: [f32; 3],
    /// Contact force on the probe, before the guard, in `w` \[N\].
    pub contact_force: [f32; 3],
    /// Contact torque on the probe about its mass centre, before the guard, in `w` \[N m\].
    pub contact_torque: [f32; 3],
    /// Number of regions.
    pub regions: u8,
    /// Largest depth \[m\].
    pub depth: f32,
    /// Contact radius of the deepest region \[m\].
    pub radius: f32,
    /// Stuck share of the deepest region's area, 0 to 1.
    pub stick: f32,
    /// Tier used.
    pub tier: Tier,
    /// What the core and the host had to say: 0 = clean; the bits are in [`crate::flags`].
    pub flags: u32,
    /// How late the thread woke \[ns\].
    pub wake_ns: u32,
    /// What the step of the core took \[ns\].
    pub step_ns: u32,
    /// From sending the previous wrench to the report that echoed it \[ns\]; 0 = none seen.
    pub round_trip_ns: u32,
}

impl TickRecord {
    /// Postcard bytes at most, without the byte that names the record.
    pub const MAX_ENCODED: usize = 2 * U64 + 19 * F32 + 1 + 3 * F32 + ENUM + 4 * U32;

    /// Whether the hand felt this tick's contact: a fresh pose came, no fault kept the output closed, and the wrench went out.
    ///
    /// After a fault a hand goes on pushing with nothing to push back, so the contact computed there is deeper than anything that
    /// was felt; peaks of a session are taken over felt ticks only.
    #[must_use]
    pub const fn was_felt(&self) -> bool {
        self.flags & flags::NOT_FELT == 0
    }
}

/// Bytes of a frame at most, its final zero included.
pub const FRAME_MAX: usize = stream_bound(Record::MAX_ENCODED);

/// A stretch of a recording that holds no record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Where it begins \[bytes from the start of the file\].
    pub offset: usize,
    /// Its length \[bytes\].
    pub skipped: usize,
    /// What is wrong with it.
    pub cause: DamageCause,
}

/// What is wrong with a stretch of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamageCause {
    /// The file ends before the frame does.
    Cut,
    /// Longer than any record.
    Long,
    /// A frame, but not a good one.
    Frame(FrameError),
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (offset, skipped) = (self.offset, self.skipped);
        write!(f, "byte {offset}: {skipped} bytes skipped: ")?;
        match self.cause {
            DamageCause::Cut => f.write_str("the recording ends within a frame"),
            DamageCause::Long => f.write_str("longer than any record"),
            DamageCause::Frame(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for Damage {}

/// Reads the records of a file, in order; damage is reported in its place and reading goes on after it. The bytes are decoded onto themselves: what has been
/// read is no recording any more.
#[derive(Debug)]
pub struct RecordReader<'a> {
    rest: &'a mut [u8],
    offset: usize,
}

impl<'a> RecordReader<'a> {
    /// Reads from the first byte of a recording.
    #[must_use]
    pub const fn new(file: &'a mut [u8]) -> Self {
        Self { rest: file, offset: 0 }
    }

    /// Where the next frame begins \[bytes from the start of the file\].
    #[must_use]
    pub const fn offset(&self) -> usize {
        self.offset
    }

    /// The next frame without its zero, and whether it had one.
    fn take_frame(&mut self) -> (&'a mut [u8], bool) {
        let rest = core::mem::take(&mut self.rest);
        let end = rest.iter().position(|&byte| byte == 0);
        let (frame, rest) = rest.split_at_mut(end.unwrap_or(rest.len()));
        let zero = usize::from(end.is_some());
        self.offset += frame.len() + zero;
        self.rest = rest.get_mut(zero..).unwrap_or_default();
        (frame, end.is_some())
    }
}

impl<'a> Iterator for RecordReader<'a> {
    type Item = Result<Record<'a>, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.rest.is_empty() {
            let offset = self.offset;
            let (frame, whole) = self.take_frame();
            let skipped = frame.len() + usize::from(whole);
            let damage = |cause| Damage { offset, skipped, cause };
            if frame.is_empty() {
                continue;
            }
            if !whole {
                return Some(Err(damage(DamageCause::Cut)));
            }
            return Some(if skipped > FRAME_MAX {
                Err(damage(DamageCause::Long))
            } else {
                decode_stream(frame).map_err(|error| damage(DamageCause::Frame(error)))
            });
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::encode_stream;
    use crate::samples::{EVENT, FAULT_RECORD, HEADER, PLACE, SESSION, SUMMARY, TUNING};
    use crate::schema::TOOL_TABLE;
    use std::vec::Vec;

    fn session() -> (Vec<u8>, Vec<Record<'static>>, Vec<usize>) {
        let ticks = (0..20)
            .map(|tick| Record::Tick(TickRecord { tick, t_us: 1000 * tick, depth: 1e-5 * tick as f32, ..TickRecord::default() }));
        let mut records = std::vec![Record::Header(HEADER)];
        records.extend(Chunk::of(&TOOL_TABLE.as_bytes()[..CHUNK_BYTES + 9]).map(Record::Schema));
        records.extend(Chunk::of(&[0; 300]).map(Record::Scene));
        records.extend([Record::Device(SESSION), Record::Tuning(TUNING), Record::Place(PLACE), Record::Rest]);
        records.extend(ticks);
        records.extend([Record::Event(EVENT), Record::Fault(FAULT_RECORD), Record::Lost { count: 3 }, Record::End(SUMMARY)]);
        let (mut file, mut ends) = (Vec::new(), Vec::new());
        for record in &records {
            let mut frame = [0; FRAME_MAX];
            let n = encode_stream(record, &mut frame).unwrap();
            file.extend_from_slice(&frame[..n]);
            ends.push(file.len());
        }
        (file, records, ends)
    }

    #[test]
    fn there_and_back() {
        let (mut file, records, _) = session();
        let read: Result<Vec<_>, _> = RecordReader::new(&mut file).collect();
        assert_eq!(read.unwrap(), records);
    }

    #[test]
    fn a_file_cut_at_any_byte_reads_up_to_its_last_whole_frame() {
        let (file, records, ends) = session();
        for cut in 0..=file.len() {
            let whole = ends.iter().filter(|&&end| end <= cut).count();
            let mut file = file[..cut].to_vec();
            let read: Vec<_> = RecordReader::new(&mut file).collect();
            let good: Vec<_> = read.iter().filter_map(|r| r.ok()).collect();
            assert_eq!(good, records[..whole], "cut at {cut}");
            let begun = cut > ends[..whole].last().copied().unwrap_or(0);
            assert_eq!(read.len() - good.len(), usize::from(begun), "cut at {cut}");
            if begun {
                let damage = read.last().unwrap().unwrap_err();
                assert_eq!(damage.cause, DamageCause::Cut);
                assert_eq!(damage.offset + damage.skipped, cut);
            }
        }
    }

    #[test]
    fn damage_costs_the_frames_it_touches() {
        let (file, records, ends) = session();
        for at in 0..file.len() {
            for flip in [0x01, 0x80, 0xFF] {
                let mut bad = file.clone();
                bad[at] ^= flip;
                let hit = ends.iter().filter(|&&end| end <= at).count();
                let read: Vec<_> = RecordReader::new(&mut bad).filter_map(Result::ok).collect();
                // a zero that is gone joins two frames
                let lost_zero = at + 1 == ends[hit];
                let lost = hit..(hit + 1 + usize::from(lost_zero)).min(records.len());
                let expected: Vec<_> = (0..records.len()).filter(|i| !lost.contains(i)).map(|i| records[i]).collect();
                assert_eq!(read, expected, "byte {at} ^ {flip:02x}");
            }
        }
    }

    #[test]
    fn the_writer_of_another_version_is_known() {
        let mut frame = [0; FRAME_MAX];
        let other = (0_u8, 9_u16, 0xDEAD_BEEF_u32, [7_u8; 12]);
        let length = encode_stream(&other, &mut frame).unwrap();
        assert_eq!(written_by(&frame[..length]), Some((9, 0xDEAD_BEEF)));
        assert_eq!(written_by(&session().0), Some((HEADER.version, HEADER.schema)));
        frame[3] ^= 1;
        for strange in [&frame[..length], &frame[..3], b"", b"\0\0", &[1; FRAME_MAX + 1]] {
            assert_eq!(written_by(strange), None);
        }
    }

    #[test]
    fn felt_is_what_went_out_fresh() {
        let felt = |flags| TickRecord { flags, ..TickRecord::default() }.was_felt();
        // the core's bits say nothing about it, nor does a late command
        for bits in [0, 1 << 3, flags::LATE] {
            assert!(felt(bits), "{bits:#x}");
        }
        for bits in [flags::NO_POSE, flags::HELD, flags::CLOSED, flags::NOT_SENT, flags::POSE_REFUSED] {
            assert!(!felt(bits) && !felt(bits | flags::LATE), "{bits:#x}");
        }
    }

    #[test]
    fn every_bit_has_its_name_in_its_place() {
        let bits = [flags::NO_POSE, flags::HELD, flags::CLOSED, flags::LATE, flags::NOT_SENT, flags::POSE_REFUSED];
        assert_eq!(bits.len(), flags::NAMES.len());
        assert!(bits.iter().enumerate().all(|(i, &bit)| bit == 1 << (24 + i)));
    }

    #[test]
    fn what_is_longer_than_any_record_is_named() {
        let file = [7; FRAME_MAX + 1];
        let mut file = [&file[..], &[0]].concat();
        let damage = RecordReader::new(&mut file).next().unwrap().unwrap_err();
        assert_eq!(damage.cause, DamageCause::Long);
        assert_eq!((damage.offset, damage.skipped), (0, FRAME_MAX + 2));
    }
}

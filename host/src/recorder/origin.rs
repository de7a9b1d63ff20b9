//! What every recording of a scene begins with: header, the text of the tables, the scene's file; and what holds at the moment it begins.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use haptor_wire::frame::{FrameError, encode_stream};
use haptor_wire::recording::{Chunk, FRAME_MAX};
use haptor_wire::schema::TOOL_TABLE;
use haptor_wire::{PROTOCOL_VERSION, Place, Record, RecordHeader, SessionHello, TOOL_SCHEMA_HASH, Tuning, scene_file};

/// Frames that belong together, as they stand in a file.
pub type Frames = Arc<[u8]>;

/// A scene's file and what recordings of it begin with.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The first frame.
    pub header: RecordHeader,
    /// The scene's file.
    scene: Arc<[u8]>,
}

impl Origin {
    /// Of a baked scene's file, from now on.
    #[must_use]
    pub fn new(rate_hz: u32, scene: Arc<[u8]>) -> Self {
        // a clock before 1970 or after 2106 is no reason not to run
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let header = RecordHeader {
            version: PROTOCOL_VERSION,
            schema: TOOL_SCHEMA_HASH,
            rate_hz,
            scene_digest: scene_file::digest(&scene),
            start_unix_s: u32::try_from(since_1970.as_secs()).unwrap_or(u32::MAX),
            schema_bytes: TOOL_TABLE.len() as u32,
            // a scene that long has no chunks
            scene_bytes: u32::try_from(scene.len()).unwrap_or(0),
        };
        Self { header, scene }
    }

    /// The scene's file.
    #[must_use]
    pub const fn scene(&self) -> &Arc<[u8]> {
        &self.scene
    }

    /// Header, tables and scene.
    pub fn frames(&self) -> Result<Vec<u8>, FrameError> {
        let mut frames = self.head(self.header)?;
        Chunk::of(&self.scene).try_for_each(|chunk| append(&mut frames, &Record::Scene(chunk)))?;
        Ok(frames)
    }

    /// Header and tables; of the scene only the digest.
    pub fn without_scene(&self) -> Result<Vec<u8>, FrameError> {
        self.head(RecordHeader { scene_bytes: 0, ..self.header })
    }

    fn head(&self, header: RecordHeader) -> Result<Vec<u8>, FrameError> {
        let mut frames = Vec::new();
        append(&mut frames, &Record::Header(header))?;
        Chunk::of(TOOL_TABLE.as_bytes()).try_for_each(|chunk| append(&mut frames, &Record::Schema(chunk)))?;
        Ok(frames)
    }
}

/// What holds at a moment of the session, as far as it is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standing {
    pub device: Option<SessionHello>,
    pub tuning: Option<Tuning>,
    pub place: Option<Place>,
    /// The tick after the last one recorded.
    pub tick: u64,
}

impl Standing {
    /// Takes note of a record that goes by.
    pub fn note(&mut self, record: &Record<'_>) {
        match *record {
            Record::Device(hello) => self.device = Some(hello),
            Record::Tuning(tuning) => self.tuning = Some(tuning),
            Record::Place(place) => self.place = Some(place),
            Record::Tick(tick) => self.tick = tick.tick + 1,
            _ => {}
        }
    }

    /// What somebody who begins to read now must know.
    pub fn append_to(&self, frames: &mut Vec<u8>) -> Result<(), FrameError> {
        let known = [self.device.map(Record::Device), self.tuning.map(Record::Tuning), self.place.map(Record::Place)];
        known.iter().flatten().try_for_each(|record| append(frames, record))
    }
}

/// Adds a record's frame.
pub fn append(frames: &mut Vec<u8>, record: &Record<'_>) -> Result<(), FrameError> {
    let mut frame = [0; FRAME_MAX];
    // the buffer has the longest record's bound
    let length = encode_stream(record, &mut frame)?;
    frames.extend_from_slice(&frame[..length]);
    Ok(())
}

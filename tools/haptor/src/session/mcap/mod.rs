//! A recording as MCAP (mcap.dev), the container of robotics tools: Foxglove and PlotJuggler open it, libraries for C++, Python, Go, Rust and TypeScript read it.
//! Chunked, indexed, not compressed; messages are JSON with their schemas in the file.
//!
//! | topic | schema | when |
//! |---|---|---|
//! | `/tick` | `haptor.Tick`: wrenches, regions, depth, stick, flags, times | every tick |
//! | `/handle` | `foxglove.PoseInFrame`, in frame `device` | every tick |
//! | `/tf` | `foxglove.FrameTransform`, `world` to `device` | the device is placed |
//! | `/log` | `foxglove.Log` | events, faults, tunings, what was lost or damaged |

mod messages;

use std::collections::BTreeMap;
use std::io::Write;

use haptor_wire::{Place, TickRecord};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions, Writer};
use serde::Serialize;

use self::messages::{Handle, Log, Moved, Tick, Time};
use super::describe::words;
use super::recording::{Happening, Recording};

/// Bytes of a chunk: about a second of ticks, so that a viewer fetches little to show a moment.
const CHUNK: u64 = 1 << 20;

/// The topics: name, schema, its text.
const TOPICS: [(&str, &str, &str); 4] = [
    ("/tick", "haptor.Tick", include_str!("tick.json")),
    ("/handle", "foxglove.PoseInFrame", include_str!("pose_in_frame.json")),
    ("/tf", "foxglove.FrameTransform", include_str!("frame_transform.json")),
    ("/log", "foxglove.Log", include_str!("log.json")),
];

/// Places of the topics.
const TICK: usize = 0;
const HANDLE: usize = 1;
const TF: usize = 2;
const LOG: usize = 3;

/// Writes a recording; `at` hears how many ticks are done.
///
/// # Errors
/// When the bytes cannot be written.
pub fn write(recording: &Recording, out: impl Write, at: impl FnMut(usize)) -> McapResult<()> {
    let mut sheet = Sheet::new(recording, out)?;
    sheet.all(recording, at)?;
    sheet.writer.finish().map(drop)
}

struct Sheet<W: Write> {
    writer: Writer<NoSeek<W>>,
    channels: [u16; 4],
    sequence: u32,
    /// Start of the session \[ns since 1970\].
    start_ns: u64,
}

impl<W: Write> Sheet<W> {
    fn new(recording: &Recording, out: W) -> McapResult<Self> {
        let options = WriteOptions::new().compression(None).chunk_size(Some(CHUNK)).disable_seeking(true);
        let mut writer = options.library(concat!("haptor ", env!("CARGO_PKG_VERSION"))).create(NoSeek::new(out))?;
        let mut channels = [0; 4];
        for (channel, (topic, name, schema)) in channels.iter_mut().zip(TOPICS) {
            let schema = writer.add_schema(name, "jsonschema", schema.as_bytes())?;
            *channel = writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
        }
        writer.write_metadata(&Metadata { name: "haptor".to_owned(), metadata: metadata(recording) })?;
        let start_s = recording.header.map_or(0, |header| header.start_unix_s);
        Ok(Self { writer, channels, sequence: 0, start_ns: 1_000_000_000 * u64::from(start_s) })
    }

    fn all(&mut self, recording: &Recording, mut at: impl FnMut(usize)) -> McapResult<()> {
        let mut happened = recording.happened.iter().peekable();
        let mut now = Time::of(self.start_ns);
        for (index, tick) in recording.ticks.iter().enumerate() {
            now = Time::of(self.start_ns + 1000 * tick.t_us);
            while let Some((_, what)) = happened.next_if(|(before, _)| *before <= index) {
                self.happening(now, what)?;
            }
            self.tick(now, tick)?;
            at(index);
        }
        happened.try_for_each(|(_, what)| self.happening(now, what))
    }

    fn tick(&mut self, now: Time, tick: &TickRecord) -> McapResult<()> {
        self.send(TICK, now, &Tick::new(now, tick))?;
        self.send(HANDLE, now, &Handle::new(now, tick))
    }

    fn happening(&mut self, now: Time, what: &Happening) -> McapResult<()> {
        if let Happening::Placed(Place { p_wd, q_wd }) = what {
            self.send(TF, now, &Moved::new(now, *p_wd, *q_wd))?;
        }
        match words(what) {
            Some(message) => self.send(LOG, now, &Log::new(now, what, message)),
            None => Ok(()),
        }
    }

    fn send(&mut self, topic: usize, now: Time, message: &impl Serialize) -> McapResult<()> {
        let data = serde_json::to_vec(message).map_err(|error| McapError::Io(error.into()))?;
        let (channel_id, log_time) = (self.channels[topic], now.ns());
        self.sequence = self.sequence.wrapping_add(1);
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, &data)
    }
}

fn metadata(recording: &Recording) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    if let Some(header) = recording.header {
        all.insert("rate_hz".to_owned(), header.rate_hz.to_string());
        all.insert("scene_digest".to_owned(), format!("{:016x}", header.scene_digest));
        all.insert("version".to_owned(), header.version.to_string());
        all.insert("schema".to_owned(), format!("{:08x}", header.schema));
    }
    all.insert("damaged_places".to_owned(), recording.damaged.to_string());
    all
}

//! The bytes between device, host and tools, as tables one can read.
//!
//! Words: the **device** is the thing at the end of the cable, the **host** the real-time program, a **tool** any program that
//! looks on. A **message** is one value of a table; a **frame** is a message with its checksum, marked off in a stream of bytes;
//! a **packet** is a frame in 64 bytes of USB. `WIRE.md` tells the same in prose for someone writing firmware in C.
//!
//! Device link (integers and arrays only; [`device`]):
//!
//! | message | direction | when | bytes at most |
//! |---|---|---|---|
//! | [`HostHello`] | host → device | first, and after every loss | 14 |
//! | [`DeviceHello`] | device → host | answers `HostHello` | 46 |
//! | [`Mode`] (`SetMode`) | host → device | to arm, rest, brake or reset | 2 |
//! | [`PoseReport`] | device → host | once a period while in session | 54 |
//! | [`WrenchCommand`] | host → device | answers every `PoseReport` | 46 |
//! | [`DeviceFault`] | device → host | once, when a fault latches | 12 |
//!
//! Tool link (host to tool, a pipe or a socket; [`status`]) and files ([`scene`], [`recording`]):
//!
//! | message | direction | when | bytes at most |
//! |---|---|---|---|
//! | [`SessionHello`] | host → tool, recording | the device has answered | 58 |
//! | [`Progress`] | host → tool | some ten times a second | 46 |
//! | [`FaultRecord`] | host → tool, recording | a fault latches | 17 |
//! | [`Summary`] | host → tool, recording | the session ends | 160 |
//! | [`BakedScene`] | tool → host | a file, before the start | 923 |
//! | [`RecordHeader`] | recording | its first frame | 39 |
//! | [`Chunk`] | recording | behind it: text of the tables, the scene's file | 1032 |
//! | [`Tuning`] | recording | the session begins, or somebody tunes | 135 |
//! | [`Place`] | recording | the session begins, or somebody tares | 29 |
//! | [`Event`] | recording | somebody freezes, stops, tares, marks | 12 |
//! | [`TickRecord`] | recording | once a tick | 131 |
//!
//! Viewer link (programs that look on and steer, over TCP or a Unix socket; [`viewer`], in prose `VIEWER.md`):
//!
//! | message | direction | when | bytes at most |
//! |---|---|---|---|
//! | [`ViewerHello`] | viewer → host | first | 41 |
//! | [`Refusal`] | host → viewer | last, when the host closes | 10 |
//! | [`Welcome`] | host → viewer | answers `ViewerHello` | 30 |
//! | [`Subscription`] | viewer → host | what it wants to see | 16 |
//! | [`UploadBegin`] | viewer → host | a model is to come, or to be gone on with | 16 |
//! | [`UploadChunk`] | viewer → host | bytes of it, in order | 4114 |
//! | [`UploadState`] | host → viewer | answers both | 23 |
//! | [`RestBegin`] | viewer → host | rest points are to come | 6 |
//! | [`RestPoints`] | viewer → host | they, in order | 3080 |
//! | [`RestState`] | host → viewer | answers both | 13 |
//! | [`Ask`] | viewer → host | a request | 141 |
//! | [`Denied`] | host → viewer | it was not carried out, and why | 169 |
//! | [`SceneNow`] | host → viewer | the scene that runs | 16 |
//! | [`SceneBytes`] | host → viewer | its file, when asked for | 4119 |
//! | [`Snapshot`] | host → viewer | every so many ticks | 1106 |
//! | [`SurfaceBlock`] | host → viewer | with every so many snapshots | 2331 |
//! | [`Statistics`] | host → viewer | every so many milliseconds | 236 |
//! | [`RecordBytes`] | host → viewer | a recording, while asked for | 4109 |
//!
//! "Bytes" counts the postcard encoding with the one byte that names the message, without checksum and framing: a stream adds
//! at most 6 to a message shorter than 250 bytes and one more per 254 to a longer one, a packet 5. Every figure is a constant (`MAX_ENCODED`) held by a test.
//! Nothing here allocates, reads a clock or can panic on any input. Frames are single letters: `w` world, `d` device base,
//! `h` handle, `p` probe. Units are SI unless the name says otherwise (`_nm` nanometre, `_un` micronewton, `_unm`
//! micronewton metre, `_q30` multiples of 2^-30, `_us`, `_ns`).
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

mod cobs;
pub mod decoder;
pub mod device;
pub mod digest;
mod first_scene;
pub mod flags;
pub mod frame;
pub mod packet;
pub mod recording;
pub mod scene;
pub mod scene_file;
pub mod schema;
pub mod sections;
pub mod status;
pub mod tuning;
pub mod units;
pub mod usb;
pub mod viewer;
pub mod viewer_ask;
pub mod viewer_look;

#[cfg(test)]
mod decoder_tests;
#[cfg(test)]
mod golden_tests;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod table_tests;
#[cfg(test)]
mod type_text;
#[cfg(test)]
mod viewer_tests;

pub use decoder::{DecodeCounts, StreamDecoder};
pub use device::{DeviceFault, DeviceHello, FaultCause, FromDevice, HostHello, Mode, PoseReport, ToDevice, WrenchCommand};
pub use digest::Digest;
pub use frame::{FrameError, decode_stream, encode_stream, stream_bound};
pub use packet::{PACKET_BYTES, decode_packet, encode_packet};
pub use recording::{Chunk, Damage, DamageCause, Event, Record, RecordHeader, RecordReader, TickRecord, What};
pub use scene::{
    BakedScene, Breakaway, Compliance, Coupling, Deformation, ForceLaw, GuardLimits, Inertia, ObjectShape, Passivity, Place,
    ProbePart, ProbeParts, ProbeShape, Tier, VirtualCoupling,
};
pub use scene_file::SceneFileError;
pub use schema::{
    PROTOCOL_VERSION, SCHEMA_HASH, TOOL_SCHEMA_HASH, VIEWER_SCHEMA_HASH, VersionMismatch, check_device_version,
    check_tool_version, check_viewer_version,
};
pub use status::{FaultRecord, FromHost, HostFault, Progress, Quantiles, RtReport, SessionHello, Summary};
pub use tuning::Tuning;
pub use units::{
    metres_to_nm, newton_metres_to_unm, newtons_to_un, nm_to_metres, q30_to_unit, un_to_newtons, unit_to_q30,
    unm_to_newton_metres,
};
pub use viewer::{
    FromViewer, Limits, RecordBytes, Refusal, RefusalCause, RestBegin, RestPoints, RestState, SceneBytes, SceneNow, Subscription,
    ToViewer, UploadBegin, UploadChunk, UploadState, ViewerHello, Welcome,
};
pub use viewer_ask::{Ask, Denial, Denied, Wish, WorkBudget};
pub use viewer_look::{OutputState, PatchLook, Snapshot, Statistics, SurfaceBlock};

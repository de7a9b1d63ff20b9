//! The viewer link: programs that look at a running host and may steer it, over TCP or a Unix socket, as COBS + CRC-32 frames.
//!
//! Words: a **viewer** is a program that looks on; a **snapshot** is what one tick was like; a **request** is something a viewer
//! asks the host to do, with a number of its choosing, and each gets one answer: `Done` or `Denied`. **Rest points** are points of
//! the object's undeformed surface whose displacement a viewer wants to see. `VIEWER.md` tells the same in prose, with the order of
//! things and a worked example.
//!
//! The first message of either side ([`FromViewer::Hello`], [`ToViewer::Refused`]) keeps its place and its fields in every version,
//! so that two builds of different tables can tell each other so. Everything a viewer sends may be hostile: every length here is
//! bounded by a named constant, and what is longer is no message.
//!
//! Frames of poses and wrenches: world `w`, probe `p`, device base `d`. Units are SI unless the name says otherwise.

use core::fmt;

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::device::{ENUM, U16, U32, U64};
use crate::recording::Event;
use crate::schema::{PROTOCOL_VERSION, VIEWER_SCHEMA_HASH, VersionMismatch};
use crate::status::{FaultRecord, SessionHello, Summary};
use crate::viewer_ask::{Ask, Denial, Denied};
use crate::viewer_look::{Snapshot, Statistics, SurfaceBlock};

/// Where a host lets viewers in when told to without an address, and where viewers look for one: a port below those that systems hand out by themselves.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:21278";

/// Bytes of a model or a recording in one message at most: a few hundred messages a megabyte, and a buffer that fits any stack.
pub const CHUNK_BYTES: usize = 4096;

/// Rest points in one message at most.
pub const POINTS_IN_MESSAGE: usize = 256;

/// Bytes of an explanation at most: two lines of a terminal.
pub const WORDS_BYTES: usize = 160;

/// Bytes of a token: more than can be guessed.
pub const TOKEN_BYTES: usize = 32;

/// The token of a viewer that has none.
pub const NO_TOKEN: [u8; TOKEN_BYTES] = [0; TOKEN_BYTES];

/// Reads a token as people write it, 64 hexadecimal digits with or without white space around them; all zeros are none.
#[must_use]
pub fn token_from_hex(text: &str) -> Option<[u8; TOKEN_BYTES]> {
    let mut digits = text.trim().chars().map(|digit| digit.to_digit(16));
    let mut token = NO_TOKEN;
    for byte in &mut token {
        let (high, low) = (digits.next()??, digits.next()??);
        // each at most 15
        *byte = (high << 4 | low) as u8;
    }
    (digits.next().is_none() && token != NO_TOKEN).then_some(token)
}

/// An explanation for people, UTF-8.
pub type Words = Vec<u8, WORDS_BYTES>;

/// As much of a text as an explanation holds, cut between two characters.
#[must_use]
pub fn words(text: &str) -> Words {
    let mut words = Words::new();
    for char in text.chars() {
        let mut utf8 = [0; 4];
        if words.extend_from_slice(char.encode_utf8(&mut utf8).as_bytes()).is_err() {
            break;
        }
    }
    words
}

/// Everything a viewer says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(clippy::large_enum_variant, reason = "a message lives from its decoding to its handling, never in a collection")]
pub enum FromViewer {
    /// Who it is; the first message, and only the first.
    Hello(ViewerHello),
    /// What it wants to see; replaces what it wanted before.
    Subscribe(Subscription),
    /// It wants to upload a model; the host answers how much of it there is.
    UploadBegin(UploadBegin),
    /// Bytes of a model begun.
    UploadChunk(UploadChunk),
    /// It will send so many rest points; those from before are forgotten.
    RestBegin(RestBegin),
    /// Rest points, in order.
    RestPoints(RestPoints),
    /// A request.
    Ask(Ask),
    /// Answered with the same number.
    Ping(u32),
}

impl FromViewer {
    /// Postcard bytes at most, the byte that names the message included.
    pub const MAX_ENCODED: usize = 1 + UploadChunk::MAX_ENCODED;
}

/// Everything the host says to a viewer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ToViewer {
    /// Why the host closes the connection; its last message.
    Refused(Refusal),
    /// The hello is good.
    Welcome(Welcome),
    /// The device of the session and what a tick may spend: when the device has answered, and whenever the work budget is another.
    Device(SessionHello),
    /// The scene that runs: after the welcome, and whenever another takes its place.
    Scene(SceneNow),
    /// How much of a model there is.
    Upload(UploadState),
    /// How many rest points there are.
    Rest(RestState),
    /// The request of this number has been carried out.
    Done(u32),
    /// A request was not carried out.
    Denied(Denied),
    /// A tick.
    Snapshot(Snapshot),
    /// Displacements of rest points.
    Surface(SurfaceBlock),
    /// The session in figures, so far.
    Statistics(Statistics),
    /// Something was done to the session, by whomever.
    Event(Event),
    /// A fault has latched.
    Fault(FaultRecord),
    /// Bytes of the file of the scene that runs.
    SceneBytes(SceneBytes),
    /// Bytes of a recording.
    RecordBytes(RecordBytes),
    /// The answer to a ping.
    Pong(u32),
    /// The session has ended; the last message.
    End(Summary),
}

impl ToViewer {
    /// Postcard bytes at most, the byte that names the message included.
    pub const MAX_ENCODED: usize = 1 + SceneBytes::MAX_ENCODED;
}

/// Who a viewer is. These fields are the same in every version.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ViewerHello {
    /// [`PROTOCOL_VERSION`] of the viewer.
    pub version: u16,
    /// [`VIEWER_SCHEMA_HASH`] of the viewer.
    pub schema: u32,
    /// What lets it in; [`NO_TOKEN`] where none is asked for.
    pub token: [u8; TOKEN_BYTES],
}

impl ViewerHello {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U16 + U32 + TOKEN_BYTES;

    /// Of this build.
    #[must_use]
    pub const fn new(token: [u8; TOKEN_BYTES]) -> Self {
        Self { version: PROTOCOL_VERSION, schema: VIEWER_SCHEMA_HASH, token }
    }
}

/// Why the host closes a connection. These fields are the same in every version; causes are only added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// [`PROTOCOL_VERSION`] of the host.
    pub version: u16,
    /// [`VIEWER_SCHEMA_HASH`] of the host.
    pub schema: u32,
    /// Why.
    pub why: RefusalCause,
}

impl Refusal {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U16 + U32 + ENUM;

    /// By this build.
    #[must_use]
    pub const fn new(why: RefusalCause) -> Self {
        Self { version: PROTOCOL_VERSION, schema: VIEWER_SCHEMA_HASH, why }
    }

    /// Both numbers, as a viewer of this build sees them.
    #[must_use]
    pub const fn mismatch(&self) -> VersionMismatch {
        VersionMismatch {
            our_version: PROTOCOL_VERSION,
            their_version: self.version,
            our_schema: VIEWER_SCHEMA_HASH,
            their_schema: self.schema,
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.why {
            RefusalCause::Version => write!(f, "{}; use programs of one build", self.mismatch()),
            why => f.write_str(why.name()),
        }
    }
}

/// Why the host closes a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RefusalCause {
    /// Viewer and host speak different versions or tables.
    Version,
    /// The token is not the host's.
    Token,
    /// As many viewers as there may be look on already.
    TooMany,
    /// The first message was no hello, or a hello came again.
    Order,
    /// No hello came in time.
    Silent,
    /// Nothing came for long; a viewer that has nothing to say pings.
    Idle,
    /// What came was not messages.
    Garbage,
    /// It does not read what it is sent.
    Stuck,
}

impl RefusalCause {
    /// Every cause, in the order of the wire.
    pub const ALL: [Self; 8] =
        [Self::Version, Self::Token, Self::TooMany, Self::Order, Self::Silent, Self::Idle, Self::Garbage, Self::Stuck];

    /// The cause in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Version => "another version",
            Self::Token => "the token is not the host's",
            Self::TooMany => "as many viewers as there may be look on already; close one",
            Self::Order => "the first message must be a hello, and only the first",
            Self::Silent => "no hello came in time",
            Self::Idle => "nothing was heard for too long",
            Self::Garbage => "what came was not messages of the viewer link",
            Self::Stuck => "what was sent was not read",
        }
    }
}

/// What a viewer meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Welcome {
    /// [`PROTOCOL_VERSION`] of the host.
    pub version: u16,
    /// [`VIEWER_SCHEMA_HASH`] of the host.
    pub schema: u32,
    /// Ticks a second.
    pub rate_hz: u32,
    /// What it will take.
    pub limits: Limits,
}

impl Welcome {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U16 + 2 * U32 + Limits::MAX_ENCODED;
}

/// What a host will take from a viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Viewers at once.
    pub viewers: u8,
    /// Bytes of a model.
    pub model_bytes: u32,
    /// Rest points of a viewer.
    pub rest_points: u32,
    /// Time after which a viewer that says nothing is closed \[ms\].
    pub idle_ms: u32,
}

impl Limits {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 1 + 3 * U32;
}

/// What a viewer wants to see; all zeros = nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Subscription {
    /// A snapshot every so many ticks; 0 = none.
    pub every: u32,
    /// Displacements of the rest points with every so many snapshots; 0 = none.
    pub surface: u32,
    /// Statistics every so many milliseconds; 0 = none.
    pub statistics_ms: u32,
}

impl Subscription {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = 3 * U32;
}

/// A model that a viewer wants to upload.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UploadBegin {
    /// [`crate::scene_file::digest`] of its file.
    pub digest: u64,
    /// Length of its file \[bytes\].
    pub length: u32,
}

impl UploadBegin {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + U32;
}

/// Bytes of a model begun; they go where the host has none yet.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UploadChunk {
    /// Which model.
    pub digest: u64,
    /// Where they go \[bytes from the start of the file\]: as many as the host has.
    pub offset: u32,
    /// The bytes.
    pub bytes: Vec<u8, CHUNK_BYTES>,
}

impl UploadChunk {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + U32 + LENGTH + CHUNK_BYTES;
}

/// How much of a model the host has; the answer to every `UploadBegin` and `UploadChunk`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UploadState {
    /// Which model.
    pub digest: u64,
    /// Bytes there are, from the first on.
    pub have: u32,
    /// Bytes there will be; 0 = the host does not take it.
    pub of: u32,
    /// Why it does not, or why bytes had no place.
    pub why: Option<Denial>,
}

impl UploadState {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + 2 * U32 + 1 + Denial::MAX_ENCODED;
}

/// How many rest points will come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RestBegin {
    /// So many.
    pub count: u32,
}

impl RestBegin {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U32;
}

/// Rest points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestPoints {
    /// The number of the first.
    pub offset: u32,
    /// Places on the undeformed surface, in `w` \[m\].
    pub points: Vec<[f32; 3], POINTS_IN_MESSAGE>,
}

impl RestPoints {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U32 + LENGTH + 12 * POINTS_IN_MESSAGE;
}

/// How many rest points the host has; the answer to every `RestBegin` and `RestPoints`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RestState {
    /// Points there are, from the first on.
    pub have: u32,
    /// Points there will be; 0 = none are taken.
    pub of: u32,
    /// Why none are taken, or why points had no place.
    pub why: Option<Denial>,
}

impl RestState {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = 2 * U32 + 1 + Denial::MAX_ENCODED;
}

/// The scene that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneNow {
    /// [`crate::scene_file::digest`] of its file.
    pub digest: u64,
    /// Length of its file \[bytes\].
    pub length: u32,
}

impl SceneNow {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + U32;
}

/// Bytes of the file of the scene that runs, in order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneBytes {
    /// Which scene.
    pub digest: u64,
    /// Where they go \[bytes from the start of the file\].
    pub offset: u32,
    /// Length of the file \[bytes\].
    pub of: u32,
    /// The bytes.
    pub bytes: Vec<u8, CHUNK_BYTES>,
}

impl SceneBytes {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + 2 * U32 + LENGTH + CHUNK_BYTES;
}

/// Bytes of a recording: a file of [`crate::recording`], from where the viewer asked for it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordBytes {
    /// Where they go \[bytes from the start of the recording\]; a gap = the viewer read too slowly, and whole frames are missing.
    pub offset: u64,
    /// The bytes.
    pub bytes: Vec<u8, CHUNK_BYTES>,
}

impl RecordBytes {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + LENGTH + CHUNK_BYTES;
}

/// Postcard bytes at most of the length of a list of less than 16,384.
pub(crate) const LENGTH: usize = 2;

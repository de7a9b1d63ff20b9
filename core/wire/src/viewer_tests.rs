//! The viewer link's tables are what they say: largest sizes, canonical text, and frames that only a whole message passes.

use std::string::ToString;
use std::vec::Vec;
use std::{format, vec};

use heapless::Vec as List;

use crate::samples::{EVENT, FAULT_RECORD, SESSION, SUMMARY, TUNING};
use crate::scene::MAX_PARTS;
use crate::schema::VIEWER_TABLE;
use crate::table_tests::{cases, encoded, structure};
use crate::viewer::{CHUNK_BYTES, DEFAULT_ADDRESS, NO_TOKEN, POINTS_IN_MESSAGE, TOKEN_BYTES, WORDS_BYTES, words};
use crate::*;

const HELLO: ViewerHello = ViewerHello { version: u16::MAX, schema: u32::MAX, token: [0xFF; TOKEN_BYTES] };
const REFUSAL: Refusal = Refusal { version: u16::MAX, schema: u32::MAX, why: RefusalCause::Stuck };
const LIMITS: Limits = Limits { viewers: u8::MAX, model_bytes: u32::MAX, rest_points: u32::MAX, idle_ms: u32::MAX };
const WELCOME: Welcome = Welcome { version: u16::MAX, schema: u32::MAX, rate_hz: u32::MAX, limits: LIMITS };
const SUBSCRIPTION: Subscription = Subscription { every: u32::MAX, surface: u32::MAX, statistics_ms: u32::MAX };
const BEGIN: UploadBegin = UploadBegin { digest: u64::MAX, length: u32::MAX };
const UPLOAD: UploadState = UploadState { digest: u64::MAX, have: u32::MAX, of: u32::MAX, why: Some(Denial::Value) };
const REST_BEGIN: RestBegin = RestBegin { count: u32::MAX };
const REST: RestState = RestState { have: u32::MAX, of: u32::MAX, why: Some(Denial::Value) };
const ASK: Ask = Ask { number: u32::MAX, what: Wish::Tune(TUNING) };
const SCENE: SceneNow = SceneNow { digest: u64::MAX, length: u32::MAX };
const PATCH: PatchLook = PatchLook {
    region: u8::MAX,
    centre: [f32::MIN; 3],
    normal: [f32::MIN; 3],
    radius: f32::MIN,
    stick_radius: f32::MIN,
    force: [f32::MIN; 3],
    torque: [f32::MIN; 3],
    depth: f32::MIN,
};
const STATISTICS: Statistics = Statistics {
    session: SUMMARY,
    viewers: u8::MAX,
    sent: u64::MAX,
    dropped: u64::MAX,
    surfaces: u64::MAX,
    passes: u64::MAX,
    points: u64::MAX,
    behind: u64::MAX,
    missed: u64::MAX,
    rejected: u32::MAX,
};

fn full<T: Clone, const N: usize>(value: T) -> List<T, N> {
    core::iter::repeat_n(value, N).collect()
}

fn chunk() -> UploadChunk {
    UploadChunk { digest: u64::MAX, offset: u32::MAX, bytes: full(0xFF) }
}

fn points() -> RestPoints {
    RestPoints { offset: u32::MAX, points: full([f32::MIN; 3]) }
}

fn denied() -> Denied {
    Denied { number: u32::MAX, why: Denial::NotRecording, words: full(0xFF) }
}

fn scene_bytes() -> SceneBytes {
    SceneBytes { digest: u64::MAX, offset: u32::MAX, of: u32::MAX, bytes: full(0xFF) }
}

fn record_bytes() -> RecordBytes {
    RecordBytes { offset: u64::MAX, bytes: full(0xFF) }
}

fn block() -> SurfaceBlock {
    SurfaceBlock { tick: u64::MAX, of: u32::MAX, offset: u32::MAX, step: f32::MIN, moved: full([i16::MIN; 3]) }
}

fn snapshot() -> Snapshot {
    Snapshot {
        tick: u64::MAX,
        t_us: u64::MAX,
        position: [f32::MIN; 3],
        rotation: [f32::MIN; 4],
        contact_force: [f32::MIN; 3],
        contact_torque: [f32::MIN; 3],
        sent_force: [f32::MIN; 3],
        sent_torque: [f32::MIN; 3],
        patches: full(PATCH),
        depth: f32::MIN,
        tier: Tier::Green,
        flags: u32::MAX,
        wake_ns: u32::MAX,
        step_ns: u32::MAX,
        round_trip_ns: u32::MAX,
        in_time_permille: u16::MAX,
        mode: Mode::Brake,
        output: OutputState::Stopped,
        fault: Some(HostFault::Overrun),
    }
}

/// The front page's figures: a message's bytes with the one that names it.
pub const SIZES: [(&str, usize); 18] = [
    ("ViewerHello", 1 + ViewerHello::MAX_ENCODED),
    ("Refusal", 1 + Refusal::MAX_ENCODED),
    ("Welcome", 1 + Welcome::MAX_ENCODED),
    ("Subscription", 1 + Subscription::MAX_ENCODED),
    ("UploadBegin", 1 + UploadBegin::MAX_ENCODED),
    ("UploadChunk", FromViewer::MAX_ENCODED),
    ("UploadState", 1 + UploadState::MAX_ENCODED),
    ("RestBegin", 1 + RestBegin::MAX_ENCODED),
    ("RestPoints", 1 + RestPoints::MAX_ENCODED),
    ("RestState", 1 + RestState::MAX_ENCODED),
    ("Ask", 1 + Ask::MAX_ENCODED),
    ("Denied", 1 + Denied::MAX_ENCODED),
    ("SceneNow", 1 + SceneNow::MAX_ENCODED),
    ("SceneBytes", ToViewer::MAX_ENCODED),
    ("Snapshot", 1 + Snapshot::MAX_ENCODED),
    ("SurfaceBlock", 1 + SurfaceBlock::MAX_ENCODED),
    ("Statistics", 1 + Statistics::MAX_ENCODED),
    ("RecordBytes", 1 + RecordBytes::MAX_ENCODED),
];

#[test]
fn the_largest_value_of_each_type_fills_its_bound() {
    let largest = [
        encoded(&HELLO),
        encoded(&REFUSAL),
        encoded(&WELCOME),
        encoded(&SUBSCRIPTION),
        encoded(&BEGIN),
        encoded(&chunk()),
        encoded(&UPLOAD),
        encoded(&REST_BEGIN),
        encoded(&points()),
        encoded(&REST),
        encoded(&ASK),
        encoded(&denied()),
        encoded(&SCENE),
        encoded(&scene_bytes()),
        encoded(&snapshot()),
        encoded(&block()),
        encoded(&STATISTICS),
        encoded(&record_bytes()),
    ];
    for ((name, bound), largest) in SIZES.into_iter().zip(largest) {
        assert_eq!(1 + largest, bound, "{name}");
    }
    assert_eq!(encoded(&WorkBudget::Work(u32::MAX)), WorkBudget::MAX_ENCODED);
    for message in from_viewer() {
        assert!(encoded(&message) <= FromViewer::MAX_ENCODED);
    }
    for message in to_viewer() {
        assert!(encoded(&message) <= ToViewer::MAX_ENCODED);
    }
}

fn from_viewer() -> Vec<FromViewer> {
    vec![
        FromViewer::Hello(HELLO),
        FromViewer::Subscribe(SUBSCRIPTION),
        FromViewer::UploadBegin(BEGIN),
        FromViewer::UploadChunk(chunk()),
        FromViewer::RestBegin(REST_BEGIN),
        FromViewer::RestPoints(points()),
        FromViewer::Ask(ASK),
        FromViewer::Ping(u32::MAX),
    ]
}

fn to_viewer() -> Vec<ToViewer> {
    vec![
        ToViewer::Refused(REFUSAL),
        ToViewer::Welcome(WELCOME),
        ToViewer::Device(SESSION),
        ToViewer::Scene(SCENE),
        ToViewer::Upload(UPLOAD),
        ToViewer::Rest(REST),
        ToViewer::Done(u32::MAX),
        ToViewer::Denied(denied()),
        ToViewer::Snapshot(snapshot()),
        ToViewer::Surface(block()),
        ToViewer::Statistics(STATISTICS),
        ToViewer::Event(EVENT),
        ToViewer::Fault(FAULT_RECORD),
        ToViewer::SceneBytes(scene_bytes()),
        ToViewer::RecordBytes(record_bytes()),
        ToViewer::Pong(u32::MAX),
        ToViewer::End(SUMMARY),
    ]
}

const WISHES: [Wish; 9] = [
    Wish::Activate(1),
    Wish::Tune(TUNING),
    Wish::Freeze(true),
    Wish::Tare,
    Wish::EStop,
    Wish::Rearm,
    Wish::Record(true),
    Wish::Download,
    Wish::Budget(WorkBudget::Auto),
];

const BUDGETS: [WorkBudget; 4] = [WorkBudget::Scene, WorkBudget::Auto, WorkBudget::Off, WorkBudget::Work(u32::MAX)];

fn viewer_table() -> std::string::String {
    [
        cases("FromViewer", &from_viewer()),
        cases("ToViewer", &to_viewer()),
        structure(&HELLO),
        structure(&REFUSAL),
        cases("RefusalCause", &RefusalCause::ALL),
        structure(&WELCOME),
        structure(&LIMITS),
        structure(&SUBSCRIPTION),
        structure(&BEGIN),
        structure(&chunk()),
        structure(&UPLOAD),
        structure(&REST_BEGIN),
        structure(&points()),
        structure(&REST),
        structure(&ASK),
        cases("Wish", &WISHES),
        cases("WorkBudget", &BUDGETS),
        structure(&denied()),
        cases("Denial", &Denial::ALL),
        structure(&SCENE),
        structure(&scene_bytes()),
        structure(&record_bytes()),
        structure(&snapshot()),
        structure(&PATCH),
        cases("OutputState", &OutputState::ALL),
        structure(&block()),
        structure(&STATISTICS),
        format!("at most: {CHUNK_BYTES} bytes, {POINTS_IN_MESSAGE} points, {WORDS_BYTES} words, {MAX_PARTS} patches\n"),
    ]
    .concat()
}

#[test]
fn the_canonical_text_is_what_the_types_are() {
    assert_eq!(viewer_table(), VIEWER_TABLE);
}

#[test]
fn every_message_crosses_a_stream() {
    fn cross<T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + std::fmt::Debug>(messages: &[T]) {
        let mut decoder = StreamDecoder::<{ stream_bound(ToViewer::MAX_ENCODED) }>::new();
        let mut got = Vec::new();
        for message in messages {
            let mut frame = [0; stream_bound(ToViewer::MAX_ENCODED)];
            let n = encode_stream(message, &mut frame).unwrap();
            decoder.feed(&frame[..n], |message: T| got.push(message));
        }
        assert_eq!(got, messages);
        assert_eq!(decoder.counts().rejected(), 0);
    }
    cross(&from_viewer());
    cross(&to_viewer());
}

/// A list that says it is longer than it may be is no message, whatever follows.
#[test]
fn lists_beyond_their_limit_are_refused() {
    let long = |count: usize, each: usize| {
        let mut length = [0; 4];
        let length = postcard::to_slice(&count, &mut length).unwrap();
        [&[0], &*length, &vec![1; each * count]].concat()
    };
    for (count, good) in [(POINTS_IN_MESSAGE, true), (POINTS_IN_MESSAGE + 1, false), (1 << 30, false)] {
        let bytes = long(count.min(1000), 12);
        let bytes = if count > 1000 { [&[0, 0xFF, 0xFF, 0xFF, 0xFF, 0x03][..], &bytes[3..]].concat() } else { bytes };
        assert_eq!(postcard::take_from_bytes::<RestPoints>(&bytes).is_ok(), good, "{count}");
    }
    for (count, good) in [(CHUNK_BYTES, true), (CHUNK_BYTES + 1, false)] {
        assert_eq!(postcard::take_from_bytes::<RecordBytes>(&long(count, 1)).is_ok(), good, "{count}");
    }
}

/// What a build of another version must still understand: the places and fields of hello and refusal, byte by byte.
#[test]
fn hello_and_refusal_never_move() {
    let mut out = [0; 64];
    let hello = FromViewer::Hello(ViewerHello { version: 300, schema: 0x0102_0304, token: [7; TOKEN_BYTES] });
    let expected = [&[0, 0xAC, 0x02, 0x84, 0x86, 0x88, 0x08][..], &[7; 32]].concat();
    assert_eq!(*postcard::to_slice(&hello, &mut out).unwrap(), expected);
    let refused = ToViewer::Refused(Refusal { version: 300, schema: 0x0102_0304, why: RefusalCause::Token });
    assert_eq!(*postcard::to_slice(&refused, &mut out).unwrap(), [0, 0xAC, 0x02, 0x84, 0x86, 0x88, 0x08, 1]);
}

#[test]
fn refusals_and_denials_say_what_to_do() {
    let refusal = Refusal { version: 9, schema: 0xDEAD_BEEF, why: RefusalCause::Version }.to_string();
    for part in ["version 9", "deadbeef", "version 1", "programs of one build"] {
        assert!(refusal.contains(part), "{refusal}");
    }
    assert!(Refusal::new(RefusalCause::Token).to_string().contains("token"));
    let denied = Denied { number: 1, why: Denial::Scene, words: words("object.radius is -1; allowed is above 0") };
    assert_eq!(denied.to_string(), "the host cannot run the scene: object.radius is -1; allowed is above 0");
    let bare = Denied { words: words(""), why: Denial::InContact, ..denied };
    assert_eq!(bare.to_string(), "the probe touches the object; lift off first");
}

#[test]
fn words_are_cut_between_characters() {
    let text: std::string::String = "µ".repeat(WORDS_BYTES);
    let cut = words(&text);
    assert_eq!(cut.len(), WORDS_BYTES);
    assert_eq!(core::str::from_utf8(&words(&format!("x{text}"))).unwrap().chars().count(), WORDS_BYTES / 2);
}

/// The page for those who write a viewer: its worked example, byte by byte.
#[test]
fn the_worked_example_of_the_page_is_what_is_sent() {
    let hello = FromViewer::Hello(ViewerHello { version: 1, schema: 0x0102_0304, token: NO_TOKEN });
    let mut frame = [0; 64];
    let n = encode_stream(&hello, &mut frame).unwrap();
    let hex: Vec<_> = frame[..n].iter().map(|byte| format!("{byte:02x}")).collect();
    let page = include_str!("../VIEWER.md");
    assert!(page.contains(&hex.join(" ")), "{}", hex.join(" "));
    for limit in [format!("`{DEFAULT_ADDRESS}`"), format!("{TOKEN_BYTES} bytes")] {
        assert!(page.contains(&limit), "{limit}");
    }
}

//! The tables are what they say: largest sizes, the figures in the front page, the canonical text.

use std::collections::BTreeMap;
use std::string::{String, ToString};
use std::vec::Vec;
use std::{format, vec};

use serde::{Deserialize, Serialize};

use crate::packet::PACKET_MESSAGE_MAX;
use crate::samples::*;
use crate::schema::{DEVICE_TABLE, TOOL_TABLE};
use crate::type_text::{case_text, type_text};
use crate::*;

/// Bytes of the longest message, and some.
const ROOM: usize = 8192;

pub fn encoded<T: Serialize>(value: &T) -> usize {
    let mut out = [0; ROOM];
    postcard::to_slice(value, &mut out).unwrap().len()
}

#[test]
fn the_largest_value_of_each_type_fills_its_bound() {
    let table = [
        ("DeviceHello", encoded(&DEVICE_HELLO), DeviceHello::MAX_ENCODED),
        ("HostHello", encoded(&HOST_HELLO), HostHello::MAX_ENCODED),
        ("PoseReport", encoded(&POSE), PoseReport::MAX_ENCODED),
        ("WrenchCommand", encoded(&WRENCH), WrenchCommand::MAX_ENCODED),
        ("DeviceFault", encoded(&FAULT), DeviceFault::MAX_ENCODED),
        ("Mode", encoded(&Mode::Brake), Mode::MAX_ENCODED),
        ("FromDevice", encoded(&FromDevice::Pose(POSE)), FromDevice::MAX_ENCODED),
        ("ToDevice", encoded(&ToDevice::Wrench(WRENCH)), ToDevice::MAX_ENCODED),
        ("SessionHello", encoded(&SESSION), SessionHello::MAX_ENCODED),
        ("Progress", encoded(&PROGRESS), Progress::MAX_ENCODED),
        ("FaultRecord", encoded(&FAULT_RECORD), FaultRecord::MAX_ENCODED),
        ("Quantiles", encoded(&QUANTILES), Quantiles::MAX_ENCODED),
        ("RtReport", encoded(&RT), RtReport::MAX_ENCODED),
        ("Summary", encoded(&SUMMARY), Summary::MAX_ENCODED),
        ("FromHost", encoded(&FromHost::Summary(SUMMARY)), FromHost::MAX_ENCODED),
        ("RecordHeader", encoded(&HEADER), RecordHeader::MAX_ENCODED),
        ("TickRecord", encoded(&TICK), TickRecord::MAX_ENCODED),
        ("Chunk", encoded(&CHUNK), Chunk::MAX_ENCODED),
        ("Tuning", encoded(&TUNING), Tuning::MAX_ENCODED),
        ("Event", encoded(&EVENT), Event::MAX_ENCODED),
        ("Record", encoded(&Record::Scene(CHUNK)), Record::MAX_ENCODED),
        ("BakedScene", encoded(&scene()), BakedScene::MAX_ENCODED),
    ];
    for (name, largest, bound) in table {
        assert_eq!(largest, bound, "{name}");
    }
}

#[test]
fn every_message_of_the_device_link_fits_a_packet() {
    for bound in [
        FromDevice::MAX_ENCODED,
        ToDevice::MAX_ENCODED,
        1 + DeviceHello::MAX_ENCODED,
        1 + HostHello::MAX_ENCODED,
        1 + DeviceFault::MAX_ENCODED,
    ] {
        assert!(bound <= PACKET_MESSAGE_MAX, "{bound}");
    }
    for message in [FromDevice::Hello(DEVICE_HELLO), FromDevice::Pose(POSE), FromDevice::Fault(FAULT)] {
        let packet = encode_packet(&message).unwrap();
        assert_eq!(decode_packet(&packet), Ok(message));
    }
    for message in [ToDevice::Hello(HOST_HELLO), ToDevice::SetMode(Mode::Brake), ToDevice::Wrench(WRENCH)] {
        let packet = encode_packet(&message).unwrap();
        assert_eq!(decode_packet(&packet), Ok(message));
    }
}

/// The front page's figures, by the first type its row names; those of the viewer link are in [`crate::viewer_tests`].
pub fn front_page() -> BTreeMap<String, usize> {
    include_str!("lib.rs")
        .lines()
        .filter_map(|line| line.strip_prefix("//! | [`"))
        .map(|row| {
            let (name, rest) = row.split_once('`').unwrap();
            let figure = rest.trim_end_matches(" |").rsplit(' ').next().unwrap();
            (name.to_string(), figure.parse().unwrap())
        })
        .collect()
}

#[test]
fn the_front_page_gives_the_true_sizes() {
    let expected = [
        ("HostHello", 1 + HostHello::MAX_ENCODED),
        ("DeviceHello", 1 + DeviceHello::MAX_ENCODED),
        ("Mode", 1 + Mode::MAX_ENCODED),
        ("PoseReport", FromDevice::MAX_ENCODED),
        ("WrenchCommand", ToDevice::MAX_ENCODED),
        ("DeviceFault", 1 + DeviceFault::MAX_ENCODED),
        ("SessionHello", 1 + SessionHello::MAX_ENCODED),
        ("Progress", 1 + Progress::MAX_ENCODED),
        ("FaultRecord", 1 + FaultRecord::MAX_ENCODED),
        ("Summary", FromHost::MAX_ENCODED),
        ("BakedScene", BakedScene::MAX_ENCODED),
        ("RecordHeader", 1 + RecordHeader::MAX_ENCODED),
        ("Chunk", Record::MAX_ENCODED),
        ("Tuning", 1 + Tuning::MAX_ENCODED),
        ("Place", 1 + Place::MAX_ENCODED),
        ("Event", 1 + Event::MAX_ENCODED),
        ("TickRecord", 1 + TickRecord::MAX_ENCODED),
    ];
    let expected = expected.into_iter().chain(viewer_tests::SIZES);
    let expected: BTreeMap<String, usize> = expected.map(|(name, size)| (name.to_string(), size)).collect();
    assert_eq!(front_page(), expected);
}

/// An enum's line: every case listed, and none beyond them.
pub fn cases<T: Serialize + Deserialize<'static>>(name: &str, all: &[T]) -> String {
    for (index, value) in all.iter().enumerate() {
        let mut out = [0; ROOM];
        let bytes = postcard::to_slice(value, &mut out).unwrap();
        assert_eq!(usize::from(bytes[0]), index, "{name} is listed out of order");
    }
    let mut beyond = vec![0_u8; ROOM];
    beyond[0] = all.len() as u8;
    assert!(postcard::take_from_bytes::<T>(beyond.leak()).is_err(), "{name} has a case that this test does not list");
    let cases: Vec<String> = all.iter().map(case_text).collect();
    format!("{name}={}\n", cases.join("|"))
}

pub fn structure<T: Serialize>(value: &T) -> String {
    format!("{}\n", type_text(value))
}

fn device_table() -> String {
    let from = [FromDevice::Hello(DEVICE_HELLO), FromDevice::Pose(POSE), FromDevice::Fault(FAULT)];
    let to = [ToDevice::Hello(HOST_HELLO), ToDevice::SetMode(Mode::Force), ToDevice::Wrench(WRENCH)];
    let causes = [
        FaultCause::Watchdog,
        FaultCause::OverSpeed,
        FaultCause::NonFinite,
        FaultCause::VersionMismatch,
        FaultCause::Protocol,
        FaultCause::Hardware,
    ];
    [
        cases("FromDevice", &from),
        cases("ToDevice", &to),
        structure(&DEVICE_HELLO),
        structure(&HOST_HELLO),
        structure(&POSE),
        structure(&WRENCH),
        structure(&FAULT),
        cases("Mode", &[Mode::Reset, Mode::Idle, Mode::Force, Mode::Brake]),
        cases("FaultCause", &causes),
    ]
    .concat()
}

fn tool_table() -> String {
    [status_table(), recording_table(), scene_table()].concat()
}

fn status_table() -> String {
    let from_host =
        [FromHost::Hello(SESSION), FromHost::Progress(PROGRESS), FromHost::Fault(FAULT_RECORD), FromHost::Summary(SUMMARY)];
    [
        cases("FromHost", &from_host),
        structure(&SESSION),
        structure(&PROGRESS),
        structure(&FAULT_RECORD),
        structure(&SUMMARY),
        structure(&QUANTILES),
        structure(&RT),
        cases("HostFault", &HostFault::ALL),
    ]
    .concat()
}

fn recording_table() -> String {
    let records = [
        Record::Header(HEADER),
        Record::Schema(CHUNK),
        Record::Scene(CHUNK),
        Record::Device(SESSION),
        Record::Tuning(TUNING),
        Record::Place(PLACE),
        Record::Rest,
        Record::Tick(TICK),
        Record::Event(EVENT),
        Record::Fault(FAULT_RECORD),
        Record::Lost { count: 1 },
        Record::End(SUMMARY),
    ];
    [
        cases("Record", &records),
        structure(&HEADER),
        structure(&CHUNK),
        structure(&TUNING),
        structure(&EVENT),
        cases("What", &What::ALL),
        structure(&TICK),
    ]
    .concat()
}

fn scene_table() -> String {
    let (radius, height, size, semi_axes) = (1.0, 1.0, [1.0; 3], [1.0; 3]);
    let objects = [
        ObjectShape::HalfSpace,
        ObjectShape::Box { size },
        ObjectShape::Sphere { radius },
        ObjectShape::Ellipsoid { semi_axes },
        ObjectShape::Cylinder { radius, height },
        ObjectShape::Mesh { grid: 1 },
    ];
    let shapes = [
        ProbeShape::Sphere { radius },
        ProbeShape::Box { size },
        ProbeShape::Cylinder { radius, height },
        ProbeShape::Cone { radius, height },
        ProbeShape::Capsule { radius, height },
        ProbeShape::Ellipsoid { semi_axes },
        ProbeShape::Mesh { grid: 1 },
    ];
    let tiers = [Tier::Point, Tier::Paper, Tier::Bristle, Tier::Influence, Tier::Green];
    let deformations = [Deformation::None, Deformation::Local, Deformation::Full];
    [
        structure(&scene()),
        cases("ObjectShape", &objects),
        structure(&COMPLIANCE),
        structure(&INERTIA),
        structure(&scene().probe),
        structure(&PART),
        cases("ProbeShape", &shapes),
        cases("Tier", &tiers),
        cases("Deformation", &deformations),
        cases("Coupling", &[Coupling::Direct, Coupling::Virtual(COUPLING)]),
        structure(&COUPLING),
        cases("Breakaway", &[Breakaway::Smooth, Breakaway::Sharp]),
        cases("ForceLaw", &[ForceLaw::Hertz, ForceLaw::Cubic { k1: 1.0, k3: 1.0 }, LAW]),
        structure(&GUARD),
        structure(&PASSIVITY),
        structure(&PLACE),
    ]
    .concat()
}

#[test]
fn the_canonical_text_is_what_the_types_are() {
    assert_eq!(device_table(), DEVICE_TABLE);
    assert_eq!(tool_table(), TOOL_TABLE);
}

#[test]
fn a_mismatch_carries_both_numbers() {
    assert_eq!(check_device_version(PROTOCOL_VERSION, SCHEMA_HASH), Ok(()));
    assert_eq!(check_tool_version(PROTOCOL_VERSION, TOOL_SCHEMA_HASH), Ok(()));
    let mismatch = check_device_version(9, 0xDEAD_BEEF).unwrap_err();
    assert_eq!((mismatch.our_version, mismatch.their_version), (1, 9));
    let text = mismatch.to_string();
    for part in ["version 9", "deadbeef", "version 1", &format!("{SCHEMA_HASH:08x}")] {
        assert!(text.contains(part), "{text}");
    }
}

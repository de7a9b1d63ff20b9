//! The hex of `WIRE.md` is what the encoder writes.

use std::format;
use std::string::String;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::*;

const GUIDE: &str = include_str!("../WIRE.md");

fn hex(bytes: &[u8]) -> String {
    let digits: std::vec::Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    digits.join(" ")
}

/// An example as the guide prints it: the message, its frame in a stream, its packet without the zeros that fill it.
fn example<T: Serialize + DeserializeOwned + PartialEq>(name: &str, message: &T) -> String {
    let mut out = [0; 64];
    let plain = hex(postcard::to_slice(message, &mut out).unwrap());
    let n = encode_stream(message, &mut out).unwrap();
    let stream = hex(&out[..n]);
    assert!(decode_stream::<T>(&mut out[..n - 1]).unwrap() == *message);
    let packet = encode_packet(message).unwrap();
    assert!(decode_packet::<T>(&packet).unwrap() == *message);
    let packet = hex(&packet[..=usize::from(packet[0])]);
    format!("{name}\n  message  {plain}\n  stream   {stream}\n  packet   {packet}\n")
}

fn examples() -> String {
    let host_hello = HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 };
    let device_hello = DeviceHello {
        version: PROTOCOL_VERSION,
        schema: SCHEMA_HASH,
        name: *b"premium15\0\0\0",
        serial: *b"SIM-1\0\0\0\0\0\0\0",
        max_force_un: 8_500_000,
        max_torque_unm: 188_000,
        watchdog_ticks: 240,
    };
    let pose = PoseReport {
        seq: 300,
        t_us: 301_000,
        position_nm: [0, 1_500_000, -5_400_000],
        rotation_q30: [1 << 30, 0, 0, -1],
        buttons: 0,
        mode: Mode::Force,
        flags: PoseReport::FLAG_FORCE_CLAMPED,
        echo: 299,
    };
    let wrench =
        WrenchCommand { seq: 300, echo: 300, force_un: [0, -250_000, 6_011_000], torque_unm: [0, 0, -2_800], hold_us: 3000 };
    let fault = DeviceFault { cause: FaultCause::Watchdog, seq: 300, detail: 240 };
    [
        example("HostHello", &ToDevice::Hello(host_hello)),
        example("DeviceHello", &FromDevice::Hello(device_hello)),
        example("SetMode", &ToDevice::SetMode(Mode::Force)),
        example("PoseReport", &FromDevice::Pose(pose)),
        example("WrenchCommand", &ToDevice::Wrench(wrench)),
        example("DeviceFault", &FromDevice::Fault(fault)),
    ]
    .concat()
}

#[test]
fn the_guide_s_examples_are_the_encoder_s_bytes() {
    let examples = examples();
    assert!(GUIDE.contains(&examples), "the guide should print\n{examples}");
}

#[test]
fn the_guide_s_numbers_are_the_code_s() {
    for text in [
        format!("version is {PROTOCOL_VERSION}"),
        format!("fingerprint is 0x{SCHEMA_HASH:08x}"),
        format!("\n{}```", schema::DEVICE_TABLE),
        format!("0x{:08X}", frame::CRC32.checksum(b"123456789")),
        format!("at most {} bytes", stream_bound(FromDevice::MAX_ENCODED)),
    ] {
        assert!(GUIDE.contains(&text), "the guide should say: {text}");
    }
}

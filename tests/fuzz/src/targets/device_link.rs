//! The cable to the device, both ends: frames of a stream and packets, and the firmware behind them.

use haptor_engine::handle_pose;
use haptor_firmware_sim::plant::{Encoders, FIRM_GRIP};
use haptor_firmware_sim::preset::PREMIUM15;
use haptor_firmware_sim::script::Reach;
use haptor_firmware_sim::{Device, Script, TxBuf};
use haptor_wire::{DecodeCounts, FromDevice, StreamDecoder, ToDevice, decode_packet, encode_packet, encode_stream, stream_bound};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::mend;

/// Bytes that come to the firmware between two calls of its clock.
const AT_ONCE: usize = 64;

/// Time between two of them \[us\].
const PERIOD_US: u32 = 1000;

/// Bytes as they are, and mended.
pub fn run(bytes: &[u8]) {
    for bytes in [bytes.to_vec(), mend::stream(bytes)] {
        both_ends(&bytes);
        firmware(&bytes);
    }
    for packet in [bytes.to_vec(), mend::packet(bytes)] {
        let _ = decode_packet::<FromDevice>(&packet).map(|message| by_packet(&message));
        let _ = decode_packet::<ToDevice>(&packet).map(|message| by_packet(&message));
    }
}

/// However a stream is cut, the same messages come out of it, and each goes into a frame and comes back.
fn both_ends(bytes: &[u8]) {
    let from_device = decoded::<FromDevice, { stream_bound(FromDevice::MAX_ENCODED) }>(bytes);
    decoded::<ToDevice, { stream_bound(ToDevice::MAX_ENCODED) }>(bytes);
    for message in from_device {
        if let FromDevice::Pose(report) = message
            && let Some(pose) = handle_pose(&report)
        {
            assert!(pose.position.is_finite() && pose.rotation.is_finite(), "{report:?}");
        }
    }
}

fn decoded<T: Serialize + DeserializeOwned + PartialEq + core::fmt::Debug, const N: usize>(bytes: &[u8]) -> Vec<T> {
    let whole = cut::<T, N>(bytes, bytes.len().max(1));
    let pieces = cut::<T, N>(bytes, 7);
    assert_eq!(whole, pieces);
    for message in &whole.0 {
        let mut frame = [0; N];
        let length = encode_stream(message, &mut frame).expect("a message fits its bound");
        assert_eq!(cut::<T, N>(&frame[..length], length).0, core::slice::from_ref(message));
    }
    whole.0
}

fn cut<T: DeserializeOwned, const N: usize>(bytes: &[u8], at: usize) -> (Vec<T>, DecodeCounts) {
    let (mut decoder, mut messages) = (StreamDecoder::<N>::new(), Vec::new());
    bytes.chunks(at).for_each(|piece| decoder.feed(piece, |message| messages.push(message)));
    assert!(decoder.pending() <= N);
    (messages, decoder.counts())
}

fn by_packet<T: Serialize + DeserializeOwned + PartialEq + core::fmt::Debug>(message: &T) {
    let packet = encode_packet(message).expect("a message of this link fits a packet");
    assert_eq!(decode_packet::<T>(&packet).as_ref(), Ok(message));
}

/// The firmware answers in whole frames, and its motors are given finite numbers.
fn firmware(bytes: &[u8]) {
    let reach = Reach::usual(FIRM_GRIP.stiffness, PREMIUM15.max_force);
    let script = Script::by_name("press", &reach, true).expect("a script");
    let mut device = Device::new(&PREMIUM15, "SIM-1", FIRM_GRIP, Encoders::of(&PREMIUM15), script);
    let mut said = TxBuf::new();
    for piece in bytes.chunks(AT_ONCE) {
        device.step(PERIOD_US, piece, &mut said);
        let (_, counts) = cut::<FromDevice, { stream_bound(FromDevice::MAX_ENCODED) }>(said.as_slice(), AT_ONCE);
        assert_eq!(counts.rejected(), 0);
        said.clear();
        let plant = device.plant();
        assert!(plant.position.is_finite() && plant.rotation.is_finite() && plant.velocity.is_finite(), "{plant:?}");
    }
}

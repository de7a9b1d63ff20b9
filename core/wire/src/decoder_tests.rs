//! What the decoder promises, on random streams: every good frame comes through, in order; damage costs what it touches; nothing
//! else comes out and nothing panics.

use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::*;

const N: usize = stream_bound(FromDevice::MAX_ENCODED) - 1;

fn pose(seq: u32, number: i32) -> FromDevice {
    FromDevice::Pose(PoseReport {
        seq,
        t_us: seq.wrapping_mul(1000),
        position_nm: [number, -number, 0],
        rotation_q30: [1 << 30, number, 0, i32::MIN],
        buttons: 0,
        mode: Mode::Force,
        flags: seq as u8,
        echo: seq.wrapping_sub(1),
    })
}

fn message() -> impl Strategy<Value = FromDevice> {
    let number = any::<i32>().prop_filter("MIN has no negative", |&n| n != i32::MIN);
    prop_oneof![
        4 => (any::<u32>(), number).prop_map(|(seq, number)| pose(seq, number)),
        1 => (any::<u32>(), any::<i32>()).prop_map(|(seq, detail)| FromDevice::Fault(DeviceFault {
            cause: FaultCause::OverSpeed,
            seq,
            detail,
        })),
        1 => (any::<[u8; 12]>(), any::<u32>()).prop_map(|(name, limit)| FromDevice::Hello(DeviceHello {
            version: PROTOCOL_VERSION,
            schema: SCHEMA_HASH,
            name,
            serial: *b"0123456789ab",
            max_force_un: limit,
            max_torque_unm: 0,
            watchdog_ticks: 240,
        })),
    ]
}

fn frame(message: &FromDevice) -> Vec<u8> {
    let mut out = [0; N + 1];
    let n = encode_stream(message, &mut out).unwrap();
    out[..n].to_vec()
}

fn decode(decoder: &mut StreamDecoder<N>, bytes: &[u8]) -> Vec<FromDevice> {
    let mut found = Vec::new();
    decoder.feed(bytes, |message| found.push(message));
    found
}

/// Damage to one frame; the index picks the place.
#[derive(Clone, Debug)]
enum Damage {
    Flip(Index, u8),
    Insert(Index, u8),
    Drop(Index),
    Truncate(Index),
}

impl Damage {
    fn apply(&self, frame: &mut Vec<u8>) {
        match self {
            Self::Flip(at, bits) => *at.get_mut(frame) ^= bits,
            Self::Insert(at, byte) => frame.insert(at.index(frame.len() + 1), *byte),
            Self::Drop(at) => drop(frame.remove(at.index(frame.len()))),
            Self::Truncate(at) => frame.truncate(at.index(frame.len())),
        }
    }
}

fn damage() -> impl Strategy<Value = Damage> {
    prop_oneof![
        (any::<Index>(), 1..=u8::MAX).prop_map(|(at, bits)| Damage::Flip(at, bits)),
        (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| Damage::Insert(at, byte)),
        any::<Index>().prop_map(Damage::Drop),
        any::<Index>().prop_map(Damage::Truncate),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn however_the_stream_is_cut_every_message_comes_through(
        messages in vec(message(), 0..20),
        cuts in vec(1..100_usize, 1..20),
    ) {
        let stream: Vec<u8> = messages.iter().flat_map(frame).collect();
        let mut decoder = StreamDecoder::<N>::new();
        let (mut found, mut rest) = (Vec::new(), &stream[..]);
        for &cut in cuts.iter().cycle() {
            if rest.is_empty() {
                break;
            }
            let (now, later) = rest.split_at(cut.min(rest.len()));
            found.extend(decode(&mut decoder, now));
            rest = later;
        }
        prop_assert_eq!(&found, &messages);
        let counts = decoder.counts();
        prop_assert_eq!((counts.accepted as usize, counts.rejected()), (messages.len(), 0));
    }

    #[test]
    fn after_garbage_it_is_in_step_at_the_next_zero(
        garbage in vec(any::<u8>(), 0..300),
        messages in vec(message(), 1..5),
    ) {
        let mut decoder = StreamDecoder::<N>::new();
        prop_assert_eq!(decode(&mut decoder, &garbage), []);
        prop_assert_eq!(decode(&mut decoder, &[0]), []);
        prop_assert_eq!(decoder.pending(), 0);
        let stream: Vec<u8> = messages.iter().flat_map(frame).collect();
        prop_assert_eq!(decode(&mut decoder, &stream), messages);
    }

    #[test]
    fn damage_to_a_frame_costs_it_and_at_most_the_next(
        messages in vec(message(), 3..10),
        which in any::<Index>(),
        damage in damage(),
    ) {
        let hit = which.index(messages.len());
        let mut frames: Vec<Vec<u8>> = messages.iter().map(frame).collect();
        damage.apply(&mut frames[hit]);
        let found = decode(&mut StreamDecoder::new(), &frames.concat());
        // without its zero, or with a byte after it, a frame takes the next one with it
        let without = |gone: &[usize]| -> Vec<FromDevice> {
            let kept = (0..messages.len()).filter(|i| !gone.contains(i));
            kept.map(|i| messages[i]).collect()
        };
        let possible = [&[][..], &[hit], &[hit + 1], &[hit, hit + 1]];
        prop_assert!(possible.iter().any(|gone| found == without(gone)), "{found:?}");
    }

    #[test]
    fn nothing_random_is_taken_for_a_message(bytes in vec(prop_oneof![3 => any::<u8>(), 1 => Just(0)], 0..2000)) {
        let mut decoder = StreamDecoder::<N>::new();
        prop_assert_eq!(decode(&mut decoder, &bytes), []);
        prop_assert_eq!(decoder.counts().accepted, 0);
    }

    #[test]
    fn packets_never_panic_and_never_lie(message in message(), at in 0..64_usize, bits in any::<u8>(), cut in 0..=64_usize) {
        let good = encode_packet(&message).unwrap();
        let mut packet = good;
        packet[at] ^= bits;
        let used = 1 + usize::from(good[0]);
        let found = decode_packet::<FromDevice>(&packet[..cut]);
        let whole = cut >= used && (bits == 0 || at >= used);
        prop_assert_eq!(found.ok(), whole.then_some(message));
    }
}

#[test]
fn what_is_dropped_is_counted_by_its_reason() {
    let good = frame(&pose(7, 1));
    let mut wrong = good.clone();
    wrong[10] ^= 0x40;
    let long = [&[9; N + 1][..], &[0]].concat();
    let table: [(&[u8], [u32; 4]); 7] = [
        (&good, [1, 0, 0, 0]),
        (&wrong, [0, 1, 0, 0]),
        (&long, [0, 0, 1, 0]),
        (&[5, 1, 0], [0, 0, 0, 1]),
        (&[2, 1, 0], [0, 0, 0, 1]),
        (&[0, 0, 0], [0, 0, 0, 0]),
        (&[2], [0, 0, 0, 0]),
    ];
    for (bytes, expected) in table {
        let mut decoder = StreamDecoder::<N>::new();
        decode(&mut decoder, bytes);
        let c = decoder.counts();
        let counts = [c.accepted, c.checksum, c.too_long, c.malformed];
        assert_eq!(counts, expected, "{bytes:02x?}");
        assert_eq!(c.rejected(), expected[1..].iter().sum::<u32>());
    }
}

#[test]
fn a_good_checksum_over_no_message_is_malformed() {
    // a fault with a cause that the table lacks, and a pose with a byte too many
    for (bytes, longer) in [(&[2_u8, 99, 0, 0][..], false), (&[2, 0, 0, 0], true)] {
        let mut plain = bytes.to_vec();
        if longer {
            plain.push(0);
        }
        let mut out = [0; 64];
        let writer = postcard::ser_flavors::crc::CrcModifier::new(cobs::CobsWriter::new(&mut out), frame::CRC32.digest());
        let n = {
            use postcard::ser_flavors::Flavor;
            let mut writer = writer;
            plain.iter().for_each(|&b| writer.try_push(b).unwrap());
            writer.finalize().unwrap()
        };
        let mut decoder = StreamDecoder::<N>::new();
        assert_eq!(decode(&mut decoder, &out[..n]), []);
        assert_eq!(decoder.counts().malformed, 1, "{plain:02x?}");
    }
}

#[test]
fn a_restart_forgets_the_frame_begun() {
    let good = frame(&pose(7, 1));
    let mut decoder = StreamDecoder::<N>::new();
    decode(&mut decoder, &good[..10]);
    assert_eq!(decoder.pending(), 10);
    decoder.restart();
    assert_eq!(decode(&mut decoder, &good), [pose(7, 1)]);
    assert_eq!(decoder.counts().rejected(), 0);
}

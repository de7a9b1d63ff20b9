//! Bytes with every checksum, length and version put right, so that what lies behind them is reached.

use haptor_wire::frame::CRC32;
use haptor_wire::recording::{Chunk, FRAME_MAX};
use haptor_wire::scene_file::{FILE_MAX, digest, encode_file};
use haptor_wire::sections::{GREEN, MAX_SECTIONS, SECTION_OVERHEAD, encode_section};
use haptor_wire::{BakedScene, PROTOCOL_VERSION, Record, RecordHeader, RecordReader, TOOL_SCHEMA_HASH, encode_stream};

/// Bytes of a checksum.
const CRC: usize = 4;

/// Bytes of a baked scene's file before the scene: magic, version, fingerprint, length.
const SCENE_HEADER: usize = 18;

/// Bytes of a section before its contents: kind, length.
const SECTION_HEADER: usize = 8;

/// Bytes of a body's table before the number of nodes along an edge, which is followed by the numbers themselves.
const TABLE_HEADER: usize = 28;

/// Nodes along an edge at least: 26 places. Each has 16 own moves, and with each, itself too, 16 more.
const FEWEST_NODES: f32 = 3.0;
const TABLE_BYTES: usize = 4 * (26 * 16 + 26 * 26 * 16);

/// A stream of frames with the checksum of each put right. What is no frame is taken for a message without one.
pub fn stream(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for frame in bytes.split(|&byte| byte == 0).filter(|frame| !frame.is_empty()) {
        let plain = cobs::decode_vec(frame).ok().filter(|plain| plain.len() >= CRC);
        let message = plain.as_ref().map_or(frame, |plain| &plain[..plain.len() - CRC]);
        out.extend(cobs::encode_vec(&[message, &CRC32.checksum(message).to_le_bytes()].concat()));
        out.push(0);
    }
    out
}

/// A packet of USB with length and checksum put right.
pub fn packet(bytes: &[u8]) -> Vec<u8> {
    let message = bytes.get(1..bytes.len().saturating_sub(CRC)).unwrap_or_default();
    // a length beyond a byte is cut, and then too short
    [&[(message.len() + CRC) as u8], message, &CRC32.checksum(message).to_le_bytes()].concat()
}

/// A recording whose frames are whole, whose header is of this build, and whose scene is the one that the header names.
pub fn recording(bytes: &[u8]) -> Vec<u8> {
    let mut whole = stream(bytes);
    let records: Vec<_> = RecordReader::new(&mut whole).flatten().collect();
    let pieces: Vec<u8> = records.iter().filter_map(scene_bytes).flatten().copied().collect();
    let scene = baked_scene(&pieces);
    let mut out = Vec::new();
    for record in &records {
        match record {
            Record::Header(header) => {
                let (version, schema, scene_bytes) = (PROTOCOL_VERSION, TOOL_SCHEMA_HASH, scene.len() as u32);
                let header = RecordHeader { version, schema, scene_bytes, scene_digest: digest(&scene), ..*header };
                append(&mut out, &Record::Header(header));
                Chunk::of(&scene).for_each(|chunk| append(&mut out, &Record::Scene(chunk)));
            }
            Record::Scene(_) => {}
            record => append(&mut out, record),
        }
    }
    out
}

fn scene_bytes<'a>(record: &Record<'a>) -> Option<&'a [u8]> {
    if let Record::Scene(chunk) = record { Some(chunk.bytes) } else { None }
}

fn append(out: &mut Vec<u8>, record: &Record<'_>) {
    let mut frame = [0; FRAME_MAX];
    if let Ok(length) = encode_stream(record, &mut frame) {
        out.extend(&frame[..length]);
    }
}

/// A baked scene's file of this build, its sections as long as they say.
pub fn baked_scene(bytes: &[u8]) -> Vec<u8> {
    let body = bytes.get(SCENE_HEADER..).unwrap_or_default();
    let Ok((scene, rest)) = postcard::take_from_bytes::<BakedScene>(body) else { return bytes.to_vec() };
    let mut out = vec![0; FILE_MAX];
    let length = encode_file(&scene, &mut out).unwrap_or_default();
    out.truncate(length);
    let mut rest = rest.get(CRC..).unwrap_or_default();
    for _ in 0..MAX_SECTIONS {
        let Some((head, after)) = rest.split_first_chunk::<SECTION_HEADER>() else { break };
        let [k0, k1, k2, k3, n0, n1, n2, n3] = *head;
        let length = (u32::from_le_bytes([n0, n1, n2, n3]) as usize).min(after.len());
        let kind = u32::from_le_bytes([k0, k1, k2, k3]);
        out.extend(if kind == GREEN { section(kind, &table(&after[..length])) } else { section(kind, &after[..length]) });
        rest = after.get(length + CRC..).unwrap_or_default();
    }
    out
}

/// A body's table with the fewest nodes along an edge and as many numbers as those need, its own over and over: whole ones are longer than an input.
fn table(contents: &[u8]) -> Vec<u8> {
    let Some((head, rest)) = contents.split_at_checked(TABLE_HEADER) else { return contents.to_vec() };
    let nodes = FEWEST_NODES.to_le_bytes();
    let numbers = rest.get(nodes.len()..).filter(|numbers| !numbers.is_empty()).unwrap_or(&[0]);
    [head, &nodes].concat().into_iter().chain(numbers.iter().copied().cycle().take(TABLE_BYTES)).collect()
}

fn section(kind: u32, contents: &[u8]) -> Vec<u8> {
    let mut out = vec![0; contents.len() + SECTION_OVERHEAD];
    let length = encode_section(kind, contents, &mut out).unwrap_or_default();
    out.truncate(length);
    out
}

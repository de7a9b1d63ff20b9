//! The file of a baked scene.
//!
//! ```text
//! "HAPTORM2" | version u16 | fingerprint u32 | n u32 | n bytes of postcard | CRC-32 of all before, u32        little endian
//! ```
//! Magic and version come first and are checked first, so that a file of another version is called that and not damaged. Behind the scene there may
//! be data in [`sections`](crate::sections).

use core::fmt;

use crate::digest::Digest;
use crate::frame::{CRC_BYTES, CRC32, FrameError};
use crate::scene::{BakedScene, MAX_PARTS};
use crate::schema::{PROTOCOL_VERSION, TOOL_SCHEMA_HASH, VersionMismatch, check_tool_version};
use crate::sections::Sections;

/// The first bytes of every baked scene.
pub const MAGIC: [u8; 8] = *b"HAPTORM2";

/// Bytes before the scene itself.
const HEADER_BYTES: usize = MAGIC.len() + 2 + 4 + 4;

/// The magic of files baked before there were sections: told apart from what is no baked scene at all.
const OLD_MAGIC: [u8; 8] = *b"HAPTORM1";

/// Bytes of a file's scene at most; sections follow it.
pub const FILE_MAX: usize = HEADER_BYTES + BakedScene::MAX_ENCODED + CRC_BYTES;

/// Why bytes are not a baked scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneFileError {
    /// The file does not begin as a baked scene does.
    BadMagic,
    /// It was baked by a build with other tables; bake it anew.
    Version(VersionMismatch),
    /// The file ends early.
    Truncated {
        /// Bytes there are.
        found: usize,
        /// Bytes there should be.
        expected: usize,
    },
    /// The checksum differs: the file is damaged.
    Crc {
        /// What the bytes give.
        computed: u32,
        /// What the file says.
        received: u32,
    },
    /// The checksum agrees, but the bytes are no scene.
    Contents,
    /// It was baked before there were sections.
    Old,
    /// A section ends early.
    SectionCut {
        /// Bytes there are.
        found: usize,
        /// Bytes there should be.
        expected: usize,
    },
    /// A section is longer than any may be, or there are too many.
    SectionSize {
        /// Its kind.
        kind: u32,
        /// Its length.
        length: usize,
    },
    /// A section is damaged.
    SectionCrc {
        /// Its kind.
        kind: u32,
        /// What the bytes give.
        computed: u32,
        /// What the file says.
        received: u32,
    },
}

impl fmt::Display for SceneFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadMagic => f.write_str("not a baked scene: it does not begin with HAPTORM2"),
            Self::Version(mismatch) => write!(f, "{mismatch}; bake the scene anew"),
            Self::Truncated { found, expected } => {
                write!(f, "the baked scene ends after {found} of {expected} bytes")
            }
            Self::Crc { computed, received } => {
                write!(f, "the baked scene is damaged: checksum {received:08x}, its bytes give {computed:08x}")
            }
            Self::Contents => f.write_str("the baked scene's bytes are no scene"),
            Self::Old => f.write_str("a baked scene of an older format, HAPTORM1; bake the scene anew"),
            Self::SectionCut { found, expected } => {
                write!(f, "the baked scene's data ends after {found} of {expected} bytes of a section")
            }
            Self::SectionSize { kind, length } => {
                let (many, long) = (crate::sections::MAX_SECTIONS, crate::sections::MAX_SECTION);
                write!(f, "section {kind} of the baked scene, {length} bytes: at most {many} sections of {long} bytes")
            }
            Self::SectionCrc { kind, computed, received } => {
                write!(f, "section {kind} of the baked scene is damaged: checksum {received:08x}, its bytes give {computed:08x}")
            }
        }
    }
}

impl core::error::Error for SceneFileError {}

/// Writes `scene` as a file to the front of `out`; yields its length.
///
/// # Errors
/// [`FrameError::BufferFull`] when `out` is shorter than the file; [`FILE_MAX`] always fits.
pub fn encode_file(scene: &BakedScene, out: &mut [u8]) -> Result<usize, FrameError> {
    let full = FrameError::BufferFull;
    let (header, body) = out.split_at_mut_checked(HEADER_BYTES).ok_or(full)?;
    let used = postcard::to_slice(scene, body).map_err(|_| full)?.len();
    // at most FILE_MAX
    let fields = MAGIC
        .into_iter()
        .chain(PROTOCOL_VERSION.to_le_bytes())
        .chain(TOOL_SCHEMA_HASH.to_le_bytes())
        .chain((used as u32).to_le_bytes());
    header.iter_mut().zip(fields).for_each(|(to, byte)| *to = byte);
    let checked = HEADER_BYTES + used;
    let (before, after) = out.split_at_mut_checked(checked).ok_or(full)?;
    let crc = CRC32.checksum(before).to_le_bytes();
    *after.first_chunk_mut().ok_or(full)? = crc;
    Ok(checked + CRC_BYTES)
}

/// Reads a file's scene, and checks its sections.
///
/// # Errors
/// [`SceneFileError`]; more than [`MAX_PARTS`] parts are `Contents`.
pub fn decode_file(file: &[u8]) -> Result<BakedScene, SceneFileError> {
    let (scene, rest) = split(file)?;
    Sections::new(rest).try_for_each(|section| section.map(|_| ()))?;
    Ok(scene)
}

/// The sections behind a file's scene, checked one by one.
///
/// # Errors
/// [`SceneFileError`] as [`decode_file`] says of the scene.
pub fn sections(file: &[u8]) -> Result<Sections<'_>, SceneFileError> {
    split(file).map(|(_, rest)| Sections::new(rest))
}

/// The scene, and the bytes behind it.
fn split(file: &[u8]) -> Result<(BakedScene, &[u8]), SceneFileError> {
    let truncated = |expected| SceneFileError::Truncated { found: file.len(), expected };
    if file.starts_with(&OLD_MAGIC) {
        return Err(SceneFileError::Old);
    }
    if !file.iter().zip(&MAGIC).all(|(a, b)| a == b) || file.is_empty() {
        return Err(SceneFileError::BadMagic);
    }
    let (header, _) = file.split_first_chunk::<HEADER_BYTES>().ok_or_else(|| truncated(HEADER_BYTES + CRC_BYTES))?;
    let [_, _, _, _, _, _, _, _, v0, v1, s0, s1, s2, s3, n0, n1, n2, n3] = *header;
    let schema = u32::from_le_bytes([s0, s1, s2, s3]);
    check_tool_version(u16::from_le_bytes([v0, v1]), schema).map_err(SceneFileError::Version)?;

    // a length that does not fit a usize cannot be there
    let length = usize::try_from(u32::from_le_bytes([n0, n1, n2, n3])).unwrap_or(usize::MAX);
    let expected = length.saturating_add(HEADER_BYTES + CRC_BYTES);
    let (whole, rest) = file.split_at_checked(expected).ok_or_else(|| truncated(expected))?;
    let (checked, crc) = whole.split_last_chunk::<CRC_BYTES>().ok_or(SceneFileError::Contents)?;
    let (computed, received) = (CRC32.checksum(checked), u32::from_le_bytes(*crc));
    if computed != received {
        return Err(SceneFileError::Crc { computed, received });
    }
    let body = checked.get(HEADER_BYTES..).unwrap_or(&[]);
    match postcard::take_from_bytes::<BakedScene>(body) {
        Ok((scene, [])) if usize::from(scene.probe.count) <= MAX_PARTS => Ok((scene, rest)),
        _ => Err(SceneFileError::Contents),
    }
}

/// Fingerprint of a file, to tell recordings of one scene from those of another: FNV-1a, 64 bits.
#[must_use]
pub fn digest(file: &[u8]) -> u64 {
    let mut digest = Digest::new();
    digest.add(file);
    digest.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::scene;
    use std::vec::Vec;

    fn baked() -> Vec<u8> {
        let mut out = [0; FILE_MAX];
        let n = encode_file(&scene(), &mut out).unwrap();
        out[..n].to_vec()
    }

    #[test]
    fn there_and_back() {
        assert_eq!(decode_file(&baked()), Ok(scene()));
    }

    #[test]
    fn a_file_cut_anywhere_is_truncated() {
        let file = baked();
        assert_eq!(decode_file(&[]), Err(SceneFileError::BadMagic));
        for n in 1..file.len() {
            let found = decode_file(&file[..n]);
            assert!(matches!(found, Err(SceneFileError::Truncated { found, .. }) if found == n), "cut to {n}: {found:?}");
        }
    }

    #[test]
    fn every_flipped_bit_is_found_and_named() {
        let file = baked();
        for at in 0..file.len() {
            for bit in 0..8 {
                let mut bad = file.clone();
                bad[at] ^= 1 << bit;
                let error = decode_file(&bad).unwrap_err();
                let named = match at {
                    0..8 => matches!(error, SceneFileError::BadMagic | SceneFileError::Old),
                    8..14 => matches!(error, SceneFileError::Version(_)),
                    14..18 => matches!(error, SceneFileError::Truncated { .. } | SceneFileError::Crc { .. }),
                    _ => matches!(error, SceneFileError::Crc { .. }),
                };
                assert!(named, "byte {at} bit {bit}: {error:?}");
            }
        }
    }

    #[test]
    fn a_file_of_the_older_format_is_called_that() {
        let mut file = baked();
        file[7] = b'1';
        assert_eq!(decode_file(&file), Err(SceneFileError::Old));
    }

    #[test]
    fn a_version_mismatch_names_both_numbers() {
        let mut file = baked();
        file[8..10].copy_from_slice(&7_u16.to_le_bytes());
        let text = std::format!("{}", decode_file(&file).unwrap_err());
        assert!(text.contains("version 7 "), "{text}");
        assert!(text.contains("this side version 1 "), "{text}");
    }

    #[test]
    fn bytes_left_over_and_too_many_parts_are_refused() {
        let mut longer = baked();
        longer.push(0);
        assert_eq!(decode_file(&longer), Err(SceneFileError::SectionCut { found: 1, expected: 12 }));

        let mut scene = scene();
        scene.probe.count = 17;
        let mut out = [0; FILE_MAX];
        let n = encode_file(&scene, &mut out).unwrap();
        assert_eq!(decode_file(&out[..n]), Err(SceneFileError::Contents));
    }

    #[test]
    fn a_small_buffer_is_an_error_at_every_size() {
        let n = baked().len();
        for size in 0..n {
            let mut out = std::vec![0; size];
            assert_eq!(encode_file(&scene(), &mut out), Err(FrameError::BufferFull), "size {size}");
        }
    }

    #[test]
    fn the_digest_is_fnv_1a() {
        assert_eq!(digest(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(digest(b"foobar"), 0x8594_4171_f739_67e8);
    }
}

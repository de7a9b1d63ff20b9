//! Data behind the scene in a baked file: tables too large for the scene itself.
//!
//! ```text
//! kind u32 | n u32 | n bytes | CRC-32 of kind, n and bytes, u32        little endian; any number up to MAX_SECTIONS, one after the other
//! ```
//!
//! | kind | what | bytes |
//! |---|---|---|
//! | 1 | the body's own Green's function | f32 each: chart's middle (3) and half extents (3), radius of the discs, nodes along an edge; own moves; table |
//! | 2 | a mesh: distance grid and samples | f32 each: first node (3), spacing, nodes along x, y, z; least (3) and largest (3) coordinates, volume, reach; number of samples; a coefficient a node, x fastest; each sample's position (3), normal (3), area |
//! | 3 | a mesh to look at, for viewers | number of vertices, u32; each vertex, three f32 \[m\]; each triangle, three u32 |
//!
//! Meshes of kinds 2 and 3 stand in the order in which shapes number them. A kind that a reader does not know is checked and passed over.

use crate::frame::{CRC_BYTES, CRC32, FrameError};
use crate::scene_file::SceneFileError;

/// Kind of the table of the body's own Green's function.
pub const GREEN: u32 = 1;

/// Kind of the distance grid and samples of a mesh; shapes name them by their order in the file.
pub const GRID: u32 = 2;

/// Kind of a mesh to look at; hosts pass it over.
pub const SKIN: u32 = 3;

/// Sections of a file at most: one table, and for object and each part of the probe a grid and a mesh to look at.
pub const MAX_SECTIONS: usize = 35;

/// Bytes of a section's contents at most: the largest Green's table has 9.6 MB, a distance grid of 128 x 128 x 128 8.4 MB.
pub const MAX_SECTION: usize = 16 << 20;

/// Bytes before the contents.
const HEAD: usize = 8;

/// Bytes around the contents.
pub const SECTION_OVERHEAD: usize = HEAD + CRC_BYTES;

/// Writes a section to the front of `out`; yields its length.
///
/// # Errors
/// [`FrameError::BufferFull`] when `out` is shorter than the section, or the contents longer than [`MAX_SECTION`].
pub fn encode_section(kind: u32, contents: &[u8], out: &mut [u8]) -> Result<usize, FrameError> {
    let full = FrameError::BufferFull;
    if contents.len() > MAX_SECTION {
        return Err(full);
    }
    let checked = HEAD + contents.len();
    let (before, after) = out.split_at_mut_checked(checked).ok_or(full)?;
    let fields = kind.to_le_bytes().into_iter().chain((contents.len() as u32).to_le_bytes());
    before.iter_mut().zip(fields.chain(contents.iter().copied())).for_each(|(to, byte)| *to = byte);
    *after.first_chunk_mut().ok_or(full)? = CRC32.checksum(before).to_le_bytes();
    Ok(checked + CRC_BYTES)
}

/// One section of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section<'a> {
    /// What it holds.
    pub kind: u32,
    /// Its contents.
    pub contents: &'a [u8],
}

/// The sections of a file, one after the other; after an error there are no more.
#[derive(Clone, Debug)]
pub struct Sections<'a> {
    rest: &'a [u8],
    seen: usize,
}

impl<'a> Sections<'a> {
    /// Over the bytes behind the scene.
    pub(crate) const fn new(rest: &'a [u8]) -> Self {
        Self { rest, seen: 0 }
    }

    fn take(&mut self) -> Result<Section<'a>, SceneFileError> {
        let cut = |expected| SceneFileError::SectionCut { found: self.rest.len(), expected };
        let (head, _) = self.rest.split_first_chunk::<HEAD>().ok_or_else(|| cut(SECTION_OVERHEAD))?;
        let [k0, k1, k2, k3, n0, n1, n2, n3] = *head;
        let kind = u32::from_le_bytes([k0, k1, k2, k3]);
        let length = usize::try_from(u32::from_le_bytes([n0, n1, n2, n3])).unwrap_or(usize::MAX);
        if length > MAX_SECTION || self.seen >= MAX_SECTIONS {
            return Err(SceneFileError::SectionSize { kind, length });
        }
        let expected = length + SECTION_OVERHEAD;
        let (whole, rest) = self.rest.split_at_checked(expected).ok_or_else(|| cut(expected))?;
        let (checked, crc) = whole.split_last_chunk::<CRC_BYTES>().ok_or_else(|| cut(expected))?;
        let (computed, received) = (CRC32.checksum(checked), u32::from_le_bytes(*crc));
        if computed != received {
            return Err(SceneFileError::SectionCrc { kind, computed, received });
        }
        (self.rest, self.seen) = (rest, self.seen + 1);
        Ok(Section { kind, contents: checked.get(HEAD..).unwrap_or(&[]) })
    }
}

impl<'a> Iterator for Sections<'a> {
    type Item = Result<Section<'a>, SceneFileError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let found = self.take();
        if found.is_err() {
            self.rest = &[];
        }
        Some(found)
    }
}

/// The numbers of a section of f32; `None` when its length is no multiple of four.
#[must_use]
pub fn numbers(contents: &[u8]) -> Option<impl ExactSizeIterator<Item = f32> + '_> {
    let (whole, rest) = contents.as_chunks::<4>();
    rest.is_empty().then(|| whole.iter().map(|four| f32::from_le_bytes(*four)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::scene;
    use crate::scene_file::{FILE_MAX, decode_file, encode_file, sections};
    use std::vec::Vec;

    fn section(kind: u32, contents: &[u8]) -> Vec<u8> {
        let mut out = std::vec![0; contents.len() + SECTION_OVERHEAD];
        assert_eq!(encode_section(kind, contents, &mut out), Ok(out.len()));
        out
    }

    /// A scene with two sections, and where the first begins.
    fn file() -> (Vec<u8>, usize) {
        let mut out = std::vec![0; FILE_MAX];
        let scene_bytes = encode_file(&scene(), &mut out).unwrap();
        out.truncate(scene_bytes);
        out.extend(section(GREEN, &[1, 2, 3, 4, 5]));
        out.extend(section(99, b""));
        (out, scene_bytes)
    }

    fn contents(file: &[u8]) -> Result<Vec<(u32, Vec<u8>)>, SceneFileError> {
        sections(file)?.map(|section| section.map(|section| (section.kind, section.contents.to_vec()))).collect()
    }

    #[test]
    fn there_and_back_and_an_unknown_kind_is_passed_over() {
        let (file, _) = file();
        assert_eq!(decode_file(&file), Ok(scene()));
        assert_eq!(contents(&file), Ok(std::vec![(GREEN, std::vec![1, 2, 3, 4, 5]), (99, std::vec![])]));
    }

    #[test]
    fn a_file_cut_inside_a_section_is_refused() {
        let (file, start) = file();
        let first = start + 5 + SECTION_OVERHEAD;
        for n in (start + 1..file.len()).filter(|&n| n != first) {
            let error = decode_file(&file[..n]).unwrap_err();
            assert!(matches!(error, SceneFileError::SectionCut { .. }), "cut to {n}: {error:?}");
        }
        assert_eq!(contents(&file[..first]).unwrap().len(), 1);
    }

    #[test]
    fn every_flipped_bit_of_a_section_is_found() {
        let (file, start) = file();
        for at in start..file.len() {
            for bit in 0..8 {
                let mut bad = file.clone();
                bad[at] ^= 1 << bit;
                let error = decode_file(&bad).unwrap_err();
                let named = matches!(
                    error,
                    SceneFileError::SectionCrc { .. } | SceneFileError::SectionCut { .. } | SceneFileError::SectionSize { .. }
                );
                assert!(named, "byte {at} bit {bit}: {error:?}");
            }
        }
    }

    #[test]
    fn too_long_and_too_many_are_refused_by_kind_and_size() {
        let (mut long, start) = file();
        long[start + 4..start + 8].copy_from_slice(&u32::MAX.to_le_bytes());
        let text = std::format!("{}", decode_file(&long).unwrap_err());
        assert!(text.contains("section 1") && text.contains("4294967295"), "{text}");

        let (file, start) = file();
        let mut many = file[..start].to_vec();
        for _ in 0..=MAX_SECTIONS {
            many.extend(section(7, b"x"));
        }
        assert!(matches!(decode_file(&many), Err(SceneFileError::SectionSize { kind: 7, .. })));
        assert!(encode_section(GREEN, &std::vec![0; MAX_SECTION + 1], &mut std::vec![0; MAX_SECTION + 64]).is_err());
    }

    #[test]
    fn a_small_buffer_is_an_error_at_every_size() {
        let length = section(GREEN, &[1, 2, 3]).len();
        for size in 0..length {
            assert_eq!(encode_section(GREEN, &[1, 2, 3], &mut std::vec![0; size]), Err(FrameError::BufferFull), "size {size}");
        }
    }

    #[test]
    fn numbers_are_read_whole_or_not_at_all() {
        let bytes: Vec<u8> = [1.5_f32, -2.0].iter().flat_map(|number| number.to_le_bytes()).collect();
        assert!(numbers(&bytes).unwrap().eq([1.5, -2.0]));
        assert!(numbers(&bytes[..7]).is_none());
    }
}

//! A table as bytes: little endian, versioned, checked.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `haptgrn` and a zero byte |
//! | u32 | [`FORMAT`] |
//! | 32 | key: SHA-256 of the inputs ([`super::GreenInputs::key`]) |
//! | 3 f32, 3 f32, f32, u32 | chart: middle, half extents; radius of the discs; nodes along an edge |
//! | f32 each | own moves, then the table, as in [`haptor_contact::green::GreenSpec`] |
//! | 32 | SHA-256 of everything before |
//!
//! A file is written whole or not at all: into a file of its own beside the goal, which then takes its name.

use std::io::Write;
use std::path::{Path, PathBuf};

use glam::Vec3;
use haptor_contact::green::{BLOCK, COMPONENTS, Chart, Green};
use sha2::{Digest, Sha256};

use super::{GreenInputs, GreenKey, GreenTable};

/// Version of the layout.
pub const FORMAT: u32 = 1;

const MAGIC: &[u8; 8] = b"haptgrn\0";
/// Magic, format, key.
const HEAD: usize = 44;
const CHART: usize = 32;
const DIGEST: usize = 32;

/// Most bytes of a file: 9 nodes an edge with room to spare.
pub const MAX_BYTES: usize = 16 << 20;

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum GreenFileError {
    /// The system says why.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        error: std::io::Error,
    },
    /// Too long, too short or of another length than its chart says.
    #[error("a table of {found} bytes: {expected} expected")]
    Length {
        /// Bytes found.
        found: usize,
        /// Bytes that fit.
        expected: usize,
    },
    /// Not a table.
    #[error("not a table: it does not begin with `haptgrn`")]
    Magic,
    /// Another version.
    #[error("table format {found}; this program reads {FORMAT}")]
    Format {
        /// Version found.
        found: u32,
    },
    /// The bytes are not those that were written.
    #[error("damaged: the digest at its end does not fit; delete it")]
    Damaged,
    /// A table of other inputs.
    #[error("a table of another body, material or method: key {found}, asked for {wanted}")]
    OtherInputs {
        /// Key in the file.
        found: GreenKey,
        /// Key of the inputs.
        wanted: GreenKey,
    },
    /// A value that the core refuses.
    #[error(transparent)]
    Invalid(#[from] haptor_contact::Invalid),
}

impl GreenTable {
    /// The table as bytes, with the key of its inputs.
    pub fn to_bytes(&self, key: &GreenKey) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(FORMAT.to_le_bytes());
        bytes.extend(key.0);
        let chart = [self.chart.centre, self.chart.half_size];
        bytes.extend(chart.iter().flat_map(Vec3::to_array).chain([self.patch_radius]).flat_map(f32::to_le_bytes));
        bytes.extend((self.chart.per_edge as u32).to_le_bytes());
        bytes.extend(self.own.iter().chain(&self.table).flat_map(|number| number.to_le_bytes()));
        let digest: [u8; DIGEST] = Sha256::digest(&bytes).into();
        bytes.extend(digest);
        bytes
    }

    /// The table in `bytes`, and its key.
    ///
    /// # Errors
    /// Names what is wrong; nothing damaged, cut or foreign is accepted.
    pub fn from_bytes(bytes: &[u8]) -> Result<(Self, GreenKey), GreenFileError> {
        let wrong = |expected| GreenFileError::Length { found: bytes.len(), expected };
        let least = HEAD + CHART + DIGEST;
        if bytes.len() < least || bytes.len() > MAX_BYTES {
            return Err(wrong(if bytes.len() < least { least } else { MAX_BYTES }));
        }
        let (body, digest) = bytes.split_at(bytes.len() - DIGEST);
        if body[..8] != MAGIC[..] {
            return Err(GreenFileError::Magic);
        }
        let found = word(body, 8);
        if found != FORMAT {
            return Err(GreenFileError::Format { found });
        }
        if <[u8; DIGEST]>::from(Sha256::digest(body)) != *digest {
            return Err(GreenFileError::Damaged);
        }
        let mut key = [0; DIGEST];
        key.copy_from_slice(&body[12..HEAD]);
        let number = |index: usize| f32::from_bits(word(body, HEAD + 4 * index));
        let vector = |first: usize| Vec3::new(number(first), number(first + 1), number(first + 2));
        // more nodes than a file may hold bytes must not overflow
        let per_edge = (word(body, HEAD + 28) as usize).min(MAX_BYTES);
        let chart = Chart { centre: vector(0), half_size: vector(3), per_edge };
        let numbers: Vec<f32> = body[HEAD + CHART..].chunks_exact(4).map(|four| f32::from_bits(word(four, 0))).collect();
        let (own, table) = split(&chart, &numbers).ok_or_else(|| wrong(length(&chart)))?;
        let table = Self { chart, patch_radius: number(6), own: own.to_vec(), table: table.to_vec() };
        Green::new(&table.spec())?;
        Ok((table, GreenKey(key)))
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// [`GreenFileError::Io`] with the path.
    pub fn write(&self, path: &Path, inputs: &GreenInputs) -> Result<(), GreenFileError> {
        let io = |error| GreenFileError::Io { path: path.to_path_buf(), error };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder).map_err(io)?;
        file.write_all(&self.to_bytes(&inputs.key())).map_err(io)?;
        file.as_file().sync_all().map_err(io)?;
        file.persist(path).map_err(|error| io(error.error))?;
        Ok(())
    }

    /// Reads the table of `inputs` from a file.
    ///
    /// # Errors
    /// Names the file, or what is wrong with its contents.
    pub fn read(path: &Path, inputs: &GreenInputs) -> Result<Self, GreenFileError> {
        let io = |error| GreenFileError::Io { path: path.to_path_buf(), error };
        let length = std::fs::metadata(path).map_err(io)?.len() as usize;
        if length > MAX_BYTES {
            return Err(GreenFileError::Length { found: length, expected: MAX_BYTES });
        }
        let (table, found) = Self::from_bytes(&std::fs::read(path).map_err(io)?)?;
        let wanted = inputs.key();
        if found == wanted { Ok(table) } else { Err(GreenFileError::OtherInputs { found, wanted }) }
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let mut four = [0; 4];
    four.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(four)
}

/// Numbers of own moves and of the table.
fn sizes(chart: &Chart) -> Option<(usize, usize)> {
    // places() of a chart of no nodes would run below zero
    if !(2..=MAX_PER_EDGE).contains(&chart.per_edge) {
        return None;
    }
    let side = COMPONENTS * chart.places();
    Some((BLOCK * chart.places(), side * side))
}

/// Beyond this no chart is valid and its size need not be counted.
const MAX_PER_EDGE: usize = haptor_contact::green::chart::MAX_PER_EDGE;

/// Bytes of a whole file with this chart; 0 for charts that are none.
fn length(chart: &Chart) -> usize {
    sizes(chart).map_or(0, |(own, table)| HEAD + CHART + 4 * (own + table) + DIGEST)
}

fn split<'n>(chart: &Chart, numbers: &'n [f32]) -> Option<(&'n [f32], &'n [f32])> {
    let (own, table) = sizes(chart)?;
    (numbers.len() == own + table).then(|| numbers.split_at(own))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::green::GreenOptions;
    use haptor_contact::{Material, ObjectShape};

    pub(crate) fn inputs() -> GreenInputs {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let shape = ObjectShape::Box { size: Vec3::splat(0.1) };
        GreenInputs { shape, material, fixed_below: 0.0, options: GreenOptions { per_edge: 3, fineness: 3 } }
    }

    fn table() -> GreenTable {
        let chart = Chart { centre: Vec3::Z * 0.05, half_size: Vec3::splat(0.05), per_edge: 3 };
        let (own, table) = sizes(&chart).unwrap();
        let number = |i: usize| (i as f32 * 0.7).sin();
        GreenTable { chart, patch_radius: 0.005, own: (0..own).map(number).collect(), table: (0..table).map(number).collect() }
    }

    #[test]
    fn a_table_comes_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cube.green");
        table().write(&path, &inputs()).unwrap();
        assert_eq!(GreenTable::read(&path, &inputs()).unwrap(), table());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let other = GreenInputs { fixed_below: 0.01, ..inputs() };
        assert!(GreenTable::read(&path, &other).unwrap_err().to_string().contains("another body"));
    }

    #[test]
    fn no_damaged_or_cut_table_is_read() {
        let bytes = table().to_bytes(&inputs().key());
        for at in (0..bytes.len()).step_by(997).chain(0..80) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            assert!(GreenTable::from_bytes(&damaged).is_err(), "{at}");
            assert!(GreenTable::from_bytes(&bytes[..at]).is_err(), "{at}");
        }
        let mut long = bytes.clone();
        long.push(0);
        assert!(GreenTable::from_bytes(&long).is_err());
    }

    #[test]
    fn a_chart_of_another_size_is_refused_by_length() {
        let mut bytes = table().to_bytes(&inputs().key());
        bytes.truncate(bytes.len() - DIGEST);
        for per_edge in [0_u32, 1, 5, u32::MAX] {
            bytes[HEAD + 28..HEAD + 32].copy_from_slice(&per_edge.to_le_bytes());
            let digest: [u8; DIGEST] = Sha256::digest(&bytes).into();
            let error = GreenTable::from_bytes(&[&bytes[..], &digest].concat()).unwrap_err();
            assert!(matches!(error, GreenFileError::Length { .. }), "{per_edge}: {error}");
        }
    }

    #[test]
    fn keys_tell_inputs_apart() {
        let material = Material { poisson_ratio: 0.3, ..inputs().material };
        let options = GreenOptions { per_edge: 5, ..inputs().options };
        let others = [
            GreenInputs { material, ..inputs() },
            GreenInputs { options, ..inputs() },
            GreenInputs { fixed_below: 0.01, ..inputs() },
        ];
        for other in others {
            assert_ne!(other.key(), inputs().key());
        }
        let denser = Material { density: 900.0, ..inputs().material };
        assert_eq!(GreenInputs { material: denser, ..inputs() }.key(), inputs().key());
    }
}

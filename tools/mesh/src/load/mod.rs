//! Reading mesh files (STL, OBJ, PLY) from anywhere: bounded in time and memory, and refused with the reason.
//!
//! The parsers are other people's crates. They accept what a format allows, which is more than a solid can use, and some trust what a header
//! says; so each file is read whole below [`MAX_FILE_BYTES`], told apart by its contents first and by its name's end second, checked for what its
//! parser would trip over, and only then parsed. Polygons become triangles. Joining of equal corners is left to [`crate::weld()`].
//!
//! | module | what it does |
//! |---|---|
//! | `stl` | ASCII and binary STL |
//! | `obj` | Wavefront OBJ: corners and faces, nothing else |
//! | `ply` | PLY: ASCII, binary of either byte order |
//! | `polygon` | polygons into triangles |

mod obj;
mod ply;
mod polygon;
mod stl;

use std::fmt::{self, Display};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use glam::DVec3;

use crate::mesh::Mesh;

/// Largest file read \[bytes\]: 5 million triangles in every binary format and as OBJ, 2 million as ASCII STL.
pub const MAX_FILE_BYTES: u64 = 512 << 20;

/// Most triangles: indices and edge tables of more would not fit a small machine's memory.
pub const MAX_TRIANGLES: usize = 5_000_000;

/// Most vertices: three for each triangle, as STL writes them.
pub const MAX_VERTICES: usize = 3 * MAX_TRIANGLES;

/// Largest coordinate \[file units, after scaling m\]: the core refuses distances beyond 1 km.
pub const MAX_COORDINATE: f64 = 1.0e3;

/// Longest line of a text file \[bytes\]: a polygon of the most corners with room to spare; parsers keep whole lines.
pub const MAX_LINE: usize = 64 << 10;

/// Longest part of a parser's own words that a message repeats \[characters\]: they may hold a whole line of the file.
const MAX_QUOTE: usize = 160;

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// STL, ASCII.
    StlText,
    /// STL, binary.
    StlBinary,
    /// Wavefront OBJ.
    Obj,
    /// PLY.
    Ply,
}

impl Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StlText => "ASCII STL",
            Self::StlBinary => "binary STL",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
        })
    }
}

/// Why a file is no mesh.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The system would not give the file.
    #[error("cannot be opened: {0}; give the path of a mesh file")]
    Open(#[source] io::Error),
    /// The file is larger than [`MAX_FILE_BYTES`].
    #[error("is {bytes} bytes, allowed is up to {MAX_FILE_BYTES}: reduce the mesh, or save it in a binary format")]
    TooLarge {
        /// Its size.
        bytes: u64,
    },
    /// Neither contents nor name tell a format.
    #[error("is no STL, OBJ or PLY file: export the mesh in one of these formats")]
    Unknown,
    /// The bytes are not what the format asks for.
    #[error("is no readable {format} file: {what}")]
    Format {
        /// The format it was read as.
        format: Format,
        /// What is wrong, and where.
        what: String,
    },
    /// Not one triangle.
    #[error("holds no triangle{instead}: export a surface of triangles or polygons")]
    Empty {
        /// What it holds instead, with a comma before; may be empty.
        instead: String,
    },
    /// More of something than is allowed.
    #[error("holds {count} {what}, allowed is up to {most}: reduce the mesh")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many there are, as far as they were counted.
        count: u64,
        /// How many may be.
        most: usize,
    },
    /// A face names a vertex that the file does not have.
    #[error("face {face} names vertex {vertex}, there are {vertices}, counted from 0: export the mesh again")]
    Corner {
        /// Which face, from 0, in the order of the file.
        face: usize,
        /// The vertex it names, from 0.
        vertex: i64,
        /// How many there are.
        vertices: usize,
    },
    /// A coordinate is not finite or too large.
    #[error("vertex {vertex} has coordinate {value} m, allowed is -{MAX_COORDINATE} to {MAX_COORDINATE} m: check the scale")]
    Coordinate {
        /// Which vertex, from 0, in the order of the file.
        vertex: usize,
        /// The coordinate after scaling.
        value: f64,
    },
    /// The scale is not above 0 or not finite.
    #[error("scale {scale}: allowed is above 0 and finite, e.g. 0.001 for a file in millimetres")]
    Scale {
        /// The scale given.
        scale: f64,
    },
}

impl LoadError {
    /// The bytes are not what `format` asks for: a parser's words, on one line and shortened.
    fn format(format: Format, what: impl Display) -> Self {
        let words = what.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        let shown = words.char_indices().nth(MAX_QUOTE).map_or(words.clone(), |(end, _)| format!("{}...", &words[..end]));
        Self::Format { format, what: shown }
    }
}

/// Loads a mesh file; `scale` takes the file's unit to metres.
///
/// # Errors
/// [`LoadError`] when it cannot be opened, is too large, is no mesh, or holds nothing a solid can be made of.
pub fn load_mesh(path: &Path, scale: f64) -> Result<Mesh, LoadError> {
    read_mesh(read_bytes(path)?, extension(path).as_deref(), scale)
}

/// The end of a file's name, in small letters, by which a file is taken whose contents do not tell.
pub fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// The bytes of a mesh file.
///
/// # Errors
/// [`LoadError`] when it cannot be opened, is no regular file or too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, LoadError> {
    // asked before it is opened: opening a pipe would wait for its writer
    let info = std::fs::metadata(path).map_err(LoadError::Open)?;
    if !info.is_file() {
        let what = if info.is_dir() { "it is a directory, not a regular file" } else { "it is not a regular file" };
        return Err(LoadError::Open(io::Error::other(what)));
    }
    let mut bytes = Vec::new();
    if info.len() <= MAX_FILE_BYTES {
        let file = File::open(path).map_err(LoadError::Open)?;
        // a file that grows meanwhile is cut, and then refused
        file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(LoadError::Open)?;
    }
    match info.len().max(bytes.len() as u64) {
        length if length > MAX_FILE_BYTES => Err(LoadError::TooLarge { bytes: length }),
        _ => Ok(bytes),
    }
}

/// Reads a mesh from the bytes of a file; `extension` is the end of its name, in small letters. See [`load_mesh`].
///
/// # Errors
/// As [`load_mesh`].
pub fn read_mesh(bytes: Vec<u8>, extension: Option<&str>, scale: f64) -> Result<Mesh, LoadError> {
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(LoadError::Scale { scale });
    }
    if bytes.is_empty() {
        return Err(LoadError::Empty { instead: ", it is an empty file".to_owned() });
    }
    let format = format_of(&bytes, extension).ok_or(LoadError::Unknown)?;
    let mesh = match format {
        Format::StlText => stl::text(bytes),
        Format::StlBinary => stl::binary(bytes),
        Format::Obj => obj::read(&bytes),
        Format::Ply => ply::read(&bytes),
    }?;
    check_count("triangles", mesh.triangles.len(), MAX_TRIANGLES)?;
    if mesh.triangles.is_empty() {
        return Err(LoadError::Empty { instead: String::new() });
    }
    scaled(mesh, scale)
}

/// The format of a file: by its contents, else by the end of its name.
pub fn format_of(bytes: &[u8], extension: Option<&str>) -> Option<Format> {
    if ply::begins(bytes) {
        return Some(Format::Ply);
    }
    if stl::is_whole_binary(bytes) {
        return Some(Format::StlBinary);
    }
    if stl::begins_as_text(bytes) {
        return Some(Format::StlText);
    }
    if obj::begins(bytes) {
        return Some(Format::Obj);
    }
    match extension? {
        "stl" => Some(Format::StlBinary),
        "obj" => Some(Format::Obj),
        "ply" => Some(Format::Ply),
        _ => None,
    }
}

const ALLOWED: std::ops::RangeInclusive<f64> = -MAX_COORDINATE..=MAX_COORDINATE;

fn scaled(mut mesh: Mesh, scale: f64) -> Result<Mesh, LoadError> {
    for (vertex, place) in mesh.vertices.iter_mut().enumerate() {
        // adding zero takes the sign off a zero
        *place = *place * scale + DVec3::ZERO;
        if let Some(&value) = place.to_array().iter().find(|value| !ALLOWED.contains(value)) {
            return Err(LoadError::Coordinate { vertex, value });
        }
    }
    Ok(mesh)
}

fn check_count(what: &'static str, count: usize, most: usize) -> Result<(), LoadError> {
    if count > most { Err(LoadError::TooMany { what, count: count as u64, most }) } else { Ok(()) }
}

/// No line of a text file may be longer than [`MAX_LINE`].
fn check_lines(format: Format, bytes: &[u8]) -> Result<(), LoadError> {
    let longest = bytes.split(|&byte| byte == b'\n').enumerate().find(|(_, line)| line.len() > MAX_LINE);
    longest.map_or(Ok(()), |(index, line)| {
        let what = format!("line {} has {} bytes, allowed is up to {MAX_LINE}", index + 1, line.len());
        Err(LoadError::format(format, what))
    })
}

#[cfg(test)]
mod tests;

//! Reading STL files, ASCII or binary, from anywhere: bounded, and refused with the reason.
//!
//! The parser accepts what the format allows, which is more than a solid can use: not-a-number coordinates, no triangles at all,
//! lengths of any size. This module refuses those.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use glam::DVec3;

use crate::mesh::Mesh;

/// Largest file read \[bytes\]: 5 million binary triangles; a contact mesh has thousands.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// Most triangles: indices and edge tables of more would not fit a small machine's memory.
pub const MAX_TRIANGLES: usize = 5_000_000;

/// Largest coordinate \[file units, after scaling m\]: the core refuses distances beyond 1 km.
pub const MAX_COORDINATE: f64 = 1.0e3;

/// Why a file is no mesh.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The system would not give the file.
    #[error("cannot be opened: {0}")]
    Open(#[source] io::Error),
    /// The file is larger than [`MAX_FILE_BYTES`].
    #[error("is {bytes} bytes, allowed is up to {MAX_FILE_BYTES}: reduce the mesh")]
    TooLarge {
        /// Its size.
        bytes: u64,
    },
    /// The bytes are no STL.
    #[error("is no readable STL file: {0}")]
    Format(#[source] io::Error),
    /// Not one triangle.
    #[error("holds no triangle")]
    Empty,
    /// More triangles than [`MAX_TRIANGLES`].
    #[error("holds {triangles} triangles, allowed is up to {MAX_TRIANGLES}: reduce the mesh")]
    TooManyTriangles {
        /// Its triangles.
        triangles: usize,
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

/// Loads an STL file; `scale` takes the file's unit to metres.
///
/// # Errors
/// [`LoadError`] when it cannot be opened, is too large, is no STL, or holds nothing a solid can be made of.
pub fn load_stl(path: &Path, scale: f64) -> Result<Mesh, LoadError> {
    let file = File::open(path).map_err(LoadError::Open)?;
    let info = file.metadata().map_err(LoadError::Open)?;
    if !info.is_file() {
        return Err(LoadError::Open(io::Error::other("not a regular file")));
    }
    if info.len() > MAX_FILE_BYTES {
        return Err(LoadError::TooLarge { bytes: info.len() });
    }
    read_stl(&mut BufReader::new(file), scale)
}

/// Reads STL from bytes that can be rewound; see [`load_stl`].
///
/// # Errors
/// As [`load_stl`].
pub fn read_stl<R: Read + Seek>(reader: &mut R, scale: f64) -> Result<Mesh, LoadError> {
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(LoadError::Scale { scale });
    }
    let file = stl_io::read_stl(reader).map_err(LoadError::Format)?;
    if file.faces.is_empty() {
        return Err(LoadError::Empty);
    }
    if file.faces.len() > MAX_TRIANGLES {
        return Err(LoadError::TooManyTriangles { triangles: file.faces.len() });
    }
    let vertices = file.vertices.iter().enumerate().map(|(vertex, v)| position(vertex, v.0, scale));
    let vertices = vertices.collect::<Result<Vec<_>, _>>()?;
    // below MAX_TRIANGLES, so every index fits 32 bits
    let triangles = file.faces.iter().map(|face| face.vertices.map(|index| index as u32)).collect();
    Ok(Mesh { vertices, triangles })
}

const ALLOWED: std::ops::RangeInclusive<f64> = -MAX_COORDINATE..=MAX_COORDINATE;

fn position(vertex: usize, coordinates: [f32; 3], scale: f64) -> Result<DVec3, LoadError> {
    let scaled = coordinates.map(|value| f64::from(value) * scale);
    match scaled.iter().find(|value| !ALLOWED.contains(value)) {
        Some(&value) => Err(LoadError::Coordinate { vertex, value }),
        None => Ok(DVec3::from_array(scaled)),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn binary(triangles: &[[[f32; 3]; 3]], count: u32) -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes.extend(count.to_le_bytes());
        for corners in triangles {
            bytes.extend([0; 12]);
            bytes.extend(corners.iter().flatten().flat_map(|value| value.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_triangle_in_millimetres_becomes_metres() {
        let mesh = read_stl(&mut Cursor::new(binary(&[TRIANGLE], 1)), 0.001).unwrap();
        assert_eq!(mesh.triangles.len(), 1);
        assert!((mesh.area() - 0.5e-6).abs() < 1e-12);
    }

    #[test]
    fn ascii_is_read_too() {
        let text =
            "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n";
        assert_eq!(read_stl(&mut Cursor::new(text), 1.0).unwrap().triangles.len(), 1);
    }

    #[test]
    fn what_no_solid_can_use_is_refused_with_the_reason() {
        let nan = [[f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let far = [[2.0e3, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let table: [(&str, Vec<u8>, f64, &str); 7] = [
            ("nothing", vec![], 1.0, "no readable STL"),
            ("text", b"hello".to_vec(), 1.0, "no readable STL"),
            ("no triangles", binary(&[], 0), 1.0, "no triangle"),
            ("count beyond the data", binary(&[TRIANGLE], 4_000_000_000), 1.0, "no readable STL"),
            ("not a number", binary(&[nan], 1), 1.0, "coordinate NaN"),
            ("too far", binary(&[far], 1), 1.0, "check the scale"),
            ("no scale", binary(&[TRIANGLE], 1), 0.0, "scale 0"),
        ];
        for (name, bytes, scale, part) in table {
            let message = read_stl(&mut Cursor::new(bytes), scale).unwrap_err().to_string();
            assert!(message.contains(part), "{name}: {message}");
        }
    }
}

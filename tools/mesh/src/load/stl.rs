//! STL through `stl_io`, once what it cannot know has been settled.
//!
//! It tells ASCII from binary by the first line, which a binary header may imitate, and reads one solid of an ASCII file, in small letters, whose
//! first line has a blank. So a binary header is blanked out, letters are made small, and each solid of a file is handed over on its own.

use std::io::{Cursor, Read, Seek};

use glam::DVec3;

use super::{Format, LoadError, MAX_TRIANGLES, check_count, check_lines};
use crate::mesh::Mesh;

/// Header, count.
const HEAD: usize = 84;
/// Bytes of the header before the count.
const COUNT_AT: usize = 80;
/// Normal, three corners, attribute.
const TRIANGLE: usize = 50;
/// What `stl_io` asks the first line of an ASCII solid to begin with.
const SOLID: &[u8] = b"solid ";

/// Is it a binary file that is as long as its count says?
pub(super) fn is_whole_binary(bytes: &[u8]) -> bool {
    promised(bytes).is_some_and(|triangles| triangles > 0 && length(triangles) == bytes.len() as u64)
}

/// Does it begin as an ASCII solid does, and hold text?
pub(super) fn begins_as_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let word = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    word && start.get(5).is_none_or(u8::is_ascii_whitespace) && !bytes[..bytes.len().min(1024)].contains(&0)
}

/// Triangles that a binary header promises.
fn promised(bytes: &[u8]) -> Option<u32> {
    let four = bytes.get(COUNT_AT..HEAD)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

fn length(triangles: u32) -> u64 {
    HEAD as u64 + TRIANGLE as u64 * u64::from(triangles)
}

/// Reads a binary file.
pub(super) fn binary(mut bytes: Vec<u8>) -> Result<Mesh, LoadError> {
    let wrong = |what: String| LoadError::format(Format::StlBinary, what);
    let Some(triangles) = promised(&bytes) else {
        return Err(wrong(format!("it has {} bytes, a header alone has {HEAD}", bytes.len())));
    };
    if length(triangles) > bytes.len() as u64 {
        let (needed, found) = (length(triangles), bytes.len());
        return Err(wrong(format!(
            "its header promises {triangles} triangles in {needed} bytes, the file has {found}: it is cut short, or no STL; export it again"
        )));
    }
    check_count("triangles", triangles as usize, MAX_TRIANGLES)?;
    if triangles == 0 && bytes.len() > HEAD {
        return Err(wrong(format!("its header promises no triangle and {} bytes follow; export it again", bytes.len() - HEAD)));
    }
    bytes[..COUNT_AT].fill(b' ');
    bytes[COUNT_AT - 1] = b'\n';
    let mut mesh = Mesh::default();
    append(&mut mesh, &mut Cursor::new(bytes), Format::StlBinary)?;
    Ok(mesh)
}

/// Reads an ASCII file: every solid in it.
pub(super) fn text(mut bytes: Vec<u8>) -> Result<Mesh, LoadError> {
    check_lines(Format::StlText, &bytes)?;
    bytes.make_ascii_lowercase();
    let mut mesh = Mesh::default();
    let mut rest = bytes.trim_ascii();
    while !rest.is_empty() {
        let (body, after) = solid(rest)?;
        append(&mut mesh, &mut Cursor::new([SOLID, body].concat()), Format::StlText)?;
        rest = after.trim_ascii_start();
    }
    Ok(mesh)
}

/// The first solid of `text` from the end of its first word on, and what follows it.
fn solid(text: &[u8]) -> Result<(&[u8], &[u8]), LoadError> {
    let Some(body) = text.strip_prefix(b"solid") else {
        let found = String::from_utf8_lossy(&text[..text.len().min(20)]);
        return Err(LoadError::format(
            Format::StlText,
            format!("after a solid's end follows {found:?}, allowed is another solid"),
        ));
    };
    let mut end = 0;
    for line in body.split_inclusive(|&byte| byte == b'\n') {
        end += line.len();
        if line.trim_ascii_start().starts_with(b"endsolid") {
            break;
        }
    }
    Ok(body.split_at(end))
}

fn append<R: Read + Seek>(mesh: &mut Mesh, reader: &mut R, format: Format) -> Result<(), LoadError> {
    let wrong = |error: std::io::Error| LoadError::format(format, error);
    for triangle in stl_io::create_stl_reader(reader).map_err(wrong)? {
        let triangle = triangle.map_err(wrong)?;
        check_count("triangles", mesh.triangles.len() + 1, MAX_TRIANGLES)?;
        // three times the most triangles fit 32 bits
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(triangle.vertices.map(|corner| DVec3::from_array(corner.0.map(f64::from))));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(())
}

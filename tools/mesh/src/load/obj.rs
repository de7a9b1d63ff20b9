//! OBJ through `tobj`, which is shown the corners and faces only.
//!
//! Everything else is kept from it: groups and materials would part the mesh, the indices of textures and normals it multiplies unchecked, and
//! comments need not be UTF-8.

use std::io::{self, BufRead, Read};

use glam::DVec3;
use tobj::LoadOptions;

use super::{Format, LoadError, MAX_TRIANGLES, MAX_VERTICES, check_count, check_lines, polygon};
use crate::mesh::Mesh;

/// Words that begin a line of an OBJ file, as they are found near its start.
const WORDS: [&[u8]; 10] = [b"v", b"vt", b"vn", b"f", b"o", b"g", b"s", b"l", b"mtllib", b"usemtl"];

/// Lines looked at to tell an OBJ file: exporters write long comments.
const LOOK: usize = 64;

/// Is the first line that is no comment an OBJ file's?
pub(super) fn begins(bytes: &[u8]) -> bool {
    let lines = bytes.split(|&byte| byte == b'\n').take(LOOK).map(<[u8]>::trim_ascii);
    let mut told = lines.filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    told.next().is_some_and(|line| WORDS.contains(&word(line).0))
}

/// The first word of a line and the rest.
fn word(line: &[u8]) -> (&[u8], &[u8]) {
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    line.split_at(end)
}

/// Reads a file.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, LoadError> {
    check_lines(Format::Obj, bytes)?;
    let mut wanted = Wanted { rest: bytes, ..Wanted::default() };
    let options = LoadOptions { single_index: true, ..LoadOptions::default() };
    let read = tobj::load_obj_buf(&mut wanted, &options, |_| Err(tobj::LoadError::GenericFailure));
    wanted.check_counts()?;
    let models = match read {
        Ok((models, _)) => models,
        Err(error @ tobj::LoadError::FaceVertexOutOfBounds) => {
            let what =
                format!("{error}: a face names a vertex that is not among the file's {}; export it again", wanted.vertices);
            return Err(LoadError::format(Format::Obj, what));
        }
        Err(error) => return Err(LoadError::format(Format::Obj, format!("line {}: {error}", wanted.line_number))),
    };
    let mut mesh = Mesh::default();
    for model in &models {
        append(&mut mesh, &model.mesh)?;
    }
    if mesh.triangles.is_empty() {
        return Err(LoadError::Empty { instead: wanted.instead() });
    }
    Ok(mesh)
}

fn append(mesh: &mut Mesh, model: &tobj::Mesh) -> Result<(), LoadError> {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(model.positions.chunks_exact(3).map(DVec3::from_slice));
    let mut rest = model.indices.as_slice();
    // no arities: every face has three corners
    let arities = model.face_arities.iter().map(|&arity| arity as usize).chain(std::iter::repeat(3));
    for arity in arities {
        let Some((corners, after)) = rest.split_at_checked(arity).filter(|(corners, _)| !corners.is_empty()) else { break };
        let corners: Vec<u32> = corners.iter().map(|&corner| first + corner).collect();
        polygon::append(mesh, &corners);
        check_count("triangles", mesh.triangles.len(), MAX_TRIANGLES)?;
        rest = after;
    }
    Ok(())
}

/// The lines of a file that the parser is shown.
#[derive(Default)]
struct Wanted<'a> {
    rest: &'a [u8],
    line: Vec<u8>,
    at: usize,
    line_number: usize,
    vertices: usize,
    faces: usize,
    /// Lines and points, which make no surface.
    others: usize,
}

impl Wanted<'_> {
    /// Takes the next line of the file.
    fn advance(&mut self) {
        let end = self.rest.iter().position(|&byte| byte == b'\n').map_or(self.rest.len(), |at| at + 1);
        let (line, rest) = self.rest.split_at(end);
        (self.rest, self.line_number, self.at) = (rest, self.line_number + 1, 0);
        self.line.clear();
        let (name, values) = word(line.trim_ascii());
        match name {
            b"v" => {
                self.vertices += 1;
                self.line.extend(b"v");
                // x, y, z, and w only where no colour follows
                let words: Vec<&[u8]> = words(values).collect();
                let count = if words.len() == 4 { 4 } else { words.len().min(3) };
                words[..count].iter().for_each(|value| self.push(value));
            }
            b"f" => {
                self.faces += 1;
                self.line.extend(b"f");
                words(values).for_each(|corner| self.push(corner.split(|&byte| byte == b'/').next().unwrap_or_default()));
            }
            b"l" | b"p" => self.others += 1,
            _ => {}
        }
        self.line.push(b'\n');
    }

    fn push(&mut self, value: &[u8]) {
        self.line.push(b' ');
        self.line.extend(value);
    }

    fn check_counts(&self) -> Result<(), LoadError> {
        check_count("faces", self.faces, MAX_TRIANGLES)?;
        check_count("vertices", self.vertices, MAX_VERTICES)
    }

    fn instead(&self) -> String {
        format!(
            ", but {} vertices, {} faces of fewer than three corners and {} lines or points",
            self.vertices, self.faces, self.others
        )
    }
}

fn words(values: &[u8]) -> impl Iterator<Item = &[u8]> {
    values.split(u8::is_ascii_whitespace).filter(|value| !value.is_empty())
}

impl BufRead for Wanted<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.line.len() && !self.rest.is_empty() {
            self.advance();
            // said in full once the parser has given up
            self.check_counts().map_err(|_| io::Error::other("too many"))?;
        }
        Ok(&self.line[self.at..])
    }

    fn consume(&mut self, bytes: usize) {
        self.at += bytes;
    }
}

impl Read for Wanted<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(out)?;
        self.consume(read);
        Ok(read)
    }
}

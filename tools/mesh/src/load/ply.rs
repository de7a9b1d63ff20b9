//! PLY through `ply-rs-bw`, record by record, once its header's counts have been held against the file's length.
//!
//! Read are the element `vertex` with x, y, z of any number type and the element `face` with the list `vertex_indices` or `vertex_index`;
//! others are read over.

use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};

use super::{Format, LoadError, MAX_LINE, MAX_TRIANGLES, MAX_VERTICES, check_count, polygon};
use crate::mesh::Mesh;

/// Longest header \[bytes\]: those of scanners with their comments have a few kilobytes.
const MAX_HEADER: usize = 64 << 10;

/// Does it begin as a PLY file does?
pub(super) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

fn wrong(what: impl std::fmt::Display) -> LoadError {
    LoadError::format(Format::Ply, what)
}

/// Reads a file.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, LoadError> {
    let head = &bytes[..bytes.len().min(MAX_HEADER)];
    const END: &[u8] = b"end_header";
    if !head.windows(END.len()).any(|window| window == END) {
        return Err(wrong(format!("no end_header within its first {MAX_HEADER} bytes; export it again")));
    }
    let parser = Parser::<Record>::new();
    let mut reader = Reader::new(bytes);
    let header = parser.read_header(&mut reader).map_err(wrong)?;
    let mut file = Body { parser, encoding: header.encoding, rest: reader.into_inner(), mesh: Mesh::default(), faces: 0 };
    check_elements(&header)?;
    for element in header.elements.values() {
        file.read(element)?;
    }
    if file.mesh.triangles.is_empty() {
        let instead = format!(", but {} vertices and {} faces", file.mesh.vertices.len(), file.faces);
        return Err(LoadError::Empty { instead });
    }
    Ok(file.mesh)
}

/// Vertices come first, with x, y, z; faces have corners.
fn check_elements(header: &Header) -> Result<(), LoadError> {
    let has = |element: &ElementDef, names: &[&str]| names.iter().any(|&name| element.properties.contains_key(name));
    let Some(vertex) = header.elements.get("vertex") else {
        return Err(wrong("it has no element vertex"));
    };
    if let Some(missing) = ["x", "y", "z"].iter().find(|name| !has(vertex, &[name])) {
        return Err(wrong(format!("its vertices have no {missing}")));
    }
    check_count("vertices", vertex.count, MAX_VERTICES)?;
    let Some(face) = header.elements.get("face") else {
        let strips = if header.elements.contains_key("tristrips") { " and triangle strips" } else { "" };
        return Err(LoadError::Empty { instead: format!(", but {} vertices{strips}", vertex.count) });
    };
    if face.count > 0 && !has(face, &["vertex_indices", "vertex_index"]) {
        return Err(wrong("its faces have no vertex_indices"));
    }
    check_count("faces", face.count, MAX_TRIANGLES)?;
    if header.elements.get_index_of("face") < header.elements.get_index_of("vertex") {
        return Err(wrong("its faces come before its vertices"));
    }
    Ok(())
}

/// What follows the header, as far as it has not been read, and what was read.
struct Body<'a> {
    parser: Parser<Record>,
    encoding: Encoding,
    rest: &'a [u8],
    mesh: Mesh,
    faces: usize,
}

impl Body<'_> {
    fn read(&mut self, element: &ElementDef) -> Result<(), LoadError> {
        self.check_length(element)?;
        // records without a property take no bytes
        if element.properties.is_empty() && self.encoding != Encoding::Ascii {
            return Ok(());
        }
        for index in 0..element.count {
            let record = self.record(element).map_err(|what| wrong(format!("{} {index}: {what}", element.name)))?;
            match element.name.as_str() {
                "vertex" => self.mesh.vertices.push(record.place),
                "face" => self.face(index, &record.corners)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// So many records take at least so many bytes: a count that the file cannot hold is refused before anything is read.
    fn check_length(&self, element: &ElementDef) -> Result<(), LoadError> {
        let least: u64 = element.properties.values().map(|property| least(&property.data_type, self.encoding)).sum();
        let needed = least.saturating_mul(element.count as u64);
        // the last line of a text may lack its end
        if needed <= self.rest.len() as u64 + 1 {
            return Ok(());
        }
        let (name, count, found) = (&element.name, element.count, self.rest.len());
        Err(wrong(format!(
            "its header promises {count} of {name} in {needed} bytes or more, {found} follow: it is cut short; export it again"
        )))
    }

    fn record(&mut self, element: &ElementDef) -> Result<Record, String> {
        let read = match self.encoding {
            Encoding::Ascii => self.parser.read_ascii_element(line(&mut self.rest)?, element),
            Encoding::BinaryBigEndian => self.parser.read_big_endian_element(&mut self.rest, element),
            Encoding::BinaryLittleEndian => self.parser.read_little_endian_element(&mut self.rest, element),
        };
        read.map_err(|error| error.to_string())
    }

    fn face(&mut self, face: usize, corners: &[i64]) -> Result<(), LoadError> {
        let vertices = self.mesh.vertices.len();
        if let Some(&vertex) = corners.iter().find(|&&corner| usize::try_from(corner).is_ok_and(|c| c < vertices).eq(&false)) {
            return Err(LoadError::Corner { face, vertex, vertices });
        }
        let corners: Vec<u32> = corners.iter().map(|&corner| corner as u32).collect();
        polygon::append(&mut self.mesh, &corners);
        self.faces += 1;
        check_count("triangles", self.mesh.triangles.len(), MAX_TRIANGLES)
    }
}

/// Takes the next line of a text.
fn line<'a>(rest: &mut &'a [u8]) -> Result<&'a str, String> {
    let end = rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |at| at + 1);
    if end == 0 || end > MAX_LINE {
        return Err(if end == 0 {
            "the file ends".to_owned()
        } else {
            format!("a line of {end} bytes, allowed is up to {MAX_LINE}")
        });
    }
    let (line, after) = rest.split_at(end);
    *rest = after;
    std::str::from_utf8(line).map(str::trim).map_err(|error| error.to_string())
}

/// Fewest bytes of a property: of a list, its length.
fn least(property: &PropertyType, encoding: Encoding) -> u64 {
    let (PropertyType::Scalar(kind) | PropertyType::List(kind, _)) = property;
    match (encoding, kind) {
        // a digit and what parts it from the next
        (Encoding::Ascii, _) => 2,
        (_, ScalarType::Char | ScalarType::UChar) => 1,
        (_, ScalarType::Short | ScalarType::UShort) => 2,
        (_, ScalarType::Int | ScalarType::UInt | ScalarType::Float) => 4,
        (_, ScalarType::Double) => 8,
    }
}

/// What is kept of a record.
#[derive(Default)]
struct Record {
    place: DVec3,
    corners: Vec<i64>,
}

impl PropertyAccess for Record {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "x" | "y" | "z" => match number(&property) {
                Some(value) => self.place["xyz".find(name).unwrap_or_default()] = value,
                None => return PropertyAccessResult::UnsupportedType,
            },
            "vertex_indices" | "vertex_index" => match whole(&property) {
                Some(values) => self.corners = values,
                None => return PropertyAccessResult::UnsupportedType,
            },
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

fn number(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(value) => f64::from(value),
        Property::UChar(value) => f64::from(value),
        Property::Short(value) => f64::from(value),
        Property::UShort(value) => f64::from(value),
        Property::Int(value) => f64::from(value),
        Property::UInt(value) => f64::from(value),
        Property::Float(value) => f64::from(value),
        Property::Double(value) => value,
        _ => return None,
    })
}

fn whole(property: &Property) -> Option<Vec<i64>> {
    fn wide<T: Copy + Into<i64>>(values: &[T]) -> Option<Vec<i64>> {
        Some(values.iter().map(|&value| value.into()).collect())
    }
    match property {
        Property::ListChar(values) => wide(values),
        Property::ListUChar(values) => wide(values),
        Property::ListShort(values) => wide(values),
        Property::ListUShort(values) => wide(values),
        Property::ListInt(values) => wide(values),
        Property::ListUInt(values) => wide(values),
        _ => None,
    }
}

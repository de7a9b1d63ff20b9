//! Writing a mesh in metres: binary STL (corners in f32, normals by the triangles' own turn), binary PLY (f32), OBJ (text, every digit).

use std::io::{self, Write};

use stl_io::{Normal, Triangle, Vertex};

use crate::mesh::{Mesh, twice_area};

/// Writes `mesh` \[m\].
///
/// # Errors
/// Those of the writer.
pub fn write_stl(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let narrow = |v: glam::DVec3| v.as_vec3().to_array();
    let triangle = |&triangle: &[u32; 3]| {
        let corners = mesh.corners(triangle);
        Triangle {
            normal: Normal::new(narrow(twice_area(corners).normalize_or_zero())),
            vertices: corners.map(|v| Vertex::new(narrow(v))),
        }
    };
    let triangles: Vec<Triangle> = mesh.triangles.iter().map(triangle).collect();
    stl_io::write_stl(out, triangles.iter())
}

/// Writes `mesh` \[m\] as binary PLY.
///
/// # Errors
/// Those of the writer.
pub fn write_ply(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    write!(out, "ply\nformat binary_little_endian 1.0\ncomment haptor: m\nelement vertex {vertices}\n")?;
    write!(out, "property float x\nproperty float y\nproperty float z\n")?;
    write!(out, "element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n")?;
    for vertex in &mesh.vertices {
        out.write_all(vertex.as_vec3().to_array().map(f32::to_le_bytes).as_flattened())?;
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        out.write_all(triangle.map(u32::to_le_bytes).as_flattened())?;
    }
    Ok(())
}

/// Writes `mesh` \[m\] as OBJ.
///
/// # Errors
/// Those of the writer.
pub fn write_obj(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "# haptor: m")?;
    for vertex in &mesh.vertices {
        writeln!(out, "v {} {} {}", vertex.x, vertex.y, vertex.z)?;
    }
    mesh.triangles.iter().try_for_each(|[a, b, c]| writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1))
}

/// The bytes of `mesh` \[m\] in the format that the end of a file's name asks for, in small letters: `stl`, `ply` or `obj`; `None` for others.
pub fn save_as(mesh: &Mesh, extension: Option<&str>) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let written = match extension? {
        "stl" => write_stl(mesh, &mut bytes),
        "ply" => write_ply(mesh, &mut bytes),
        "obj" => write_obj(mesh, &mut bytes),
        _ => return None,
    };
    // a vector takes whatever is written
    written.ok().map(|()| bytes)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{check, properties, read_mesh, tessellate, weld};

    #[test]
    fn what_is_written_reads_back_as_the_same_solid() {
        let mesh = tessellate::ellipsoid(DVec3::new(0.02, 0.03, 0.04), 48);
        for extension in ["stl", "ply", "obj"] {
            let file = save_as(&mesh, Some(extension)).unwrap();
            let back = weld(&read_mesh(file, None, 1.0).unwrap(), None);
            assert!(check(&back).is_solid(), "{extension}: {:?}", check(&back));
            assert_eq!(back.triangles.len(), mesh.triangles.len());
            let (one, other) = (properties(&mesh).unwrap().volume, properties(&back).unwrap().volume);
            assert!((one / other - 1.0).abs() < 1e-6, "{extension}: {one} {other}");
        }
        assert_eq!(save_as(&mesh, Some("step")), None);
    }
}

//! Writing a mesh as binary STL: corners in f32, normals by the triangles' own turn.

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

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{check, properties, read_mesh, tessellate, weld};

    #[test]
    fn what_is_written_reads_back_as_the_same_solid() {
        let mesh = tessellate::ellipsoid(DVec3::new(0.02, 0.03, 0.04), 48);
        let mut file = Vec::new();
        write_stl(&mesh, &mut file).unwrap();
        let back = weld(&read_mesh(file, None, 1.0).unwrap(), None);
        assert!(check(&back).is_solid(), "{:?}", check(&back));
        assert_eq!(back.triangles.len(), mesh.triangles.len());
        let (one, other) = (properties(&mesh).unwrap().volume, properties(&back).unwrap().volume);
        assert!((one / other - 1.0).abs() < 1e-6, "{one} {other}");
    }
}

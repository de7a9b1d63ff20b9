//! Meshes to look at, behind the scene of a baked file: the host feels a mesh by its distance grid and passes these over; a viewer that has only the
//! file, or a recording, draws them.

use haptor_mesh::{DVec3, Mesh};
use haptor_wire::scene_file::{self, SceneFileError};
use haptor_wire::sections::{MAX_SECTION, SKIN};

/// Bytes of a vertex or a triangle: three f32, three u32.
const TRIPLE: usize = 12;

/// The contents of a mesh's section; `None` when it is too large for one and cannot be carried.
pub fn contents(mesh: &Mesh) -> Option<Vec<u8>> {
    let length = 4 + TRIPLE * (mesh.vertices.len() + mesh.triangles.len());
    if length > MAX_SECTION {
        return None;
    }
    let mut bytes = Vec::with_capacity(length);
    bytes.extend((mesh.vertices.len() as u32).to_le_bytes());
    bytes.extend(mesh.vertices.iter().flat_map(|v| v.as_vec3().to_array()).flat_map(f32::to_le_bytes));
    bytes.extend(mesh.triangles.iter().flatten().flat_map(|index| index.to_le_bytes()));
    Some(bytes)
}

/// The meshes that a baked file carries, as its shapes number them; one that is damaged is empty.
///
/// # Errors
/// [`SceneFileError`] when the file is none, or a section's checksum is wrong.
pub fn read(file: &[u8]) -> Result<Vec<Mesh>, SceneFileError> {
    let mut skins = Vec::new();
    for section in scene_file::sections(file)? {
        let section = section?;
        if section.kind == SKIN {
            skins.push(mesh(section.contents).unwrap_or_default());
        }
    }
    Ok(skins)
}

fn mesh(contents: &[u8]) -> Option<Mesh> {
    let (count, rest) = contents.split_first_chunk::<4>()?;
    let count = usize::try_from(u32::from_le_bytes(*count)).ok()?;
    let (vertices, triangles) = rest.split_at_checked(count.checked_mul(TRIPLE)?)?;
    let vertices: Vec<_> = triples(vertices)?.map(|v| DVec3::from_array(v.map(|bits| f64::from(f32::from_bits(bits))))).collect();
    let triangles: Vec<_> = triples(triangles)?.collect();
    let good = vertices.iter().all(|v| v.is_finite()) && triangles.iter().flatten().all(|&index| (index as usize) < count);
    good.then_some(Mesh { vertices, triangles })
}

/// Three words of 32 bits each time; `None` when bytes are left over.
fn triples(bytes: &[u8]) -> Option<impl Iterator<Item = [u32; 3]> + '_> {
    let (words, rest) = bytes.as_chunks::<4>();
    let (triples, left) = words.as_chunks::<3>();
    (rest.is_empty() && left.is_empty()).then(|| triples.iter().map(|triple| triple.map(u32::from_le_bytes)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_mesh::tessellate;

    #[test]
    fn a_mesh_comes_back_and_damage_is_nothing() {
        let ball = tessellate::ellipsoid(DVec3::new(0.5, 0.25, 0.125), 8).mapped(|v| v.as_vec3().as_dvec3());
        let bytes = contents(&ball).unwrap();
        assert_eq!(mesh(&bytes), Some(ball.clone()));
        assert_eq!(mesh(&bytes[..bytes.len() - 1]), None);
        assert_eq!(mesh(&bytes[..3]), None);
        let mut wild = bytes.clone();
        let end = wild.len();
        wild[end - 4..].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(mesh(&wild), None);
        wild[..4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(mesh(&wild), None);
    }
}

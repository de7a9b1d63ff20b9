//! Mesh files, and the bodies that small ones become.

use haptor_mesh::body::{Recipe, Role, make};
use haptor_mesh::{BakeSpec, Mesh, read_mesh};

/// Triangles of a mesh at most that is made into a body: baking looks at all of them from every node of its grid.
const MOST_TRIANGLES: usize = 64;

/// A coarse grid: the fineness adds time and no other path.
const COARSE: BakeSpec = BakeSpec { cells: 8, samples: 16 };

/// As STL, whatever it is not told apart from.
pub fn stl(bytes: &[u8]) {
    read(bytes, "stl");
}

/// As OBJ.
pub fn obj(bytes: &[u8]) {
    read(bytes, "obj");
}

/// As PLY.
pub fn ply(bytes: &[u8]) {
    read(bytes, "ply");
}

fn read(bytes: &[u8], extension: &str) {
    let Ok(mesh) = read_mesh(bytes.to_vec(), Some(extension), 1.0) else { return };
    check(&mesh);
    if mesh.triangles.len() > MOST_TRIANGLES {
        return;
    }
    for mend in [false, true] {
        let recipe = Recipe { scale: 1.0, role: Role::Object, mend, bake: COARSE };
        let Ok(body) = make(&mesh, &recipe, &mut |_| {}) else { continue };
        for part in &body.parts {
            let _ = part.baked.shape();
        }
    }
}

/// Triangles have corners, corners have places.
fn check(mesh: &Mesh) {
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.vertices.iter().all(|place| place.is_finite()));
    assert!(mesh.triangles.iter().flatten().all(|&corner| (corner as usize) < mesh.vertices.len()));
}

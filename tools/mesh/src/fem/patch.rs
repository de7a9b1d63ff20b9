//! A bonded rigid patch on the top of a quarter body, moved by one unit: its stiffness.
//!
//! On a curved body the half space leaves tractions beside the contact that grow towards it, so that the remainder is not smooth.
//! Instead the patch itself is meshed, with bricks graded towards its edge. The edge's singular stresses cost the same share on a
//! flat body cut in the same way, whose compliance is known from the remainder: the difference of the two is what is used.

use super::FemError;
use super::bricks::{Bricks, Skin};
use super::element::Lame;
use super::system::Stiffness;
use super::{Direction, mirrors};

/// Stiffness of the patch of radius `radius` about the z axis, for each of `directions`; shear modulus 1.
pub(super) fn stiffnesses(
    mesh: &Bricks,
    radius: f64,
    nu: f64,
    directions: &[Direction],
    progress: &mut dyn FnMut(u32),
) -> Result<Vec<f64>, FemError> {
    let stiffness = Stiffness::new(mesh, Lame::of_unit_shear(nu))?;
    let mut found = Vec::new();
    for &direction in directions {
        let mut held = mirrors(mesh, direction);
        let mut u = vec![0.0; held.len()];
        for face in &mesh.faces {
            for &node in &face.nodes {
                let start = 3 * node as usize;
                let at = mesh.nodes[node as usize];
                let bonded = face.skin == Skin::Contact && at.x.hypot(at.y) <= radius * (1.0 + 1.0e-6);
                if bonded {
                    u[start..start + 3].copy_from_slice(&direction.rigid(at).to_array());
                }
                if bonded || face.skin == Skin::Base {
                    held[start..start + 3].fill(true);
                }
            }
        }
        let load = vec![0.0; held.len()];
        let moved = stiffness.factor(&held)?.solve(&load, &u);
        let energy: f64 = stiffness.times(&moved).iter().zip(&moved).map(|(force, u)| force * u).sum();
        found.push(4.0 * energy);
        progress(1);
    }
    Ok(found)
}

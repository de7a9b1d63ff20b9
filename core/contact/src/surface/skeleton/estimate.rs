//! Compliance of a body from its beam alone, for bodies that neither a closed form nor finite elements know.
//!
//! The cantilever from the base to the contact, with the section of every height, gives shear, bending, torsion and length. The half space that
//! the contact's own stiffness counts already takes part of it away: [`DRAG_SHARE`] and [`TWIST_SHARE`] remain (PHYSICS 3.1). How far the estimates are
//! from finite elements is in theory.md, section 9.2.

use glam::{Vec2, Vec3};

use crate::math::{clamp, max, min};
use crate::model::{Compliance, Material, ObjectShape};
use crate::surface::section::Section;

/// Share of the beam's drag compliance that is not the half space's.
pub const DRAG_SHARE: f32 = 0.77;

/// Share of the beam's twist compliance that is not the half space's.
pub const TWIST_SHARE: f32 = 0.67;

/// Slices of the beam: twice as many change the estimate of a sphere by less than 1 %.
const SLICES: usize = 24;

/// Narrowest section that counts, over the widest: nearer to a pole the patch's own half space stands for the body.
const NARROWEST: f32 = 0.75;

/// Sums over the beam from the base to the contact, each per unit load.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Lateral by shear and bending along x and along y, axial \[m/N\].
    lateral: Vec2,
    axial: f32,
    /// Torsion and bending rotation \[rad/(N m)\].
    torsion: f32,
    bending: Vec2,
}

impl Sums {
    fn over(object: &ObjectShape<'_>, section: &Section, material: &Material, base: f32, top: f32) -> Self {
        let (e, g) = (material.young_modulus, material.shear_modulus());
        let slice = (top - base) / SLICES as f32;
        let mut sums = Self::default();
        for i in 0..SLICES {
            let z = base + (i as f32 + 0.5) * slice;
            let here = section.scaled(max(Section::width_at(object, z), NARROWEST));
            let arm = top - z;
            let bent = Vec2::new(slice / (e * here.bending.x), slice / (e * here.bending.y));
            sums.lateral += bent * (arm * arm) + Vec2::splat(slice / (g * here.area));
            sums.bending += bent;
            sums.axial += slice / (e * here.area);
            sums.torsion += slice / (g * here.torsion);
        }
        sums
    }
}

/// The beam's estimate at a contact `p_wc` with the outward normal `n` on a body held below `base`; nothing for a half space.
///
/// On top the normal compliance is nothing, as finite elements find; on a side the beam bends under the load. Between, by the square
/// of the normal's height.
pub fn estimate(object: &ObjectShape<'_>, material: &Material, base: f32, p_wc: Vec3, n: Vec3) -> Compliance {
    let Some(section) = Section::of(object) else { return Compliance::default() };
    if p_wc.z <= base {
        return Compliance::default();
    }
    let sums = Sums::over(object, &section, material, base, p_wc.z);
    let lateral = 0.5 * (sums.lateral.x + sums.lateral.y);
    let top = Compliance { normal: 0.0, drag: DRAG_SHARE * lateral, twist: TWIST_SHARE * sums.torsion };
    let side = Compliance {
        normal: DRAG_SHARE * lateral,
        drag: DRAG_SHARE * 0.5 * (lateral + sums.axial),
        twist: TWIST_SHARE * min(sums.bending.x, sums.bending.y),
    };
    let up = clamp(n.z * n.z, 0.0, 1.0);
    let mix = |top: f32, side: f32| up * top + (1.0 - up) * side;
    Compliance { normal: mix(top.normal, side.normal), drag: mix(top.drag, side.drag), twist: mix(top.twist, side.twist) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Estimates in units of finite elements, drag and twist, at the top.
    fn over_finite_elements(object: ObjectShape<'_>, length: f32, drag: f32, twist: f32) -> (f32, f32) {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let (base, top) = (object.default_fixed_below(), Vec3::Z * object.height());
        let found = estimate(&object, &material, base, top, Vec3::Z);
        (found.drag * 1.0e6 * length / drag, found.twist * 1.0e6 * length * length * length / twist)
    }

    #[test]
    fn estimates_are_as_far_from_finite_elements_as_theory_says() {
        // C_t G L and C_theta G L^3 at nu = 0.5 (tools/mesh/FEM.md, body.rs), and the estimates over them
        let cases = [
            (ObjectShape::Box { size: Vec3::splat(0.1) }, 0.1, (1.79, 4.75), (1.00, 1.00)),
            (ObjectShape::Box { size: Vec3::new(0.05, 0.05, 0.1) }, 0.05, (11.40, 11.73), (0.86, 0.81)),
            (ObjectShape::Cylinder { radius: 0.05, height: 0.1 }, 0.05, (1.408, 0.889), (0.97, 0.96)),
            (ObjectShape::Cylinder { radius: 0.02, height: 0.08 }, 0.02, (9.42, 2.162), (0.84, 0.79)),
            (ObjectShape::Sphere { radius: 0.05 }, 0.05, (2.75, 1.15), (0.59, 1.23)),
        ];
        for (object, length, (drag, twist), expected) in cases {
            let found = over_finite_elements(object, length, drag, twist);
            let off = (found.0 - expected.0).abs().max((found.1 - expected.1).abs());
            assert!(off < 0.01, "{object:?} {found:?}");
        }
        // the cube's side at mid height
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let side = estimate(&cube, &material, 0.0, Vec3::new(0.05, 0.0, 0.05), Vec3::X);
        let found = [side.normal * 1.0e5 / 0.43, side.drag * 1.0e5 / 0.538, side.twist * 1.0e3 / 1.585];
        assert!(found.iter().zip([1.19, 0.60, 0.85]).all(|(x, expected)| (x - expected).abs() < 0.01), "{found:?}");
        assert_eq!(estimate(&ObjectShape::HalfSpace, &material, 0.0, Vec3::Z, Vec3::Z), Compliance::default());
    }
}

//! Compliance of the object's body beyond the half space's (PHYSICS 3.1; theory.md, section 7).
//!
//! A force at a contact also shears, bends and twists the whole body down to its fixed base. In series with the local
//! stiffness: 1/K = 1/K_local + C. The closed forms are those of the calibrated shapes; the rest is a beam from the contact to
//! the base, scaled by the factors that finite elements gave for the cube (0.67 in twist, 0.77 in drag).

use glam::Vec3;

use crate::math::{PI, clamp, max, min};
use crate::model::{Compliance, Model, ObjectShape};

/// Share of the beam's torsion that finite elements find beyond the half space.
const TWIST_SHARE: f32 = 0.67;
/// Share of the beam's shear and bending.
const DRAG_SHARE: f32 = 0.77;

/// Section and length of the beam from the contact to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Beam {
    length: f32,
    area: f32,
    /// Torsion constant \[m^4\].
    torsion: f32,
    /// Second moments of area against bending along x and along y \[m^4\].
    bending: (f32, f32),
}

/// Compliance at a patch with centre `p_wc`, outward normal `n` and contact radius `a`.
pub fn compliance(model: &Model<'_>, p_wc: Vec3, n: Vec3, a: f32) -> Compliance {
    if let Some(given) = model.compliance {
        return given;
    }
    let g = model.material.shear_modulus();
    let nu = model.material.poisson_ratio;
    let height = max(p_wc.z - model.fixed_below, 0.0);
    match model.object {
        ObjectShape::HalfSpace => Compliance::default(),
        ObjectShape::Box { size } => of_column(box_beam(size, height), min(size.x, size.y), g, nu, n, a),
        ObjectShape::Cylinder { radius, .. } => {
            let width = 2.0 * radius;
            of_column(ellipse_beam(radius, radius, height), width, g, nu, n, a)
        }
        ObjectShape::Sphere { radius } => of_round(Vec3::splat(radius), height, g, nu, n),
        ObjectShape::Ellipsoid { semi_axes } => of_round(semi_axes, height, g, nu, n),
    }
}

/// Compliance along the normal only: none on top, where the cube's tables show that the finite body hardly matters.
pub fn normal(model: &Model<'_>, p_wc: Vec3, n: Vec3) -> f32 {
    match model.compliance {
        Some(given) => given.normal,
        None if n.z >= LEVEL => 0.0,
        None => compliance(model, p_wc, n, 0.0).normal,
    }
}

/// Above this z a normal counts as straight up; the sideways part is then below 0.1 %.
const LEVEL: f32 = 0.999_999_5;

fn box_beam(size: Vec3, length: f32) -> Beam {
    let (wide, thin) = (max(size.x, size.y), min(size.x, size.y));
    let slender = thin / wide;
    // Roark: torsion constant of a rectangle, 0.1406 b^4 for the square
    let torsion = wide * thin * thin * thin * (1.0 / 3.0 - 0.21 * slender * (1.0 - slender * slender * slender * slender / 12.0));
    let bending = (size.y * size.x * size.x * size.x / 12.0, size.x * size.y * size.y * size.y / 12.0);
    Beam { length, area: size.x * size.y, torsion, bending }
}

fn ellipse_beam(ax: f32, ay: f32, length: f32) -> Beam {
    let torsion = PI * ax * ax * ax * ay * ay * ay / (ax * ax + ay * ay);
    let bending = (0.25 * PI * ax * ax * ax * ay, 0.25 * PI * ax * ay * ay * ay);
    Beam { length, area: PI * ax * ay, torsion, bending }
}

/// Box and cylinder: the cube's calibration on top, the cantilever's directions elsewhere.
fn of_column(beam: Beam, width: f32, g: f32, nu: f32, n: Vec3, a: f32) -> Compliance {
    let lateral = lateral(&beam, g, nu);
    let axial = beam.length / (2.0 * (1.0 + nu) * g * beam.area);
    let ratio = min(a / width, 0.5);
    let top = n.z * n.z;
    // the half-space part of a wide patch already holds part of the body
    let overlap = 1.0 - 1.75 * ratio * ratio;
    let drag_top = DRAG_SHARE * lateral * overlap * incompressible_excess(nu);
    let drag_side = 0.5 * (DRAG_SHARE * lateral + axial);
    let twist_top = TWIST_SHARE * beam.length / (g * beam.torsion);
    let twist_side = beam.length / (2.0 * (1.0 + nu) * g * min(beam.bending.0, beam.bending.1));
    Compliance {
        normal: (1.0 - top) * DRAG_SHARE * lateral,
        drag: top * drag_top + (1.0 - top) * drag_side,
        twist: top * twist_top + (1.0 - top) * TWIST_SHARE * twist_side,
    }
}

/// C_t G b of the cube is 1.79 + 1.0 (0.5 - nu); the beam's own dependence on nu is divided out.
fn incompressible_excess(nu: f32) -> f32 {
    let beam = |nu: f32| 1.0 + 2.0 / (1.0 + nu);
    (1.79 + (0.5 - nu)) / 1.79 * beam(0.5) / beam(nu) * CUBE_DRAG
}

/// The cube's 1.79 over the scaled beam's 0.77 x 7/3: makes the box rule meet the calibration exactly.
const CUBE_DRAG: f32 = 1.79 / (0.77 * 7.0 / 3.0);

/// Shear and bending of the cantilever, mean of the two directions \[m/N\].
fn lateral(beam: &Beam, g: f32, nu: f32) -> f32 {
    let e = 2.0 * (1.0 + nu) * g;
    let bend = beam.length * beam.length * beam.length / (3.0 * e);
    beam.length / (g * beam.area) + 0.5 * (bend / beam.bending.0 + bend / beam.bending.1)
}

/// C_theta G R^3 of a sphere held below an eighth of its height.
const SPHERE_TWIST: f32 = 1.15;

/// Sphere and ellipsoid. The beam has the section of the equator, and is scaled so that the sphere's twist is met.
fn of_round(semi_axes: Vec3, height: f32, g: f32, nu: f32, n: Vec3) -> Compliance {
    let beam = ellipse_beam(semi_axes.x, semi_axes.y, height);
    // sphere: length 1.75 R over torsion constant pi R^4 / 2
    let share = SPHERE_TWIST * PI / (2.0 * 1.75);
    let top = clamp(n.z * n.z, 0.0, 1.0);
    let lateral = DRAG_SHARE * lateral(&beam, g, nu);
    let e = 2.0 * (1.0 + nu) * g;
    let twist_side = TWIST_SHARE * beam.length / (e * min(beam.bending.0, beam.bending.1));
    Compliance {
        normal: (1.0 - top) * lateral,
        drag: top * lateral + (1.0 - top) * 0.5 * (lateral + beam.length / (e * beam.area)),
        twist: top * share * beam.length / (g * beam.torsion) + (1.0 - top) * twist_side,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Material, ModelSpec, ProbePart, ProbeShape};

    fn at_top(object: ObjectShape, nu: f32, a: f32) -> Compliance {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: nu, density: 1100.0 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let model = Model::new(&ModelSpec::new(object, material, &ball)).unwrap();
        compliance(&model, Vec3::Z * object.height(), Vec3::Z, a)
    }

    #[test]
    fn the_cube_meets_its_calibration() {
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        for nu in [0.3, 0.45, 0.5] {
            let g = 3.0e6 / (2.0 * (1.0 + nu));
            let found = at_top(cube, nu, 0.01);
            let drag = (1.79 + (0.5 - nu)) * (1.0 - 1.75 * 0.01) / (g * 0.1);
            assert!((found.drag / drag - 1.0).abs() < 0.01, "nu {nu}: {found:?} expected {drag}");
            assert!((found.twist * g * 1.0e-3 / 4.75 - 1.0).abs() < 0.01, "nu {nu}: {found:?}");
            assert_eq!(found.normal, 0.0);
        }
    }

    #[test]
    fn the_sphere_meets_its_calibration_and_the_half_space_has_none() {
        let found = at_top(ObjectShape::Sphere { radius: 0.05 }, 0.5, 0.004);
        assert!((found.twist * 1.0e6 * 1.25e-4 / 1.15 - 1.0).abs() < 0.001, "{found:?}");
        assert_eq!(at_top(ObjectShape::HalfSpace, 0.5, 0.004), Compliance::default());
    }
}

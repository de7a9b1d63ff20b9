//! Compliance of the object's body beyond the half space's (PHYSICS 3.1; theory.md, section 7).
//!
//! A force at a contact also shears, bends and twists the whole body down to its fixed base. In series with the local
//! stiffness: 1/K = 1/K_local + C. Closed forms fitted to finite elements (`tools/mesh/FEM.md`): the half space that the local stiffness
//! already counts takes a fixed length off the body, not a share of it. Every figure is for the contact's two directions alike.

use glam::Vec3;

use crate::green::kernel::{Load, bent_drag};
use crate::green::{Block, Green};
use crate::math::{PI, clamp, ln, max, min, perpendicular, root};
use crate::model::{Compliance, Material, Model, ObjectShape};

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

/// Compliance at a patch with centre `p_wc`, outward normal `n` and contact radius `a`, where the object's mean curvature is `curvature`.
pub fn compliance(model: &Model<'_>, p_wc: Vec3, n: Vec3, a: f32, curvature: f32) -> Compliance {
    if let Some(given) = model.compliance {
        return given;
    }
    if let Some(green) = model.table() {
        return by_table(&own(model, green, p_wc, n, a, curvature), n);
    }
    let object = stand_in(&model.object);
    let height = max(p_wc.z - model.fixed_below, 0.0);
    let Some(beam) = beam_under(&object, height) else { return Compliance::default() };
    let (up, side) = (upright(n), || side(&beam, &model.material));
    // only what counts, and both where the normal is neither up nor level
    if up <= 0.0 {
        return side();
    }
    let top = top(&object, height, &model.material, a);
    if up >= 1.0 { top } else { between(top, side(), up) }
}

/// Drag compliance that patches share at a patch with centre `p_wc`, outward normal `n` and mean curvature `curvature`: what is beyond the closed form that the curvature gives.
pub fn shared_drag(model: &Model<'_>, p_wc: Vec3, n: Vec3, curvature: f32) -> f32 {
    let far = match stand_in(&model.object) {
        ObjectShape::HalfSpace | ObjectShape::Mesh(_) => return 0.0,
        ObjectShape::Box { size } => root(size.x * size.y),
        ObjectShape::Cylinder { radius, .. } | ObjectShape::Sphere { radius } => 2.0 * radius,
        ObjectShape::Ellipsoid { semi_axes } => 2.0 * root(semi_axes.x * semi_axes.y),
    };
    let bent = bent_drag(curvature, model.material.poisson_ratio, SPACING * far) / (2.0 * model.material.shear_modulus());
    max(compliance(model, p_wc, n, SPACING * far, curvature).drag - bent, 0.0)
}

/// Turn of the body about its vertical axis, at the height of `p_wc`, per torque about it \[rad/(N m)\].
pub fn torsion(model: &Model<'_>, p_wc: Vec3) -> f32 {
    if let Some(given) = model.compliance {
        return given.twist;
    }
    let g = model.material.shear_modulus();
    let height = max(p_wc.z - model.fixed_below, 0.0);
    match stand_in(&model.object) {
        ObjectShape::HalfSpace | ObjectShape::Mesh(_) => 0.0,
        ObjectShape::Box { size } => box_twist(size, height, g),
        ObjectShape::Cylinder { radius, .. } => cylinder_twist(radius, height, g),
        ObjectShape::Sphere { radius } => round_twist(Vec3::splat(radius), height, g),
        ObjectShape::Ellipsoid { semi_axes } => round_twist(semi_axes, height, g),
    }
}

/// Distance at which the drag compliance that patches share is taken, as a share of the body's width: a patch of this radius has its traction that far apart.
const SPACING: f32 = 0.2;

/// What the body's table says of a patch itself, for its place, normal, radius `a` and the object's curvature there.
pub fn own(model: &Model<'_>, green: &Green<'_>, p_wc: Vec3, n: Vec3, a: f32, curvature: f32) -> Block {
    let own = green.own(p_wc);
    let e1 = perpendicular(n);
    let tangents = [e1, n.cross(e1)];
    let (share, bent) = (wide(model, n, a), narrow(model, green, curvature, a));
    let mut changed = own;
    for (i, t) in tangents.into_iter().enumerate() {
        for (j, u) in tangents.into_iter().enumerate() {
            let found = own.times(&Load { force: u, torque: 0.0 }).shift.dot(t);
            let more = (share - 1.0) * found + if i == j { bent } else { 0.0 };
            changed = changed.plus(t, u, more);
        }
    }
    changed
}

/// What a patch of radius `a` on a curved body is dragged by beyond the disc of the table (11.5).
fn narrow(model: &Model<'_>, green: &Green<'_>, curvature: f32, a: f32) -> f32 {
    if a <= 0.0 {
        return 0.0;
    }
    let at = |d: f32| bent_drag(curvature, model.material.poisson_ratio, d);
    (at(a) - at(green.patch_radius())) / (2.0 * model.material.shear_modulus())
}

/// What is left of a box's drag compliance under a patch of radius `a`, whose own stiffness holds part of the body (7.1); 1 on other bodies.
pub fn wide(model: &Model<'_>, n: Vec3, a: f32) -> f32 {
    let ObjectShape::Box { size } = stand_in(&model.object) else { return 1.0 };
    let across = if n.x * n.x > 0.5 { size.y } else { size.x };
    let width = if n.z * n.z > 0.5 { min(size.x, size.y) } else { min(size.z, across) };
    let ratio = min(a / width, WIDEST);
    1.0 - OVERLAP * ratio * ratio
}

/// Fall of a face's drag compliance with the square of a/b.
const OVERLAP: f32 = 1.75;

/// Largest a/b the fall is applied to: 0.3 was fitted.
const WIDEST: f32 = 0.5;

/// The mean over the directions along the surface of what the table says.
fn by_table(own: &Block, n: Vec3) -> Compliance {
    let along = |v: Vec3| own.times(&Load { force: v, torque: 0.0 }).shift.dot(v);
    let e1 = perpendicular(n);
    let twist = own.times(&Load { force: Vec3::ZERO, torque: 1.0 }).turn;
    let drag = 0.5 * (along(e1) + along(n.cross(e1)));
    Compliance { normal: max(along(n), 0.0), drag: max(drag, 0.0), twist: max(twist, 0.0) }
}

/// The primitive whose closed forms an object takes: its own, or a mesh's stand-in.
fn stand_in(object: &ObjectShape<'_>) -> ObjectShape<'static> {
    // arm by arm: a copy of the whole would take a mesh's room with it
    match object {
        ObjectShape::Mesh(mesh) => mesh.stand_in(),
        ObjectShape::HalfSpace => ObjectShape::HalfSpace,
        &ObjectShape::Box { size } => ObjectShape::Box { size },
        &ObjectShape::Sphere { radius } => ObjectShape::Sphere { radius },
        &ObjectShape::Ellipsoid { semi_axes } => ObjectShape::Ellipsoid { semi_axes },
        &ObjectShape::Cylinder { radius, height } => ObjectShape::Cylinder { radius, height },
    }
}

/// Compliance along the normal only: none on top, where the cube's tables show that the finite body hardly matters.
pub fn normal(model: &Model<'_>, p_wc: Vec3, n: Vec3) -> f32 {
    match model.compliance {
        Some(given) => given.normal,
        None if model.table().is_some() => compliance(model, p_wc, n, 0.0, 0.0).normal,
        None if n.z >= LEVEL => 0.0,
        None => {
            let beam = beam_under(&stand_in(&model.object), max(p_wc.z - model.fixed_below, 0.0));
            // a top gives none
            beam.map_or(0.0, |beam| (1.0 - upright(n)) * (SIDE.normal * lateral(&beam, &model.material)))
        }
    }
}

/// Above this z a normal counts as straight up; the sideways part is then below 0.1 %.
const LEVEL: f32 = 0.999_999_5;

/// The beam from the base up to `height`; none under a body that has no base.
fn beam_under(object: &ObjectShape<'_>, height: f32) -> Option<Beam> {
    match *object {
        ObjectShape::HalfSpace | ObjectShape::Mesh(_) => None,
        ObjectShape::Box { size } => Some(box_beam(size, height)),
        ObjectShape::Cylinder { radius, .. } | ObjectShape::Sphere { radius } => Some(ellipse_beam(radius, radius, height)),
        ObjectShape::Ellipsoid { semi_axes } => Some(ellipse_beam(semi_axes.x, semi_axes.y, height)),
    }
}

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

/// How much of the top's compliance a patch with normal `n` has: the square of the normal's height.
fn upright(n: Vec3) -> f32 {
    clamp(n.z * n.z, 0.0, 1.0)
}

/// Compliance of which `up` is the top's.
fn between(top: Compliance, side: Compliance, up: f32) -> Compliance {
    let mix = |top: f32, side: f32| up * top + (1.0 - up) * side;
    Compliance { normal: mix(top.normal, side.normal), drag: mix(top.drag, side.drag), twist: mix(top.twist, side.twist) }
}

/// Coefficients of h^2, h and 1 in the drag compliance of a column, at one Poisson's ratio.
type DragRow = (f32, [f32; 3]);

/// Square column, h in edges, C_t G b = 2 h^3/(1 + nu) + ...; finite elements, 0.2 % for h >= 0.75.
const SQUARE_DRAG: [DragRow; 4] = [
    (0.0, [-0.005, 1.208, -0.749]),
    (0.3, [-0.137, 1.261, -0.609]),
    (0.4, [-0.227, 1.287, -0.564]),
    (0.5, [-0.344, 1.321, -0.522]),
];

/// Cylinder, h in radii, C_t G R = 4 h^3/(6 pi (1 + nu)) + ...; finite elements, 0.2 % for h >= 1.
const CYLINDER_DRAG: [DragRow; 4] = [
    (0.0, [0.0, 0.3723, -0.4208]),
    (0.3, [-0.0262, 0.3989, -0.3529]),
    (0.4, [-0.0425, 0.4085, -0.3296]),
    (0.5, [-0.0632, 0.4186, -0.3063]),
];

/// Drag compliance of a column over its height: cubics at two Poisson's ratios and the share of the way between them.
struct Column {
    cubic: f32,
    low: [f32; 3],
    high: [f32; 3],
    share: f32,
}

impl Column {
    /// The column of `rows` with bending coefficient `cubic`, at Poisson's ratio `nu`.
    fn new(rows: &[DragRow; 4], cubic: f32, nu: f32) -> Self {
        let mut column = Self { cubic, low: rows[0].1, high: rows[0].1, share: 0.0 };
        for pair in rows.windows(2) {
            if let [(from, low), (to, high)] = *pair
                && nu >= from
            {
                column = Self { cubic, low, high, share: min((nu - from) / (to - from), 1.0) };
            }
        }
        column
    }

    /// At height `h`; 0 for bodies so flat that the half space counts more than all of it.
    fn drag(&self, h: f32) -> f32 {
        let at = |[square, linear, constant]: [f32; 3]| max(self.cubic * h * h * h + square * h * h + linear * h + constant, 0.0);
        let (low, high) = (at(self.low), at(self.high));
        low + (high - low) * self.share
    }
}

/// C_theta G b^3 of the square column is 7.088 h/b less this, which meets the cube's 4.75; finite elements, 1 % for h/b >= 1.
const SQUARE_TWIST_OFF: f32 = 2.338;

/// Top of a body, under a patch of radius `a`.
fn top(object: &ObjectShape<'_>, height: f32, material: &Material, a: f32) -> Compliance {
    match *object {
        ObjectShape::HalfSpace | ObjectShape::Mesh(_) => Compliance::default(),
        ObjectShape::Box { size } => top_of_box(size, height, material, a),
        ObjectShape::Cylinder { radius, .. } => top_of_cylinder(radius, height, material),
        ObjectShape::Sphere { radius } => top_of_round(Vec3::splat(radius), height, material, a),
        ObjectShape::Ellipsoid { semi_axes } => top_of_round(semi_axes, height, material, a),
    }
}

/// Top of a box: the square column of the same section area, scaled by what the rectangle's beam has more than the square's; the cube meets its
/// calibration C_t G b = (1.79 + (0.5 - nu))(1 - 1.75 (a/b)^2) exactly.
fn top_of_box(size: Vec3, height: f32, material: &Material, a: f32) -> Compliance {
    let (g, nu) = (material.shear_modulus(), material.poisson_ratio);
    let b = root(size.x * size.y);
    // at the held plane both beams have no length, and their quotient is that of the least one
    let length = max(height, LEAST_LENGTH * b);
    let (beam, square) = (box_beam(size, length), box_beam(Vec3::new(b, b, size.z), length));
    let h = height / b;
    let ratio = min(a / min(size.x, size.y), WIDEST);
    // the half-space part of a wide patch already holds part of the body
    let overlap = 1.0 - OVERLAP * ratio * ratio;
    let column = Column::new(&SQUARE_DRAG, 2.0 / (1.0 + nu), nu);
    let calibrated = (1.79 + (0.5 - nu)) / column.drag(1.0) * column.drag(h) * overlap / (g * b);
    let drag = calibrated * lateral(&beam, material) / lateral(&square, material);
    Compliance { normal: 0.0, drag, twist: box_twist(size, height, g) }
}

/// Shortest beam whose compliances are compared, as a share of its width: its cube over that of the longest body stays within an f32.
const LEAST_LENGTH: f32 = 1.0e-6;

fn box_twist(size: Vec3, height: f32, g: f32) -> f32 {
    let b = root(size.x * size.y);
    let square = box_beam(Vec3::new(b, b, size.z), height).torsion;
    max(7.088 * height / b - SQUARE_TWIST_OFF, 0.0) / (g * b * b * b) * square / box_beam(size, height).torsion
}

/// Top of an upright cylinder; C_theta G R^3 = 2/pi h/R - 0.385 within 0.1 % of finite elements for h >= R.
fn top_of_cylinder(radius: f32, height: f32, material: &Material) -> Compliance {
    let (g, nu) = (material.shear_modulus(), material.poisson_ratio);
    let h = height / radius;
    let drag = Column::new(&CYLINDER_DRAG, 4.0 / (6.0 * PI * (1.0 + nu)), nu).drag(h);
    Compliance { normal: 0.0, drag: drag / (g * radius), twist: cylinder_twist(radius, height, g) }
}

fn cylinder_twist(radius: f32, height: f32, g: f32) -> f32 {
    max(2.0 / PI * height / radius - 0.385, 0.0) / (g * radius * radius * radius)
}

/// Share of the cantilever's figures that finite elements find on the side of a cube at mid height: lateral along the normal, mean of lateral and
/// axial along the surface, bending rotation about the normal.
const SIDE: Compliance = Compliance { normal: 0.643, drag: 1.30, twist: 0.79 };

/// Side of a column: the cantilever up to the contact.
fn side(beam: &Beam, material: &Material) -> Compliance {
    let e = 2.0 * (1.0 + material.poisson_ratio) * material.shear_modulus();
    let (lateral, axial) = (lateral(beam, material), beam.length / (e * beam.area));
    let twist = beam.length / (e * min(beam.bending.0, beam.bending.1));
    Compliance { normal: SIDE.normal * lateral, drag: SIDE.drag * 0.5 * (lateral + axial), twist: SIDE.twist * twist }
}

/// Shear and bending of the cantilever, mean of the two directions \[m/N\].
fn lateral(beam: &Beam, material: &Material) -> f32 {
    let (g, nu) = (material.shear_modulus(), material.poisson_ratio);
    let e = 2.0 * (1.0 + nu) * g;
    let bend = beam.length * beam.length * beam.length / (3.0 * e);
    beam.length / (g * beam.area) + 0.5 * (bend / beam.bending.0 + bend / beam.bending.1)
}

/// C_theta G R^3 of a sphere held below an eighth of its height.
const SPHERE_TWIST: f32 = 1.15;

/// Height from the held plane to the top of a round body, in vertical semi-axes, that the fits belong to.
const ROUND_HEIGHT: f32 = 1.75;

/// Sphere and ellipsoid. Twist: the beam with the equator's section, scaled to the sphere. Drag: fit over six shapes, 5 % of finite elements.
fn top_of_round(semi_axes: Vec3, height: f32, material: &Material, a: f32) -> Compliance {
    let (g, nu) = (material.shear_modulus(), material.poisson_ratio);
    let beam = ellipse_beam(semi_axes.x, semi_axes.y, height);
    let full = ellipse_beam(semi_axes.x, semi_axes.y, ROUND_HEIGHT * semi_axes.z);
    let drag = 0.5
        * (round_drag(semi_axes.x, semi_axes.y, semi_axes.z, nu, a) + round_drag(semi_axes.y, semi_axes.x, semi_axes.z, nu, a))
        / g;
    let drag = drag * lateral(&beam, material) / lateral(&full, material);
    Compliance { normal: 0.0, drag, twist: round_twist(semi_axes, height, g) }
}

fn round_twist(semi_axes: Vec3, height: f32, g: f32) -> f32 {
    // sphere: length 1.75 R over torsion constant pi R^4 / 2
    let share = SPHERE_TWIST * PI / (2.0 * ROUND_HEIGHT);
    share * height / (g * ellipse_beam(semi_axes.x, semi_axes.y, height).torsion)
}

/// C_t G of an ellipsoid held below an eighth of its height, dragged along the semi-axis `p` by a patch of radius `a` on its top: bending of the whole
/// and, with the logarithm, the curved surface under the patch.
fn round_drag(p: f32, q: f32, c: f32, nu: f32, a: f32) -> f32 {
    let mean = root(p * q);
    let bending = 1.570 * c * c * c / (p * p * p * q);
    let narrowing = max(mean / max(a, 1.0e-3 * mean), 1.0);
    let surface = (0.597 + 0.2205 * ln(narrowing)) * c / (p * q) * root(root(q / p));
    (1.0 + 0.85 * (0.5 - nu)) * (bending + surface)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ModelSpec, ProbePart, ProbeShape};

    fn at_top(object: ObjectShape<'_>, nu: f32, a: f32) -> Compliance {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: nu, density: 1100.0 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let model = Model::new(&ModelSpec::new(object, material, &ball)).unwrap();
        compliance(&model, Vec3::Z * object.height(), Vec3::Z, a, 0.0)
    }

    #[test]
    fn the_compliance_along_the_normal_is_the_normal_part_of_the_whole() {
        let cylinder = ObjectShape::Cylinder { radius: 0.04, height: 0.1 };
        let bodies = [
            ObjectShape::Box { size: Vec3::new(0.1, 0.08, 0.12) },
            cylinder,
            ObjectShape::Sphere { radius: 0.05 },
            ObjectShape::HalfSpace,
        ];
        for object in bodies {
            let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.45, density: 1100.0 };
            let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
            let model = Model::new(&ModelSpec::new(object, material, &ball)).unwrap();
            for n in [Vec3::X, Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.8, 0.6), Vec3::NEG_Z] {
                let place = Vec3::new(0.01, 0.0, 0.07);
                let whole = compliance(&model, place, n, 0.005, 20.0).normal;
                assert_eq!(normal(&model, place, n), whole, "{object:?} {n}");
                assert_eq!(whole > 0.0, n.z.abs() < 1.0 && object != ObjectShape::HalfSpace, "{object:?} {n}");
            }
        }
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
    fn a_patch_at_the_held_plane_or_below_has_figures() {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let object = ObjectShape::Box { size: Vec3::new(0.06, 0.05, 0.04) };
        let model = Model::new(&ModelSpec::new(object, material, &ball)).unwrap();
        for z in [0.0, -1.0e-3, 1.0e-9] {
            let found = compliance(&model, Vec3::new(0.03, 0.0, z), Vec3::X, 0.004, 0.0);
            assert!(found.drag >= 0.0 && found.drag < 1.0e-4 && found.twist >= 0.0 && found.normal >= 0.0, "{z}: {found:?}");
        }
    }

    #[test]
    fn other_bodies_meet_finite_elements() {
        // C_t G L and C_theta G L^3 at nu = 0.5 (tools/mesh/FEM.md)
        let cases = [
            (ObjectShape::Cylinder { radius: 0.05, height: 0.1 }, 0.05, 1.408, 0.889),
            (ObjectShape::Cylinder { radius: 0.02, height: 0.08 }, 0.02, 9.42, 2.162),
            (ObjectShape::Box { size: Vec3::new(0.05, 0.05, 0.1) }, 0.05, 11.40, 11.73),
            (ObjectShape::Sphere { radius: 0.05 }, 0.05, 2.75, 1.15),
        ];
        for (object, length, drag, twist) in cases {
            let found = at_top(object, 0.5, 0.1 * length);
            let (drag_found, twist_found) = (found.drag * 1.0e6 * length, found.twist * 1.0e6 * length * length * length);
            assert!((drag_found / drag - 1.0).abs() < 0.08, "{object:?} {drag_found}");
            assert!((twist_found / twist - 1.0).abs() < 0.02, "{object:?} {twist_found}");
        }
    }

    #[test]
    fn the_sphere_meets_its_calibration_and_the_half_space_has_none() {
        let found = at_top(ObjectShape::Sphere { radius: 0.05 }, 0.5, 0.004);
        assert!((found.twist * 1.0e6 * 1.25e-4 / 1.15 - 1.0).abs() < 0.001, "{found:?}");
        assert_eq!(at_top(ObjectShape::HalfSpace, 0.5, 0.004), Compliance::default());
    }
}

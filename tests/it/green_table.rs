//! A body's own table, laid over the core's closed forms by hand, meets displacement fields and stiffnesses of others' finite elements.
//!
//! No tick runs here: what is tested is the table and how its parts are to be added up (theory.md, section 11). Errors are shares of the
//! patch's own motion, or of the outermost motion of its rim.

use haptor_contact::green::{Disc, Green, Load};
use haptor_contact::{Material, Model, ModelSpec, ObjectShape, ProbePart, ProbeShape, Vec3};
use haptor_mesh::green::GreenTable;
use haptor_tests::bodies;
use serde::Deserialize;

/// Tables B1, B3 and B4 of the reference, thinned.
#[derive(Deserialize)]
struct Truth {
    cube: Vec<Cube>,
    ellipsoid: Vec<Ellipsoid>,
}

/// A disc bonded to the middle of the cube's top, moved by 1 m or 1 rad.
#[derive(Deserialize)]
struct Cube {
    mode: String,
    a_m: f32,
    nu: f32,
    stiffness: f32,
    field: Vec<[f32; 6]>,
}

/// A patch on the ellipsoid's pole, or two legs beside it, turned about the vertical by 1 rad.
#[derive(Deserialize)]
struct Ellipsoid {
    offset_m: f32,
    a_m: f32,
    nu: f32,
    stiffness: f32,
    field: Vec<[f32; 6]>,
}

fn truth() -> Truth {
    serde_json::from_str(include_str!("../truth/green_fields.json")).expect("the table parses")
}

fn material(poisson_ratio: f32) -> Material {
    Material { young_modulus: 3.0e6, poisson_ratio, density: 1100.0 }
}

/// A loaded patch.
struct Patch<'a> {
    green: Green<'a>,
    disc: Disc,
    place: Vec3,
}

impl<'a> Patch<'a> {
    fn new(table: &'a GreenTable, shape: ObjectShape<'_>, nu: f32, place: Vec3, n: Vec3, a: f32, object_radius: f32) -> Self {
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let model = Model::new(&ModelSpec::new(shape, material(nu), &ball)).expect("a model");
        let green = Green::new(&table.spec()).expect("a table that the core takes");
        Self { green, disc: Disc::new(&model, place, n, a, object_radius), place }
    }

    fn field(&self, load: &Load, p_w: Vec3) -> Vec3 {
        let (at, here) = (self.green.chart().cell(p_w), self.green.chart().cell(self.place));
        self.disc.displacement(load, p_w) + self.green.respond(&at, &here, load).shift
    }

    fn turn(&self, load: &Load, p_w: Vec3, n: Vec3) -> f32 {
        let (at, here) = (self.green.chart().cell(p_w), self.green.chart().cell(self.place));
        self.disc.at(load, p_w, n, 0.0).turn + self.green.respond(&at, &here, load).turn
    }
}

fn force(force: Vec3) -> Load {
    Load { force, torque: 0.0 }
}

const TWIST: Load = Load { force: Vec3::ZERO, torque: 1.0 };

fn scaled(load: &Load, by: f32) -> Load {
    Load { force: load.force * by, torque: load.torque * by }
}

#[test]
fn the_cube_meets_drag_push_and_twist() {
    const CUBE: ObjectShape<'_> = ObjectShape::Box { size: Vec3::splat(0.1) };
    const TOP: Vec3 = Vec3::new(0.0, 0.0, 0.1);
    for nu in [0.4999, 0.3] {
        let table = bodies::table(CUBE, material(nu));
        for case in truth().cube.iter().filter(|case| case.nu == nu) {
            let (a, g) = (case.a_m, material(nu).shear_modulus());
            let patch = Patch::new(table, CUBE, nu, TOP, Vec3::Z, a, f32::INFINITY);
            let own = patch.green.own(TOP);
            let (local, load, rim) = match case.mode.as_str() {
                "drag" => (8.0 * g * a / (2.0 - nu), force(Vec3::X), 1.0),
                "push" => (2.0 * material(nu).contact_modulus() * a, force(Vec3::Z), 1.0),
                _ => (16.0 / 3.0 * g * a * a * a, TWIST, a),
            };
            let moved = own.times(&load);
            let stiffness = 1.0 / (1.0 / local + moved.shift.dot(load.force) + moved.turn * load.torque);
            assert!((stiffness / case.stiffness - 1.0).abs() < 0.015, "{} {a}: {stiffness} {}", case.mode, case.stiffness);
            let load = scaled(&load, stiffness);
            for &[x, y, z, ux, uy, uz] in &case.field {
                let found = patch.field(&load, Vec3::new(x, y, z));
                let off = found - Vec3::new(ux, uy, uz);
                // the reference's disc is kept from tilting, the table's is not: beside a drag that shows along z
                let off = if case.mode == "drag" { Vec3::new(off.x, off.y, 0.0) } else { off };
                assert!(off.length() < 0.04 * rim, "{} {a} at {x} {y} {z}: {found}, expected {ux} {uy} {uz}", case.mode);
            }
        }
    }
}

/// The ellipsoid of the reference, its base at the origin.
const AXES: Vec3 = Vec3::new(0.06, 0.05, 0.04);

/// Loss of twist stiffness of a convex surface per radius over radius of curvature (theory.md, section 7).
const CONVEX_LOSS: f32 = 0.735;

/// A leg on the ellipsoid.
#[derive(Clone, Copy)]
struct Leg {
    place: Vec3,
    n: Vec3,
    /// Radius along the surface \[m\].
    a: f32,
    /// Mean radius of curvature of the surface \[m\].
    radius: f32,
}

/// A leg at `x`, of radius `a` seen from above.
fn leg(x: f32, a: f32) -> Leg {
    let z = AXES.z * (1.0 - (x / AXES.x).powi(2)).sqrt();
    let squares = AXES * AXES;
    let n = (Vec3::new(x, 0.0, z) / squares).normalize();
    let width = (squares * n * n).element_sum().sqrt();
    let curvature = 0.5 * width * ((1.0 / squares).element_sum() - (n * n / squares).element_sum());
    Leg { place: Vec3::new(x, 0.0, z + AXES.z), n, a: a / n.z.sqrt(), radius: 1.0 / curvature }
}

/// Force and torque on a patch at `x` for 1 rad about the vertical; the other leg has the opposite force.
fn loads(one: &Patch<'_>, two: &Patch<'_>, leg: &Leg, nu: f32) -> (f32, f32) {
    let (g, a, x) = (material(nu).shear_modulus(), leg.a, leg.place.x);
    let own = one.green.own(one.place);
    let (pulled, turned) = (own.times(&force(Vec3::Y)), own.times(&TWIST));
    let local_turn = 3.0 / (16.0 * g * a.powi(3) * (1.0 - CONVEX_LOSS * a / leg.radius));
    if x == 0.0 {
        return (0.0, 1.0 / (local_turn + turned.turn));
    }
    // the table's own drag is that of its own disc
    let softer = 3.0 - 2.0 * nu * (1.0 - 2.0 * nu);
    let bent = softer / (8.0 * std::f32::consts::PI * g * leg.radius) * (one.green.patch_radius() / a).ln();
    let back = force(-Vec3::Y);
    let yy = (2.0 - nu) / (8.0 * g * a) + bent + pulled.shift.y + two.field(&back, one.place).y;
    let yt = turned.shift.y + two.field(&TWIST, one.place).y;
    let ty = pulled.turn + two.turn(&back, one.place, leg.n);
    let tt = local_turn + turned.turn + two.turn(&TWIST, one.place, leg.n);
    let determinant = yy * tt - yt * ty;
    ((x * tt - yt * leg.n.z) / determinant, (yy * leg.n.z - ty * x) / determinant)
}

#[test]
fn the_ellipsoid_meets_one_patch_and_two_legs() {
    const SHAPE: ObjectShape<'_> = ObjectShape::Ellipsoid { semi_axes: AXES };
    let table = bodies::table(SHAPE, material(0.4999));
    for case in &truth().ellipsoid {
        let (x, nu) = (case.offset_m, case.nu);
        let leg = leg(x, case.a_m);
        let mirror = |v: Vec3| Vec3::new(-v.x, v.y, v.z);
        let one = Patch::new(table, SHAPE, nu, leg.place, leg.n, leg.a, leg.radius);
        let two = Patch::new(table, SHAPE, nu, mirror(leg.place), mirror(leg.n), leg.a, leg.radius);
        let (pull, torque) = loads(&one, &two, &leg, nu);
        let legs = if x > 0.0 { 2.0 } else { 1.0 };
        let stiffness = legs * (x * pull + leg.n.z * torque);
        let (stiff, near) = if x > 0.0 { (0.04, 0.06) } else { (0.05, 0.05) };
        println!("legs at {x} m, {} m: {:.4} of the reference", case.a_m, stiffness / case.stiffness);
        assert!((stiffness / case.stiffness - 1.0).abs() < stiff, "{x} {}: {stiffness}, expected {}", case.a_m, case.stiffness);
        for &[px, py, pz, ux, uy, uz] in &case.field {
            // under the patch the surface follows the patch
            if (px.abs() - x).hypot(py) < case.a_m {
                continue;
            }
            let p = Vec3::new(px, py, pz);
            let mut found = one.field(&Load { force: Vec3::Y * pull, torque }, p);
            if x > 0.0 {
                found += two.field(&Load { force: -Vec3::Y * pull, torque }, p);
            }
            let off = (found - Vec3::new(ux, uy, uz)).length() / (x + case.a_m);
            assert!(off < near, "{x} {} at {px} {py} {pz}: {found}, expected {ux} {uy} {uz}", case.a_m);
        }
    }
}

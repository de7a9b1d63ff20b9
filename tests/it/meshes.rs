//! A mesh copy of a primitive is felt as the primitive: as probe and as object, pressed, dragged and twisted, without ripple as it turns.
//!
//! Documented resolution. Round bodies of radius R: triangle edges e with e^2/(8 R) below 1 % of the depth, grid spacing at most R/16. Flats: spacing
//! at most a fortieth of the flat's radius. Edges and tips are rounded over a spacing and lose about a third of it in depth.

use std::f32::consts::FRAC_PI_2;
use std::sync::LazyLock;

use glam::{DVec3, Quat, Vec3};
use haptor_contact::geometry::support::support;
use haptor_contact::{ObjectShape, ParamsSpec, ProbePart, ProbeShape, Tier, Wrench};
use haptor_mesh::bake::on_its_base;
use haptor_mesh::{BakeSpec, Baked, Mesh, bake, tessellate};

use crate::alloc::counted;
use crate::support::drive::{CUBE, Drive, RUBBER};

fn baked(mesh: &Mesh, cells: usize) -> Baked {
    bake(mesh, &BakeSpec { cells, samples: 512 }, &mut |_| {}).expect("a solid")
}

fn shape_of(baked: &'static Baked) -> ProbeShape<'static> {
    ProbeShape::Mesh(baked.shape().expect("the core takes what was baked"))
}

fn object_of(baked: &'static Baked) -> ObjectShape<'static> {
    ObjectShape::Mesh(baked.shape().expect("the core takes what was baked"))
}

/// A ball of 20 mm with edges of 1 mm: 6 um under the true ball at the middle of a triangle.
static BALL: LazyLock<Baked> = LazyLock::new(|| baked(&tessellate::ellipsoid(DVec3::splat(0.02), 128), 36));
const TRUE_BALL: ProbeShape<'static> = ProbeShape::Sphere { radius: 0.02 };

/// Press 1 mm, drag 1 mm, twist 0.3 rad.
fn felt(object: ObjectShape<'static>, shape: ProbeShape<'static>, top: Vec3, turn: Quat, lift: f32) -> Vec<Wrench> {
    let params = ParamsSpec { tier: Tier::Bristle, ..ParamsSpec::default() };
    let mut drive = Drive::new(object, RUBBER, &[ProbePart::at_origin(shape)], &params);
    let mut found = Vec::new();
    for i in 0..=60 {
        let ramp = |from: i32, to: i32| ((i - from) as f32 / (to - from) as f32).clamp(0.0, 1.0);
        let (press, drag, twist) = (ramp(0, 20), ramp(20, 40), ramp(40, 60));
        let at = top + Vec3::new(0.8e-3 * drag, 0.6e-3 * drag, lift - 1.0e-3 * press);
        found.push(drive.tick(at, (Quat::from_rotation_z(0.3 * twist) * turn).normalize()).contact);
    }
    found
}

/// Largest difference over the largest force, and over the largest torque or that of the load on a lever of 1 mm.
fn apart(copy: &[Wrench], truth: &[Wrench]) -> (f32, f32) {
    let largest = |of: &dyn Fn(&Wrench) -> f32| truth.iter().map(of).fold(0.0, f32::max);
    let off = |of: &dyn Fn(&Wrench) -> Vec3| copy.iter().zip(truth).map(|(a, b)| (of(a) - of(b)).length()).fold(0.0, f32::max);
    let force = largest(&|w| w.force.length());
    (off(&|w| w.force) / force, off(&|w| w.torque) / largest(&|w| w.torque.length()).max(1.0e-3 * force))
}

fn check(name: &str, copy: &[Wrench], truth: &[Wrench]) {
    let (force, torque) = apart(copy, truth);
    println!("{name}: {:.2} % of the force, {:.2} % of the torque", 100.0 * force, 100.0 * torque);
    assert!(force < 0.03 && torque < 0.03, "{name}: {force} {torque}");
}

#[test]
fn a_mesh_probe_is_felt_as_its_primitive() {
    let lying = Quat::from_rotation_x(FRAC_PI_2);
    let (radius, height, size) = (0.01, 0.02, Vec3::new(0.02, 0.03, 0.024));
    let semi_axes = Vec3::new(0.025, 0.02, 0.018);
    let wide = |v: Vec3| v.as_dvec3();
    let cases = [
        ("capsule", ProbeShape::Capsule { radius, height }, tessellate::capsule(0.01, 0.02, 96), 64, lying),
        ("cylinder upright", ProbeShape::Cylinder { radius, height }, tessellate::cylinder(0.01, 0.02, 96), 80, Quat::IDENTITY),
        ("cylinder lying", ProbeShape::Cylinder { radius, height }, tessellate::cylinder(0.01, 0.02, 96), 50, lying),
        ("box", ProbeShape::Box { size }, tessellate::cuboid(wide(size)), 90, Quat::IDENTITY),
        ("ellipsoid", ProbeShape::Ellipsoid { semi_axes }, tessellate::ellipsoid(wide(semi_axes), 160), 50, Quat::IDENTITY),
    ];
    let egg = ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) };
    for (name, truth, mesh, cells, turn) in cases {
        let copy: &'static Baked = Box::leak(Box::new(baked(&mesh, cells)));
        let lift = -(turn * support(&truth, turn.conjugate() * Vec3::NEG_Z)).z;
        for object in [ObjectShape::HalfSpace, CUBE] {
            let top = Vec3::Z * object.height();
            let [copy, truth] = [shape_of(copy), truth].map(|shape| felt(object, shape, top, turn, lift));
            check(&format!("{name} on {object:?}"), &copy, &truth);
        }
    }
    for object in [ObjectShape::HalfSpace, CUBE, egg, ObjectShape::Sphere { radius: 0.05 }] {
        let top = Vec3::Z * object.height();
        let [copy, truth] = [shape_of(&BALL), TRUE_BALL].map(|shape| felt(object, shape, top, Quat::IDENTITY, 0.02));
        check(&format!("ball on {object:?}"), &copy, &truth);
    }
}

#[test]
fn a_mesh_object_is_felt_as_its_primitive() {
    let semi_axes = Vec3::new(0.06, 0.05, 0.04);
    let cases = [
        (CUBE, tessellate::cuboid(DVec3::splat(0.1)), 32),
        (ObjectShape::Cylinder { radius: 0.03, height: 0.1 }, tessellate::cylinder(0.03, 0.1, 64), 40),
        (ObjectShape::Sphere { radius: 0.05 }, tessellate::ellipsoid(DVec3::splat(0.05), 128), 40),
        (ObjectShape::Ellipsoid { semi_axes }, tessellate::ellipsoid(semi_axes.as_dvec3(), 128), 40),
    ];
    for (truth, mesh, cells) in cases {
        let (mesh, _) = on_its_base(&mesh).expect("a solid");
        let copy: &'static Baked = Box::leak(Box::new(baked(&mesh, cells)));
        let top = Vec3::Z * truth.height();
        for (name, shape, lift) in
            [("ball", TRUE_BALL, 0.02), ("punch", ProbeShape::Cylinder { radius: 0.01, height: 0.04 }, 0.02)]
        {
            let [felt_copy, felt_truth] = [object_of(copy), truth].map(|object| felt(object, shape, top, Quat::IDENTITY, lift));
            check(&format!("{name} on a copy of {truth:?}"), &felt_copy, &felt_truth);
        }
        if truth == CUBE {
            let [both, truth] = [(object_of(copy), shape_of(&BALL)), (truth, TRUE_BALL)]
                .map(|(object, shape)| felt(object, shape, top, Quat::IDENTITY, 0.02));
            check("both are copies", &both, &truth);
        }
    }
}

/// Normal force over 200 turns by half a degree, less than a sample's or a triangle's share of a turn, at constant depth.
#[test]
fn a_turning_mesh_ball_does_not_ripple() {
    let frictionless = ParamsSpec { friction_dynamic: 0.0, ..ParamsSpec::default() };
    for axis in [Vec3::Y, Vec3::new(0.48, 0.6, 0.64)] {
        let mut drive = Drive::new(CUBE, RUBBER, &[ProbePart::at_origin(shape_of(&BALL))], &frictionless);
        let forces = (0..200).map(|i| {
            let turn = Quat::from_axis_angle(axis, 0.5_f32.to_radians() * i as f32);
            drive.tick(Vec3::new(0.004, 0.007, 0.119), turn).contact.force
        });
        let forces: Vec<Vec3> = forces.collect();
        let (least, most) = forces.iter().fold((f32::MAX, 0.0_f32), |(l, m), f| (l.min(f.z), m.max(f.z)));
        let sideways = forces.iter().map(|f| f.truncate().length()).fold(0.0, f32::max);
        println!("about {axis}: {least} to {most} N, {sideways} N sideways");
        assert!(most - least < 0.01 * most && sideways < 1.0e-4 * most, "about {axis}: {least} to {most} N, {sideways} N");
    }
}

/// Far away nothing is felt; anywhere inside, on the border of the grids and beyond, all is finite, and a tick allocates nothing.
#[test]
fn extremes_stay_finite_and_allocate_nothing() {
    let (mesh, _) = on_its_base(&tessellate::cylinder(0.03, 0.1, 64)).expect("a solid");
    let body: &'static Baked = Box::leak(Box::new(baked(&mesh, 32)));
    let objects = [ObjectShape::HalfSpace, CUBE, object_of(body)];
    let shapes = [shape_of(&BALL), TRUE_BALL, ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) }];
    for (object, shape) in objects.iter().flat_map(|o| shapes.iter().map(move |s| (*o, *s))) {
        for tier in [Tier::Point, Tier::Bristle, Tier::Paper] {
            let params = ParamsSpec { tier, ..ParamsSpec::default() };
            let fresh = || Drive::new(object, RUBBER, &[ProbePart::at_origin(shape)], &params);
            let felt = |drive: &mut Drive, at: Vec3, turn: f32| {
                let (found, calls) = counted(|| drive.tick(at, Quat::from_rotation_y(turn)).contact);
                assert!(found.force.is_finite() && found.torque.is_finite(), "{object:?} {shape:?} {at}: {found:?}");
                assert_eq!(calls, 0, "{object:?} {shape:?} {tier:?}");
                found
            };
            let corners = [Vec3::Z * 0.05, Vec3::ZERO, Vec3::new(0.03, 0.0, 0.1), Vec3::new(0.021, 0.021, 0.1), Vec3::Z * -0.3];
            for (i, at) in corners.into_iter().enumerate() {
                felt(&mut fresh(), at, i as f32);
            }
            let mut drive = fresh();
            for i in 0..60 {
                felt(&mut drive, Vec3::new(0.002, 0.001, -0.003) * i as f32 + Vec3::Z * 0.13, 0.1 * i as f32);
            }
            assert_eq!(felt(&mut fresh(), Vec3::new(300.0, -400.0, 800.0), 0.0), Wrench::ZERO);
        }
    }
}

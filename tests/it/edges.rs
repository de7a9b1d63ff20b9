//! A part with flats that slides off an edge, or tips about one, is felt without a jump: force and torque per tick are bounded.
//!
//! Rubber of 3 MPa, 1 mm deep, without friction; a tick slides by 0.05 mm (50 mm/s at 1 kHz) or tips by 1 mrad (1 rad/s). What is left of a step
//! is the slope of the rule, not a jump: a flat of 20 mm comes to lie on the turned normal within a few ticks.

use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec3};
use haptor_contact::geometry::support::support;
use haptor_contact::{ObjectShape, ParamsSpec, ProbePart, ProbeShape, Wrench};

use crate::support::drive::{CUBE, Drive, RUBBER};

const DEPTH: f32 = 1.0e-3;
const SLIDE: f32 = 0.05e-3;
const TIP: f32 = 1.0e-3;

/// Largest change of force \[N\] and torque \[N m\] between two ticks.
fn steps(felt: &[Wrench]) -> (f32, f32) {
    let change = |pair: &[Wrench]| ((pair[1].force - pair[0].force).length(), (pair[1].torque - pair[0].torque).length());
    felt.windows(2).map(change).fold((0.0, 0.0), |(f, t), (df, dt)| (f.max(df), t.max(dt)))
}

/// Height of a part's origin over its lowest point along `n`.
fn lift(shape: &ProbeShape<'_>, turn: Quat, n: Vec3) -> f32 {
    -(turn * support(shape, turn.conjugate() * -n)).dot(n)
}

fn drive(object: ObjectShape<'static>, shape: ProbeShape<'static>) -> Drive {
    Drive::new(object, RUBBER, &[ProbePart::at_origin(shape)], &ParamsSpec { friction_dynamic: 0.0, ..ParamsSpec::default() })
}

/// From 40 mm off the middle of the top to beyond the edge or rim at x = 50 mm, tilted and turned.
fn slid(object: ObjectShape<'static>, shape: ProbeShape<'static>, tilt: f32, turn: f32) -> Vec<Wrench> {
    let (mut drive, turn) = (drive(object, shape), Quat::from_rotation_y(tilt) * Quat::from_rotation_z(turn));
    let z = object.height() + lift(&shape, turn, Vec3::Z) - DEPTH;
    (0..700).map(|i| drive.tick(Vec3::new(0.04 + SLIDE * i as f32, 0.003, z), turn).contact).collect()
}

/// From lying on the top to lying on the side, the part's lowest face always 1 mm under `edge` along its own normal.
fn tipped(object: ObjectShape<'static>, shape: ProbeShape<'static>, edge: Vec3, axis: Vec3) -> Vec<Wrench> {
    let mut drive = drive(object, shape);
    let pose = |i: i32| {
        let turn = Quat::from_axis_angle(axis, TIP * i as f32);
        let n = turn * Vec3::Z;
        (edge + n * (lift(&shape, turn, n) - DEPTH), turn)
    };
    (0..(FRAC_PI_2 / TIP) as i32).map(pose).map(|(at, turn)| drive.tick(at, turn).contact).collect()
}

/// Shape, and the bounds that are promised: newtons and newton metres per tick.
const PROMISED: [(ProbeShape<'static>, f32, f32); 6] = [
    (ProbeShape::Sphere { radius: 0.02 }, 0.4, 1.0e-4),
    (ProbeShape::Capsule { radius: 0.01, height: 0.03 }, 0.3, 0.004),
    (ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.03, 0.02, 0.015) }, 0.3, 0.003),
    (ProbeShape::Cylinder { radius: 0.01, height: 0.04 }, 3.2, 0.025),
    (ProbeShape::Cone { radius: 0.02, height: 0.02 }, 1.0, 0.01),
    (ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) }, 7.0, 0.07),
];

#[test]
fn no_flat_jumps_at_an_edge() {
    let round = ObjectShape::Cylinder { radius: 0.05, height: 0.1 };
    let corner = Vec3::new(-0.6, 0.8, 0.0);
    for (shape, force, torque) in PROMISED {
        let mut found = Vec::new();
        for (object, far) in [(CUBE, Vec3::new(0.05, 0.05, 0.1)), (round, Vec3::new(0.04, 0.03, 0.1))] {
            for (tilt, turn) in [(0.0, 0.4), (0.3, 0.0), (1.2, 0.0)] {
                found.push(steps(&slid(object, shape, tilt, turn)));
            }
            found.push(steps(&tipped(object, shape, Vec3::new(0.05, 0.003, 0.1), Vec3::Y)));
            found.push(steps(&tipped(object, shape, far, corner)));
        }
        let (f, t) = found.iter().fold((0.0_f32, 0.0_f32), |(f, t), &(df, dt)| (f.max(df), t.max(dt)));
        println!("{shape:?}: {f:.2} N, {t:.4} N m per tick");
        assert!(f <= force && t <= torque, "{shape:?}: {f} N, {t} N m per tick, promised {force} N, {torque} N m");
    }
}

/// Half of a level punch over the edge carries half: the share is that of the area that lies on the face.
#[test]
fn an_overhanging_punch_carries_what_lies_on_the_face() {
    let shape = ProbeShape::Box { size: Vec3::splat(0.02) };
    let load = |x: f32| {
        let mut drive = drive(CUBE, shape);
        drive.tick(Vec3::new(x, 0.0, 0.11 - 0.2e-3), Quat::IDENTITY);
        (drive.contact().force.z, drive.state().patches()[0].centre.x)
    };
    let (whole, half) = (load(0.02), load(0.05));
    // at half the area a square is a strip of two to one: sqrt(1/2) of the radius, 1.01 times as stiff as its disc
    assert!((half.0 / whole.0 - 0.5_f32.sqrt()).abs() < 0.02, "{whole:?} {half:?}");
    // twelve rays cut the corners off a square
    assert!((half.1 - 0.045).abs() < 5.0e-4, "the patch's middle moves onto the face: {half:?}");
}

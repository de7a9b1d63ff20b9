//! Tier `green` against finite elements of others: how stiff a body is under one patch and under two legs.

use haptor_contact::{Flags, Material, ModelSpec, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Quat, Tier, Vec3};
use haptor_tests::bodies;

use crate::support::drive::{Drive, RUBBER};

/// The ellipsoid of the reference tables: 60, 50 and 40 mm, held below an eighth of its height.
const ELLIPSOID: ObjectShape<'static> = ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) };
const MATERIAL: Material = Material { poisson_ratio: 0.499_9, ..RUBBER };
const BALL: f32 = 0.06;

/// Balls at the level offsets `legs` along x, each pressed along the normal so deep that its contact has the radius `wanted` seen from above.
fn pressed(legs: &[f32], wanted: f32) -> Drive {
    let mut depth = wanted * wanted / BALL;
    // the radius follows the depth's root: three rounds meet it to a thousandth
    for _ in 0..3 {
        let drive = at_depth(legs, depth, Tier::Point);
        let patch = drive.state().patches()[0];
        let ratio = wanted / (patch.footprint.radius * patch.normal.z.sqrt());
        depth *= ratio * ratio;
    }
    at_depth(legs, depth, Tier::Green)
}

fn at_depth(legs: &[f32], depth: f32, tier: Tier) -> Drive {
    let params = ParamsSpec { tier, samples: 112, friction_dynamic: 10.0, region_distance: 0.0, ..ParamsSpec::default() };
    let parts: Vec<ProbePart<'static>> = legs.iter().map(|&x| leg(x, depth)).collect();
    let parts: &'static [ProbePart<'static>] = Box::leak(parts.into_boxed_slice());
    let spec = ModelSpec { green: Some(bodies::green(ELLIPSOID, MATERIAL)), ..ModelSpec::new(ELLIPSOID, MATERIAL, parts) };
    let mut drive = Drive::from_spec(&spec, &params);
    (0..4).for_each(|_| _ = drive.tick(Vec3::ZERO, Quat::IDENTITY));
    drive
}

fn leg(x: f32, depth: f32) -> ProbePart<'static> {
    let z = 0.04 * (1.0 - (x / 0.06) * (x / 0.06)).sqrt();
    let normal = Vec3::new(x / 0.0036, 0.0, z / 0.0016).normalize();
    let position = Vec3::new(x, 0.0, 0.04 + z) + normal * (BALL - depth);
    ProbePart { shape: ProbeShape::Sphere { radius: BALL }, position, rotation: Quat::IDENTITY }
}

/// Torque per turn about the vertical through the middle [N m/rad], with the legs' forces taken at their places on the undeformed surface.
fn stiffness(drive: &mut Drive) -> f32 {
    const TURN: f32 = 1.0e-3;
    let about = |drive: &Drive| -> f32 {
        let held = |p: &haptor_contact::Patch| (p.at_rest().cross(p.to_world(p.grip.force)) + p.normal * p.grip.torque).z;
        drive.state().patches().iter().map(held).sum()
    };
    let before = about(drive);
    drive.turn(Vec3::Z, TURN, 5);
    // what the last tick's few sweeps left is made up at rest
    (0..10).for_each(|i| _ = drive.tick(Vec3::Z * 1.0e-9 * (i % 2) as f32, drive.rotation));
    (about(drive) - before) / TURN
}

#[test]
fn one_patch_and_two_legs_on_the_ellipsoid_are_as_stiff_as_finite_elements_say() {
    // legs at, radius seen from above, torque per turn
    let cases: [(&[f32], f32, f32); 6] = [
        (&[0.0], 0.004, 0.328_0),
        (&[0.0], 0.008, 2.486_9),
        (&[0.0], 0.016, 16.861),
        (&[0.012, -0.012], 0.006, 10.136),
        (&[0.02, -0.02], 0.006, 21.701),
        (&[0.03, -0.03], 0.006, 40.212),
    ];
    for (legs, radius, expected) in cases {
        let mut drive = pressed(legs, radius);
        let found = stiffness(&mut drive);
        let error = found / expected - 1.0;
        println!("legs at {legs:?}, {radius} m: {found:.3} N m/rad, {:.1} %", 100.0 * error);
        let tolerance = if legs.len() == 1 { 0.05 } else { 0.04 };
        assert!(error.abs() < tolerance, "{legs:?} {radius}: {found} N m/rad, expected {expected}");
        assert!(!drive.report().flags.contains(Flags::TIER_LOWERED));
    }
}

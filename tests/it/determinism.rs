//! The same bits everywhere: a long mixed session has the digest that is written here, in debug and in release, on every machine.

use glam::{Quat, Vec3};
use haptor_contact::{
    Breakaway, Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Scratch, State,
    Tier, step,
};

use crate::support::noise::noise;

/// Ticks of a session: ten turning points of every coordinate.
const TICKS: u32 = 160;

/// Fowler, Noll and Vo's hash, 64 bits, of every bit of every output.
#[derive(Clone, Copy)]
struct Digest(u64);

impl Digest {
    const START: Self = Self(0xcbf2_9ce4_8422_2325);

    fn take(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn take_all(&mut self, values: &[f32]) {
        values.iter().for_each(|value| self.take(value.to_bits()));
    }
}

/// Smooth value between the sequence's numbers at every 16th tick.
fn wave(channel: u32, tick: u32) -> f32 {
    let (knot, part) = (tick / 16, (tick % 16) as f32 / 16.0);
    let (a, b) = (noise(channel * 7919 + knot), noise(channel * 7919 + knot + 1));
    a + (b - a) * part * part * (3.0 - 2.0 * part)
}

/// A probe with every shape, six legs on a ring of 25 mm.
fn probe() -> Vec<ProbePart<'static>> {
    let shapes = [
        ProbeShape::Sphere { radius: 0.01 },
        ProbeShape::Box { size: Vec3::new(0.012, 0.016, 0.02) },
        ProbeShape::Cylinder { radius: 0.006, height: 0.02 },
        ProbeShape::Cone { radius: 0.01, height: 0.013_333_334 },
        ProbeShape::Capsule { radius: 0.005, height: 0.01 },
        ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.008, 0.012, 0.01) },
    ];
    // the corners of a hexagon, told in decimals: no sine
    let corners = [(1.0, 0.0), (0.5, 0.866_025_4), (-0.5, 0.866_025_4), (-1.0, 0.0), (-0.5, -0.866_025_4), (0.5, -0.866_025_4)];
    shapes
        .into_iter()
        .zip(corners)
        .map(|(shape, (x, y))| ProbePart { position: Vec3::new(0.025 * x, 0.025 * y, 0.0), ..ProbePart::at_origin(shape) })
        .collect()
}

/// Digest of `ticks` of a wandering probe on `object`.
fn session(object: ObjectShape<'static>, spec: &ParamsSpec, ticks: u32) -> u64 {
    let parts: &'static [ProbePart<'static>] = Box::leak(probe().into_boxed_slice());
    let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.45, density: 1.1e3 };
    let model = Model::new(&ModelSpec::new(object, material, parts)).expect("valid");
    let params = Params::new(spec).expect("valid");
    let (mut state, mut scratch) = (Box::new(State::<16, 64>::new()), Scratch::<16>::new());
    let mut digest = Digest::START;
    for tick in 0..ticks {
        let position = Vec3::new(3.0e-3 * wave(0, tick), 3.0e-3 * wave(1, tick), object.height() + 0.01 - 1.5e-3 * wave(2, tick));
        let rotation = Quat::from_xyzw(0.03 * wave(3, tick), 0.03 * wave(4, tick), 0.3 * wave(5, tick), 1.0).normalize();
        let input = Input { pose: Pose::new(position, rotation), dt: 1.0e-3 };
        let output = step(&model, &params, &mut state, &mut scratch, input);
        digest.take_all(&output.contact.force.to_array());
        digest.take_all(&output.contact.torque.to_array());
        digest.take_all(&output.wrench.force.to_array());
        digest.take_all(&output.wrench.torque.to_array());
        digest.take_all(&[output.report.depth, output.report.radius, output.report.stick]);
        digest.take(output.report.flags.0);
        digest.take(u32::from(output.report.regions) << 8 | u32::from(output.report.high_water));
        digest.take(output.report.refused);
    }
    digest.0
}

fn objects() -> [ObjectShape<'static>; 5] {
    [
        ObjectShape::HalfSpace,
        ObjectShape::Box { size: Vec3::new(0.1, 0.08, 0.06) },
        ObjectShape::Sphere { radius: 0.3 },
        ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.3, 0.25, 0.2) },
        ObjectShape::Cylinder { radius: 0.05, height: 0.1 },
    ]
}

fn tiers() -> [ParamsSpec; 4] {
    let plain = |tier| ParamsSpec { tier, friction_static: Some(0.9), ..ParamsSpec::default() };
    [
        plain(Tier::Point),
        ParamsSpec { samples: 256, ..plain(Tier::Paper) },
        plain(Tier::Bristle),
        ParamsSpec { breakaway: Breakaway::Sharp, gravity: true, samples: 16, ..plain(Tier::Bristle) },
    ]
}

/// One digest over every object and tier.
fn everything() -> u64 {
    let mut digest = Digest::START;
    for object in objects() {
        for spec in tiers() {
            let part = session(object, &spec, TICKS);
            digest.take(part as u32);
            digest.take((part >> 32) as u32);
        }
    }
    digest.0
}

/// Changes only with the physics: say so in the change that changes it.
const EXPECTED: u64 = 0x9b85_7a0a_0cb3_90b0;

#[test]
fn every_build_gives_these_bits() {
    let found = everything();
    assert_eq!(found, EXPECTED, "found {found:#018x}");
}

#[test]
fn two_runs_give_the_same_bits() {
    for object in objects() {
        assert_eq!(session(object, &tiers()[2], TICKS / 2), session(object, &tiers()[2], TICKS / 2), "{object:?}");
    }
}

/// The session is worth its digest: it makes and loses contacts, in every number.
#[test]
fn the_session_is_a_mixed_one() {
    let parts: &'static [ProbePart<'static>] = Box::leak(probe().into_boxed_slice());
    let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.45, density: 1.1e3 };
    let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, material, parts)).expect("valid");
    let params = Params::new(&tiers()[2]).expect("valid");
    let (mut state, mut scratch) = (Box::new(State::<16, 64>::new()), Scratch::<16>::new());
    let mut seen = [false; 7];
    for tick in 0..TICKS {
        let position = Vec3::new(3.0e-3 * wave(0, tick), 3.0e-3 * wave(1, tick), 0.01 - 1.5e-3 * wave(2, tick));
        let rotation = Quat::from_xyzw(0.03 * wave(3, tick), 0.03 * wave(4, tick), 0.3 * wave(5, tick), 1.0).normalize();
        let output = step(&model, &params, &mut state, &mut scratch, Input { pose: Pose::new(position, rotation), dt: 1.0e-3 });
        seen[usize::from(output.report.regions)] = true;
    }
    assert!(seen.iter().filter(|&&seen| seen).count() >= 5, "{seen:?}");
}

/// glam without SIMD: its types have no wider alignment than their numbers, and its products are the same everywhere.
#[test]
fn glam_is_scalar() {
    assert_eq!((align_of::<Quat>(), align_of::<glam::Vec4>()), (4, 4));
}

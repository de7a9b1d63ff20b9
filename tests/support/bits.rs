//! A session of the core without any machine: the same poses, and the digest of every wrench, on a PC and on a Cortex-M7.
//!
//! Needs nothing but the core, so that the image for the Cortex-M7 can include this file.

use haptor_contact::{
    Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Quat, Scratch, State, Tier,
    Vec3, step,
};

/// Digest that every build must give. It changes with the physics and with nothing else.
pub const EXPECTED: u64 = 0xddfe_0b72_3b3a_7125;

/// Ticks of each scene: press, twist, slide and lift at a coarse rate.
const TICKS: usize = 400;

/// The material of the paper's Table I.
const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };

/// Runs every tier over three objects and digests the bits of all wrenches.
pub fn session() -> u64 {
    let ball = ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 });
    let leg = |x: f32| ProbePart { position: Vec3::new(x, 0.0, 0.0), ..ball };
    let objects = [
        (ObjectShape::HalfSpace, [leg(-0.025), leg(0.025)]),
        (
            ObjectShape::Box { size: Vec3::splat(0.1) },
            [leg(-0.025), ProbePart { shape: ProbeShape::Cylinder { radius: 0.01, height: 0.04 }, ..leg(0.02) }],
        ),
        (ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) }, [leg(-0.012), leg(0.012)]),
    ];
    let mut digest = FNV_OFFSET;
    for (object, parts) in &objects {
        for tier in [Tier::Point, Tier::Paper, Tier::Bristle] {
            digest = felt(*object, parts, tier, digest);
        }
    }
    digest
}

/// FNV-1a, 64 bits.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0100_0000_01b3;

/// One scene under one tier.
fn felt(object: ObjectShape<'static>, parts: &[ProbePart<'_>], tier: Tier, digest: u64) -> u64 {
    let spec = ModelSpec::new(object, RUBBER, parts);
    let (Ok(model), Ok(params)) = (Model::new(&spec), Params::new(&ParamsSpec { tier, ..ParamsSpec::default() })) else {
        return 0;
    };
    let (mut state, mut scratch) = (State::<16, 64>::new(), Scratch::<16>::new());
    (0..TICKS).fold(digest, |digest, tick| {
        let input = Input { pose: pose(&object, tick as f32 / TICKS as f32), dt: 1.0e-3 };
        let output = step(&model, &params, &mut state, &mut scratch, input);
        let floats = [output.contact.force, output.contact.torque, output.wrench.force, output.wrench.torque];
        let words = floats.into_iter().flat_map(|v| v.to_array()).map(f32::to_bits);
        words.flat_map(u32::to_le_bytes).fold(digest, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(FNV_PRIME))
    })
}

/// Pose at share `t` of the session, by products and sums only: press 1.5 mm, twist and tilt, slide, lift.
fn pose(object: &ObjectShape<'_>, t: f32) -> Pose<haptor_contact::World, haptor_contact::ProbeFrame> {
    let ramp = |from: f32, to: f32| ((t - from) / (to - from)).clamp(0.0, 1.0);
    let depth = 0.0015 * ramp(0.05, 0.3) - 0.004 * ramp(0.9, 1.0);
    let (twist, tilt, slide) = (0.3 * ramp(0.3, 0.6) - 0.2 * ramp(0.6, 0.7), 0.05 * ramp(0.4, 0.8), 0.004 * ramp(0.6, 0.9));
    let half = Quat::from_xyzw(0.5 * tilt, 0.25 * tilt, 0.5 * twist, 1.0).normalize();
    Pose::new(Vec3::new(slide, 0.5 * slide, object.height() + 0.02 - depth), half)
}

//! The short version of `cargo xtask extremes`: random corners of the box keep the laws, and what lies outside it is refused or flagged by name.
//!
//! What the laws are and why their bounds are what they are stands in the document that the command writes.

use haptor_contact::{
    Flags, Input, MAX_TICK, MIN_TICK, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape,
    Quat, Scratch, State, Vec3, step,
};
use haptor_tests::extremes::laws::{LAWS, Law, place_of};
use haptor_tests::extremes::run::some;

/// Seed of the short run: not that of the long one, whose cases are kept.
const SEED: u64 = 7;

/// Cases of the short run.
const CASES: u64 = 240;

/// Laws that hold to the bit or to rounding in every case.
const STRICT: [Law; 4] = [Law::Wander, Law::Coupled, Law::Times, Law::Hold];

/// Share of the measured cases of another law that may be above its bound: detection at edges, and slices of boxes below 20 um.
const ABOVE: f64 = 0.15;

#[test]
fn random_corners_keep_the_laws() {
    let tallies = some(SEED, CASES);
    assert_eq!(tallies.faulty, 0, "{:#?}", tallies.faults);
    for law in LAWS {
        let rows = &tallies.laws[place_of(law)];
        let (measured, above): (u64, u64) = rows.iter().fold((0, 0), |(m, a), row| (m + row.measured, a + row.above));
        println!("{}: {measured} measured, {above} above", law.name());
        let most = if STRICT.contains(&law) { 0.0 } else { (ABOVE * measured as f64).max(2.0) };
        assert!(above as f64 <= most, "{}: {above} of {measured} cases above the bound: {rows:#?}", law.name());
        assert!(measured > 0, "{} was never measured", law.name());
    }
}

#[test]
fn two_runs_are_the_same() {
    assert_eq!(some(SEED, 48).digest, some(SEED, 48).digest);
}

/// A ball on a half space for the drills below.
fn on_rubber(radius: f32, young_modulus: f32) -> impl FnMut(Vec3, f32) -> haptor_contact::Output {
    let parts: &'static [ProbePart<'static>] =
        Box::leak(vec![ProbePart::at_origin(ProbeShape::Sphere { radius })].into_boxed_slice());
    let material = Material { young_modulus, poisson_ratio: 0.5, density: 1.1e3 };
    let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, material, parts)).expect("valid");
    let params = Params::new(&ParamsSpec::default()).expect("valid");
    let (mut state, mut scratch) = (Box::new(State::<16, 64>::new()), Scratch::<16>::new());
    move |at, dt| step(&model, &params, &mut state, &mut scratch, Input { pose: Pose::new(at, Quat::IDENTITY), dt })
}

#[test]
fn ticks_that_are_none_are_refused_and_count_no_time() {
    let mut tick = on_rubber(0.02, 3.0e6);
    let at = Vec3::Z * 0.019;
    tick(at, 1.0e-3);
    for dt in [0.5 * MIN_TICK, 2.0 * MAX_TICK, f32::MAX, 1.0e-40] {
        assert!(tick(at, dt).report.flags.contains(Flags::POSE_REFUSED), "{dt}");
    }
    for dt in [MIN_TICK, MAX_TICK] {
        assert!(!tick(at, dt).report.flags.contains(Flags::POSE_REFUSED), "{dt}");
    }
}

/// The same depth near the origin, far from it, and a depth that no pose near the origin can tell.
#[test]
fn depths_below_the_digits_of_the_pose_are_flagged() {
    let coarse = |at: Vec3| on_rubber(0.02, 3.0e6)(at, 1.0e-3).report.flags.contains(Flags::POSE_COARSE);
    assert!(!coarse(Vec3::Z * 0.019), "1 mm deep at the origin");
    assert!(coarse(Vec3::new(900.0, 0.0, 0.019)), "1 mm deep at 900 m");
    assert!(coarse(Vec3::Z * (0.02 - 1.0e-8)), "10 nm deep at the origin");
}

/// Friction whose shares among the samples would leave the range of an f32 is none, and the load stays.
#[test]
fn friction_below_its_range_is_none() {
    let mut tick = on_rubber(1.0e-6, 1.0e2);
    let (radius, depth) = (1.0e-6, 1.0e-10);
    tick(Vec3::Z * (radius - depth), 1.0e-3);
    let output = tick(Vec3::new(depth, 0.0, radius - depth), 1.0e-3);
    assert_eq!((output.contact.force.x, output.contact.force.y), (0.0, 0.0));
    assert!(output.contact.force.z > 0.0);
}

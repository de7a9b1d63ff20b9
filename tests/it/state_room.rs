//! A state is as large as the tier needs: less room lowers the tier and says so, and what a tier does not use it need not have.

use haptor_contact::{
    Flags, Input, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Quat, Scratch, State, Tier,
    Vec3, Wrench, step,
};

use crate::support::drive::RUBBER;

/// A press with a drag and a twist; the last wrench and all flags.
fn felt<const SAMPLES: usize, const TRACES: usize>(tier: Tier, samples: usize) -> (Wrench, Flags) {
    let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
    let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, RUBBER, &ball)).unwrap();
    let params = Params::new(&ParamsSpec { tier, samples, ..ParamsSpec::default() }).unwrap();
    let (mut state, mut scratch) = (Box::new(State::<1, SAMPLES, TRACES>::new()), Scratch::<1>::new());
    let mut last = (Wrench::ZERO, Flags::CLEAN);
    for tick in 0..200 {
        let t = tick as f32 / 200.0;
        let pose = Pose::new(Vec3::new(2.0e-4 * t, 0.0, 0.02 - 3.0e-4 * t), Quat::from_rotation_z(0.1 * t));
        let output = step(&model, &params, &mut state, &mut scratch, Input { pose, dt: 1.0e-3 });
        last = (output.contact, last.1 | output.report.flags);
    }
    last
}

#[test]
fn a_tier_takes_the_room_it_needs_and_no_more() {
    let point = felt::<0, 0>(Tier::Point, 64);
    assert_eq!(point, felt::<256, 256>(Tier::Point, 64));
    assert_eq!(felt::<0, 0>(Tier::Paper, 64), felt::<256, 256>(Tier::Paper, 64));
    assert_eq!(felt::<64, 0>(Tier::Bristle, 64), felt::<256, 256>(Tier::Bristle, 64));
    assert_eq!(felt::<80, 80>(Tier::Influence, 52), felt::<256, 256>(Tier::Influence, 52));
    assert_eq!([point.1, felt::<64, 0>(Tier::Bristle, 64).1, felt::<80, 80>(Tier::Influence, 52).1], [Flags::CLEAN; 3]);
}

#[test]
fn less_room_lowers_the_tier_and_says_so() {
    assert_eq!(felt::<0, 0>(Tier::Bristle, 64), (felt::<0, 0>(Tier::Point, 64).0, Flags::TIER_LOWERED));
    assert_eq!(felt::<256, 0>(Tier::Influence, 52).1, Flags::TIER_LOWERED);
    assert_eq!(felt::<0, 0>(Tier::Influence, 52), (felt::<0, 0>(Tier::Point, 64).0, Flags::TIER_LOWERED));
    assert_eq!(felt::<256, 256>(Tier::Green, 52), (felt::<256, 256>(Tier::Influence, 52).0, Flags::TIER_LOWERED));
}

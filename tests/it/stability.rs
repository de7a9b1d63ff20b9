//! The closed loop of hand, device, link and core: inside the stated region it holds still and does not kick, beyond it the rig really shakes. The whole map is
//! `tests/bench/STABILITY.md`; here are loops of every kind.

use glam::{Quat, Vec3};
use haptor_contact::{
    CouplingSpec, Flags, GuardSpec, Inertia, Input, Material, Model, ModelSpec, ObjectShape, Output, Params, ParamsSpec,
    Passivity, Pose, ProbePart, ProbeShape, Scratch, State, Tier, VirtualCoupling, step,
};
use haptor_firmware_sim::plant::FIRM_GRIP;
use haptor_tests::stability::map::{HANDS, LIGHT_GRIP, MACHINES, on_two_threads};
use haptor_tests::stability::rig::{Case, Seen};
use haptor_tests::stability::words::REGION;

use crate::support::noise::noise;

/// A loop on the Premium class device at 1 kHz.
fn premium(coupled: bool, young_modulus: f32, delay: usize) -> Case {
    let machine = MACHINES[0];
    Case { machine, hand: FIRM_GRIP, young_modulus, rate_hz: 1000, delay, coupled, passive: false, mass: 1.0 }
}

/// Loops of every device, hand and coupling: a coarse map.
fn coarse() -> Vec<Case> {
    let mut cases = Vec::new();
    for (machine, (_, hand)) in MACHINES.into_iter().flat_map(|machine| HANDS.map(|hand| (machine, hand))) {
        for (rate_hz, young_modulus, delay) in [(1000, 1.0e5, 5), (1000, 3.0e6, 0), (1000, 1.0e8, 1), (4000, 3.0e6, 2)] {
            let kind = |coupled, passive, mass| Case { machine, hand, young_modulus, rate_hz, delay, coupled, passive, mass };
            cases.extend([kind(false, false, 1.0), kind(true, false, 1.0), kind(true, false, 0.0), kind(true, true, 1.0)]);
        }
    }
    cases
}

fn run(cases: &[Case]) -> Vec<(Case, Seen)> {
    cases.iter().copied().zip(on_two_threads(cases, Case::run)).collect()
}

/// Largest step of the force that a loop may make in a tick \[N\]: what the handle moves in a tick and two steps of the encoder, on the stiffness that it meets within the tick. With a
/// coupling that is five times its own while the probe has mass (theory.md, 10.4). The controller may come and go with all its damping.
fn largest_step(case: &Case, seen: &Seen) -> f32 {
    let (k, _) = case.stiffness(seen);
    let rate = case.rate_hz as f32;
    let damper = if case.passive { case.machine.damps.0 * (seen.fastest + case.machine.preset.encoder * rate) } else { 0.0 };
    let quick = if case.coupled && case.mass > 0.0 { 5.0 * k } else { k };
    quick * (seen.fastest / rate + 2.0 * case.machine.preset.encoder) + damper
}

#[test]
fn inside_the_region_nothing_shakes_grows_or_kicks() {
    let inside: Vec<_> = run(&coarse()).into_iter().filter(|(case, seen)| case.gain(seen) <= REGION).collect();
    assert!(inside.len() > 60, "the coarse map has too few loops inside: {}", inside.len());
    for (case, seen) in inside {
        assert!(seen.is_bounded(), "shakes at gain {}: {case:?} {seen:?}", case.gain(&seen));
        assert!(seen.speed.1 <= 1.5 * seen.speed.0 + 0.5e-3, "grows: {case:?} {seen:?}");
        // touch-down, twist and lift-off give the hand no more than the region's share of what its damping takes
        assert!(seen.energy <= REGION * seen.spent + 1.0e-4, "gains energy: {case:?} {seen:?}");
        assert!(seen.force_step <= largest_step(&case, &seen), "kicks by {}: {case:?} {seen:?}", seen.force_step);
        assert!(seen.force > 0.1 * case.machine.preset.max_force || case.young_modulus < 1.0e6, "no contact: {case:?} {seen:?}");
    }
}

#[test]
fn beyond_it_loops_shake() {
    let light = |case: Case| Case { hand: LIGHT_GRIP, ..case };
    let shaky = [
        premium(false, 1.0e8, 4),
        light(premium(false, 3.0e6, 0)),
        light(premium(false, 1.0e6, 1)),
        light(premium(true, 3.0e6, 8)),
        Case { rate_hz: 500, ..light(premium(true, 3.0e4, 8)) },
        Case { machine: MACHINES[1], ..light(premium(true, 1.0e8, 6)) },
    ];
    for (case, seen) in run(&shaky) {
        assert!(!seen.is_bounded(), "gain {}: {case:?} {seen:?}", case.gain(&seen));
        assert!(case.gain(&seen) > REGION, "inside the region: {case:?}");
    }
}

#[test]
fn with_a_virtual_coupling_the_object_s_stiffness_decides_nothing() {
    for delay in [0, 8] {
        for (case, seen) in run(&[1.0e5, 3.0e6, 1.0e8, 1.0e12].map(|e| premium(true, e, delay))) {
            assert!(seen.is_quiet(), "{case:?} {seen:?}");
        }
    }
    let (case, seen) = run(&[premium(false, 1.0e8, 8)])[0];
    assert!(!seen.is_bounded(), "{case:?} {seen:?}");
}

#[test]
fn the_controller_calms_what_it_has_the_damping_for() {
    let shaky = Case { machine: MACHINES[1], rate_hz: 4000, hand: LIGHT_GRIP, ..premium(false, 1.0e7, 1) };
    let calmed = Case { passive: true, ..shaky };
    let results = run(&[shaky, calmed]);
    let [(_, without), (_, with)] = results.as_slice() else { panic!("two runs") };
    assert!(!without.is_bounded() && with.is_quiet() && with.damped > 0, "{without:?} {with:?}");
}

/// The core alone, driven pose by pose.
struct Felt {
    model: Model<'static>,
    params: Params,
    state: Box<State<16, 64>>,
    scratch: Scratch<16>,
}

const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };

impl Felt {
    fn new(object: ObjectShape<'static>, material: Material, parts: &[ProbePart<'static>], mass: f32, spec: &ParamsSpec) -> Self {
        let parts: &'static [ProbePart<'static>] = Box::leak(parts.to_vec().into_boxed_slice());
        let spec_of_model = ModelSpec { mass, ..ModelSpec::new(object, material, parts) };
        Self {
            model: Model::new(&spec_of_model).expect("valid model"),
            params: Params::new(spec).expect("valid parameters"),
            state: Box::new(State::new()),
            scratch: Scratch::new(),
        }
    }

    fn tick(&mut self, position: Vec3, rotation: Quat, dt: f32) -> Output {
        let input = Input { pose: Pose::new(position, rotation), dt };
        step(&self.model, &self.params, &mut self.state, &mut self.scratch, input)
    }
}

fn virtual_spec() -> ParamsSpec {
    ParamsSpec { coupling: CouplingSpec::Virtual(VirtualCoupling::default()), ..ParamsSpec::default() }
}

fn ball() -> [ProbePart<'static>; 1] {
    [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })]
}

#[test]
fn an_hour_at_rest_does_not_drift() {
    let mut felt = Felt::new(ObjectShape::HalfSpace, RUBBER, &ball(), 1.0, &virtual_spec());
    let at = |share: f32| (Vec3::new(0.002 * share, 0.0, 0.021 - 0.008 * share), Quat::from_rotation_z(0.05 * share));
    for i in 0..=1000 {
        let (position, rotation) = at(i as f32 / 1000.0);
        felt.tick(position, rotation, 1.0e-3);
    }
    let (position, rotation) = at(1.0);
    let settled = (0..10_000).map(|_| felt.tick(position, rotation, 1.0e-3)).last().expect("ticks");
    let probe = felt.state.probe_pose();
    assert!(settled.wrench.force.z > 4.0 && (settled.wrench.force - settled.contact.force).length() < 2.0e-3, "{settled:?}");
    // 1 kHz for an hour
    for tick in 0..3_600_000 {
        assert_eq!(felt.tick(position, rotation, 1.0e-3), settled, "tick {tick}");
    }
    assert_eq!(felt.state.probe_pose(), probe);
}

/// A number between powers of ten.
fn decades(i: u32, low: f32, high: f32) -> f32 {
    10.0_f32.powf(low + (high - low) * 0.5 * (noise(i) + 1.0))
}

fn shape(kind: u32, size: f32) -> ProbeShape<'static> {
    let (radius, height) = (0.5 * size, size);
    match kind % 6 {
        0 => ProbeShape::Sphere { radius },
        1 => ProbeShape::Box { size: Vec3::new(size, 0.5 * size, 0.8 * size) },
        2 => ProbeShape::Cylinder { radius, height },
        3 => ProbeShape::Cone { radius, height },
        4 => ProbeShape::Capsule { radius, height },
        _ => ProbeShape::Ellipsoid { semi_axes: Vec3::new(radius, 0.5 * radius, 0.7 * radius) },
    }
}

/// Random scenes of every size, stiffness, mass and tick, with handles that jump, jitter and turn.
#[test]
fn no_input_breaks_the_coupling() {
    for scene in 0..300_u32 {
        let pick = |channel: u32| scene * 64 + channel;
        let size = decades(pick(0), -3.0, 1.0);
        let legs: Vec<_> = (0..1 + scene % 3)
            .map(|i| ProbePart {
                position: Vec3::new(size * (i as f32 - 0.5), 0.3 * size * noise(pick(20 + i)), 0.0),
                ..ProbePart::at_origin(shape(scene + i, size))
            })
            .collect();
        let objects =
            [ObjectShape::HalfSpace, ObjectShape::Box { size: Vec3::splat(3.0 * size) }, ObjectShape::Sphere { radius: size }];
        let object = objects[scene as usize % 3];
        let material = Material { young_modulus: decades(pick(1), 2.0, 12.0), ..RUBBER };
        let mass = if scene % 4 == 0 { 0.0 } else { decades(pick(2), -6.0, 4.0) };
        let dt = decades(pick(3), -6.0, 0.0);
        let coupling = VirtualCoupling {
            max_force: if scene % 5 == 0 { 1.0 } else { f32::INFINITY },
            translational_damping: (scene % 7 == 0).then_some(1.0e5),
            ..VirtualCoupling::closable(decades(pick(4), 0.0, 6.0), decades(pick(5), -4.0, 4.0))
        };
        let guard = GuardSpec { passivity: (scene % 2 == 0).then(Passivity::default), ..GuardSpec::default() };
        let tier = [Tier::Point, Tier::Paper, Tier::Bristle][scene as usize % 3];
        let spec = ParamsSpec { coupling: CouplingSpec::Virtual(coupling), guard, tier, ..ParamsSpec::default() };
        let mut felt = Felt::new(object, material, &legs, mass, &spec);
        for tick in 0..150_u32 {
            let wander = |channel: u32| noise(scene * 4096 + channel * 997 + tick / 8);
            let position =
                Vec3::new(0.1 * size * wander(0), 0.1 * size * wander(1), object.height() + size * (0.4 + 0.4 * wander(2)));
            let rotation = Quat::from_xyzw(wander(3), wander(4), wander(5), 1.0).normalize();
            let output = felt.tick(position, rotation, dt);
            let told = || format!("scene {scene} tick {tick}: {output:?}");
            assert!(output.wrench.is_finite() && output.contact.is_finite(), "{}", told());
            assert!(!output.report.flags.contains(Flags::NON_FINITE), "{}", told());
            assert!(
                output.wrench.force.length() <= 8.5 * 1.00001 && output.wrench.torque.length() <= 0.188 * 1.00001,
                "{}",
                told()
            );
            let probe = felt.state.probe_pose().expect("a tick was run");
            assert!(probe.position.is_finite() && (probe.rotation.length() - 1.0).abs() < 1.0e-5, "{}", told());
        }
    }
}

#[test]
fn the_coupling_may_be_changed_while_it_holds() {
    let direct = ParamsSpec::default();
    let mut felt = Felt::new(ObjectShape::HalfSpace, RUBBER, &ball(), 0.2, &direct);
    let pressed = Vec3::Z * 0.0196;
    for tick in 0..2000_u32 {
        let spec = if (tick / 500) % 2 == 0 { direct } else { virtual_spec() };
        felt.params = Params::new(&spec).expect("valid");
        let output = felt.tick(pressed, Quat::IDENTITY, 1.0e-3);
        assert!(!output.report.flags.contains(Flags::NON_FINITE));
        if tick % 500 == 499 {
            let probe = felt.state.probe_pose().expect("ticks").position;
            let expected = if (tick / 500) % 2 == 0 { 0.0196 } else { 0.02 };
            assert!((probe.z - expected).abs() < 1.0e-4, "tick {tick}: probe at {probe}");
        }
    }
}

/// The virtual coupling's bits: changes only with the physics.
const EXPECTED: u64 = 0x12a6_1f19_7b64_053a;

#[test]
fn every_build_gives_these_bits() {
    let mut digest = 0xcbf2_9ce4_8422_2325_u64;
    for (mass, scene) in [(0.0, 0_u32), (0.3, 1), (1.0, 2)] {
        let legs = [shape(scene, 0.02), shape(scene + 1, 0.02)].map(ProbePart::at_origin);
        let legs = [ProbePart { position: Vec3::X * 0.02, ..legs[0] }, ProbePart { position: Vec3::X * -0.02, ..legs[1] }];
        let guard = GuardSpec { passivity: Some(Passivity::default()), ..GuardSpec::default() };
        let mut felt = Felt::new(ObjectShape::HalfSpace, RUBBER, &legs, mass, &ParamsSpec { guard, ..virtual_spec() });
        for tick in 0..400_u32 {
            let wander = |channel: u32| {
                let (knot, part) = (tick / 32, (tick % 32) as f32 / 32.0);
                let (a, b) = (noise(channel * 7919 + knot), noise(channel * 7919 + knot + 1));
                a + (b - a) * part * part * (3.0 - 2.0 * part)
            };
            let position = Vec3::new(3.0e-3 * wander(0), 3.0e-3 * wander(1), 6.0e-3 + 6.0e-3 * wander(2));
            let rotation = Quat::from_xyzw(0.05 * wander(3), 0.05 * wander(4), 0.2 * wander(5), 1.0).normalize();
            let output = felt.tick(position, rotation, 1.0e-3);
            let vectors = [output.contact.force, output.contact.torque, output.wrench.force, output.wrench.torque];
            for byte in vectors.iter().flat_map(|v| [v.x, v.y, v.z]).flat_map(|x| x.to_bits().to_le_bytes()) {
                digest = (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    assert_eq!(digest, EXPECTED, "found {digest:#018x}");
}

#[test]
fn a_given_inertia_is_used_and_a_wrong_one_refused() {
    let parts: &'static [ProbePart<'static>] = Box::leak(ball().to_vec().into_boxed_slice());
    let spec = ModelSpec::new(ObjectShape::HalfSpace, RUBBER, parts);
    let own = Model::new(&spec).expect("valid").inertia();
    assert!((own.moments - Vec3::splat(0.4 * 4.0e-4)).length() < 1.0e-8, "{own:?}");
    let given = Inertia { moments: Vec3::new(1.0e-3, 1.0e-3, 2.0e-4), products: Vec3::ZERO };
    assert_eq!(Model::new(&ModelSpec { inertia: Some(given), ..spec }).expect("valid").inertia(), given);
    let wrong = Inertia { moments: Vec3::new(1.0e-3, 1.0e-4, 1.0e-4), products: Vec3::ZERO };
    let refused = Model::new(&ModelSpec { inertia: Some(wrong), ..spec }).expect_err("no body has it");
    assert_eq!(refused.name, "probe.inertia.moments");
    let soft = VirtualCoupling { translational_stiffness: 0.0, ..VirtualCoupling::default() };
    let refused = Params::new(&ParamsSpec { coupling: CouplingSpec::Virtual(soft), ..ParamsSpec::default() });
    assert_eq!(refused.expect_err("no coupling").name, "coupling.translational_stiffness");
}

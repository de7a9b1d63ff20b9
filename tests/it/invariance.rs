//! What must not matter: where the scene stands, which way it faces, in which units it is told, how the probe is put together; and what
//! friction can never do: push along the motion, or give work.

use std::f64::consts::{PI, TAU};

use glam::{EulerRot, Quat, Vec3};
use haptor_contact::geometry::support::support;
use haptor_contact::{Input, Wrench};
use haptor_contact::{
    Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Scratch, Tier, step,
};

use crate::support::drive::{Drive, FullState, RUBBER};
use crate::support::led::Units;

const TIERS: [Tier; 3] = [Tier::Point, Tier::Paper, Tier::Bristle];

fn tier(tier: Tier) -> ParamsSpec {
    ParamsSpec { tier, ..ParamsSpec::default() }
}

/// Poses of a hand's motion over a level top at height 0: approach, press, twist, slide round, tilt, lift. The ball has 20 mm.
fn motion() -> Vec<(Vec3, Quat)> {
    (0..=300)
        .map(|i| {
            let t = i as f32 / 300.0;
            let wave = |rate: f32| (TAU as f32 * rate * t).sin();
            let depth = 1.5e-3 * (PI as f32 * t).sin() - 1.0e-4;
            let at = Vec3::new(1.5e-3 * wave(1.3), 1.0e-3 * wave(2.1), 0.02 - depth);
            (at, Quat::from_euler(EulerRot::ZYX, 0.6 * wave(1.0), 0.02 * wave(1.7), 0.03 * wave(0.6)))
        })
        .collect()
}

/// Wrenches of `motion`, each pose moved by `place`.
fn felt(
    object: ObjectShape<'static>,
    probe: &[ProbePart<'static>],
    params: &ParamsSpec,
    place: impl Fn(Vec3, Quat) -> (Vec3, Quat),
) -> Vec<Wrench> {
    let mut drive = Drive::new(object, RUBBER, probe, params);
    motion()
        .into_iter()
        .map(|(at, turn)| {
            let (at, turn) = place(at, turn);
            drive.tick(at, turn.normalize()).contact
        })
        .collect()
}

const BALL: [ProbePart<'static>; 1] = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];

/// Largest difference of two sessions, over the largest force and the largest torque of the first.
fn apart(a: &[Wrench], b: &[Wrench]) -> (f32, f32) {
    let peak = |of: &dyn Fn(&Wrench) -> f32| a.iter().map(of).fold(0.0, f32::max);
    let off = |of: &dyn Fn(&Wrench) -> Vec3| a.iter().zip(b).map(|(a, b)| (of(a) - of(b)).length()).fold(0.0, f32::max);
    (off(&|w| w.force) / peak(&|w| w.force.length()), off(&|w| w.torque) / peak(&|w| w.torque.length()))
}

fn turned(w: &Wrench, by: Quat) -> Wrench {
    Wrench::new(by * w.force, by * w.torque)
}

fn check(what: &str, choice: Tier, a: &[Wrench], b: &[Wrench], tolerance: f32) {
    let (force, torque) = apart(a, b);
    println!("{what}, {choice:?}: {force:.2e} of the force, {torque:.2e} of the torque");
    assert!(force < tolerance && torque < tolerance, "{what}, {choice:?}: {force} {torque}");
}

/// On a half space x and y have no origin. At 1 m an f32 resolves 0.06 um, 5e-5 of s0.
#[test]
fn place_does_not_matter() {
    for choice in TIERS {
        let here = felt(ObjectShape::HalfSpace, &BALL, &tier(choice), |at, turn| (at, turn));
        let there = felt(ObjectShape::HalfSpace, &BALL, &tier(choice), |at, turn| (at + Vec3::new(0.25, -0.5, 0.0), turn));
        check("moved", choice, &here, &there, 2.0e-3);
    }
}

/// Samples stand in a pattern; 64 of them know direction by less than 1 %, and left from right by less than 2 %.
const PATTERN: f32 = 0.02;

/// Nor a direction: turned about z, the same session gives the same wrenches, turned.
#[test]
fn direction_does_not_matter() {
    for choice in TIERS {
        let here = felt(ObjectShape::HalfSpace, &BALL, &tier(choice), |at, turn| (at, turn));
        for degrees in [90.0_f32, 180.0, 33.0, 251.0] {
            let by = Quat::from_rotation_z(degrees.to_radians());
            let there = felt(ObjectShape::HalfSpace, &BALL, &tier(choice), |at, turn| (by * at, by * turn));
            let expected: Vec<Wrench> = here.iter().map(|w| turned(w, by)).collect();
            check(&format!("turned by {degrees}"), choice, &expected, &there, PATTERN);
        }
    }
}

/// Mirrored in the plane y = 0: forces mirror, torques mirror the other way round.
#[test]
fn left_and_right_are_alike() {
    for choice in TIERS {
        let here = felt(ObjectShape::HalfSpace, &BALL, &tier(choice), |at, turn| (at, turn));
        let there = felt(ObjectShape::HalfSpace, &BALL, &tier(choice), |at, turn| {
            (Vec3::new(at.x, -at.y, at.z), Quat::from_xyzw(-turn.x, turn.y, -turn.z, turn.w))
        });
        let mirror = |w: &Wrench| {
            let (f, t) = (w.force, w.torque);
            Wrench::new(Vec3::new(f.x, -f.y, f.z), Vec3::new(-t.x, t.y, -t.z))
        };
        let expected: Vec<Wrench> = here.iter().map(mirror).collect();
        check("mirrored", choice, &expected, &there, PATTERN);
    }
}

/// A drag of half and of full slip, in 24 directions: the same force, and along the drag.
#[test]
fn friction_is_isotropic() {
    for choice in TIERS {
        for share in [0.5, 1.5] {
            let mut sizes = Vec::new();
            for i in 0..24 {
                let angle = TAU as f32 * i as f32 / 24.0;
                let mut drive = Drive::ball(ObjectShape::HalfSpace, 0.02, 0.5, &tier(choice));
                drive.press_to(0.02, 1.0e-3);
                let units = Units::of(&drive, 0.75);
                // the paper's tier takes a longer way: G s/l instead of K_t
                let reach = if choice == Tier::Paper { 60.0 } else { 1.0 };
                let along = Vec3::new(angle.cos(), angle.sin(), 0.0);
                drive.shift(along * (share * reach * units.shift) as f32, 60);
                let held = drive.held();
                let force = Vec3::new(held[0] as f32, held[1] as f32, 0.0);
                let size = force.length();
                assert!(force.dot(along) > 0.999_9 * size, "{choice:?} at {angle}: {force}");
                sizes.push(size);
            }
            let (least, most) = sizes.iter().fold((f32::MAX, 0.0_f32), |(l, m), &s| (l.min(s), m.max(s)));
            println!("{choice:?}, {share} of slip: {:.2e} apart", most / least - 1.0);
            assert!(most / least - 1.0 < 0.01, "{choice:?} {share}: {least} to {most} N");
        }
    }
}

/// Lengths times s and moduli times t: forces go as t s^2, torques as t s^3. Powers of two scale every product exactly, so that only
/// thresholds told in metres could show.
#[test]
fn units_do_not_matter() {
    for choice in TIERS {
        let session = |s: f32, t: f32| -> Vec<Wrench> {
            let material = Material { young_modulus: RUBBER.young_modulus * t, ..RUBBER };
            let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 * s })];
            let parts: &'static [ProbePart<'static>] = Box::leak(ball.to_vec().into_boxed_slice());
            let spec = ModelSpec { paper_length: 0.1 * s, ..ModelSpec::new(ObjectShape::HalfSpace, material, parts) };
            let params = ParamsSpec { region_distance: 0.004 * s, ..tier(choice) };
            let mut drive = Drive::from_spec(&spec, &params);
            let scale = |w: Wrench| Wrench::new(w.force / (t * s * s), w.torque / (t * s * s * s));
            motion().into_iter().map(|(at, turn)| scale(drive.tick(at * s, turn.normalize()).contact)).collect()
        };
        let here = session(1.0, 1.0);
        for (s, t) in [(0.125, 1.0), (8.0, 1.0), (1.0, 1024.0), (0.0625, 64.0), (0.3, 7.0)] {
            check(&format!("lengths x {s}, moduli x {t}"), choice, &here, &session(s, t), 2.0e-4);
        }
    }
}

/// A part turned inside the probe is the probe turned: what counts is where the shape is.
#[test]
fn part_rotation_is_probe_rotation() {
    let shapes = [
        ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) },
        ProbeShape::Cylinder { radius: 0.015, height: 0.04 },
        ProbeShape::Cone { radius: 0.02, height: 0.02 },
        ProbeShape::Capsule { radius: 0.01, height: 0.02 },
        ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.03, 0.02, 0.02) },
    ];
    let inner = Quat::from_euler(EulerRot::XYZ, 0.4, -0.3, 0.8);
    for choice in TIERS {
        for shape in shapes {
            let plain = [ProbePart::at_origin(shape)];
            let inside = [ProbePart { rotation: inner, ..ProbePart::at_origin(shape) }];
            // `motion` is told for a ball of 20 mm
            let down = inner * support(&shape, inner.conjugate() * Vec3::NEG_Z);
            let lift = Vec3::Z * (-down.z - 0.02);
            let a = felt(ObjectShape::HalfSpace, &plain, &tier(choice), |at, turn| (at + lift, turn * inner));
            let b = felt(ObjectShape::HalfSpace, &inside, &tier(choice), |at, turn| (at + lift, turn));
            check(&format!("{shape:?}"), choice, &a, &b, 2.0e-3);
        }
    }
}

/// A ball away from the mass centre: the torque is r x F plus what the ball itself would feel about its own centre.
#[test]
fn torque_is_about_the_mass_centre() {
    let arm = Vec3::new(0.03, -0.02, 0.01);
    for choice in [Tier::Point, Tier::Bristle] {
        let probe = [ProbePart { position: arm, ..BALL[0] }];
        let mut carried = Drive::new(ObjectShape::HalfSpace, RUBBER, &probe, &tier(choice));
        let mut own = Drive::new(ObjectShape::HalfSpace, RUBBER, &BALL, &tier(choice));
        for (at, turn) in motion() {
            let turn = turn.normalize();
            let r = turn * arm;
            let ball = own.tick(at, turn).contact;
            let probe = carried.tick(at - r, turn).contact;
            let expected = r.cross(ball.force) + ball.torque;
            // poses are rounded differently: 2 nm at 30 mm
            assert!((probe.force - ball.force).length() < 2e-3 * (1.0 + ball.force.length()), "{choice:?}: {probe:?} {ball:?}");
            assert!((probe.torque - expected).length() < 2e-3 * (0.02 + expected.length()), "{choice:?}: {probe:?} {expected}");
        }
    }
}

/// Work done by the probe on the object over closed cycles, in joules per cycle and over the largest energy the cycle stored or lost.
fn cycles(choice: Tier, at: impl Fn(f32) -> (Vec3, Quat), ticks: usize) -> Vec<f64> {
    let model_parts: &'static [ProbePart<'static>] = Box::leak(BALL.to_vec().into_boxed_slice());
    let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, RUBBER, model_parts)).expect("valid");
    let params = Params::new(&tier(choice)).expect("valid");
    let (mut state, mut scratch) = (Box::new(FullState::new()), Scratch::<16>::new());
    let mut felt = |t: f32| {
        let (position, rotation) = at(t);
        let input = Input { pose: Pose::new(position, rotation.normalize()), dt: 1.0e-3 };
        (position, rotation, step(&model, &params, &mut state, &mut scratch, input).contact)
    };
    let mut last = felt(0.0);
    (0..4)
        .map(|_| {
            let mut work = 0.0;
            for tick in 1..=ticks {
                let next = felt(tick as f32 / ticks as f32);
                let moved = next.0 - last.0;
                let (axis, angle) = (next.1 * last.1.conjugate()).to_axis_angle();
                let force = (next.2.force + last.2.force) * 0.5;
                let torque = (next.2.torque + last.2.torque) * 0.5;
                work -= f64::from(force.dot(moved) + torque.dot(axis) * angle);
                last = next;
            }
            work
        })
        .collect()
}

/// Friction takes, never gives: over every closed cycle the hand does work on the object, or at most 1 % of the cycle's own scale is missing.
#[test]
fn friction_gives_no_energy() {
    type Cycle = fn(f32) -> (Vec3, Quat);
    let cases: [(&str, Cycle); 5] = [
        ("drag to and fro", |t| (Vec3::new(8e-4 * (TAU as f32 * t).sin(), 0.0, 0.019), Quat::IDENTITY)),
        ("small drag", |t| (Vec3::new(1e-4 * (TAU as f32 * t).sin(), 0.0, 0.019), Quat::IDENTITY)),
        ("round and round", |t| {
            let (s, c) = (TAU as f32 * t).sin_cos();
            (Vec3::new(8e-4 * c, 8e-4 * s, 0.019), Quat::IDENTITY)
        }),
        ("twist to and fro", |t| (Vec3::Z * 0.019, Quat::from_rotation_z(0.15 * (TAU as f32 * t).sin()))),
        ("spiral", |t| {
            let (s, c) = (TAU as f32 * t).sin_cos();
            (Vec3::new(5e-4 * c, 7e-4 * s, 0.019), Quat::from_rotation_z(0.12 * (2.0 * TAU as f32 * t).sin()))
        }),
    ];
    // mu P s0 of the press by 1 mm: what a slip of one s0 costs
    let scale = 17.8 * 1.13e-3;
    for choice in [Tier::Point, Tier::Bristle] {
        for (name, at) in cases {
            let work = cycles(choice, at, 400);
            println!("{choice:?}, {name}: {work:?} J");
            assert!(work.iter().all(|&w| w > -0.01 * scale), "{choice:?}, {name}: {work:?} J");
            // cycles repeat
            assert!((work[3] - work[2]).abs() < 0.01 * scale, "{choice:?}, {name}: {work:?} J");
        }
    }
}

/// With the load changing inside the cycle: pressing while dragged and lifting while twisted must not pump energy out either.
#[test]
fn changing_loads_give_no_energy() {
    type Cycle = fn(f32) -> (Vec3, Quat);
    let cases: [(&str, Cycle); 3] = [
        ("deep forth, shallow back", |t| {
            let (s, c) = (TAU as f32 * t).sin_cos();
            (Vec3::new(6e-4 * s, 0.0, 0.019 + 4e-4 * c), Quat::IDENTITY)
        }),
        ("shallow forth, deep back", |t| {
            let (s, c) = (TAU as f32 * t).sin_cos();
            (Vec3::new(6e-4 * s, 0.0, 0.019 - 4e-4 * c), Quat::IDENTITY)
        }),
        ("twist and press", |t| {
            let (s, c) = (TAU as f32 * t).sin_cos();
            (Vec3::Z * (0.019 - 4e-4 * c), Quat::from_rotation_z(0.1 * s))
        }),
    ];
    let scale = 17.8 * 1.13e-3;
    for choice in [Tier::Point, Tier::Bristle] {
        for (name, at) in cases {
            let work = cycles(choice, at, 800);
            println!("{choice:?}, {name}: {work:?} J");
            assert!(work.iter().all(|&w| w > -0.01 * scale), "{choice:?}, {name}: {work:?} J");
        }
    }
}

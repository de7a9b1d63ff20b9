//! Scenes that are refused, limits that are laid over each other, and contacts felt through the device's frame.

use std::f32::consts::FRAC_1_SQRT_2;

use haptor_contact as contact;
use haptor_contact::{Vec3, Wrench};
use haptor_wire as wire;
use haptor_wire::units::{NOT_A_NUMBER, metres_to_nm, unit_to_q30};
use haptor_wire::{BakedScene, DeviceHello, Mode, PoseReport, Tuning, sections};

use crate::{OwnedEngine, Placed, Scene, command, handle_pose};

pub fn baked() -> BakedScene {
    BakedScene::ball_on(wire::ObjectShape::HalfSpace)
}

const PASSIVITY: wire::Passivity =
    wire::Passivity { max_damping: 5.0, max_spin_damping: 0.004, allowance: 1.0e-6, reserve: 0.1, delay_ticks: 0 };

fn with(change: fn(&mut wire::VirtualCoupling)) -> wire::Coupling {
    let mut coupling = wire::VirtualCoupling::DEVICE_S_OWN;
    change(&mut coupling);
    wire::Coupling::Virtual(coupling)
}

fn report(position: [f32; 3], rotation: [f32; 4]) -> PoseReport {
    PoseReport {
        seq: 1,
        t_us: 0,
        position_nm: position.map(metres_to_nm),
        rotation_q30: rotation.map(unit_to_q30),
        buttons: 0,
        mode: Mode::Force,
        flags: 0,
        echo: 0,
    }
}

#[test]
fn what_this_build_cannot_do_is_named() {
    type Spoil = fn(&mut BakedScene);
    let table: [(Spoil, &str); 13] = [
        (|s| s.tier = wire::Tier::Influence, "52 or 112 for tiers influence and green"),
        (|s| s.tier = wire::Tier::Green, "carries no table"),
        (|s| s.coupling = with(|c| c.translational_stiffness = Some(0.0)), "coupling.translational_stiffness"),
        (|s| s.coupling = with(|c| c.rotational_damping = Some(f32::NAN)), "coupling.rotational_damping"),
        (|s| s.coupling = with(|c| c.max_force = f32::NAN), "coupling.max_force"),
        (|s| s.coupling = with(|c| c.max_torque = -1.0), "coupling.max_torque"),
        (|s| s.guard.passivity = Some(wire::Passivity { delay_ticks: 9, ..PASSIVITY }), "guard.passivity.delay_ticks"),
        (|s| s.samples = 300, "16 to 256"),
        (|s| s.young_modulus = -1.0, "object.young_modulus"),
        (|s| s.place.q_wd = [0.0; 4], "place.q_wd"),
        (|s| s.guard.max_force = f32::NAN, "guard.max_force"),
        (|s| s.guard.max_torque_rate = 0.0, "guard.max_torque_rate"),
        (|s| s.force_law = wire::ForceLaw::Cubic { k1: -1.0, k3: 0.0 }, "model.force_law.k1"),
    ];
    for (spoil, named) in table {
        let mut scene = baked();
        spoil(&mut scene);
        let text = Scene::new(&scene).unwrap_err().to_string();
        assert!(text.contains(named), "{text} lacks {named}");
    }
    Scene::new(&baked()).unwrap();
}

/// A file of the ball on a cube in tier `green`, with a section of these numbers.
fn file(numbers: &[f32]) -> Vec<u8> {
    let mut scene = baked();
    scene.object = wire::ObjectShape::Box { size: [0.1; 3] };
    (scene.tier, scene.samples) = (wire::Tier::Green, 52);
    let mut file = vec![0; wire::scene_file::FILE_MAX];
    let length = wire::scene_file::encode_file(&scene, &mut file).unwrap();
    file.truncate(length);
    let contents: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let mut section = vec![0; contents.len() + sections::SECTION_OVERHEAD];
    sections::encode_section(sections::GREEN, &contents, &mut section).unwrap();
    [file, section].concat()
}

/// A table of 26 places whose loads move nothing but themselves, by `own` along x.
fn table(own: f32) -> Vec<f32> {
    let mut numbers = vec![0.0, 0.0, 0.05, 0.05, 0.05, 0.05, 0.005, 3.0];
    for _ in 0..26 {
        numbers.extend([own].into_iter().chain([0.0; 15]));
    }
    numbers.extend(vec![0.0; (4 * 26) * (4 * 26)]);
    numbers
}

#[test]
fn a_table_behind_the_scene_reaches_the_core() {
    let dragged = |own: f32| {
        let scene = Scene::read(&file(&table(own))).unwrap();
        let mut core = scene.engine().unwrap();
        let mut felt = None;
        for x in [0.0, 0.0, 1.0e-4] {
            felt = Some(core.step(&handle_pose(&report([x, 0.0, 0.119], [1.0, 0.0, 0.0, 0.0])).unwrap(), 1.0e-3));
        }
        let felt = felt.unwrap();
        assert_eq!(felt.tier, wire::Tier::Green);
        felt.contact_force[0].abs()
    };
    // 1e-4 m/N beside about 4e-5 m/N of the contact itself
    assert!(dragged(1.0e-4) < 0.6 * dragged(0.0), "{} {}", dragged(1.0e-4), dragged(0.0));
}

#[test]
fn a_table_that_does_not_fit_is_named() {
    let good = table(0.0);
    let mut odd = good.clone();
    odd[7] = 4.0;
    let mut endless = good.clone();
    endless[100] = f32::NAN;
    let cases: [(&[f32], &str); 5] = [
        (&good[..7], "within its head"),
        (&good[..100], "within the own moves"),
        (&good[..good.len() - 1], "green.table (length)"),
        (&odd, "nodes an edge"),
        (&endless, "green.table"),
    ];
    for (numbers, named) in cases {
        let text = Scene::read(&file(numbers)).unwrap_err().to_string();
        assert!(text.contains(named), "{text} lacks {named}");
    }
    Scene::read(&file(&good)).unwrap();
}

fn hello(max_force_un: u32, max_torque_unm: u32) -> DeviceHello {
    let (name, serial) = ([0; 12], [0; 12]);
    DeviceHello { version: 1, schema: 0, name, serial, max_force_un, max_torque_unm, watchdog_ticks: 160 }
}

#[test]
fn the_lower_of_the_scene_s_and_the_device_s_limit_holds() {
    let own = wire::GuardLimits::DEVICE_S_OWN;
    let premium = hello(8_500_000, 188_000);
    let table = [
        // scene, device, force, torque, their rates
        (own, premium, [8.5, 0.188, 425.0, 9.4]),
        (wire::GuardLimits { max_force: 3.0, max_torque_rate: 1.0, ..own }, premium, [3.0, 0.188, 425.0, 1.0]),
        (wire::GuardLimits { max_force: 30.0, max_torque: 2.0, ..own }, premium, [8.5, 0.188, 425.0, 9.4]),
        // no torque: the guard's own limit; no force: refused, the limits stay as they were
        (own, hello(12_000_000, 0), [12.0, 0.188, 600.0, 9.4]),
        (wire::GuardLimits { max_force: 3.0, ..own }, hello(0, 0), [3.0, 0.188, 425.0, 9.4]),
    ];
    for (guard, device, expected) in table {
        let scene = Scene::new(&BakedScene { guard, ..baked() }).unwrap();
        let mut core = scene.engine().unwrap();
        assert_eq!(core.fit(&device).is_err(), device.max_force_un == 0);
        let held = core.get().spec.guard;
        let found = [held.max_force, held.max_torque, held.max_force_rate, held.max_torque_rate];
        assert!(found.iter().zip(expected).all(|(f, e): (&f32, f32)| (f / e - 1.0).abs() < 1.0e-5), "{found:?} {expected:?}");
    }
}

#[test]
fn what_a_scene_leaves_out_of_its_coupling_is_fitted_to_the_device() {
    let table = [
        // coupling, device, stiffnesses, largest force and torque
        (with(|_| ()), hello(8_500_000, 188_000), [800.0, 0.3, 8.5, 0.188]),
        (with(|_| ()), hello(12_000_000, 200_000), [1129.4, 0.319, 12.0, 0.2]),
        (with(|_| ()), hello(3_300_000, 0), [310.6, 0.3, 3.3, 0.188]),
        (
            with(|c| (c.translational_stiffness, c.max_torque) = (Some(50.0), 0.1)),
            hello(12_000_000, 200_000),
            [50.0, 0.319, 12.0, 0.1],
        ),
        (with(|c| c.max_force = 30.0), hello(0, 0), [800.0, 0.3, 8.5, 0.188]),
    ];
    for (coupling, device, expected) in table {
        let scene = Scene::new(&BakedScene { coupling, ..baked() }).unwrap();
        let mut core = scene.engine().unwrap();
        assert_eq!(core.fit(&device).is_err(), device.max_force_un == 0);
        let contact::CouplingSpec::Virtual(held) = core.get().spec.coupling else { panic!("virtual") };
        let found = [held.translational_stiffness, held.rotational_stiffness, held.max_force, held.max_torque];
        assert!(found.iter().zip(expected).all(|(f, e): (&f32, f32)| (f / e - 1.0).abs() < 2.0e-3), "{found:?} {expected:?}");
    }
}

#[test]
fn a_virtual_coupling_gives_the_hand_its_spring_and_the_probe_the_contact() {
    let scene = Scene::new(&BakedScene { coupling: with(|_| ()), ..baked() }).unwrap();
    let mut core = scene.engine().unwrap();
    let at = |z: f32| handle_pose(&report([0.0, 0.0, z], [1.0, 0.0, 0.0, 0.0])).unwrap();
    core.step(&at(0.021), 1.0e-3);
    let felt = (0..2000).map(|_| core.step(&at(0.015), 1.0e-3)).last().unwrap();
    // 5 mm into rubber of 25 kN/m with a spring of 800 N/m: nearly all of it is the spring's
    assert!((3.5..4.0).contains(&felt.wrench.force.z), "{felt:?}");
    assert!((felt.wrench.force.z / felt.contact_force[2] - 1.0).abs() < 1.0e-3, "at rest both are one: {felt:?}");
    assert!(felt.depth < 5.0e-4, "{felt:?}");
}

#[test]
fn a_measured_force_law_is_what_is_felt() {
    let mut force = [0.0; 16];
    force.iter_mut().enumerate().for_each(|(i, f)| *f = i as f32);
    let laws = [
        (wire::ForceLaw::Cubic { k1: 2000.0, k3: 4.0e9 }, 2000.0 * 5.0e-4 + 4.0e9 * 5.0e-4_f32.powi(3)),
        (wire::ForceLaw::Table { step: 1.0e-4, force }, 5.0),
    ];
    let press = handle_pose(&report([0.0, 0.0, 0.0195], [1.0, 0.0, 0.0, 0.0])).unwrap();
    for (force_law, expected) in laws {
        let scene = Scene::new(&BakedScene { force_law, ..baked() }).unwrap();
        let felt = scene.engine().unwrap().step(&press, 1.0e-3).contact_force[2];
        assert!((felt / expected - 1.0).abs() < 1.0e-3, "{force_law:?}: {felt} N, expected {expected} N");
    }
}

#[test]
fn poses_are_renormalised_or_refused() {
    let pose = handle_pose(&report([0.01, -0.02, 0.03], [FRAC_1_SQRT_2 * 1.0005, 0.0, FRAC_1_SQRT_2, 0.0])).unwrap();
    assert!((pose.rotation.length() - 1.0).abs() < 1.0e-6);
    assert!((pose.position - Vec3::new(0.01, -0.02, 0.03)).length() < 1.0e-8);
    for bad in [
        report([f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]),
        report([0.0; 3], [f32::NAN, 0.0, 0.0, 0.0]),
        report([0.0; 3], [1.002, 0.0, 0.0, 0.0]),
        report([0.0; 3], [0.0; 4]),
    ] {
        assert!(handle_pose(&bad).is_none(), "{bad:?}");
    }
}

#[test]
fn a_press_is_felt_in_the_device_frame_wherever_the_device_stands() {
    let upright = Scene::new(&baked()).unwrap();
    let press = handle_pose(&report([0.0, 0.0, 0.0195], [1.0, 0.0, 0.0, 0.0])).unwrap();
    let straight = upright.engine().unwrap().step(&press, 1.0e-3);
    assert!(straight.contact_force[2] > 1.0 && straight.regions == 1);

    // the device lies on its side: its x axis is the world's z
    let mut lying = baked();
    lying.place = wire::Place { p_wd: [0.0, 0.0, 0.1], q_wd: [FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2, 0.0] };
    let scene = Scene::new(&lying).unwrap();
    let press = handle_pose(&report([0.0195 - 0.1, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])).unwrap();
    let felt = scene.engine().unwrap().step(&press, 1.0e-3);
    assert!((felt.contact_force[2] / straight.contact_force[2] - 1.0).abs() < 1.0e-3);
    assert!((felt.wrench.force.x - straight.wrench.force.z).abs() <= 1.0e-3 * straight.wrench.force.z);
    assert!(felt.wrench.force.y.abs() + felt.wrench.force.z.abs() < 1.0e-3);
}

#[test]
fn commands_carry_micronewtons_and_a_nan_stays_one() {
    let wrench = Wrench::new(Vec3::new(1.5, 0.0, -2.0), Vec3::new(0.0, f32::NAN, 0.1));
    let c = command(3, 9, &wrench, 4000);
    assert_eq!((c.seq, c.echo, c.hold_us), (3, 9, 4000));
    assert_eq!(c.force_un, [1_500_000, 0, -2_000_000]);
    assert_eq!(c.torque_unm, [0, NOT_A_NUMBER, 100_000]);
}

/// Forces of a ball that is pressed in and dragged along.
fn dragged(core: &mut OwnedEngine, ticks: std::ops::Range<u16>) -> Vec<[u32; 3]> {
    let at = |tick: u16| [1.0e-5 * f32::from(tick), 0.0, 0.0199 - 1.0e-6 * f32::from(tick)];
    let pose = |tick| handle_pose(&report(at(tick), [1.0, 0.0, 0.0, 0.0])).unwrap();
    ticks.map(|tick| core.step(&pose(tick), 1.0e-3).contact_force.map(f32::to_bits)).collect()
}

#[test]
fn an_engine_at_rest_is_as_new_and_a_tuned_one_as_one_made_so() {
    let scene = Scene::new(&baked()).unwrap();
    let new = dragged(&mut scene.engine().unwrap(), 0..50);
    let mut core = scene.engine().unwrap();
    dragged(&mut core, 0..30);
    core.rest();
    assert_eq!(dragged(&mut core, 0..50), new);

    let smooth = BakedScene { tier: wire::Tier::Paper, friction_static: 0.2, friction_dynamic: 0.1, ..baked() };
    let other = dragged(&mut Scene::new(&smooth).unwrap().engine().unwrap(), 0..50);
    assert_ne!(other, new);
    core.tune(&scene.tuned(&Tuning::of(&smooth)).unwrap());
    core.rest();
    assert_eq!((dragged(&mut core, 0..50), *core.get().tuning()), (other, Tuning::of(&smooth)));
}

#[test]
fn a_tuning_keeps_to_the_device_and_is_refused_by_name() {
    let scene = Scene::new(&baked()).unwrap();
    let mut core = scene.engine().unwrap();
    core.fit(&hello(3_000_000, 0)).unwrap();
    let guard = wire::GuardLimits { max_force: 5.0, max_torque: 0.1, ..wire::GuardLimits::DEVICE_S_OWN };
    core.tune(&scene.tuned(&Tuning { guard, ..Tuning::of(&baked()) }).unwrap());
    assert_eq!((core.get().spec.guard.max_force, core.get().spec.guard.max_torque), (3.0, 0.1));
    core.fit(&hello(8_000_000, 0)).unwrap();
    assert_eq!(core.get().spec.guard.max_force, 5.0);

    type Spoil = fn(&mut Tuning);
    let table: [(Spoil, &str); 4] = [
        (|t| t.tier = wire::Tier::Green, "carries no table"),
        (|t| t.samples = 300, "16 to 256"),
        (|t| t.friction_dynamic = f32::NAN, "friction.dynamic"),
        (|t| t.guard.max_force = 0.0, "guard.max_force"),
    ];
    for (spoil, named) in table {
        let mut tuning = Tuning::of(&baked());
        spoil(&mut tuning);
        let text = scene.tuned(&tuning).unwrap_err().to_string();
        assert!(text.contains(named), "{text} lacks {named}");
    }
}

#[test]
fn a_device_that_stands_elsewhere_feels_the_same_thing_there() {
    let scene = Scene::new(&baked()).unwrap();
    let mut core = scene.engine().unwrap();
    let straight = core.step(&handle_pose(&report([0.0, 0.0, 0.0195], [1.0, 0.0, 0.0, 0.0])).unwrap(), 1.0e-3);
    let place = wire::Place { p_wd: [0.0, 0.0, 0.25], q_wd: [1.0, 0.0, 0.0, 0.0] };
    core.place(&Placed::new(&place).unwrap());
    core.rest();
    let felt = core.step(&handle_pose(&report([0.0, 0.0, 0.0195 - 0.25], [1.0, 0.0, 0.0, 0.0])).unwrap(), 1.0e-3);
    assert!((felt.contact_force[2] / straight.contact_force[2] - 1.0).abs() < 1.0e-3);
    assert_eq!(*core.get().placed(), place);
    for bad in [wire::Place { p_wd: [f32::INFINITY, 0.0, 0.0], ..place }, wire::Place { q_wd: [2.0, 0.0, 0.0, 0.0], ..place }] {
        assert!(Placed::new(&bad).is_err());
    }
}

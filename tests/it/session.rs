//! A session from end to end on real bytes: what the hand does is what the core felt is what the device was told.

use std::sync::atomic::AtomicBool;

use haptor_contact::{
    CouplingSpec, GuardSpec, Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape,
    Quat, Scratch, State, Vec3, VirtualCoupling, step,
};
use haptor_engine::Scene;
use haptor_host::link::{Link, mem};
use haptor_host::rt::account::Account;
use haptor_host::rt::blackbox::black_box;
use haptor_host::rt::clock::Virtual;
use haptor_host::rt::control::Control;
use haptor_host::rt::desk::closed_desk;
use haptor_host::rt::flags;
use haptor_host::rt::line::{Line, exchange};
use haptor_wire::{
    BakedScene, Coupling, DeviceHello, FromDevice, FromHost, HostFault, Mode, PROTOCOL_VERSION, RtReport, SCHEMA_HASH,
    TickRecord, encode_stream,
};

use crate::host_rig::{RATE_HZ, Rig, ball_on_cube, length, settings};

/// A whole press, twist, slide and lift, and the way home.
const TICKS: u64 = 4_000;

fn played() -> Rig {
    let mut rig = Rig::new("press-twist-slide", Some(TICKS));
    while !rig.control.is_over() {
        rig.tick();
    }
    rig
}

#[test]
fn the_hand_presses_twists_and_slides_and_feels_it() {
    let rig = played();
    let summary = rig.summary();
    assert_eq!((summary.ticks, summary.in_time, summary.late), (TICKS, TICKS, 0));
    assert_eq!((summary.fault, summary.rejected, summary.recorder_dropped), (None, 0, 0));
    assert_eq!(rig.ticks.len() as u64, TICKS);
    assert!(rig.ticks.iter().map(|t| t.tick).eq(0..TICKS));
    // the hand wants 0.8 of the device's 8.5 N, and its own spring gives way to the object's
    assert!((3.0..8.5).contains(&summary.peak_force), "{} N", summary.peak_force);
    assert!(summary.peak_torque > 0.01, "{} N m", summary.peak_torque);
    assert!(rig.ticks.iter().any(|t| length(t.contact_force) == 0.0 && t.tick > 2000), "lifted");
    assert!(matches!(rig.told[0], FromHost::Hello(hello) if hello.max_force_un == 8_500_000));
    assert!(rig.told.iter().filter(|m| matches!(m, FromHost::Progress(_))).count() >= 39);
}

#[test]
fn what_was_recorded_is_what_the_core_says_bit_for_bit() {
    let last = replay(&played(), CouplingSpec::Direct);
    assert!(last > TICKS - 10);
}

/// The rule for dt counts the ticks in which no pose came.
#[test]
fn a_recording_with_gaps_replays_too() {
    let mut rig = Rig::new("press-twist-slide", Some(TICKS));
    while !rig.control.is_over() {
        if rig.ticks.len() % 500 == 400 {
            rig.far().stall(10_000);
        }
        rig.tick();
    }
    assert!(rig.ticks.iter().filter(|t| t.flags & flags::HELD != 0).count() > 50, "stalls that were ridden through");
    assert_eq!(rig.summary().fault, None);
    replay(&rig, CouplingSpec::Direct);
}

/// A scene that asks for a virtual coupling and gives no number: all of it comes from the device, which the recording names.
#[test]
fn a_virtual_coupling_holds_a_session_and_its_recording_replays() {
    let scene = BakedScene { coupling: Coupling::Virtual(haptor_wire::VirtualCoupling::DEVICE_S_OWN), ..ball_on_cube() };
    let mut rig = Rig::on(&scene, "press-twist-slide", Some(TICKS), |cable| Box::new(cable));
    while !rig.control.is_over() {
        rig.tick();
    }
    let (summary, direct) = (rig.summary(), played().summary());
    assert_eq!((summary.ticks, summary.in_time, summary.fault), (TICKS, TICKS, None));
    // the same hand on a softer spring: it feels less, never more than the device renders
    assert!((1.0..direct.peak_force).contains(&summary.peak_force), "{} N, direct {} N", summary.peak_force, direct.peak_force);
    assert!(summary.peak_torque > 0.005, "{} N m", summary.peak_torque);
    assert!(rig.ticks.iter().any(|t| length(t.contact_force) == 0.0 && t.tick > 2000), "lifted");
    let device = rig.device.expect("the recording names the device");
    let (max_force, max_torque) = (device.max_force_un as f32 * 1.0e-6, device.max_torque_unm as f32 * 1.0e-6);
    replay(&rig, CouplingSpec::Virtual(VirtualCoupling { max_force, max_torque, ..VirtualCoupling::default() }));
}

/// Feeds the recorded poses to the core itself: every figure of every tick must come out again, bit for bit. Yields the last tick
/// with a pose.
fn replay(rig: &Rig, coupling: CouplingSpec) -> u64 {
    let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
    let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
    let model = Model::new(&ModelSpec::new(ObjectShape::Box { size: Vec3::splat(0.1) }, rubber, &ball)).unwrap();
    let params = Params::new(&ParamsSpec { guard: GuardSpec::default(), coupling, ..ParamsSpec::default() }).unwrap();
    let (mut state, mut scratch) = (Box::new(State::<16, 256, 256>::new()), Scratch::<16>::new());
    let mut stepped_at = None;
    for tick in rig.ticks.iter().filter(|t| t.flags & flags::NO_POSE == 0) {
        let since = stepped_at.map_or(1, |at| tick.tick - at);
        stepped_at = Some(tick.tick);
        let [w, x, y, z] = tick.rotation;
        let place = Vec3::from_array(ball_on_cube().place.p_wd);
        let pose = Pose::new(place + Vec3::from_array(tick.position), Quat::from_xyzw(x, y, z, w).normalize());
        let dt = (since as f64 / 1000.0) as f32;
        let output = step(&model, &params, &mut state, &mut scratch, Input { pose, dt });
        assert_eq!(output.contact.force.to_array(), tick.contact_force, "tick {}", tick.tick);
        assert_eq!(output.contact.torque.to_array(), tick.contact_torque, "tick {}", tick.tick);
        assert_eq!(output.wrench.force.to_array(), tick.force, "tick {}", tick.tick);
        assert_eq!(output.wrench.torque.to_array(), tick.torque, "tick {}", tick.tick);
        assert_eq!((output.report.regions, output.report.depth), (tick.regions, tick.depth));
    }
    stepped_at.expect("poses came")
}

#[test]
fn the_same_session_twice_is_the_same() {
    let (first, second) = (played(), played());
    assert!(first.ticks == second.ticks);
    assert_eq!(first.summary(), second.summary());
}

#[test]
fn a_session_that_ends_leaves_the_device_at_rest_without_a_fault() {
    let mut rig = Rig::new("press", Some(800));
    rig.control.run(&AtomicBool::new(false));
    let (mode, fault) = {
        let far = rig.far();
        (far.device.mode(), far.device.fault())
    };
    assert_eq!((mode, fault), (Mode::Reset, None));
    rig.collect();
    assert_eq!((rig.ticks.len(), rig.summary().fault), (800, None));
}

#[test]
fn a_set_stop_flag_ends_a_session_that_has_no_end() {
    let mut rig = Rig::new("press", None);
    assert!(rig.until(50, |rig| !rig.ticks.is_empty()));
    rig.control.run(&AtomicBool::new(true));
    assert_eq!(rig.far().device.mode(), Mode::Reset);
}

#[test]
fn round_trips_are_measured_for_every_command() {
    let rig = played();
    let q = rig.summary().round_trip_ns;
    // sent at once after a report, echoed by the next: a period, to the device's tick
    assert!((875_000..=1_010_000).contains(&q.p50), "{q:?}");
    let measured: Vec<&TickRecord> = rig.ticks.iter().filter(|t| t.round_trip_ns > 0).collect();
    assert!(measured.len() as u64 > TICKS - 20);
}

/// A host on a link whose other end is the test.
fn lonely(capacity: usize) -> (Control<Virtual>, mem::MemLink) {
    let (host, device) = mem::pair(capacity);
    let (links, _) = exchange();
    let (account, _) = Account::new(black_box(RATE_HZ).0, RATE_HZ);
    let scene: &'static Scene = Box::leak(Box::new(Scene::new(&ball_on_cube()).unwrap()));
    let line = Line::new(Box::new(host), links);
    (Control::new(settings(None), Virtual::default(), line, scene.engine().unwrap(), account, closed_desk()), device)
}

#[test]
fn a_device_of_another_version_is_refused_with_both_numbers() {
    let (mut control, mut device) = lonely(4096);
    control.tick();
    let hello = DeviceHello {
        version: PROTOCOL_VERSION + 6,
        schema: SCHEMA_HASH,
        name: [0; 12],
        serial: [0; 12],
        max_force_un: 1,
        max_torque_unm: 0,
        watchdog_ticks: 240,
    };
    let mut frame = [0; 128];
    let n = encode_stream(&FromDevice::Hello(hello), &mut frame).unwrap();
    device.send(&frame[..n]).unwrap();
    control.run(&AtomicBool::new(false));
    let text = control.mismatch().unwrap().to_string();
    assert!(text.contains(&format!("version {}", PROTOCOL_VERSION + 6)), "{text}");
    assert!(text.contains(&format!("version {PROTOCOL_VERSION} ")), "{text}");
    assert_eq!(control.summary(RtReport::default()).fault, Some(HostFault::VersionMismatch));
}

#[test]
fn a_device_that_never_answers_ends_the_session_before_it_began() {
    let (mut control, device) = lonely(64 * 1024);
    control.run(&AtomicBool::new(false));
    let summary = control.summary(RtReport::default());
    assert_eq!((summary.fault, summary.ticks), (Some(HostFault::Stale), 0));
    drop(device);
}

//! The loop closed on a wall, over the real bytes: device, one tick of delay, a host of ten lines.
//!
//! The wall is what a ball of 20 mm radius feels on rubber of 3 MPa: Hertz's force, a tangential spring that slips at Coulomb's
//! limit, and a torsional spring that slips at its own, each with the stiffness of full stick. Cruder than the core and as stiff.

use std::collections::VecDeque;
use std::vec::Vec;

use glam::{Quat, Vec3};
use haptor_wire::units::{newton_metres_to_unm, newtons_to_un, nm_to_metres, q30_to_unit};
use haptor_wire::{
    FromDevice, HostHello, Mode, PROTOCOL_VERSION, PoseReport, SCHEMA_HASH, StreamDecoder, ToDevice, WrenchCommand, encode_stream,
};

use crate::plant::{Encoders, FIRM_GRIP, Hand};
use crate::preset::{OMEGA6, PREMIUM15, Preset, TOUCH};
use crate::script::{CLEARANCE, Reach};
use crate::{Device, Script, TxBuf};

const RADIUS: f32 = 0.02;
const FRICTION: f32 = 0.75;

/// Reduced modulus of the rubber, 3 MPa / (1 - 0.5^2) \[Pa\].
const RUBBER: f32 = 4e6;

/// The ball on the wall; the ball's centre is the handle's origin.
struct Wall {
    /// Reduced modulus \[Pa\].
    modulus: f32,
    /// Stretch of the tangential spring \[m\] and of the torsional one \[rad\].
    drag: Vec3,
    twist: f32,
    last: Option<(Vec3, Quat)>,
}

impl Wall {
    /// Force and torque on the ball about its centre, and its depth.
    fn press(&mut self, position: Vec3, rotation: Quat) -> (Vec3, Vec3, f32) {
        let depth = -position.z - CLEARANCE;
        let (before, turned) = self.last.replace((position, rotation)).unwrap_or((position, rotation));
        if depth <= 0.0 {
            self.drag = Vec3::ZERO;
            self.twist = 0.0;
            return (Vec3::ZERO, Vec3::ZERO, depth);
        }
        let (g, a) = (self.modulus / 4.0, (RADIUS * depth).sqrt());
        let normal = 4.0 / 3.0 * self.modulus * RADIUS.sqrt() * depth.powf(1.5);
        let arm = Vec3::new(0.0, 0.0, -RADIUS);
        let turn = (rotation * turned.conjugate()).to_scaled_axis();
        let slid = position - before + turn.cross(arm);
        let stiffness = 8.0 * g * a / 1.5;
        self.drag += Vec3::new(slid.x, slid.y, 0.0);
        self.drag = self.drag.clamp_length_max(FRICTION * normal / stiffness);
        let spin_stiffness = 16.0 / 3.0 * g * a.powi(3);
        let most = 0.589 * FRICTION * normal * a / spin_stiffness;
        self.twist = (self.twist + turn.z).clamp(-most, most);
        let force = Vec3::new(0.0, 0.0, normal) - self.drag * stiffness;
        let torque = arm.cross(force) - Vec3::Z * (self.twist * spin_stiffness);
        (force, torque, depth)
    }
}

/// A host: answers every report with the wall's wrench.
struct Host {
    decoder: StreamDecoder<64>,
    /// Answers on their way; the front one arrives next.
    sent: VecDeque<Vec<u8>>,
    seq: u32,
    wall: Wall,
    /// Of each report: force and torque of the wall, depth.
    felt: Vec<(Vec3, Vec3, f32)>,
    flags: u8,
}

fn frame(message: &ToDevice) -> Vec<u8> {
    let mut out = [0; 64];
    let n = encode_stream(message, &mut out).unwrap();
    out[..n].to_vec()
}

fn opening() -> Vec<u8> {
    let hello = HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 };
    [frame(&ToDevice::SetMode(Mode::Reset)), frame(&ToDevice::Hello(hello)), frame(&ToDevice::SetMode(Mode::Force))].concat()
}

impl Host {
    /// The answer to a report arrives at the begin of the next tick, and `late` ticks after that.
    fn new(late: usize, modulus: f32) -> Self {
        let sent = VecDeque::from(std::vec![Vec::new(); late]);
        Self {
            decoder: StreamDecoder::new(),
            sent,
            seq: 0,
            wall: Wall { modulus, drag: Vec3::ZERO, twist: 0.0, last: None },
            felt: Vec::new(),
            flags: 0,
        }
    }

    /// Takes what the device said in the last tick, yields what arrives there at the begin of the next.
    fn turn(&mut self, said: &[u8]) -> Vec<u8> {
        let mut poses: Vec<PoseReport> = Vec::new();
        self.decoder.feed(said, |message| {
            if let FromDevice::Pose(pose) = message {
                poses.push(pose);
            }
        });
        let frames: Vec<u8> = poses.iter().flat_map(|pose| self.answer(pose)).collect();
        self.sent.push_back(frames);
        self.sent.pop_front().unwrap()
    }

    fn answer(&mut self, pose: &PoseReport) -> Vec<u8> {
        self.flags |= pose.flags;
        let position = Vec3::from(pose.position_nm.map(nm_to_metres));
        let [w, x, y, z] = pose.rotation_q30.map(q30_to_unit);
        let felt = self.wall.press(position, Quat::from_xyzw(x, y, z, w));
        self.felt.push(felt);
        self.seq += 1;
        frame(&ToDevice::Wrench(WrenchCommand {
            seq: self.seq,
            echo: pose.seq,
            force_un: felt.0.to_array().map(newtons_to_un),
            torque_unm: felt.1.to_array().map(newton_metres_to_unm),
            hold_us: 20_000,
        }))
    }
}

struct Run {
    host: Host,
    device: Device,
}

/// Runs the paper's motion once against the wall.
fn run(preset: &Preset, hand: Hand, encoders: Encoders, late: usize, modulus: f32) -> Run {
    let reach = Reach::usual(FIRM_GRIP.stiffness, preset.max_force);
    let script = Script::by_name("press-twist-slide", &reach, false).unwrap();
    let ticks = script.length_us() / 1000;
    let mut device = Device::new(preset, "T", hand, encoders, script);
    let mut host = Host::new(late, modulus);
    let mut tx = TxBuf::new();
    device.step(0, &opening(), &mut tx);
    for _ in 0..ticks {
        let rx = host.turn(tx.as_slice());
        tx.clear();
        device.step(1000, &rx, &mut tx);
    }
    Run { host, device }
}

impl Run {
    /// Largest force.
    fn peak(&self) -> f32 {
        self.host.felt.iter().map(|felt| felt.0.length()).fold(0.0, f32::max)
    }

    fn peak_torque(&self) -> f32 {
        self.host.felt.iter().map(|felt| felt.1.length()).fold(0.0, f32::max)
    }

    /// Difference of largest and smallest normal force over a stretch of ticks.
    fn ripple(&self, ticks: core::ops::Range<usize>) -> f32 {
        let forces = self.host.felt[ticks].iter().map(|felt| felt.0.z);
        let (low, high) = forces.fold((f32::MAX, f32::MIN), |(l, h), f| (l.min(f), h.max(f)));
        high - low
    }

    /// Ripple of the normal force while the hand holds still after pressing, and after twisting.
    fn steady_ripples(&self) -> [f32; 2] {
        [self.ripple(1150..1190), self.ripple(2050..2090)]
    }
}

/// What one fine encoder step makes on the pressed rubber [N]: 23 kN/m times 1 um.
const ONE_STEP: f32 = 0.023;

#[test]
fn the_demo_presses_0_4_mm_within_the_limits_and_does_not_buzz() {
    let run = run(&PREMIUM15, FIRM_GRIP, Encoders::FINE, 0, RUBBER);
    let (force, _, depth) = run.host.felt[1190];
    assert!((depth - 0.4e-3).abs() < 0.01e-3, "{depth} m");
    assert!((force.z - 6.0).abs() < 0.1, "{force} N");
    assert!(run.peak() < PREMIUM15.max_force, "{} N", run.peak());
    assert!(run.peak_torque() < PREMIUM15.max_torque, "{} N m", run.peak_torque());
    for ripple in run.steady_ripples() {
        assert!(ripple < 1.5 * ONE_STEP, "{ripple} N");
    }
    assert_eq!((run.host.flags, run.device.mode()), (0, Mode::Force));
}

#[test]
fn the_loop_has_margin_in_delay_and_in_stiffness() {
    for (late, stiffer) in [(1, 1.0), (5, 1.0), (0, 4.0)] {
        let run = run(&PREMIUM15, FIRM_GRIP, Encoders::FINE, late, stiffer * RUBBER);
        for ripple in run.steady_ripples() {
            let step = ONE_STEP * stiffer.powf(2.0 / 3.0);
            assert!(ripple < 1.5 * step, "{late} late, {stiffer} x: {ripple} N");
        }
        assert_eq!(run.host.flags, 0);
    }
}

#[test]
fn a_light_grip_buzzes() {
    let light = Hand { mass: 0.1, damping: 5.0, ..FIRM_GRIP };
    let run = run(&PREMIUM15, light, Encoders::FINE, 0, RUBBER);
    assert!(run.ripple(1150..1190) > 8.5);
    assert!(run.host.flags & PoseReport::FLAG_FORCE_CLAMPED != 0);
}

#[test]
fn coarse_encoders_toggle_by_about_a_step() {
    let run = run(&PREMIUM15, FIRM_GRIP, Encoders::of(&PREMIUM15), 0, RUBBER);
    let ripple = run.ripple(1150..1190);
    assert!((0.3..1.5).contains(&ripple), "{ripple} N");
}

#[test]
fn a_device_without_torque_says_so_and_holds() {
    for preset in [OMEGA6, TOUCH] {
        let run = run(&preset, FIRM_GRIP, Encoders::FINE, 0, RUBBER);
        assert_eq!(run.host.flags, PoseReport::FLAG_TORQUE_NOT_RENDERED, "{}", preset.name);
        assert_eq!(run.device.mode(), Mode::Force);
        assert!(run.peak() < preset.max_force, "{}: {} N", preset.name, run.peak());
    }
}

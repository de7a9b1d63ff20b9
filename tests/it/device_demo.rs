//! The simulated device on the real core, in virtual time: the demo's motion is felt, stays within the device's limits and does not
//! buzz. One tick from report to wrench, as over a cable; no clock, no process, the same figures on every machine.

use glam::Vec3;
use haptor_contact::Flags;
use haptor_engine::{Felt, OwnedEngine, Scene, command, handle_pose};
use haptor_firmware_sim::plant::{Encoders, FIRM_GRIP};
use haptor_firmware_sim::preset::{OMEGA6, PREMIUM15, Preset, SIGMA7, TOUCH};
use haptor_firmware_sim::script::{CLEARANCE, Reach};
use haptor_firmware_sim::{Device, Script, TxBuf};
use haptor_wire::{
    BakedScene, Deformation, FromDevice, HostHello, Mode, ObjectShape, PROTOCOL_VERSION, Place, PoseReport, SCHEMA_HASH,
    StreamDecoder, Tier, ToDevice, encode_stream,
};

const RADIUS: f32 = 0.02;
const HEIGHT: f32 = 0.1;

/// The ball on the rubber cube; the device stands so that the ball hovers at the script's clearance.
fn ball_on_cube(tier: Tier) -> BakedScene {
    let place = Place { p_wd: [0.0, 0.0, HEIGHT + RADIUS + CLEARANCE], q_wd: [1.0, 0.0, 0.0, 0.0] };
    let scene = BakedScene::ball_on(ObjectShape::Box { size: [HEIGHT; 3] });
    BakedScene { tier, deformation: Deformation::None, place, ..scene }
}

fn frame(message: &ToDevice) -> Vec<u8> {
    let mut out = [0; 64];
    let n = encode_stream(message, &mut out).unwrap();
    out[..n].to_vec()
}

struct Session {
    felt: Vec<Felt>,
    reports: Vec<PoseReport>,
    mode: Mode,
}

/// Runs the paper's motion once.
fn run(preset: &Preset, tier: Tier) -> Session {
    let scene = Scene::new(&ball_on_cube(tier)).unwrap();
    let mut engine = scene.engine().unwrap();
    let reach = Reach::usual(FIRM_GRIP.stiffness, preset.max_force);
    let script = Script::by_name("press-twist-slide", &reach, false).unwrap();
    let ticks = script.length_us() / 1000;
    let mut device = Device::new(preset, "T", FIRM_GRIP, Encoders::FINE, script);
    let mut session = Session { felt: Vec::new(), reports: Vec::new(), mode: Mode::Reset };
    let (mut tx, mut decoder) = (TxBuf::new(), StreamDecoder::<64>::new());
    let hello = HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 };
    let mut rx = [frame(&ToDevice::Hello(hello)), frame(&ToDevice::SetMode(Mode::Force))].concat();
    for _ in 0..ticks {
        tx.clear();
        device.step(1000, &rx, &mut tx);
        rx.clear();
        decoder.feed(tx.as_slice(), |message| rx.extend(answer(&mut engine, &mut session, message)));
    }
    session.mode = device.mode();
    session
}

fn answer(engine: &mut OwnedEngine, session: &mut Session, message: FromDevice) -> Vec<u8> {
    match message {
        FromDevice::Hello(hello) => {
            engine.fit(&hello).unwrap();
            Vec::new()
        }
        FromDevice::Pose(report) => {
            let felt = engine.step(&handle_pose(&report).unwrap(), 1e-3);
            session.felt.push(felt);
            session.reports.push(report);
            frame(&ToDevice::Wrench(command(session.felt.len() as u32, report.seq, &felt.wrench, 5000)))
        }
        FromDevice::Fault(fault) => panic!("{fault:?}"),
    }
}

impl Session {
    fn force(&self, tick: usize) -> Vec3 {
        Vec3::from(self.felt[tick].contact_force)
    }

    fn peak(&self, of: impl Fn(&Felt) -> [f32; 3]) -> f32 {
        self.felt.iter().map(|felt| Vec3::from(of(felt)).length()).fold(0.0, f32::max)
    }

    fn flags(&self) -> u8 {
        self.reports.iter().fold(0, |all, report| all | report.flags)
    }

    /// Largest deviation of the force from the straight line between its neighbours, while well in contact.
    fn buzz(&self) -> f32 {
        (1..self.felt.len() - 1)
            .filter(|&i| (i - 1..=i + 1).all(|j| self.force(j).z > 1.0))
            .map(|i| (self.force(i) - (self.force(i - 1) + self.force(i + 1)) * 0.5).length())
            .fold(0.0, f32::max)
    }
}

/// End of the hold after pressing, after twisting, after sliding [ticks].
const PRESSED: usize = 1190;
const TWISTED: usize = 2090;
const SLID: usize = 2990;

/// Ticks at the beginnings and ends of a touch that are too shallow for the digits of their place.
const MOST_COARSE: usize = 8;

/// What one step of the fine encoders makes on the rubber at the deepest press, 27 kN/m times 1 um [N].
const ONE_STEP: f32 = 0.027;

#[test]
fn every_device_and_tier_renders_the_motion_without_a_buzz() {
    for preset in [PREMIUM15, SIGMA7, OMEGA6, TOUCH] {
        for tier in [Tier::Point, Tier::Paper, Tier::Bristle] {
            let session = run(&preset, tier);
            let told = format!("{} {}", preset.name, tier.name());
            let unrendered = if preset.max_torque > 0.0 { 0 } else { PoseReport::FLAG_TORQUE_NOT_RENDERED };
            assert_eq!((session.flags(), session.mode), (unrendered, Mode::Force), "{told}");
            // the first ticks of a touch may be shallower than the digits of its place tell
            let (coarse, others): (Vec<u32>, Vec<u32>) = session
                .felt
                .iter()
                .map(|felt| felt.flags)
                .filter(|&flags| flags != 0)
                .partition(|&flags| flags == Flags::POSE_COARSE.0);
            assert!(
                coarse.len() <= MOST_COARSE && others.is_empty(),
                "{told}: the core complains: {} coarse, {others:?}",
                coarse.len()
            );
            assert!(session.peak(|felt| felt.contact_force) < preset.max_force, "{told}");
            let buzz = session.buzz();
            assert!(buzz < ONE_STEP, "{told}: {buzz} N");
        }
    }
}

#[test]
fn the_demo_is_felt_as_its_closed_forms_say() {
    let session = run(&PREMIUM15, Tier::Bristle);
    let depth = session.felt[PRESSED].depth;
    assert!((depth - 0.4e-3).abs() < 0.01e-3, "{depth} m");
    // Hertz, R = 20 mm, E* = 4 MPa
    let hertz = 4.0 / 3.0 * 4e6 * RADIUS.sqrt() * depth.powf(1.5) * (1.0 - depth / (10.0 * RADIUS));
    let force = session.force(PRESSED).z;
    assert!((force / hertz - 1.0).abs() < 0.01, "{force} N, Hertz {hertz} N");
    // a twist of 0.5 rad slips nearly everywhere: T_max = (3 pi / 16) mu P a
    let radius = session.felt[TWISTED].radius;
    let slip = 3.0 * std::f32::consts::PI / 16.0 * 0.75 * session.force(TWISTED).z * radius;
    let torque = -session.felt[TWISTED].contact_torque[2];
    assert!((0.9..=1.01).contains(&(torque / slip)), "{torque} N m, full slip {slip} N m");
    // and so does a slide of 10 mm
    let drag = -session.force(SLID).x / (0.75 * session.force(SLID).z);
    assert!((0.9..=1.01).contains(&drag), "{drag} of full slip");
    // lifted
    assert_eq!(session.felt.last().unwrap().contact_force, [0.0; 3]);
}

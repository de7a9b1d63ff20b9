//! The device link written twice: `firmware-sim/c-example/device.c`, made from WIRE.md alone, answers as the simulated device does, and
//! the real host runs on it.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use haptor_wire::units::NOT_A_NUMBER;
use haptor_wire::{
    DeviceFault, FaultCause, FromDevice, HostFault, HostHello, Mode, PROTOCOL_VERSION, PoseReport, SCHEMA_HASH, Summary,
    ToDevice, WrenchCommand,
};

use crate::cli::{self, built};
use crate::served::{Peer, Served, alone, host, host_command, model, patiently, signal};
use crate::support::noise::noise;

/// Poses among which an answer must show: the device's turn is one, a busy machine holds back some tens.
const SOON: u32 = 500;

/// Watchdog of the conversations [ticks of 125 us]: longer than a busy machine keeps a test from answering.
const WATCHDOG: u16 = 16_000;

/// Sessions begun at most when the machine is too busy for one.
const ATTEMPTS: u32 = 10;

/// The example, compiled with every warning an error.
fn compiled() -> &'static PathBuf {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| cli::compiled("firmware-sim/c-example/device.c", "c-example-device", &[]))
}

fn in_c(args: &[&str]) -> Served {
    Served::start(Command::new(compiled()).args(args))
}

fn in_rust(args: &[&str]) -> Served {
    Served::start(Command::new(built("haptor-firmware-sim")).args(args))
}

const HELLO: HostHello = HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 };

fn wrench(seq: u32, force_un: [i32; 3], torque_unm: [i32; 3]) -> ToDevice {
    ToDevice::Wrench(WrenchCommand { seq, echo: 0, force_un, torque_unm, hold_us: 1000 })
}

fn told(cause: FaultCause, detail: i32) -> impl Fn(FromDevice) -> DeviceFault {
    move |message| match message {
        FromDevice::Fault(fault) if (fault.cause, fault.detail) == (cause, detail) => fault,
        other => panic!("{other:?} in place of {cause:?}, {detail}"),
    }
}

fn greeted(message: FromDevice) {
    let FromDevice::Hello(hello) = message else { panic!("{message:?} in place of a hello") };
    assert_eq!((hello.version, hello.schema, hello.watchdog_ticks), (PROTOCOL_VERSION, SCHEMA_HASH, WATCHDOG));
    assert_eq!((hello.max_force_un, hello.max_torque_unm), (8_500_000, 188_000));
}

/// Before a session: silence, one answer to what is out of turn, both numbers to another version.
fn refuses_without_a_session(peer: &mut Peer) {
    for _ in 0..3 {
        peer.say(&ToDevice::SetMode(Mode::Force));
        peer.say(&wrench(1, [0; 3], [0; 3]));
    }
    let fault = told(FaultCause::Protocol, Mode::Reset as i32)(peer.hear());
    assert_eq!(fault.seq, u32::MAX, "no report was sent");
    for hello in [HostHello { version: PROTOCOL_VERSION + 1, ..HELLO }, HostHello { schema: !SCHEMA_HASH, ..HELLO }] {
        peer.say(&ToDevice::Hello(hello));
        greeted(peer.hear());
        told(FaultCause::VersionMismatch, i32::from(PROTOCOL_VERSION))(peer.hear());
    }
}

/// Reset to Force, wrenches on the way.
fn goes_by_its_modes(peer: &mut Peer) {
    peer.say(&ToDevice::Hello(HELLO));
    greeted(peer.hear());
    let first = peer.pose(1, |_| true);
    assert_eq!((first.seq, first.mode, first.echo, first.flags), (0, Mode::Idle, 0, 0));
    assert_eq!((first.position_nm, first.rotation_q30), ([0; 3], [1 << 30, 0, 0, 0]));
    peer.say(&wrench(7, [1, 2, 3], [4, 5, 6]));
    peer.pose(SOON, |pose| pose.echo == 7 && pose.mode == Mode::Idle);
    peer.say(&ToDevice::SetMode(Mode::Force));
    peer.pose(SOON, |pose| pose.mode == Mode::Force);
    for (seq, force, torque, flags) in [
        (8, [9_000_000, 0, 0], [0; 3], PoseReport::FLAG_FORCE_CLAMPED),
        (9, [0, 0, 8_400_000], [0, 200_000, 0], PoseReport::FLAG_TORQUE_CLAMPED),
        (10, [0; 3], [0; 3], 0),
    ] {
        peer.say(&wrench(seq, force, torque));
        assert_eq!(peer.pose(SOON, |pose| pose.echo == seq).flags, flags, "command {seq}");
    }
    // older, repeated, and half the numbers back: ignored whatever is in them
    for seq in [9, 10, 10_u32.wrapping_sub(1 << 31)] {
        peer.say(&wrench(seq, [NOT_A_NUMBER; 3], [0; 3]));
    }
    peer.say(&wrench(11, [0; 3], [0; 3]));
    peer.pose(SOON, |pose| pose.echo == 11 && pose.mode == Mode::Force);
}

/// From Force to a latched fault and back to Idle.
fn latches_what_is_not_a_number(peer: &mut Peer) {
    peer.say(&wrench(12, [0; 3], [0, NOT_A_NUMBER, 0]));
    told(FaultCause::NonFinite, 12)(peer.hear_words());
    for message in [ToDevice::SetMode(Mode::Idle), ToDevice::SetMode(Mode::Force), wrench(13, [1; 3], [0; 3])] {
        peer.say(&message);
    }
    peer.say(&ToDevice::Hello(HELLO));
    greeted(peer.hear_words());
    assert_eq!(peer.pose(1, |_| true).mode, Mode::Brake, "braked through a hello");
    peer.say(&ToDevice::SetMode(Mode::Reset));
    peer.pose(SOON, |pose| pose.mode == Mode::Reset);
    for _ in 0..3 {
        peer.say(&ToDevice::SetMode(Mode::Force));
    }
    told(FaultCause::Protocol, Mode::Reset as i32)(peer.hear_words());
    peer.say(&ToDevice::SetMode(Mode::Idle));
    peer.pose(SOON, |pose| pose.mode == Mode::Idle);
}

/// Noise does nothing; a frame that begins with a zero is understood after it.
fn is_in_step_again_after_noise(peer: Peer) -> Peer {
    let mut link = peer.into_link();
    for burst in 0..40 {
        let bytes: Vec<u8> = (0..50).map(|i| ((noise(50 * burst + i) + 1.0) * 127.9) as u8).collect();
        link.send(&bytes).unwrap();
    }
    // a fresh decoder begins its first frame with a zero
    let mut peer = Peer::on(link);
    peer.say(&ToDevice::SetMode(Mode::Brake));
    peer.pose(SOON, |pose| pose.mode == Mode::Brake);
    peer.say(&ToDevice::SetMode(Mode::Reset));
    peer.say(&ToDevice::Hello(HELLO));
    greeted(peer.hear_words());
    peer
}

/// Left alone in Force it brakes, by the tick it has promised.
fn brakes_when_left_alone(peer: &mut Peer) {
    peer.say(&ToDevice::SetMode(Mode::Force));
    let fault = told(FaultCause::Watchdog, i32::from(WATCHDOG))(peer.hear_words());
    assert!(fault.seq != u32::MAX);
}

#[test]
fn two_devices_written_apart_answer_alike() {
    let (ticks, ms) = (WATCHDOG.to_string(), (WATCHDOG / 8).to_string());
    for device in [in_c(&["--watchdog-ticks", &ticks]), in_rust(&["--watchdog-ms", &ms, "--script", "hold"])] {
        let mut peer = device.connect();
        refuses_without_a_session(&mut peer);
        goes_by_its_modes(&mut peer);
        latches_what_is_not_a_number(&mut peer);
        let mut peer = is_in_step_again_after_noise(peer);
        brakes_when_left_alone(&mut peer);
    }
}

/// Numbers that the example prints after `word`.
fn numbers(line: &str, word: &str) -> Vec<i64> {
    let words = line.split_whitespace().skip_while(|found| *found != word).skip(1);
    words.map_while(|number| number.parse().ok()).collect()
}

/// The wrenches it has rendered so far [uN, uN m].
fn rendered(device: &Served) -> Vec<Vec<i64>> {
    device.said().iter().filter(|line| line.starts_with("render")).map(|line| numbers(line, "render")).collect()
}

#[test]
fn the_c_example_shortens_without_turning_and_brakes_at_its_speed_limit() {
    let device = in_c(&["--watchdog-ticks", "16000", "--trace", "--over-speed-um-s", "1000"]);
    let mut peer = device.connect();
    peer.say(&ToDevice::Hello(HELLO));
    greeted(peer.hear());
    peer.say(&ToDevice::SetMode(Mode::Force));
    let (force, torque) = ([20_000_000, -1_000_000, i32::MAX], [-150_000, 150_000, 2]);
    peer.say(&wrench(1, force, torque));
    // the handle sets out and is too fast within a fraction of a second
    let FromDevice::Fault(fault) = peer.hear_words() else { panic!("no fault") };
    assert_eq!(fault.cause, FaultCause::OverSpeed);
    assert!((1001..2000).contains(&fault.detail), "{fault:?}");
    peer.pose(SOON, |pose| pose.mode == Mode::Brake && pose.flags & PoseReport::FLAG_OVER_SPEED != 0);
    let first = rendered(&device)[0].clone();
    for (asked, got, limit) in [(force, &first[..3], 8_500_000.0), (torque, &first[3..], 188_000.0)] {
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (asked, got) = (asked.map(f64::from), [0, 1, 2].map(|i| got[i] as f64));
        assert!(length(&got) <= limit && length(&got) > limit - 3.0, "{got:?}");
        for (a, g) in asked.iter().zip(got) {
            assert!((a / length(&asked) - g / length(&got)).abs() < 1.0e-5, "{asked:?} turned: {got:?}");
        }
    }
    assert_eq!(rendered(&device).last(), Some(&vec![0; 6]));
}

/// A host that is patient with a busy machine.
const PATIENT: [&str; 4] = ["--hold", "100", "--fade", "100"];

/// A session of four seconds on the example that the machine did not spoil; and the example's books.
fn session(device_args: &[&str]) -> (Summary, String) {
    let folder = tempfile::tempdir().unwrap();
    let model = model(folder.path());
    for _ in 0..ATTEMPTS {
        let device = in_c(&[&["--watchdog-ticks", "8000"], device_args].concat());
        let said = host(&model, &device.address(), &[&PATIENT[..], &["--seconds", "4"]].concat());
        let summary = said.summary.expect("a host that ends says so");
        let lateness = [None, Some(HostFault::Overrun), Some(HostFault::Stale), Some(HostFault::DeviceWatchdog)];
        assert!(lateness.contains(&summary.fault), "{said:?}");
        let books = device.end().pop().unwrap();
        if summary.fault.is_none() {
            return (summary, books);
        }
    }
    panic!("none of {ATTEMPTS} sessions was without a late tick too many: this machine is far too busy");
}

#[test]
fn the_real_host_runs_on_the_c_example() {
    let _alone = alone();
    let (summary, books) = session(&[]);
    // a thread that sleeps through the end counts what it slept
    assert!(summary.ticks >= 4000, "{summary:?}");
    assert_eq!((summary.rejected, summary.out_of_order), (0, 0), "{summary:?}");
    assert!((3.0..8.5).contains(&summary.peak_force), "{} N", summary.peak_force);
    assert!(summary.peak_torque > 0.005, "{} N m", summary.peak_torque);
    let count = |word| numbers(&books, word)[0];
    assert_eq!((count("rejected"), count("faults"), count("dropped")), (0, 0, 0), "{books}");
    // the machine may hold both up, but what is reported is answered
    assert!(count("reports") > 1000 && 10 * count("commands") > 9 * count("reports"), "{books}");
}

#[test]
fn noise_costs_frames_and_not_the_session() {
    let _alone = alone();
    let (summary, books) = session(&["--garbage-every", "7"]);
    assert_eq!(summary.fault, None);
    assert!(summary.ticks >= 4000 && summary.lost > 150 && summary.rejected > 150, "{summary:?}");
    assert!(summary.peak_force > 3.0);
    // one report in seven is spoilt
    assert!(10 * numbers(&books, "commands")[0] > 7 * numbers(&books, "reports")[0], "{books}");
}

#[test]
fn another_version_is_refused_by_the_host() {
    let folder = tempfile::tempdir().unwrap();
    let device = in_c(&["--version", "9"]);
    let said = host(&model(folder.path()), &device.address(), &["--seconds", "2"]);
    assert_eq!(said.code, Some(1));
    assert_eq!(said.summary.and_then(|summary| summary.fault), Some(HostFault::VersionMismatch));
    assert!(said.complained.contains("device refused") && said.complained.contains("version 9"), "{}", said.complained);
}

#[test]
fn a_killed_host_leaves_a_braked_device_that_serves_the_next() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let model = model(folder.path());
    let device = in_c(&["--watchdog-ticks", "1600", "--trace"]);
    let args = [&PATIENT[..], &["--seconds", "600"]].concat();
    let mut killed = host_command(&model, &device.address(), &args).stdout(Stdio::null()).spawn().unwrap();
    let presses = |wrench: &Vec<i64>| wrench[2] > 3_000_000;
    patiently("the hand presses", || rendered(&device).iter().any(presses));
    signal(killed.id(), "KILL");
    killed.wait().unwrap();
    patiently("the watchdog", || device.said().iter().any(|line| line == "fault 0 detail 1600"));
    assert_eq!(rendered(&device).last(), Some(&vec![0; 6]), "nothing is rendered after it");
    let next = host(&model, &device.address(), &[&PATIENT[..], &["--seconds", "1"]].concat());
    assert!(next.summary.is_some_and(|summary| summary.ticks > 0), "{next:?}");
}

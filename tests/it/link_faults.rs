//! Fault drills: whatever happens to cable and device, the wrench reaches zero in the stated ticks, the fault is named and latched,
//! nothing hangs, and forces come back only from a small one.

use std::time::Duration;

use haptor_firmware_sim::preset::TOUCH;
use haptor_host::link::wrap::{FaultLink, Plan};
use haptor_host::link::{Link, LinkError};
use haptor_host::rt::blackbox::BLACKBOX_TICKS;
use haptor_host::rt::budget::OVERRUN_TICKS;
use haptor_host::rt::clock::Virtual;
use haptor_host::rt::flags;
use haptor_host::rt::stale::{FADE_TICKS, HOLD_TICKS, SMALL_FORCE};
use haptor_wire::units::NOT_A_NUMBER;
use haptor_wire::{FromDevice, HostFault, Mode, PoseReport, Record, StreamDecoder, TickRecord, encode_stream, stream_bound};

use crate::host_rig::{Cable, Rig, length};

const ZERO_AFTER: u32 = HOLD_TICKS + FADE_TICKS;

/// Ticks that a stall or noise lasts: the 50 ms of the drills.
const DRILL_US: u64 = 50_000;

/// A hand that presses: its force on the device is well above small.
fn pressing() -> Rig {
    let mut rig = Rig::new("press", None);
    assert!(rig.until(2_000, |rig| rig.ticks.last().is_some_and(|t| length(t.force) > 3.0)), "the hand presses");
    assert!(rig.faults.is_empty());
    rig
}

fn cut(rig: &mut Rig) {
    rig.far().cut = true;
}

fn stall(rig: &mut Rig) {
    rig.far().stall(DRILL_US);
}

fn noise(rig: &mut Rig) {
    rig.far().drown(DRILL_US);
}

fn restart(rig: &mut Rig) {
    rig.far().restart();
}

fn kick(rig: &mut Rig) {
    rig.far().device.kick([0.0, 0.0, 2.0]);
}

/// Something that happens to cable or device.
type Drill = fn(&mut Rig);

/// What to do to a pressing session, what it is called, within how many ticks the wrench is zero.
const DRILLS: [(&str, Drill, HostFault, u32); 5] = [
    ("cut", cut, HostFault::LinkLost, 2),
    ("stall", stall, HostFault::Stale, ZERO_AFTER + 1),
    ("noise", noise, HostFault::Garbage, ZERO_AFTER + 1),
    ("restart", restart, HostFault::DeviceRestarted, 3),
    ("kick", kick, HostFault::DeviceOverSpeed, 3),
];

#[test]
fn every_drill_ends_at_zero_in_the_stated_ticks_with_its_name() {
    for (name, drill, expected, within) in DRILLS {
        let mut rig = pressing();
        drill(&mut rig);
        let done = rig.until(within, |rig| length(rig.last().force) == 0.0 && length(rig.last().torque) == 0.0);
        assert!(done, "{name}: {} N after {within} ticks", length(rig.last().force));
        assert_eq!(rig.faults.len(), 1, "{name}: {:?}", rig.faults);
        let fault = rig.faults[0];
        assert_eq!((fault.cause, fault.tick), (expected, rig.last().tick), "{name}");
        assert!(fault.after_ticks <= ZERO_AFTER);
        assert_eq!(rig.summary().fault, Some(expected), "{name}");
    }
}

#[test]
fn after_a_fault_the_wrench_stays_zero_until_the_hand_has_come_out() {
    for (name, drill, ..) in DRILLS {
        let mut rig = pressing();
        drill(&mut rig);
        assert!(rig.until(ZERO_AFTER + 1, |rig| !rig.faults.is_empty()), "{name}");
        if name == "cut" {
            assert!(rig.until(500, |rig| rig.last().tick > 900), "{name}: the host goes on without a link");
            rig.reopen();
        }
        let from = rig.ticks.len();
        let again = rig.until(8_000, |rig| rig.last().flags & flags::CLOSED == 0 && length(rig.last().force) > 3.0);
        assert!(again, "{name}: forces never came back");
        let closed: Vec<_> = rig.ticks[from..].iter().take_while(|t| t.flags & flags::CLOSED != 0).collect();
        assert!(closed.iter().all(|t| length(t.force) == 0.0), "{name}");
        let opened = rig.ticks[from..].iter().find(|t| t.flags & flags::CLOSED == 0).expect("it opened");
        assert!(length(opened.contact_force) < SMALL_FORCE, "{name}: opened at {} N", length(opened.contact_force));
        assert_eq!(rig.far().device.mode(), Mode::Force, "{name}");
        assert_eq!(rig.summary().fault, Some(rig.faults[0].cause), "{name}: the first fault stays latched");
        assert!(rig.ticks.windows(2).all(|t| t[1].tick == t[0].tick + 1), "{name}: a tick is missing");
    }
}

/// With nothing to push back the hand goes deeper than it ever felt.
#[test]
fn peaks_are_of_what_was_felt() {
    for (name, drill, ..) in DRILLS {
        let mut rig = pressing();
        drill(&mut rig);
        rig.until(300, |_| false);
        let peak = |keep: fn(&TickRecord) -> bool| -> f32 {
            rig.ticks.iter().filter(|t| keep(t)).map(|t| length(t.contact_force)).fold(0.0, f32::max)
        };
        let (felt, summary) = (peak(TickRecord::was_felt), rig.summary());
        assert!((summary.peak_force - felt).abs() <= 1.0e-5 * felt, "{name}: {} N, felt {felt} N", summary.peak_force);
        assert!((3.0..8.5).contains(&felt), "{name}: {felt} N");
        if name == "restart" || name == "stall" {
            assert!(peak(|_| true) > felt, "{name}: the hand pushes on");
        }
    }
}

#[test]
fn between_the_last_pose_and_zero_the_wrench_is_held_and_then_only_falls() {
    let mut rig = pressing();
    stall(&mut rig);
    let held = rig.last().force;
    rig.until(ZERO_AFTER + 1, |rig| !rig.faults.is_empty());
    let stale: Vec<f32> = rig.ticks.iter().filter(|t| t.flags & flags::NO_POSE != 0).map(|t| length(t.force)).collect();
    let tail = &stale[stale.len() - ZERO_AFTER as usize..];
    assert!(tail[..HOLD_TICKS as usize].windows(2).all(|f| f[0] == f[1]));
    assert!((tail[0] - length(held)).abs() < 0.5, "{} N held, {} N before", tail[0], length(held));
    assert!(tail[HOLD_TICKS as usize - 1..].windows(2).all(|f| f[1] < f[0]), "{tail:?}");
    assert_eq!(tail.last(), Some(&0.0));
}

#[test]
fn the_black_box_ends_with_the_fault_s_own_tick() {
    let mut rig = pressing();
    assert!(rig.dumps.take().is_none());
    stall(&mut rig);
    rig.until(ZERO_AFTER + 1, |rig| !rig.faults.is_empty());
    let dump = rig.dumps.take().expect("a dump");
    assert_eq!(dump.fault, rig.faults[0]);
    let kept: Vec<_> = dump.ring.iter().collect();
    assert!(kept.len() <= BLACKBOX_TICKS as usize);
    assert_eq!(kept.last().map(|t| t.tick), Some(dump.fault.tick));
    assert!(kept.iter().any(|t| length(t.force) > 3.0), "the press is in it");
}

#[test]
fn a_poor_line_costs_frames_and_not_the_session() {
    let plan = Plan { drop: 100, delay: 50, corrupt: 50, duplicate: 50, garbage: 20 };
    for seed in 1..=5 {
        let mut rig = Rig::with_link("press-twist-slide", Some(6_000), |cable| Box::new(FaultLink::new(cable, plan, seed)));
        while !rig.control.is_over() {
            rig.tick();
        }
        let s = rig.summary();
        assert_eq!((s.fault, s.ticks), (None, 6_000), "seed {seed}");
        assert!(s.lost > 500 && s.rejected > 200 && s.out_of_order > 100, "seed {seed}: {s:?}");
        assert!(s.peak_force > 3.0, "seed {seed}");
        for t in &rig.ticks {
            assert!(t.force.iter().chain(&t.torque).all(|x| x.is_finite()) && length(t.force) <= 8.5 * 1.0001, "{t:?}");
        }
    }
}

#[test]
fn a_hopeless_line_ends_at_zero_and_does_not_hang() {
    for (plan, expected) in [
        (Plan { drop: 1000, ..Plan::default() }, HostFault::Stale),
        (Plan { corrupt: 1000, ..Plan::default() }, HostFault::Garbage),
    ] {
        let mut rig = Rig::with_link("press", Some(6_000), |cable| Box::new(FaultLink::new(cable, plan, 3)));
        while !rig.control.is_over() {
            rig.tick();
        }
        assert_eq!((rig.summary().fault, rig.summary().ticks), (Some(expected), 0));
    }
}

/// A cable on which reports are altered, the n-th of the session by `alter(n, report)`, and which takes nothing any more from `deaf_from` on.
struct Altered {
    cable: Cable,
    decoder: StreamDecoder<128>,
    reports: u32,
    alter: fn(u32, &mut PoseReport),
    deaf_from: u32,
}

/// A rig on such a cable.
fn altered(alter: fn(u32, &mut PoseReport), deaf_from: u32) -> Rig {
    Rig::with_link("press", None, move |cable| {
        Box::new(Altered { cable, decoder: StreamDecoder::new(), reports: 0, alter, deaf_from })
    })
}

impl Link for Altered {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        if self.reports >= self.deaf_from { Err(LinkError::Full) } else { self.cable.send(bytes) }
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        let mut raw = [0; 256];
        let n = self.cable.receive(&mut raw, wait)?;
        let (mut length, alter, reports) = (0, self.alter, &mut self.reports);
        self.decoder.feed(&raw[..n], |mut message: FromDevice| {
            if let FromDevice::Pose(pose) = &mut message {
                alter(*reports, pose);
                *reports += 1;
            }
            length += encode_stream(&message, &mut into[length..]).expect("room for what fitted before");
        });
        Ok(length)
    }

    fn name(&self) -> &str {
        self.cable.name()
    }
}

#[test]
fn poses_that_are_none_count_as_not_come_and_are_named() {
    assert!(stream_bound(FromDevice::MAX_ENCODED) <= 128);
    let blind = |n: u32, pose: &mut PoseReport| {
        if n >= 900 {
            pose.position_nm[1] = NOT_A_NUMBER;
        }
    };
    let mut rig = altered(blind, u32::MAX);
    assert!(rig.until(1_500, |rig| !rig.faults.is_empty()));
    assert_eq!((rig.faults[0].cause, rig.faults[0].after_ticks), (HostFault::NonFinite, ZERO_AFTER));
    assert_eq!(length(rig.last().force), 0.0);
    assert!(rig.last().flags & flags::POSE_REFUSED != 0);
    assert!(rig.ticks.iter().all(|t| t.force.iter().all(|x| x.is_finite())));
}

#[test]
fn a_device_at_rest_for_a_moment_gets_forces_back_by_the_small_force_rule() {
    let resting = |n: u32, pose: &mut PoseReport| {
        if (900..920).contains(&n) {
            pose.mode = Mode::Idle;
        }
    };
    let mut rig = altered(resting, u32::MAX);
    assert!(rig.until(950, |rig| rig.ticks.last().is_some_and(|t| length(t.force) > 3.0)), "the hand presses");
    assert!(rig.until(950, |rig| rig.last().flags & flags::CLOSED != 0));
    let closed = rig.ticks.len();
    assert!(rig.until(8_000, |rig| rig.last().flags & flags::CLOSED == 0), "forces never came back");
    assert!(rig.ticks[closed..rig.ticks.len() - 1].iter().all(|t| length(t.force) == 0.0));
    assert!(rig.ticks.len() - closed > 40, "the device was back before the hand came out");
    assert!(length(rig.last().contact_force) < SMALL_FORCE, "opened at {} N", length(rig.last().contact_force));
    assert!(rig.faults.is_empty(), "{:?}", rig.faults);
}

#[test]
fn a_device_that_takes_nothing_is_not_called_a_slow_machine() {
    let mut rig = altered(|_, _| {}, 900);
    assert!(rig.until(2_000, |rig| !rig.faults.is_empty()));
    assert_eq!((rig.faults[0].cause, length(rig.last().force)), (HostFault::LinkLost, 0.0));
}

/// Another device at the same address: its limits are learned, from rest, and the recording says so before the first tick under them.
#[test]
fn a_device_that_comes_back_as_another_is_learned_anew() {
    let mut rig = pressing();
    cut(&mut rig);
    rig.until(5, |_| false);
    rig.far().device.restart(&TOUCH, "OTHER");
    rig.reopen();
    let before = rig.records.len();
    assert!(rig.until(8_000, |rig| rig.last().flags & flags::CLOSED == 0 && length(rig.last().contact_force) > 4.0));
    let hello = rig.device.expect("recorded");
    assert_eq!((hello.max_force_un, hello.max_torque_unm), (3_300_000, 0));
    let news = &rig.records[before..];
    let rest = news.iter().position(|record| matches!(record, Record::Rest)).expect("a rest");
    assert!(news[..rest].iter().any(|record| matches!(record, Record::Device(_))));
    let after: Vec<_> = news[rest..].iter().filter_map(|r| if let Record::Tick(tick) = r { Some(tick) } else { None }).collect();
    assert!(after.iter().all(|t| length(t.force) <= 3.3 * 1.0001), "more than it renders");
    assert!(after.iter().any(|t| length(t.force) > 3.0), "the hand presses again");
}

/// A cable that takes two periods to send.
struct Slow(Cable, Virtual);

impl Link for Slow {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.1.advance_ns(2_000_000);
        self.0.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        self.0.receive(into, wait)
    }

    fn name(&self) -> &str {
        self.0.name()
    }
}

#[test]
fn a_machine_that_cannot_keep_up_is_told_so() {
    let mut rig = Rig::with_link("press", None, |cable| {
        let clock = cable.0.lock().expect("one thread").clock.clone();
        Box::new(Slow(cable, clock))
    });
    assert!(rig.until(200, |rig| !rig.faults.is_empty()));
    let ran = rig.ticks.len() as u32;
    assert_eq!((rig.faults[0].cause, ran), (HostFault::Overrun, OVERRUN_TICKS + 1));
    let s = rig.summary();
    assert_eq!((s.in_time, s.late), (0, s.ticks));
}

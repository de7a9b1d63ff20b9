//! At 1, 2, 4 and 8 kHz alike: every report is felt, every tick recorded, and what takes a time takes the same time. Host and simulated device in one thread on a
//! virtual clock, bytes through memory.

use haptor_host::rt::blackbox::BLACKBOX_TICKS;
use haptor_host::rt::flags;
use haptor_host::rt::stale::{FADE_TICKS, HOLD_TICKS, SMALL_FORCE};
use haptor_wire::{HostFault, TickRecord};

use crate::host_rig::{Rig, ball_on_cube, length, settings_at};

/// Ticks a second [Hz], and how many of them make a tick of 1 kHz.
const RATES: [(u32, u32); 4] = [(1000, 1), (2000, 2), (4000, 4), (8000, 8)];

fn rig(rate_hz: u32, script: &str) -> Rig {
    Rig::at(settings_at(rate_hz, None), &ball_on_cube(), script, |cable| Box::new(cable))
}

/// Force at the end of a press of some time.
fn pressed(rig: &mut Rig, ticks: u32) -> f32 {
    (0..ticks).for_each(|_| rig.tick());
    length(rig.last().force)
}

#[test]
fn every_report_is_felt_every_tick_recorded_and_the_press_is_the_same() {
    let mut forces = Vec::new();
    for (rate_hz, k) in RATES {
        let mut rig = rig(rate_hz, "press");
        forces.push(pressed(&mut rig, 1_200 * k));
        let summary = rig.summary();
        assert_eq!((summary.fault, summary.lost, summary.recorder_dropped, summary.late), (None, 0, 0, 0), "{rate_hz} Hz");
        assert_eq!(rig.ticks.len() as u64, summary.ticks, "{rate_hz} Hz");
        // the first reports of a session come while the device arms
        let blind = rig.ticks.iter().skip(10).filter(|tick| tick.flags & flags::NO_POSE != 0).count();
        assert_eq!(blind, 0, "{rate_hz} Hz");
        let told = rig.device.expect("the session has begun");
        assert_eq!(told.period_us, 1_000_000 / rate_hz);
    }
    // a hand on a spring ends in the same place, however often it is felt
    let all = forces.iter().all(|force| (force / forces[0] - 1.0).abs() < 0.02);
    assert!(forces[0] > 3.0 && all, "{forces:?}");
}

#[test]
fn a_silent_device_is_held_faded_and_let_back_in_after_the_same_time() {
    for (rate_hz, k) in RATES {
        let mut rig = rig(rate_hz, "press-twist-slide");
        assert!(pressed(&mut rig, 600 * k) > SMALL_FORCE, "{rate_hz} Hz");
        rig.far().stall(100_000);
        assert!(rig.until(200 * k, |rig| !rig.faults.is_empty()), "{rate_hz} Hz");
        assert_eq!((rig.faults[0].cause, rig.faults[0].after_ticks), (HostFault::Stale, k * (HOLD_TICKS + FADE_TICKS)));
        let dump = rig.dumps.take().expect("a black box");
        let kept = dump.ring.iter().count();
        assert!(kept > 500 * k as usize && kept <= (k * BLACKBOX_TICKS) as usize, "{rate_hz} Hz: {kept}");
        let open = |tick: &TickRecord| tick.flags & flags::CLOSED == 0;
        assert!(rig.until(8_000 * k, |rig| open(rig.last())), "{rate_hz} Hz: forces come back");
        assert_eq!(rig.summary().recorder_dropped, 0);
    }
}

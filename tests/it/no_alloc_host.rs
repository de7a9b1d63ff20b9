//! After start-up the real-time thread calls no allocator: not while it runs well, not while it loses its link, and not while it
//! recovers.

use haptor_host::rt::flags;

use crate::alloc::counted;
use crate::host_rig::{Rig, length};

/// Runs `ticks`, counting what the host alone allocates.
fn run(rig: &mut Rig, ticks: u32) -> u64 {
    let mut calls = 0;
    for _ in 0..ticks {
        calls += counted(|| rig.control.tick()).1;
        rig.collect();
    }
    calls
}

#[test]
fn no_tick_allocates_whatever_happens() {
    let mut rig = Rig::new("press", None);
    // the handshake and the session's begin are part of it: all memory is there before the first tick
    assert_eq!(run(&mut rig, 1_000), 0, "start and press");
    let press = rig.last().force;
    assert!(length(press) > 1.0, "{press:?}");

    rig.far().stall(1_000_000);
    assert_eq!(run(&mut rig, 1_200), 0, "a stall, a fault, a black box");
    assert_eq!(rig.faults.len(), 1);

    rig.far().cut = true;
    assert_eq!(run(&mut rig, 100), 0, "the link dies");
    rig.reopen();
    assert_eq!(run(&mut rig, 8_000), 0, "a new link, recovery");
    assert_eq!(rig.last().flags & flags::CLOSED, 0, "the output is open again");
    assert!(rig.ticks.len() > 10_000);
}

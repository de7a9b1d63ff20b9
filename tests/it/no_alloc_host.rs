//! After start-up the real-time thread calls no allocator: not while it runs well, not while it loses its link, and not while it
//! recovers.

use haptor_engine::{Limit, Scene};
use haptor_host::rt::desk::{Activation, Note, Numbered, Order};
use haptor_host::rt::flags;
use haptor_wire::{Denial, Tuning};

use crate::alloc::counted;
use crate::host_rig::{Rig, ball_on_cube, length};

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

/// What viewers ask is carried out, and what they see is shown, without a call to the allocator; what is not needed any more goes back to be dropped elsewhere.
#[test]
fn no_order_of_a_viewer_allocates_and_no_look() {
    let mut rig = Rig::new("press-twist-slide", None);
    let mut counter = rig.counter.take().expect("nobody has it yet");
    let scene = Scene::new(&ball_on_cube()).expect("a good scene");
    let slippery = Tuning { friction_static: 0.1, friction_dynamic: 0.1, ..Tuning::of(&ball_on_cube()) };
    let tuned = scene.tuned(&slippery).expect("a good tuning");
    counter.wanted.look_every(0, 3);
    assert_eq!(run(&mut rig, 600), 0, "looks, until no box is left");
    assert!(counter.wanted.missed() > 0 && counter.looks.slots() > 10);
    let engine = scene.engine().expect("a good scene");
    let orders = [
        Order::Tune { scene: 0, tuned },
        Order::Freeze(true),
        Order::Freeze(false),
        Order::Rearm,
        Order::Tare,
        Order::Activate(Activation { engine, scene: 1, digest: 7 }),
        Order::Tune { scene: 0, tuned },
        Order::Limit(Limit::new(Some(20_000)).expect("a good budget")),
    ];
    let (mut done, mut retired) = (Vec::new(), 0);
    for (number, order) in (0..).zip(orders) {
        counter.orders.push(Numbered { number, order }).expect("room");
        counter.wanted.stop();
        assert_eq!(run(&mut rig, 50), 0, "order {number}, and an emergency stop");
        counter.orders.push(Numbered { number: 100, order: Order::Rearm }).expect("room");
        // armed again, and the hand lifts
        assert_eq!(run(&mut rig, 2_000), 0, "order {number}");
        while let Ok(note) = counter.notes.pop() {
            if let Note::Answer { number, result, retired: old } = note {
                retired += u32::from(old.is_some());
                done.extend((number < 100).then_some(result));
            }
        }
        while let Ok(look) = counter.looks.pop() {
            counter.spare.push(look).expect("room");
        }
    }
    assert_eq!(done.len(), 8);
    assert_eq!((done[0], done[1], done[2], done[5], done[6]), (Ok(()), Ok(()), Ok(()), Ok(()), Err(Denial::Busy)), "{done:?}");
    assert_eq!(done[7], Ok(()), "whatever runs");
    assert_eq!((retired, rig.summary().fault), (1, None));
}

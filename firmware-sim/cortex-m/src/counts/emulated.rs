//! The scenes on the emulated board: timer, painted stack, and lines over semihosting.

use core::fmt::Write;
use core::hint::black_box;

use cortex_m::singleton;
use cortex_m_rt::entry;
use cortex_m_semihosting::debug;
use cortex_m_semihosting::hio::{self, HostStream};

use crate::bench::{self, Count, Room};
use crate::board::{PAINT, Register, paint_stack};
use crate::cases::{self, Case};
use crate::sizes;

#[entry]
fn main() -> ! {
    let good = match (singleton!(: Room = Room::new()), hio::hstdout()) {
        (Some(room), Ok(mut out)) => say_sizes(&mut out) && count_all(room, &mut out),
        _ => false,
    };
    debug::exit(if good { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {
        cortex_m::asm::wfi();
    }
}

/// What the memory of a tick takes here; whether it could be written.
fn say_sizes(out: &mut HostStream) -> bool {
    sizes::all().iter().all(|(what, bytes)| writeln!(out, "{what}\t{bytes}").is_ok())
}

/// Every scene, from a state as new; whether all went well.
fn count_all(room: &mut Room, out: &mut HostStream) -> bool {
    cases::all().all(|case| {
        room.clear();
        let mut counter = Counter::start();
        let top = paint_stack(PAINTED_BYTES);
        let regions = bench::run(&case, room, &mut counter);
        let stack = stack_used(top);
        if regions != Ok(case.regions) {
            let _ = writeln!(out, "{}: refused, or not with {} regions", case.name, case.regions);
            return false;
        }
        counter.say(&case, stack, out)
    })
}

/// Bytes that are painted below a scene: more than a surface needs.
const PAINTED_BYTES: usize = 256 * 1024;

/// Bytes of the painted stack that are painted no more.
fn stack_used(top: usize) -> usize {
    let painted = (top - PAINTED_BYTES..top).step_by(4).take_while(|&at| Register(at).read() == PAINT).count();
    PAINTED_BYTES - 4 * painted
}

/// Timer 0 of Arm's CMSDK, which counts down at the board's 25 MHz, and what it has counted.
struct Counter {
    /// What reading it and calling costs \[ticks\].
    own: u32,
    calls: u32,
    total: u64,
    worst: u32,
    worst_call: u32,
}

impl Counter {
    /// Bit 0 runs.
    const CONTROL: Register = Register(0x4000_0000);
    const VALUE: Register = Register(0x4000_0004);
    const RELOAD: Register = Register(0x4000_0008);

    fn start() -> Self {
        Self::RELOAD.write(u32::MAX);
        Self::VALUE.write(u32::MAX);
        Self::CONTROL.write(1);
        Self { own: Self::ticks(nothing), calls: 0, total: 0, worst: 0, worst_call: 0 }
    }

    /// Ticks that a call takes, and the reading before and after.
    fn ticks(call: impl FnOnce()) -> u32 {
        let before = Self::VALUE.read();
        call();
        before.wrapping_sub(Self::VALUE.read())
    }

    /// A line for a scene; whether it could be written.
    fn say(&self, case: &Case, stack: usize, out: &mut HostStream) -> bool {
        let Self { calls, total, worst, worst_call, .. } = self;
        writeln!(out, "{}\t{calls}\t{total}\t{worst}\t{worst_call}\t{stack}", case.name).is_ok()
    }
}

impl Count for Counter {
    fn count(&mut self, call: impl FnOnce()) {
        // a tick of the timer takes 40 ns, an instruction 256 ns: one is 6.4 ticks, and half of that rounds
        let count = (Self::ticks(call).saturating_sub(self.own).saturating_mul(10).saturating_add(32)) / 64;
        if count > self.worst {
            (self.worst, self.worst_call) = (count, self.calls);
        }
        self.total += u64::from(count);
        self.calls += 1;
    }
}

#[inline(never)]
fn nothing() {
    black_box(());
}

//! Runs a session of the contact core on a Cortex-M7 and says over semihosting whether its bits are those of every other machine.
//!
//! No heap, no operating system, no panic path from a tick. The emulator ends with success only if the digest is the expected one.
#![no_std]
#![no_main]

#[path = "../../../tests/support/bits.rs"]
mod bits;

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};

#[entry]
fn main() -> ! {
    let digest = bits::session();
    let (high, low) = ((digest >> 32) as u32, digest as u32);
    hprintln!("digest {:08x}{:08x}", high, low);
    let status = if digest == bits::EXPECTED { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE };
    debug::exit(status);
    loop {
        cortex_m::asm::wfi();
    }
}

/// Ends the emulator: a panic is a failed session.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    hprintln!("panicked");
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}

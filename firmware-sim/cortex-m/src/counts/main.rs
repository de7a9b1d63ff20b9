//! Counts the instructions of a tick on a Cortex-M7, scene by scene: the list of `tests/counts/cases.rs`, which a PC counts too.
//!
//! QEMU runs it with `-icount shift=8`: an instruction takes 256 ns of emulated time, 6.4 ticks of the board's 25 MHz timer, so that a difference of the timer tells
//! the instructions exactly. No interrupt is enabled. What it says has tabs between fields: a line for each size, what and bytes; then a line for each scene, name, calls,
//! instructions of all, of the dearest, which call that was from 0, bytes of stack from `bench::run` down. The emulator ends with success only if every scene came to its end with the regions that it must have.
//!
//! Built for a PC it runs the same scenes and says nothing: there it is linked to be looked at.
//!
//! No heap. No panic either, for every shape, tier and table of the core: the handler calls a function that does not exist, so an image in which anything could
//! panic does not link.
#![no_std]
#![no_main]

#[path = "../../../../tests/counts/bench.rs"]
mod bench;
#[cfg(target_os = "none")]
#[path = "../board.rs"]
mod board;
#[path = "../../../../tests/counts/cases.rs"]
#[cfg_attr(not(target_os = "none"), expect(dead_code, reason = "nothing is said there, so no name either"))]
mod cases;
#[cfg(target_os = "none")]
mod emulated;
#[cfg(not(target_os = "none"))]
mod hosted;
#[cfg(target_os = "none")]
#[path = "../../../../tests/counts/sizes.rs"]
mod sizes;

use core::panic::PanicInfo;

unsafe extern "C" {
    /// Nowhere defined.
    fn a_panic_can_be_reached() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: an image that calls it does not link
    unsafe { a_panic_can_be_reached() }
}

//! What the images share of QEMU's mps2-an500: registers, and a stack that is painted to be measured.

use core::ptr;

/// A register of a peripheral, or a word of memory.
#[derive(Clone, Copy)]
pub struct Register(pub usize);

impl Register {
    pub fn read(self) -> u32 {
        // SAFETY: every register of the images is one of the board's, aligned, and reading it changes nothing that the compiler knows of
        unsafe { ptr::read_volatile(self.0 as *const u32) }
    }

    pub fn write(self, value: u32) {
        // SAFETY: as for reading; words of memory that are written lie below every frame in use
        unsafe { ptr::write_volatile(self.0 as *mut u32, value) }
    }
}

/// What the stack is painted with.
pub const PAINT: u32 = 0xA5A5_5A5A;

/// Bytes below the stack pointer that painting itself may use.
const OWN_BYTES: usize = 256;

/// Paints `bytes` of the stack below this function, so that what was used of it can be read afterwards; yields where its own frame ends.
#[inline(never)]
pub fn paint_stack(bytes: usize) -> usize {
    let here = cortex_m::register::msp::read() as usize & !3;
    for at in (here - bytes..here - OWN_BYTES).step_by(4) {
        Register(at).write(PAINT);
    }
    here
}

//! Asking a serial driver to pass on what it has at once.
//!
//! Linux keeps a flag for it, `ASYNC_LOW_LATENCY`, that any user of a port may set (`setserial PORT low_latency`). With it the driver of
//! FTDI's chips waits 1 ms for a packet to fill and not 16, and the drivers of chips on the board hand over each interrupt's bytes. Drivers of USB
//! CDC ports and pseudo-terminals wait for nothing and have no such flag. `serialport` does not offer it, hence a system call and `unsafe`.

use std::ffi::{c_char, c_int, c_uint, c_ulong, c_ushort, c_void};
use std::os::fd::AsFd;

use rustix::io::Errno;
use rustix::ioctl::{Getter, Opcode, Setter, ioctl};

/// `ASYNC_LOW_LATENCY` of linux/tty_flags.h.
const LOW_LATENCY: c_int = 1 << 13;

/// `struct serial_struct` of linux/serial.h.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
struct SerialStruct {
    kind: c_int,
    line: c_int,
    port: c_uint,
    irq: c_int,
    flags: c_int,
    xmit_fifo_size: c_int,
    custom_divisor: c_int,
    baud_base: c_int,
    close_delay: c_ushort,
    io_type: c_char,
    reserved_char: c_char,
    hub6: c_int,
    closing_wait: c_ushort,
    closing_wait2: c_ushort,
    iomem_base: *mut c_void,
    iomem_reg_shift: c_ushort,
    port_high: c_uint,
    iomap_base: c_ulong,
}

/// Sets the flag; false when the driver has none.
pub(super) fn set(port: impl AsFd) -> bool {
    try_set(port).is_ok()
}

fn try_set(port: impl AsFd) -> Result<(), Errno> {
    // SAFETY: TIOCGSERIAL writes one serial_struct, laid out as above
    let mut settings: SerialStruct = unsafe {
        let get = Getter::<{ libc::TIOCGSERIAL as Opcode }, SerialStruct>::new();
        ioctl(&port, get)?
    };
    settings.flags |= LOW_LATENCY;
    // SAFETY: TIOCSSERIAL reads one serial_struct, which the kernel itself has just filled in
    unsafe {
        let set = Setter::<{ libc::TIOCSSERIAL as Opcode }, SerialStruct>::new(settings);
        ioctl(&port, set)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::pty::{OpenptFlags, openpt};

    #[test]
    fn a_pseudo_terminal_has_no_such_flag() {
        assert!(!set(openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap()));
        // of the kernel's header, on machines of 64 bits
        assert_eq!(size_of::<SerialStruct>(), if cfg!(target_pointer_width = "64") { 72 } else { 60 });
    }
}

//! The simulated device as firmware: logic, handle and hand on a Cortex-M7, its UART the device link of `core/wire/WIRE.md`.
//!
//! ```text
//!  UART0 receives ──► rx ──┐
//!                          ▼ once a millisecond
//!  SysTick ──► Device::step(1 ms, rx) ──► tx ──► UART0 sends
//! ```
//! The processor sleeps between bytes and milliseconds. Interrupts stay masked: one that is pending ends the sleep all the same, so
//! there is no handler and nothing is shared. A millisecond that passes while the last one is still being worked on is left out: time of the device
//! is milliseconds that it has worked through, and an emulator that is too slow makes it slow, not wrong.
//!
//! No heap. No panic either: the handler calls a function that does not exist, so an image in which anything could panic does not link.
#![no_std]
#![no_main]

#[path = "../board.rs"]
mod board;

use core::panic::PanicInfo;

use board::{Register, paint_stack};
use cortex_m::asm;
use cortex_m_rt::entry;
use haptor_firmware_sim::plant::{Encoders, FIRM_GRIP};
use haptor_firmware_sim::preset::PREMIUM15;
use haptor_firmware_sim::script::Reach;
use haptor_firmware_sim::{Device, Preset, Script, TxBuf};

/// Time of a turn \[us\].
const TURN_US: u32 = 1_000;

/// Clock of the processor and of SysTick on QEMU's mps2-an500 \[Hz\].
const CLOCK_HZ: u32 = 25_000_000;

/// The device on an emulator is slower than on a desk by as much as the emulator: a second of its own time without a wrench and it brakes.
const WATCHDOG_TICKS: u16 = 8_000;

/// Bytes kept of what comes in a turn: twenty commands. More is not read, and waits in the line.
const RX_BYTES: usize = 1_024;

/// Bytes below the stack's top that are painted: far more than is used, which the measurement shows.
const PAINTED_BYTES: usize = 32 * 1024;

#[entry]
fn main() -> ! {
    paint_stack(PAINTED_BYTES);
    let preset = Preset { watchdog_ticks: WATCHDOG_TICKS, ..PREMIUM15 };
    let reach = Reach::usual(FIRM_GRIP.stiffness, preset.max_force);
    if let Some(script) = Script::by_name("press-twist-slide", &reach, true) {
        serve(&mut Device::new(&preset, "M7-1", FIRM_GRIP, Encoders::FINE, script));
    }
    loop {
        asm::wfi();
    }
}

/// Serves for ever.
fn serve(device: &mut Device) {
    let (uart, clock) = (Uart::open(), Clock::start());
    let (mut rx, mut used, mut tx) = ([0; RX_BYTES], 0, TxBuf::new());
    loop {
        asm::wfi();
        used += uart.receive(rx.get_mut(used..).unwrap_or_default());
        if clock.has_struck() {
            turn(device, rx.get(..used).unwrap_or_default(), &mut tx);
            used = 0;
            tx.as_slice().iter().for_each(|&byte| uart.send(byte));
            tx.clear();
        }
    }
}

/// A turn; the name is what the bound of the stack is told.
#[inline(never)]
fn turn(device: &mut Device, rx: &[u8], tx: &mut TxBuf) {
    device.step(TURN_US, rx, tx);
}

/// The first UART of Arm's CMSDK: a byte each way, no queue.
struct Uart;

impl Uart {
    const DATA: Register = Register(0x4000_4000);
    /// Bit 0 no room to send, bit 1 a byte has come.
    const STATE: Register = Register(0x4000_4004);
    /// Bits 0, 1 send, receive; bit 3 interrupt when a byte has come.
    const CONTROL: Register = Register(0x4000_4008);
    /// Writing bit 1 takes the interrupt back.
    const INTERRUPT: Register = Register(0x4000_400C);
    const BAUD_DIVIDER: Register = Register(0x4000_4010);
    /// Interrupt enable and pending of the NVIC; the receiver is number 0.
    const ENABLE: Register = Register(0xE000_E100);
    const UNPEND: Register = Register(0xE000_E280);

    fn open() -> Self {
        // the smallest that is allowed: 1.56 Mbit/s. An emulated line takes no time
        Self::BAUD_DIVIDER.write(16);
        Self::CONTROL.write(0b1011);
        cortex_m::interrupt::disable();
        Self::ENABLE.write(1);
        Self
    }

    /// Takes what has come, as far as there is room; yields how much.
    fn receive(&self, into: &mut [u8]) -> usize {
        let mut used = 0;
        for slot in into {
            Self::INTERRUPT.write(0b10);
            Self::UNPEND.write(1);
            if Self::STATE.read() & 0b10 == 0 {
                break;
            }
            *slot = Self::DATA.read() as u8;
            used += 1;
        }
        used
    }

    /// Sends a byte, waiting for room.
    fn send(&self, byte: u8) {
        while Self::STATE.read() & 1 != 0 {}
        Self::DATA.write(byte.into());
    }
}

/// SysTick, once a turn.
struct Clock;

impl Clock {
    /// Bit 0 runs, bit 1 interrupt, bit 2 by the processor's clock; bit 16 has struck since last read.
    const CONTROL: Register = Register(0xE000_E010);
    const RELOAD: Register = Register(0xE000_E014);
    const VALUE: Register = Register(0xE000_E018);
    /// Writing bit 25 takes SysTick's interrupt back.
    const UNPEND: Register = Register(0xE000_ED04);

    fn start() -> Self {
        Self::RELOAD.write(CLOCK_HZ / 1_000_000 * TURN_US - 1);
        Self::VALUE.write(0);
        Self::CONTROL.write(0b111);
        Self
    }

    /// Whether a turn has passed since last asked; however many have, it is one.
    fn has_struck(&self) -> bool {
        Self::UNPEND.write(1 << 25);
        Self::CONTROL.read() & 1 << 16 != 0
    }
}

unsafe extern "C" {
    /// Nowhere defined.
    fn a_panic_can_be_reached() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: an image that calls it does not link
    unsafe { a_panic_can_be_reached() }
}

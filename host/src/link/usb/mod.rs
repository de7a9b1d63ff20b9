//! A USB device by libusb: one interface, a message in each packet of 64 bytes.
//!
//! The default is the **interrupt** pair of endpoints, because the bus reserves its turns and bounds the time between two of them; the **bulk**
//! pair gets what is left, and is there for hosts and hubs that serve interrupts badly. Over a simulated bus both cost the same.
//!
//! Transfers are made once, when a device is opened, and used again: some are always on their way to fetch what the device says, one brings
//! what the host says. Neither sending nor receiving waits for the device, so a device that stops listening costs no time; libusb's
//! synchronous calls count in whole milliseconds, cannot just look, and wait. What remains of libusb on the real-time thread: it allocates and frees
//! 56 bytes in C for every transfer that it submits, two a tick (the synchronous calls: four), out of sight of this program's allocator.
//!
//! Whatever ends a transfer badly, a halted endpoint too, ends the link: clearing a halt asks the device and waits for its answer, up to seconds,
//! which is no business of the real-time thread. The reopening thread finds the device again and clears what is halted.
//!
//! | file | what it is |
//! |---|---|
//! | [`find`] | which device is meant; what is said when it is none, several, or not allowed |
//! | [`transfers`] | transfers that are used again; the one file with `unsafe` |

pub mod find;
pub mod transfers;

use std::io;
use std::time::Duration;

use haptor_wire::PACKET_BYTES;
use haptor_wire::usb::{BULK, INTERFACE, INTERRUPT};
use rusb::{Context, DeviceHandle};

use super::{Framing, Link, LinkError};
use transfers::{Kind, Transfers};

/// An opened and claimed device.
#[derive(Debug)]
pub struct UsbLink {
    transfers: Transfers,
    name: String,
}

impl UsbLink {
    /// Finds, opens and claims the device with this serial number; without one, the only device. `bulk` = by the bulk endpoints.
    ///
    /// # Errors
    /// None found, several to choose from, no right to it, claimed by another program: each with what to do.
    pub fn open(serial: Option<&str>, bulk: bool) -> io::Result<Self> {
        let (handle, serial) = find::open(serial)?;
        claim(&handle).map_err(|error| find::explain(error, &serial))?;
        let (kind, pair) = if bulk { (Kind::Bulk, BULK) } else { (Kind::Interrupt, INTERRUPT) };
        for endpoint in [pair.to_device, pair.to_host] {
            handle.clear_halt(endpoint).map_err(|error| find::explain(error, &serial))?;
        }
        let transfers = Transfers::start(handle, kind, pair).map_err(|error| find::explain(error, &serial))?;
        let kind = if bulk { "usb-bulk" } else { "usb" };
        Ok(Self { transfers, name: format!("{kind}:{serial}") })
    }
}

fn claim(handle: &DeviceHandle<Context>) -> rusb::Result<()> {
    // not on every system; where it is not, no kernel driver is in the way either
    let _ = handle.set_auto_detach_kernel_driver(true);
    handle.claim_interface(INTERFACE)
}

impl Link for UsbLink {
    fn framing(&self) -> Framing {
        Framing::Packet
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let packet = bytes.first_chunk::<PACKET_BYTES>().ok_or(LinkError::Full)?;
        self.transfers.send(packet)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        self.transfers.receive(into, wait)
    }

    fn name(&self) -> &str {
        &self.name
    }
}

//! A USB device by libusb: one interface, interrupt endpoints, a message in each packet of 64 bytes.
//!
//! Interrupt endpoints, because the bus reserves their turn and bounds the time between two polls; bulk does neither. What libusb's
//! synchronous calls cost: they count in whole milliseconds and never "not at all", so a look that may not wait asks nothing, and one
//! that may waits a millisecond at least. Ticks should therefore follow the device (`--pace device`, the default for USB). They also
//! allocate in C, out of sight of this program's allocator.
//!
//! This file is built by default and held by no test of this crate: that needs a kernel that believes in a USB device.

use std::io;
use std::time::Duration;

use rusb::{Context, Device, DeviceDescriptor, DeviceHandle, Error, UsbContext};

use super::{Framing, Link, LinkError};

/// Vendor of haptor devices: pid.codes, whose numbers are free for open hardware.
pub const VENDOR_ID: u16 = 0x1209;

/// Product: pid.codes' number for private tests. A device that is handed to anyone needs its own, here and nowhere else.
pub const PRODUCT_ID: u16 = 0x0001;

/// Class, subclass and protocol of the interface; matched as well, since others may use the test number.
const INTERFACE_TRIPLE: (u8, u8, u8) = (0xFF, 0x48, 0x01);

/// The interface.
const INTERFACE: u8 = 0;

/// Endpoint to the device.
const OUT: u8 = 0x01;

/// Endpoint from the device.
const IN: u8 = 0x81;

/// Time a packet may take to go out: at 125 us to 1 ms a poll a device that takes longer is not reading.
const SEND_TIMEOUT: Duration = Duration::from_millis(5);

/// The shortest wait libusb has; its 0 means for ever.
const SHORTEST_WAIT: Duration = Duration::from_millis(1);

/// An opened and claimed device.
#[derive(Debug)]
pub struct UsbLink {
    handle: DeviceHandle<Context>,
    name: String,
}

impl UsbLink {
    /// Finds, opens and claims the device with this serial number, or the first one.
    ///
    /// # Errors
    /// libusb's: none found, no right to it, claimed by another program.
    pub fn open(serial: Option<&str>) -> io::Result<Self> {
        // libusb calls it "other error" when the system has no USB at all, as in most containers
        let context = Context::new().map_err(|error| match error {
            Error::Other => io::Error::other("this system gives no access to USB; is /dev/bus/usb there?"),
            error => into_io(error),
        })?;
        let devices = context.devices().map_err(into_io)?;
        let mut refused = None;
        for device in devices.iter() {
            match try_open(&device, serial) {
                Ok(Some(link)) => return Ok(link),
                Ok(None) => {}
                Err(error) => refused = Some(error),
            }
        }
        // a device that was there and did not open says more than that none was found
        Err(into_io(refused.unwrap_or(Error::NotFound)))
    }
}

/// Opens the device if it is ours and the one asked for.
fn try_open(device: &Device<Context>, serial: Option<&str>) -> rusb::Result<Option<UsbLink>> {
    let descriptor = device.device_descriptor()?;
    if (descriptor.vendor_id(), descriptor.product_id()) != (VENDOR_ID, PRODUCT_ID) || !has_interface(device)? {
        return Ok(None);
    }
    let handle = device.open()?;
    let found = serial_number(&handle, &descriptor);
    if serial.is_some_and(|wanted| found.as_deref() != Some(wanted)) {
        return Ok(None);
    }
    // not on every system; where it is not, no kernel driver is in the way either
    let _ = handle.set_auto_detach_kernel_driver(true);
    handle.claim_interface(INTERFACE)?;
    Ok(Some(UsbLink { handle, name: format!("usb:{}", found.unwrap_or_default()) }))
}

fn has_interface(device: &Device<Context>) -> rusb::Result<bool> {
    let config = device.active_config_descriptor()?;
    let found = config.interfaces().flat_map(|interface| interface.descriptors()).any(|d| {
        d.interface_number() == INTERFACE && (d.class_code(), d.sub_class_code(), d.protocol_code()) == INTERFACE_TRIPLE
    });
    Ok(found)
}

fn serial_number(handle: &DeviceHandle<Context>, descriptor: &DeviceDescriptor) -> Option<String> {
    handle.read_serial_number_string_ascii(descriptor).ok()
}

fn into_io(error: Error) -> io::Error {
    let kind = match error {
        Error::Access => io::ErrorKind::PermissionDenied,
        Error::NotFound | Error::NoDevice => io::ErrorKind::NotFound,
        Error::Busy => io::ErrorKind::ResourceBusy,
        _ => io::ErrorKind::Other,
    };
    let advice = match error {
        Error::Access => "; a udev rule gives the right to it",
        Error::NotFound => "; no haptor device is plugged in, or not this one",
        _ => "",
    };
    io::Error::new(kind, format!("{error}{advice}"))
}

impl Link for UsbLink {
    fn framing(&self) -> Framing {
        Framing::Packet
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        match self.handle.write_interrupt(OUT, bytes, SEND_TIMEOUT) {
            Ok(n) if n == bytes.len() => Ok(()),
            Ok(_) | Err(Error::Timeout | Error::Interrupted) => Err(LinkError::Full),
            Err(Error::Pipe) => self.handle.clear_halt(OUT).map_err(|_| LinkError::Closed).and(Err(LinkError::Full)),
            Err(_) => Err(LinkError::Closed),
        }
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        if wait.is_zero() {
            return Ok(0);
        }
        let packet = into.len().min(haptor_wire::PACKET_BYTES);
        match self.handle.read_interrupt(IN, &mut into[..packet], wait.max(SHORTEST_WAIT)) {
            Ok(n) => Ok(n),
            Err(Error::Timeout | Error::Interrupted) => Ok(0),
            Err(Error::Pipe) => self.handle.clear_halt(IN).map(|()| 0).map_err(|_| LinkError::Closed),
            Err(_) => Err(LinkError::Closed),
        }
    }

    fn name(&self) -> &str {
        &self.name
    }
}

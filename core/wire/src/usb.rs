//! What a haptor device is on the bus: the numbers by which host, tool and device find each other and talk.
//!
//! One interface, two pairs of endpoints. The host chooses a pair by using it; the device answers on the pair that spoke last. Every
//! packet is one of [`crate::packet`].

/// Vendor: pid.codes, whose numbers are free for open hardware.
pub const VENDOR_ID: u16 = 0x1209;

/// Product: pid.codes' number for private tests. A device that is handed to anyone needs its own, here and nowhere else.
pub const PRODUCT_ID: u16 = 0x0001;

/// Number of the interface.
pub const INTERFACE: u8 = 0;

/// Class, subclass and protocol of the interface; matched as well, since others may use the test number.
pub const INTERFACE_TRIPLE: (u8, u8, u8) = (0xFF, 0x48, 0x01);

/// A pair of endpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Endpoints {
    /// Address of the one to the device.
    pub to_device: u8,
    /// Address of the one to the host.
    pub to_host: u8,
}

/// The interrupt pair: the bus reserves its turns and bounds the time between two of them. For the loop.
pub const INTERRUPT: Endpoints = Endpoints { to_device: 0x01, to_host: 0x81 };

/// The bulk pair: whatever turns are left.
pub const BULK: Endpoints = Endpoints { to_device: 0x02, to_host: 0x82 };

/// `bInterval` of the interrupt pair: 1 = every micro-frame of 125 us on high speed, every frame of 1 ms on full speed.
pub const INTERRUPT_INTERVAL: u8 = 1;

//! Where a device is, as the command line says it, and the one function that opens it.

use std::fmt;
use std::net::{SocketAddr, ToSocketAddrs};
use std::str::FromStr;

use super::AnyLink;
use super::port::Port;
use super::serial::SerialLink;
use super::tcp::TcpLink;
use crate::error::HostError;

/// Where a device is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `serial:PATH`, a serial port or a pseudo-terminal; `serial:NUMBER`, the port of the USB device with that serial number.
    Serial(Port),
    /// `tcp:HOST:PORT`.
    Tcp(SocketAddr),
    /// `usb` or `usb:SERIAL`, by the interrupt endpoints; `usb-bulk` or `usb-bulk:SERIAL` by the bulk ones.
    Usb(UsbAddress),
}

/// A device on USB.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsbAddress {
    /// Its serial number; without one, the only device there is.
    pub serial: Option<String>,
    /// By its bulk endpoints.
    pub bulk: bool,
}

impl UsbAddress {
    fn named(kind: &str, serial: &str) -> Self {
        Self { serial: (!serial.is_empty()).then(|| serial.to_owned()), bulk: kind == "usb-bulk" }
    }
}

impl Address {
    /// Whether opening it again after a loss reaches the same device. A pseudo-terminal that died never comes back: its number goes
    /// to the next program that asks, which may be somebody's shell. One that is named by a symbolic link is vouched for by whoever
    /// keeps the link.
    #[must_use]
    pub fn comes_back(&self) -> bool {
        !matches!(self, Self::Serial(Port::Path(path)) if path.starts_with("/dev/pts"))
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        match (kind, rest) {
            ("serial", "") | ("tcp", "") => Err(format!("`{text}` lacks what follows `{kind}:`")),
            ("serial", port) => Ok(Self::Serial(port.into())),
            ("tcp", address) => resolve(address).map(Self::Tcp),
            ("usb" | "usb-bulk", serial) => Ok(Self::Usb(UsbAddress::named(kind, serial))),
            _ => Err(format!(
                "`{text}` is no device; allowed: serial:PATH, serial:NUMBER, tcp:HOST:PORT, usb, usb:SERIAL, usb-bulk, usb-bulk:SERIAL"
            )),
        }
    }
}

fn resolve(address: &str) -> Result<SocketAddr, String> {
    let mut found = address.to_socket_addrs().map_err(|e| format!("`{address}` is no address and port: {e}"))?;
    found.next().ok_or_else(|| format!("`{address}` names no machine"))
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(port) => write!(f, "serial:{port}"),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Usb(UsbAddress { serial, bulk }) => {
                f.write_str(if *bulk { "usb-bulk" } else { "usb" })?;
                serial.iter().try_for_each(|serial| write!(f, ":{serial}"))
            }
        }
    }
}

/// Opens the link to a device. Allocates and may block for seconds: not for the real-time thread.
///
/// # Errors
/// [`HostError::Open`] with the device and the system's reason.
pub fn open(address: &Address) -> Result<AnyLink, HostError> {
    let failed = |reason: std::io::Error| HostError::Open { device: address.to_string(), reason };
    match address {
        Address::Serial(port) => Ok(Box::new(SerialLink::open(port).map_err(failed)?)),
        Address::Tcp(to) => Ok(Box::new(TcpLink::connect(*to).map_err(failed)?)),
        #[cfg(feature = "usb")]
        Address::Usb(usb) => Ok(Box::new(super::usb::UsbLink::open(usb.serial.as_deref(), usb.bulk).map_err(failed)?)),
        #[cfg(not(feature = "usb"))]
        Address::Usb(_) => Err(failed(std::io::Error::new(
            std::io::ErrorKind::Unsupported,
            "this build has no USB; build haptor-host with its feature `usb`",
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_read_as_they_print() {
        for text in ["serial:/dev/ttyACM0", "serial:A17", "tcp:127.0.0.1:4000", "usb", "usb:A17", "usb-bulk", "usb-bulk:A17"] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn a_bare_pseudo_terminal_does_not_come_back() {
        for (text, expected) in [
            ("serial:/dev/pts/3", false),
            ("serial:/dev/ttyACM0", true),
            ("serial:/run/device", true),
            ("serial:A17", true),
            ("usb", true),
        ] {
            assert_eq!(text.parse::<Address>().unwrap().comes_back(), expected, "{text}");
        }
    }

    #[test]
    fn what_is_no_address_says_what_is_allowed() {
        for text in ["", "serial", "serial:", "tcp:", "tcp:localhost", "can:0"] {
            assert!(text.parse::<Address>().is_err(), "{text}");
        }
        assert!("can:0".parse::<Address>().unwrap_err().contains("usb:SERIAL"));
    }
}

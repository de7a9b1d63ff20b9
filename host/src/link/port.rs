//! Which serial port a name means, and why one did not open.
//!
//! | written | means |
//! |---|---|
//! | `serial:/dev/ttyACM0` | that port |
//! | `serial:/dev/serial/by-id/usb-Maker_Device_A17-if00` | the same device whatever number it gets: a link that the system keeps |
//! | `serial:A17` | the port of the USB device with that serial number, looked up at every opening |

use std::fmt;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use serialport::{SerialPortInfo, SerialPortType};

/// Where the kernel lists terminals; a system without it has no ports to look up.
const TERMINALS: &str = "/sys/class/tty";

/// A serial port as it was named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Port {
    /// By its path.
    Path(PathBuf),
    /// By the serial number of its USB device.
    Number(String),
}

impl From<&str> for Port {
    /// What has a slash is a path; serial numbers have none.
    fn from(text: &str) -> Self {
        if text.contains('/') { Self::Path(text.into()) } else { Self::Number(text.to_owned()) }
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Path(path) => path.display().fmt(f),
            Self::Number(number) => f.write_str(number),
        }
    }
}

impl Port {
    /// The port's path as of now.
    ///
    /// # Errors
    /// When no port, or more than one, has the serial number.
    pub fn path(&self) -> io::Result<PathBuf> {
        match self {
            Self::Path(path) => Ok(path.clone()),
            Self::Number(number) => find(number, &ports()),
        }
    }
}

fn ports() -> Vec<SerialPortInfo> {
    if !Path::new(TERMINALS).is_dir() {
        return Vec::new();
    }
    serialport::available_ports().unwrap_or_default()
}

fn find(number: &str, ports: &[SerialPortInfo]) -> io::Result<PathBuf> {
    let has = |port: &&SerialPortInfo| match &port.port_type {
        SerialPortType::UsbPort(usb) => usb.serial_number.as_deref() == Some(number),
        _ => false,
    };
    let found: Vec<&str> = ports.iter().filter(has).map(|port| port.port_name.as_str()).collect();
    match found.as_slice() {
        [one] => Ok(one.into()),
        [] => Err(io::Error::new(
            ErrorKind::NotFound,
            "no serial port has that serial number; `haptor devices` lists them, a port is also named by its path, as in serial:/dev/ttyACM0",
        )),
        several => Err(io::Error::new(
            ErrorKind::InvalidInput,
            format!("{} have that serial number; name one by its path under /dev/serial/by-id", several.join(" and ")),
        )),
    }
}

/// Why a port did not open, with what to do about it.
pub(super) fn explain(path: &Path, error: &io::Error) -> io::Error {
    let path = path.display();
    let text = match error.kind() {
        ErrorKind::NotFound => "no such port; `haptor devices` lists those there are".to_owned(),
        ErrorKind::PermissionDenied => {
            format!(
                "no right to it; the group of {path} has (`ls -lL {path}`): `sudo usermod -aG dialout $USER` and log in again"
            )
        }
        ErrorKind::ResourceBusy => format!("in use by another program; `fuser -v {path}` names it"),
        _ => error.to_string(),
    };
    io::Error::new(error.kind(), text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serialport::UsbPortInfo;

    fn port(name: &str, number: &str) -> SerialPortInfo {
        let usb = UsbPortInfo {
            vid: 0x1209,
            pid: 1,
            serial_number: Some(number.to_owned()),
            manufacturer: Some("Maker".to_owned()),
            product: None,
        };
        SerialPortInfo { port_name: name.to_owned(), port_type: SerialPortType::UsbPort(usb) }
    }

    #[test]
    fn a_number_finds_its_one_port() {
        let other = SerialPortInfo { port_name: "/dev/ttyS0".to_owned(), port_type: SerialPortType::Unknown };
        let ports = [other, port("/dev/ttyACM0", "A17"), port("/dev/ttyACM1", "B2"), port("/dev/ttyACM2", "B2")];
        assert_eq!(find("A17", &ports).unwrap(), Path::new("/dev/ttyACM0"));
        for (number, named) in [("A1", "haptor devices"), ("B2", "/dev/ttyACM1 and /dev/ttyACM2")] {
            let text = find(number, &ports).unwrap_err().to_string();
            assert!(text.contains(named), "{text}");
        }
        assert_eq!(Port::from("A17"), Port::Number("A17".to_owned()));
        assert_eq!(Port::from("./tty").path().unwrap(), Path::new("./tty"));
    }
}

//! Which device is meant, and what is said when it is none, several, or not allowed.

use std::io;
use std::sync::{Mutex, PoisonError};

use haptor_wire::usb::{INTERFACE, INTERFACE_TRIPLE, PRODUCT_ID, VENDOR_ID};
use rusb::{Context, Device, DeviceHandle, Error, UsbContext};

/// What to do without the right to a device.
const RIGHTS: &str = "put host/udev/70-haptor.rules (`haptor doctor` prints it) into /etc/udev/rules.d/, run `udevadm control --reload` as root, \
    and plug the device in again";

/// What was found.
enum Found {
    /// One to open, opened, with its serial number.
    Open(DeviceHandle<Context>, String),
    /// One that does not open.
    Refused(Error),
}

/// Opens the device of that serial number, or the only one; not claimed yet.
///
/// # Errors
/// With what to do, see the module.
pub fn open(serial: Option<&str>) -> io::Result<(DeviceHandle<Context>, String)> {
    let context = context()?;
    let devices = context.devices().map_err(|error| explain(error, "the USB devices"))?;
    let ours = devices.iter().filter(|device| is_ours(device).unwrap_or(false));
    choose(serial, ours.map(|device| found(&device)).collect())
}

/// One for the whole process: each has a thread of its own that watches for devices, and a device that comes back is seen only by those
/// that were there before.
fn context() -> io::Result<Context> {
    static ONE: Mutex<Option<Context>> = Mutex::new(None);
    let mut one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(context) = &*one {
        return Ok(context.clone());
    }
    // libusb calls it "other error" when the system has no USB at all, as in most containers
    let context = Context::new().map_err(|error| match error {
        Error::Other => io::Error::other("this system gives no access to USB; is /dev/bus/usb there?"),
        error => explain(error, "USB"),
    })?;
    Ok(one.insert(context).clone())
}

fn is_ours(device: &Device<Context>) -> rusb::Result<bool> {
    let descriptor = device.device_descriptor()?;
    if (descriptor.vendor_id(), descriptor.product_id()) != (VENDOR_ID, PRODUCT_ID) {
        return Ok(false);
    }
    let config = device.active_config_descriptor()?;
    let found = config.interfaces().flat_map(|interface| interface.descriptors()).any(|d| {
        d.interface_number() == INTERFACE && (d.class_code(), d.sub_class_code(), d.protocol_code()) == INTERFACE_TRIPLE
    });
    Ok(found)
}

fn found(device: &Device<Context>) -> Found {
    let open = || {
        let handle = device.open()?;
        let serial = handle.read_serial_number_string_ascii(&device.device_descriptor()?)?;
        Ok((handle, printable(&serial)))
    };
    match open() {
        Ok((handle, serial)) => Found::Open(handle, serial),
        Err(error) => Found::Refused(error),
    }
}

/// A serial number as it is shown and asked for: control characters, which steer terminals, as the `?` that libusb makes of what is not ASCII.
fn printable(serial: &str) -> String {
    serial.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

fn choose(wanted: Option<&str>, found: Vec<Found>) -> io::Result<(DeviceHandle<Context>, String)> {
    let (mut open, mut refused) = (Vec::new(), None);
    for one in found {
        match one {
            Found::Open(handle, serial) => open.push((handle, serial)),
            Found::Refused(error) => refused = Some(error),
        }
    }
    let serials: Vec<_> = open.iter().map(|(_, serial)| serial.clone()).collect();
    let at = index(wanted, &serials, refused)?;
    Ok(open.swap_remove(at))
}

/// Which of the devices that opened; `refused` = there was one more that did not.
fn index(wanted: Option<&str>, serials: &[String], refused: Option<Error>) -> io::Result<usize> {
    let list = || serials.iter().map(|serial| format!("usb:{serial}")).collect::<Vec<_>>().join(", ");
    let at: Vec<_> = (0..serials.len()).filter(|&at| wanted.is_none_or(|wanted| wanted == serials[at])).collect();
    match (at.as_slice(), wanted) {
        (&[one], _) => Ok(one),
        // a device that was there and did not open says more than that none was found
        ([], _) if refused.is_some() => Err(explain(refused.unwrap_or(Error::Access), "a haptor device")),
        ([], Some(_)) if !serials.is_empty() => {
            Err(io::Error::new(io::ErrorKind::NotFound, format!("it is not plugged in; there are {}", list())))
        }
        ([], _) => Err(io::Error::new(io::ErrorKind::NotFound, "no haptor device is plugged in")),
        (_, None) => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("several haptor devices are plugged in; name one: {}", list()),
        )),
        (_, Some(serial)) => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("{} devices have the serial number {serial}; unplug all but one", at.len()),
        )),
    }
}

/// libusb's error with what to do about it.
pub(super) fn explain(error: Error, what: &str) -> io::Error {
    let kind = match error {
        Error::Access => io::ErrorKind::PermissionDenied,
        Error::NotFound | Error::NoDevice => io::ErrorKind::NotFound,
        Error::Busy => io::ErrorKind::ResourceBusy,
        _ => io::ErrorKind::Other,
    };
    let text = match error {
        Error::Access => format!("{what}: no right to open it; {RIGHTS}"),
        Error::Busy => format!("{what}: another program has it, perhaps a second haptor-host"),
        Error::NotFound | Error::NoDevice => format!("{what}: it was unplugged"),
        error => format!("{what}: {error}"),
    };
    io::Error::new(kind, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_serial_number_cannot_steer_the_terminal() {
        assert_eq!(printable("A17\u{1b}[2J\r\n"), "A17?[2J??");
    }

    #[test]
    fn one_is_chosen_or_the_choice_is_shown() {
        let serials = |names: &[&str]| -> Vec<String> { names.iter().map(|name| (*name).to_owned()).collect() };
        let (none, one, two, twins) = (serials(&[]), serials(&["A"]), serials(&["A", "B"]), serials(&["A", "A"]));
        assert_eq!(index(None, &one, None).unwrap(), 0);
        assert_eq!(index(Some("B"), &two, None).unwrap(), 1);
        assert_eq!(index(None, &one, Some(Error::Busy)).unwrap(), 0, "another device is not the one");
        for (wanted, serials, refused, part) in [
            (None, &none, None, "no haptor device is plugged in"),
            (Some("X"), &none, None, "no haptor device is plugged in"),
            (None, &two, None, "name one: usb:A, usb:B"),
            (Some("X"), &two, None, "there are usb:A, usb:B"),
            (Some("A"), &twins, None, "2 devices have the serial number A"),
            (None, &none, Some(Error::Access), "70-haptor.rules"),
            (Some("X"), &one, Some(Error::Access), "70-haptor.rules"),
            (None, &none, Some(Error::Busy), "second haptor-host"),
        ] {
            let text = index(wanted, serials, refused).unwrap_err().to_string();
            assert!(text.contains(part), "{wanted:?} of {serials:?}: {text}");
        }
    }
}

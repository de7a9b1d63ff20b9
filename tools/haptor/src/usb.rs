//! USB devices as the kernel lists them; hubs and hosts among them.

use std::fs;
use std::path::{Path, PathBuf};

use haptor_wire::usb::{PRODUCT_ID, VENDOR_ID};

/// Where Linux lists USB devices.
pub const FOLDER: &str = "/sys/bus/usb/devices";

/// A device that is plugged in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plugged {
    /// Vendor, four hexadecimal digits.
    pub vendor: String,
    /// Product, likewise.
    pub product: String,
    /// Maker and product in words, as far as the device tells.
    pub name: String,
    /// Serial number.
    pub serial: Option<String>,
    /// Its device file.
    pub node: Option<PathBuf>,
}

impl Plugged {
    /// Whether its numbers are those of a haptor device.
    pub fn is_haptor(&self) -> bool {
        let number = |text: &str| u16::from_str_radix(text, 16).ok();
        (number(&self.vendor), number(&self.product)) == (Some(VENDOR_ID), Some(PRODUCT_ID))
    }

    /// What `--device` takes to mean this one.
    pub fn address(&self) -> String {
        self.serial.as_ref().map_or_else(|| "usb".to_owned(), |serial| format!("usb:{serial}"))
    }
}

/// The devices in a folder as [`FOLDER`], by their place.
pub fn plugged_in(folder: &Path) -> Vec<Plugged> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths.iter().filter_map(|path| device(path)).collect()
}

fn device(path: &Path) -> Option<Plugged> {
    let read = |name: &str| fs::read_to_string(path.join(name)).ok().map(|text| text.trim().to_owned());
    let name = [read("manufacturer"), read("product")].into_iter().flatten().collect::<Vec<_>>().join(" ");
    Some(Plugged { vendor: read("idVendor")?, product: read("idProduct")?, name, serial: read("serial"), node: node(path) })
}

/// The device file of a device, by its folder.
fn node(path: &Path) -> Option<PathBuf> {
    let number = |name: &str| fs::read_to_string(path.join(name)).ok()?.trim().parse::<u16>().ok();
    Some(PathBuf::from(format!("/dev/bus/usb/{:03}/{:03}", number("busnum")?, number("devnum")?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_listed_as_the_kernel_writes_them_and_ours_are_known() {
        let folder = tempfile::tempdir().unwrap();
        let put = |device: &str, files: &[(&str, &str)]| {
            let path = folder.path().join(device);
            fs::create_dir(&path).unwrap();
            files.iter().for_each(|(name, text)| fs::write(path.join(name), format!("{text}\n")).unwrap());
        };
        put(
            "1-1",
            &[
                ("idVendor", "1209"),
                ("idProduct", "0001"),
                ("serial", "A17"),
                ("manufacturer", "haptor"),
                ("busnum", "1"),
                ("devnum", "12"),
            ],
        );
        put("1-0:1.0", &[("bInterfaceClass", "ff")]);
        put("usb1", &[("idVendor", "1d6b"), ("idProduct", "0002"), ("product", "root hub")]);
        let found = plugged_in(folder.path());
        let told: Vec<_> = found.iter().map(|device| (device.name.as_str(), device.is_haptor(), device.address())).collect();
        assert_eq!(told, [("haptor", true, "usb:A17".to_owned()), ("root hub", false, "usb".to_owned())]);
        assert_eq!(found[0].node.as_deref(), Some(Path::new("/dev/bus/usb/001/012")));
        assert!(plugged_in(Path::new("/nowhere")).is_empty());
    }
}

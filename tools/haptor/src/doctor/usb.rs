//! Haptor devices on USB and the right to open them.

use std::fs::OpenOptions;
use std::path::Path;

use super::{Finding, Mark};
use crate::usb::{FOLDER, Plugged, plugged_in};

/// The rule that gives the right, as it is shipped.
const RULE_FILE: &str = include_str!("../../../../host/udev/70-haptor.rules");

/// Its name where it belongs.
const RULE_NAME: &str = "70-haptor.rules";

/// Where udev looks for rules.
const RULE_FOLDERS: [&str; 4] = ["/etc/udev/rules.d", "/run/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"];

/// May the devices that are plugged in be opened, and will those that come?
pub fn check() -> Finding {
    let devices: Vec<_> = plugged_in(Path::new(FOLDER)).into_iter().filter(Plugged::is_haptor).collect();
    let closed: Vec<_> = devices.iter().filter(|device| !device.node.as_deref().is_some_and(opens)).collect();
    let ruled = RULE_FOLDERS.iter().any(|folder| Path::new(folder).join(RULE_NAME).exists());
    judge(devices.len(), closed.first().map(|device| device.address()), ruled)
}

fn opens(node: &Path) -> bool {
    OpenOptions::new().read(true).write(true).open(node).is_ok()
}

fn judge(devices: usize, closed: Option<String>, ruled: bool) -> Finding {
    let what = "USB devices";
    match (devices, closed) {
        (_, Some(device)) if ruled => {
            let advice = "the udev rule is there: `udevadm control --reload` as root, plug the device in again, log in at this machine's seat";
            Finding::bad(what, Mark::Warn, format!("no right to open {device}"), advice)
        }
        (_, Some(device)) => Finding::bad(what, Mark::Warn, format!("no right to open {device}"), &advice()),
        (0, None) if ruled => Finding::ok(what, "none plugged in, udev rule installed"),
        (0, None) => Finding { advice: Some(advice()), ..Finding::ok(what, "none plugged in, no udev rule") },
        (count, None) => Finding::ok(what, format!("{count} plugged in, can be opened")),
    }
}

/// The rule and where it goes.
fn advice() -> String {
    format!("a line for /etc/udev/rules.d/{RULE_NAME} gives the right to haptor devices: {}", rule())
}

fn rule() -> &'static str {
    RULE_FILE.lines().find(|line| !line.starts_with('#')).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_wire::usb::{PRODUCT_ID, VENDOR_ID};

    #[test]
    fn the_shipped_rule_is_one_line_and_of_our_devices() {
        assert_eq!(RULE_FILE.lines().filter(|line| !line.starts_with('#')).count(), 1);
        for part in [format!("ATTR{{idVendor}}==\"{VENDOR_ID:04x}\""), format!("ATTR{{idProduct}}==\"{PRODUCT_ID:04x}\"")] {
            assert!(rule().contains(&part), "{part}: {}", rule());
        }
    }

    #[test]
    fn what_is_missing_is_said_with_the_rule() {
        for (devices, closed, ruled, mark, part) in [
            (0, None, true, Mark::Ok, "udev rule installed"),
            (0, None, false, Mark::Ok, "no udev rule"),
            (2, None, false, Mark::Ok, "2 plugged in"),
            (1, Some("usb:A"), false, Mark::Warn, "usb:A"),
            (1, Some("usb:A"), true, Mark::Warn, "usb:A"),
        ] {
            let finding = judge(devices, closed.map(str::to_owned), ruled);
            assert!(finding.mark == mark && finding.found.contains(part), "{finding:?}");
            let rule_told = finding.advice.as_deref().is_some_and(|advice| advice.contains(rule()));
            assert_eq!(rule_told, !ruled && (devices == 0 || closed.is_some()), "{finding:?}");
        }
    }
}

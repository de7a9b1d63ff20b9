//! How long the drivers of serial ports hold back what has come.

use std::fs;
use std::path::Path;

use super::{Finding, Mark};

/// Where the kernel lists terminals.
const TERMINALS: &str = "/sys/class/tty";

/// Longest wait that a tick of 1 ms forgives \[ms\]. FTDI's chips start at 16.
const LONGEST_MS: u32 = 1;

/// Do USB-serial chips wait for packets to fill? Only chips of FTDI's kind have the setting; the host sets it where it may.
pub fn latency() -> Finding {
    judge(&timers(Path::new(TERMINALS)))
}

fn judge(timers: &[(String, u32)]) -> Finding {
    let slow: Vec<_> = timers.iter().filter(|(_, ms)| *ms > LONGEST_MS).map(|(port, ms)| format!("{port} {ms} ms")).collect();
    if slow.is_empty() {
        let found = if timers.is_empty() { "no port holds bytes back" } else { "1 ms at most" };
        return Finding::ok("serial latency", found);
    }
    let advice = "the host asks the driver for 1 ms when it opens the port; for good, a udev rule: \
                  `ACTION==\"add\", SUBSYSTEM==\"usb-serial\", DRIVER==\"ftdi_sio\", ATTR{latency_timer}=\"1\"`";
    Finding::bad("serial latency", Mark::Warn, slow.join(", "), advice)
}

/// Ports that have the setting, and what it is \[ms\].
fn timers(folder: &Path) -> Vec<(String, u32)> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let timer = |port: &Path| fs::read_to_string(port.join("device/latency_timer")).ok()?.trim().parse().ok();
    let named = entries.flatten().filter_map(|entry| Some((entry.file_name().into_string().ok()?, timer(&entry.path())?)));
    let mut found: Vec<_> = named.collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_ports_are_named_with_the_rule_that_mends_them() {
        let folder = tempfile::tempdir().unwrap();
        for (port, ms) in [("ttyUSB1", "16\n"), ("ttyUSB0", "1\n")] {
            let device = folder.path().join(port).join("device");
            fs::create_dir_all(&device).unwrap();
            fs::write(device.join("latency_timer"), ms).unwrap();
        }
        fs::create_dir_all(folder.path().join("ttyACM0/device")).unwrap();
        let found = timers(folder.path());
        assert_eq!(found, [("ttyUSB0".to_owned(), 1), ("ttyUSB1".to_owned(), 16)]);
        let finding = judge(&found);
        assert_eq!((finding.mark, finding.found.as_str()), (Mark::Warn, "ttyUSB1 16 ms"));
        assert!(finding.advice.unwrap().contains("latency_timer"));
        assert_eq!(judge(&found[..1]).mark, Mark::Ok);
        assert_eq!(judge(&[]).mark, Mark::Ok);
    }
}

//! Plugs the device straight into this machine's kernel: `vhci-hcd` takes one end of a pair of sockets and believes in a device at the other.
//! Needs root and the modules; no network and no `usbip` program.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;

use anyhow::{Context, Result};

use super::wire::{DEVICE_ID, HIGH_SPEED};

/// The first virtual host controller.
const VHCI: &str = "/sys/devices/platform/vhci_hcd.0";

/// How the kernel writes that a port is free.
const FREE: &str = "004";

/// Plugs in at a free port; yields its number and the device's end.
pub fn attach() -> Result<(u32, UnixStream)> {
    let status = fs::read_to_string(format!("{VHCI}/status")).context("no virtual USB here; as root: modprobe vhci-hcd")?;
    let port = free_port(&status).context("every port of the virtual USB is taken")?;
    let (ours, kernels) = UnixStream::pair().context("cannot make a pair of sockets")?;
    let order = format!("{port} {} {DEVICE_ID} {HIGH_SPEED}", kernels.as_raw_fd());
    let attach = format!("{VHCI}/attach");
    let written = OpenOptions::new().write(true).open(&attach).and_then(|mut file| file.write_all(order.as_bytes()));
    written.with_context(|| format!("cannot plug in by {attach}; this needs root"))?;
    Ok((port, ours))
}

/// The first free high-speed port of a status as the kernel prints it: `hs  0000 004 000 00000000 000000 0-0`.
fn free_port(status: &str) -> Option<u32> {
    status.lines().find_map(|line| {
        let mut words = line.split_whitespace();
        let (hub, port, state) = (words.next()?, words.next()?, words.next()?);
        if hub == "hs" && state == FREE { port.parse().ok() } else { None }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_is_free_and_of_high_speed() {
        let status = "hub port sta spd dev      sockfd local_busid\n\
                      hs  0000 006 003 00010002 000005 1-1\n\
                      hs  0001 004 000 00000000 000000 0-0\n\
                      ss  0008 004 000 00000000 000000 0-0\n";
        assert_eq!(free_port(status), Some(1));
        assert_eq!(free_port(&status.replace("hs  0001 004", "hs  0001 006")), None);
        assert_eq!(free_port(""), None);
    }
}

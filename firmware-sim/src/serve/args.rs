//! The command line.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use clap::{Parser, ValueEnum};
use haptor_firmware_sim::Preset;
use haptor_firmware_sim::preset::PRESETS;
use haptor_firmware_sim::script::NAMES;

use super::drill::Drill;
use super::usbip::Way;

/// A simulated haptic device: firmware, handle and the hand that moves it, in real time
#[derive(Debug, Parser)]
#[command(
    name = "haptor-firmware-sim",
    version,
    after_help = "Example: haptor-firmware-sim --serve pty --preset premium15 --script press-twist-slide --seconds 10"
)]
pub struct Args {
    /// Where to serve: `pty`, `tcp:ADDRESS` (port 0 = any free one), `usbip[:ADDRESS]` for `usbip attach`, `vhci` for this machine's own USB
    #[arg(long, default_value = "pty", value_parser = place)]
    pub serve: Place,
    /// Which device: premium15, sigma7, omega6, touch
    #[arg(long, default_value = "premium15", value_parser = preset)]
    pub preset: Preset,
    /// What the hand does: hold, press, twist, slide, lift, press-twist-slide, two-legs
    #[arg(long, default_value = "press-twist-slide", value_parser = script)]
    pub script: String,
    /// Run the script once instead of over and over
    #[arg(long)]
    pub once: bool,
    /// Position resolution: `fine` (interpolated, 1 um) or `sheet` (the maker's step)
    #[arg(long, value_enum, default_value_t = Resolution::Fine)]
    pub encoders: Resolution,
    /// End after this many seconds
    #[arg(long, value_parser = seconds)]
    pub seconds: Option<f64>,
    /// End when standard input is closed; Ctrl-C is then left to whoever holds it open
    #[arg(long)]
    pub until_stdin_closes: bool,
    /// Milliseconds without an answer until the device brakes, 1 to 8191; raise it where the machine is not real-time
    #[arg(long, default_value_t = 30, overrides_with = "watchdog_ms", value_parser = clap::value_parser!(u16).range(1..=8191))]
    pub watchdog_ms: u16,
    /// Serial number told in the hello, at most 12 characters
    #[arg(long, default_value = "SIM-1", value_parser = serial)]
    pub serial: String,
    /// Seed of the random bytes in drills
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// A drill, T seconds after forces are first armed. May be repeated. At once: die@T, restart@T, kick@T, version@T. For a while: garbage@T[:50ms],
    /// stall, corrupt, duplicate, reorder, delay, drop, nan, freeze; on USB halt, unplug, reboot
    #[arg(long = "fault", value_name = "KIND@T[:LENGTH]")]
    pub faults: Vec<Drill>,
}

/// Where to serve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A new pseudo terminal.
    Pty,
    /// A TCP port.
    Tcp(SocketAddr),
    /// A USB cable.
    Usb(Way),
}

/// Where `usbip attach` looks when it is told nothing else; this machine only.
const USBIP: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 3240);

/// How finely the encoders resolve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Resolution {
    /// Interpolated.
    Fine,
    /// As on the maker's sheet.
    Sheet,
}

fn place(text: &str) -> Result<Place, String> {
    let at = |address: &str| address.parse().map_err(|_| format!("`{address}` is no address and port, as in 127.0.0.1:0"));
    match text.split_once(':').unwrap_or((text, "")) {
        ("pty", "") => Ok(Place::Pty),
        ("vhci", "") => Ok(Place::Usb(Way::Vhci)),
        ("usbip", "") => Ok(Place::Usb(Way::Tcp(USBIP))),
        ("usbip", address) => at(address).map(|address| Place::Usb(Way::Tcp(address))),
        ("tcp", address) => at(address).map(Place::Tcp),
        _ => Err("expected `pty`, `tcp:ADDRESS` as in tcp:127.0.0.1:0, `usbip`, `usbip:ADDRESS` or `vhci`".into()),
    }
}

fn preset(name: &str) -> Result<Preset, String> {
    let names = PRESETS.map(|preset| preset.name).join(", ");
    Preset::by_name(name).ok_or(format!("no such device; there are {names}"))
}

fn script(name: &str) -> Result<String, String> {
    if NAMES.contains(&name) {
        return Ok(name.to_owned());
    }
    Err(format!("no such script; there are {}", NAMES.join(", ")))
}

fn serial(text: &str) -> Result<String, String> {
    let good = (1..=12).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_graphic());
    if good {
        return Ok(text.to_owned());
    }
    Err("expected 1 to 12 printable ASCII characters without spaces".to_owned())
}

/// A time in seconds: finite, not negative, below the eleven days in which f64 still counts nanoseconds.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1e6).contains(&value) => Ok(value),
        _ => Err(format!("`{text}` is not a number of seconds from 0 to 1000000")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Args::command().debug_assert();
        Args::try_parse_from(["sim"]).unwrap();
    }

    #[test]
    fn places_and_names_are_checked() {
        assert_eq!(place("pty"), Ok(Place::Pty));
        assert_eq!(place("tcp:127.0.0.1:0"), Ok(Place::Tcp(([127, 0, 0, 1], 0).into())));
        assert!(place("tcp:nowhere").unwrap_err().contains("nowhere"));
        assert_eq!(place("usbip"), Ok(Place::Usb(Way::Tcp(USBIP))));
        assert_eq!(place("vhci"), Ok(Place::Usb(Way::Vhci)));
        for text in ["usb", "usbip:x", "vhci:1", "pty:1", "tcp"] {
            assert!(place(text).is_err(), "{text}");
        }
        for bad in [
            ["--preset", "falcon"],
            ["--script", "dance"],
            ["--seconds", "-1"],
            ["--seconds", "nan"],
            ["--fault", "flood@1"],
            ["--serial", "much-too-long"],
            ["--watchdog-ms", "0"],
            ["--watchdog-ms", "8192"],
        ] {
            Args::try_parse_from(["sim", bad[0], bad[1]]).unwrap_err();
        }
    }
}

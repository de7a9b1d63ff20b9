//! `haptor devices`: what could be driven from this machine.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use serialport::{SerialPortInfo, SerialPortType};

use crate::failure::Outcome;
use crate::output::say;
use crate::usb::{FOLDER, Plugged, plugged_in};

/// Lists serial ports, USB devices and the devices that can be simulated.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor devices --json")]
pub struct Args {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A device that `haptor-firmware-sim` simulates.
#[derive(Clone, Copy, Debug)]
struct Preset {
    name: &'static str,
    model: &'static str,
    max_force: f64,
    max_torque: f64,
}

/// Names and limits as the makers print them; a test compares them with the simulation's own.
const PRESETS: [Preset; 4] = [
    Preset { name: "premium15", model: "PHANTOM Premium 1.5/6DOF", max_force: 8.5, max_torque: 0.188 },
    Preset { name: "sigma7", model: "sigma.7", max_force: 12.0, max_torque: 0.2 },
    Preset { name: "omega6", model: "omega.6", max_force: 12.0, max_torque: 0.0 },
    Preset { name: "touch", model: "Touch", max_force: 3.3, max_torque: 0.0 },
];

/// Where the system keeps a link to every USB serial port by what it is, so that it is found whatever number it gets.
const BY_ID: &str = "/dev/serial/by-id";

/// Where the kernel lists terminals.
const TERMINALS: &str = "/sys/class/tty";

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let usb: Vec<_> = plugged_in(Path::new(FOLDER)).iter().map(usb).collect();
    let serial = serial(Path::new(BY_ID));
    if args.json {
        let value = json!({ "serial": serial, "usb": usb, "simulated": PRESETS.iter().map(preset).collect::<Vec<_>>() });
        say(format_args!("{value:#}"));
        return Ok(());
    }
    print(&serial, "serial ports", port_line);
    print(&usb, "USB devices", |device| {
        let ours =
            device.get("device").and_then(Value::as_str).map(|address| format!("  -> haptor run SCENE --device {address}"));
        format!("{}:{}  {}{}", text(device, "vendor"), text(device, "product"), text(device, "name"), ours.unwrap_or_default())
    });
    say("simulated (haptor demo --preset NAME)");
    for Preset { name, model, max_force, max_torque } in PRESETS {
        let torque = if max_torque > 0.0 { format!("{max_torque} N m") } else { "no torque".to_owned() };
        say(format_args!("  {name:<11}{model}, {max_force} N, {torque}"));
    }
    Ok(())
}

fn preset(preset: &Preset) -> Value {
    json!({ "name": preset.name, "model": preset.model, "max_force_n": preset.max_force, "max_torque_nm": preset.max_torque })
}

fn serial(by_id: &Path) -> Vec<Value> {
    if !Path::new(TERMINALS).is_dir() {
        return Vec::new();
    }
    // a system that cannot list its ports has none that could be named here
    serialport::available_ports().unwrap_or_default().iter().map(|info| port(info, by_id)).collect()
}

/// A port with its names: the path, the link that stays, and the serial number of its USB device.
fn port(info: &SerialPortInfo, by_id: &Path) -> Value {
    let what = match &info.port_type {
        SerialPortType::UsbPort(usb) => {
            [&usb.manufacturer, &usb.product].into_iter().flatten().cloned().collect::<Vec<_>>().join(" ")
        }
        SerialPortType::PciPort => "on the PCI bus".to_owned(),
        SerialPortType::BluetoothPort => "Bluetooth".to_owned(),
        SerialPortType::Unknown => String::new(),
    };
    let serial = match &info.port_type {
        SerialPortType::UsbPort(usb) => usb.serial_number.clone(),
        _ => None,
    };
    json!({ "port": info.port_name, "by_id": link_to(Path::new(&info.port_name), by_id), "serial": serial, "what": what })
}

/// The link in `folder` that leads to `port`.
fn link_to(port: &Path, folder: &Path) -> Option<String> {
    let port = fs::canonicalize(port).ok()?;
    let links = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    let mut found: Vec<_> = links.filter(|link| fs::canonicalize(link).is_ok_and(|to| to == port)).collect();
    found.sort();
    found.first().map(|link| link.display().to_string())
}

/// Every name by which `--device` takes the port.
fn port_line(port: &Value) -> String {
    let names = ["port", "serial", "by_id"].iter().filter_map(|key| port.get(key)?.as_str());
    let names: Vec<String> = names.map(|name| format!("serial:{name}")).collect();
    format!("{}  {}", names.join("  or  "), text(port, "what"))
}

/// `device` is what `--device` takes, and null when it is no haptor device.
fn usb(usb: &Plugged) -> Value {
    let Plugged { vendor, product, name, serial, .. } = usb;
    let device = usb.is_haptor().then(|| usb.address());
    json!({ "vendor": vendor, "product": product, "name": name, "serial": serial, "device": device })
}

fn print(list: &[Value], title: &str, line: impl Fn(&Value) -> String) {
    say(format_args!("{title}{}", if list.is_empty() { ": none" } else { "" }));
    list.iter().for_each(|item| say(format_args!("  {}", printable(&line(item)))));
}

/// What a device says of itself, harmless to a terminal.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value.get(key).and_then(Value::as_str).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_port_is_shown_with_every_name_that_it_has() {
        let folder = tempfile::tempdir().unwrap();
        let (device, by_id) = (folder.path().join("ttyACM0"), folder.path().join("by-id"));
        fs::write(&device, "").unwrap();
        fs::create_dir(&by_id).unwrap();
        symlink("../ttyACM0", by_id.join("usb-Maker_Thing_A17-if00")).unwrap();
        symlink("../ttyACM9", by_id.join("usb-Gone-if00")).unwrap();
        let usb = serialport::UsbPortInfo {
            vid: 1,
            pid: 2,
            serial_number: Some("A17".to_owned()),
            manufacturer: Some("Maker".to_owned()),
            product: Some("Thing".to_owned()),
        };
        let name = device.to_str().unwrap().to_owned();
        let usb = SerialPortInfo { port_name: name.clone(), port_type: SerialPortType::UsbPort(usb) };
        let link = by_id.join("usb-Maker_Thing_A17-if00");
        let line = port_line(&port(&usb, &by_id));
        assert_eq!(line, format!("serial:{name}  or  serial:A17  or  serial:{}  Maker Thing", link.display()));
        let plain = SerialPortInfo { port_name: "/dev/none".to_owned(), port_type: SerialPortType::Unknown };
        assert_eq!(port_line(&port(&plain, &by_id)), "serial:/dev/none  ");
    }

    #[test]
    fn a_name_cannot_steer_the_terminal() {
        assert_eq!(printable("Maker \u{1b}]0;mine\u{7}\u{9b}2J Größe"), "Maker ?]0;mine??2J Größe");
    }
}

//! `haptor devices`: what could be driven from this machine.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use serialport::{SerialPortInfo, SerialPortType};

use crate::failure::Outcome;
use crate::output::say;

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

/// Where Linux lists USB devices.
const USB: &str = "/sys/bus/usb/devices";

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let (serial, usb) = (serial(), usb(Path::new(USB)));
    if args.json {
        let value = json!({ "serial": serial, "usb": usb, "simulated": PRESETS.iter().map(preset).collect::<Vec<_>>() });
        say(format_args!("{value:#}"));
        return Ok(());
    }
    print(&serial, "serial ports", |port| format!("serial:{}  {}", text(port, "port"), text(port, "what")));
    print(&usb, "USB devices", |device| {
        format!("{}:{}  {}", text(device, "vendor"), text(device, "product"), text(device, "name"))
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

fn serial() -> Vec<Value> {
    // a system that cannot list its ports has none that could be named here
    serialport::available_ports().unwrap_or_default().iter().map(port).collect()
}

fn port(info: &SerialPortInfo) -> Value {
    let what = match &info.port_type {
        SerialPortType::UsbPort(usb) => {
            let words = [&usb.manufacturer, &usb.product, &usb.serial_number];
            words.into_iter().flatten().cloned().collect::<Vec<_>>().join(" ")
        }
        SerialPortType::PciPort => "on the PCI bus".to_owned(),
        SerialPortType::BluetoothPort => "Bluetooth".to_owned(),
        SerialPortType::Unknown => String::new(),
    };
    json!({ "port": info.port_name, "what": what })
}

/// USB devices as the kernel lists them; hubs and hosts among them.
fn usb(folder: &Path) -> Vec<Value> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut devices: Vec<_> = entries.flatten().filter_map(|entry| usb_device(&entry.path())).collect();
    devices.sort_by_key(|(name, _)| name.clone());
    devices.into_iter().map(|(_, device)| device).collect()
}

fn usb_device(path: &Path) -> Option<(String, Value)> {
    let read = |name: &str| fs::read_to_string(path.join(name)).ok().map(|text| text.trim().to_owned());
    let (vendor, product) = (read("idVendor")?, read("idProduct")?);
    let name = [read("manufacturer"), read("product")].into_iter().flatten().collect::<Vec<_>>().join(" ");
    let place = path.file_name()?.to_string_lossy().into_owned();
    Some((place, json!({ "vendor": vendor, "product": product, "name": name, "serial": read("serial") })))
}

fn print(list: &[Value], title: &str, line: impl Fn(&Value) -> String) {
    say(format_args!("{title}{}", if list.is_empty() { ": none" } else { "" }));
    list.iter().for_each(|item| say(format_args!("  {}", line(item))));
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value.get(key).and_then(Value::as_str).unwrap_or("")
}

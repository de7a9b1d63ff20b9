//! `haptor devices`: what could be driven from this machine.

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

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let (serial, usb) = (serial(), plugged_in(Path::new(FOLDER)).iter().map(usb).collect::<Vec<_>>());
    if args.json {
        let value = json!({ "serial": serial, "usb": usb, "simulated": PRESETS.iter().map(preset).collect::<Vec<_>>() });
        say(format_args!("{value:#}"));
        return Ok(());
    }
    print(&serial, "serial ports", |port| format!("serial:{}  {}", text(port, "port"), text(port, "what")));
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

/// `device` is what `--device` takes, and null when it is no haptor device.
fn usb(usb: &Plugged) -> Value {
    let Plugged { vendor, product, name, serial, .. } = usb;
    let device = usb.is_haptor().then(|| usb.address());
    json!({ "vendor": vendor, "product": product, "name": name, "serial": serial, "device": device })
}

fn print(list: &[Value], title: &str, line: impl Fn(&Value) -> String) {
    say(format_args!("{title}{}", if list.is_empty() { ": none" } else { "" }));
    list.iter().for_each(|item| say(format_args!("  {}", line(item))));
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value.get(key).and_then(Value::as_str).unwrap_or("")
}

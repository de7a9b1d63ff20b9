//! Hosts that must not get a device, and are told why.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use crate::drills::report;
use crate::programs::{Host, NOBODY, Options, Sim, said};
use crate::recording::Recording;

/// Length of the session that must not be disturbed \[s\]: until the hand presses, and some.
const SECONDS: f64 = 1.5;

/// Length of a session that must not begin \[s\].
const REFUSED_S: f64 = 0.5;

/// What the last column says of them.
const UNDISTURBED: &str = "-|-|never stopped";

/// Runs all of them.
pub fn run(model: &Path) {
    report("a second host on the same device", second_host(model));
    report("two devices, none named", two_devices(model));
    report("a user without the right to the device", no_right(model));
}

/// A host that is refused: its exit code is 1, it says `part`, and it writes nothing.
fn refused(model: &Path, device: &str, options: Options<'_>, part: &str) -> Result<()> {
    let file = PathBuf::from("/tmp/refused.haptor");
    let code = Host::start_with(model, device, REFUSED_S, &file, options)?.end()?;
    let said = said(&file);
    ensure!(code == 1 && said.contains(part), "it ended with {code} and said: {said}");
    if fs::exists(&file)? {
        bail!("it left a recording");
    }
    Ok(())
}

/// A session of `device` that ends well, while `meanwhile` happens; the serial number of the device it was with.
fn undisturbed(model: &Path, device: &str, meanwhile: impl FnOnce() -> Result<()>) -> Result<String> {
    let file = PathBuf::from("/tmp/undisturbed.haptor");
    let mut host = Host::start(model, device, SECONDS, &file)?;
    host.run_for(SECONDS / 2.0)?;
    let outcome = meanwhile();
    let code = host.end()?;
    outcome?;
    let recording = Recording::read(&file)?;
    let fault = recording.summary.context("the recording has no end")?.fault;
    ensure!(code == 0 && fault.is_none(), "the undisturbed one ended with {code}, {fault:?}");
    Ok(recording.serial)
}

fn second_host(model: &Path) -> Result<String> {
    let _sim = Sim::start(&["--script", "press"])?;
    undisturbed(model, "usb:G1", || refused(model, "usb", Options::default(), "another program has it"))?;
    Ok(format!("none in the first; the second is refused: another program has it|{UNDISTURBED}"))
}

fn two_devices(model: &Path) -> Result<String> {
    let _first = Sim::start(&["--script", "press"])?;
    let _second = Sim::start_as("G2", &["--script", "press"])?;
    refused(model, "usb", Options::default(), "several haptor devices are plugged in; name one: usb:G")?;
    refused(model, "usb:G3", Options::default(), "it is not plugged in; there are usb:G")?;
    let serial = undisturbed(model, "usb:G2", || Ok(()))?;
    ensure!(serial == "G2", "usb:G2 opened {serial}");
    Ok("refused: several are plugged in, both named; with its number each opens|-|-|-".to_owned())
}

fn no_right(model: &Path) -> Result<String> {
    let _sim = Sim::start(&["--script", "press"])?;
    refused(model, "usb", Options { user: Some(NOBODY), ..Options::default() }, "70-haptor.rules")?;
    Ok("refused: no right to open it, with the udev rule|-|-|-".to_owned())
}

//! The real-time host as a child process, and what it says over the tool link.

use std::io::Read;
use std::path::Path;
use std::process::Command;
use std::sync::mpsc::{self, Receiver};
use std::thread;

use haptor_wire::{FromHost, StreamDecoder, stream_bound};

use crate::config;
use crate::failure::Failure;
use crate::programs::{self, Child};

/// Bytes of the longest frame of the tool link.
const FRAME_MAX: usize = stream_bound(FromHost::MAX_ENCODED);

/// Bytes read from the pipe at once: some tens of frames.
const CHUNK: usize = 4096;

/// Ticks at 1 kHz without a pose through which the last wrench is held, and over which it then fades, before a fault latches. Twice
/// the host's own figures: a simulated device is an ordinary process, seen to oversleep 26 ms on a busy machine, and a stall of 50 ms
/// must still be a fault.
const PATIENCE: (u32, u32) = (8, 32);

/// The same as arguments, at a rate.
pub fn patience(rate_hz: u32) -> [String; 4] {
    hold_fade(rate_hz, PATIENCE)
}

/// Hold and fade as arguments. Above 1 kHz they stand for a time, below for a count, as the host's own do.
fn hold_fade(rate_hz: u32, (hold, fade): (u32, u32)) -> [String; 4] {
    let ticks = |ticks: u32| (ticks * rate_hz.max(config::RATE)).div_ceil(config::RATE).to_string();
    ["--hold".to_owned(), ticks(hold), "--fade".to_owned(), ticks(fade)]
}

/// How a session with a simulated device is run.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The baked scene.
    pub model: &'a Path,
    /// The device, as the host spells it: `serial:PORT`, `usb[:SERIAL]`.
    pub device: &'a str,
    /// Ticks per second \[Hz\].
    pub rate_hz: u32,
    /// Length of the session \[s\].
    pub seconds: f64,
    /// The recording to write, if any.
    pub record: Option<&'a Path>,
    /// Where viewers come in, if they may.
    pub viewers: Option<&'a str>,
    /// Hold and fade \[ticks at 1 kHz\]; [`Self::PATIENCE`] for people.
    pub hold_fade: (u32, u32),
    /// Further arguments.
    pub more: &'a [String],
}

impl Plan<'_> {
    /// The usual hold and fade with a simulated device.
    pub const PATIENCE: (u32, u32) = PATIENCE;
}

/// A running host.
#[derive(Debug)]
pub struct Host {
    /// The running program.
    pub child: Child,
    /// What it says, in order; closed at its end.
    pub messages: Receiver<FromHost>,
}

impl Host {
    /// Starts it.
    ///
    /// # Errors
    /// [`Failure::Problem`] when it is missing or does not start.
    pub fn start(plan: &Plan<'_>) -> Result<Self, Failure> {
        let mut command = Command::new(programs::find(programs::HOST)?);
        command.arg(plan.model).args(["--device", plan.device, "--rate", &plan.rate_hz.to_string(), "--rt", "ignore"]);
        command
            .args(["--seconds", &plan.seconds.to_string(), "--status", "frames"])
            .arg(programs::TIED)
            .args(hold_fade(plan.rate_hz, plan.hold_fade))
            .args(plan.more);
        if let Some(record) = plan.record {
            command.arg("--record").arg(record);
        }
        if let Some(address) = plan.viewers {
            command.args(["--viewer", address]);
        }
        let mut child = Child::start(&mut command)?;
        let (send, messages) = mpsc::channel();
        if let Some(mut output) = child.stdout() {
            thread::spawn(move || decode(&mut output, |message| send.send(message).is_ok()));
        }
        Ok(Self { child, messages })
    }
}

/// Decodes the stream until it ends or nobody wants more.
fn decode(stream: &mut impl Read, mut wanted: impl FnMut(FromHost) -> bool) {
    let mut decoder = StreamDecoder::<FRAME_MAX>::new();
    let mut bytes = [0; CHUNK];
    while let Ok(count @ 1..) = stream.read(&mut bytes) {
        for &byte in &bytes[..count] {
            if let Some(message) = decoder.push(byte)
                && !wanted(message)
            {
                return;
            }
        }
    }
}

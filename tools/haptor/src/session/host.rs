//! The real-time host as a child process, and what it says over the tool link.

use std::io::Read;
use std::path::Path;
use std::process::Command;
use std::sync::mpsc::{self, Receiver};
use std::thread;

use haptor_wire::{FromHost, StreamDecoder, stream_bound};

use crate::failure::Failure;
use crate::programs::{self, Child};

/// Bytes of the longest frame of the tool link.
const FRAME_MAX: usize = stream_bound(FromHost::MAX_ENCODED);

/// Bytes read from the pipe at once: some tens of frames.
const CHUNK: usize = 4096;

/// Ticks without a pose through which the last wrench is held, and over which it then fades, before a fault latches. Twice the
/// host's own figures: a simulated device is an ordinary process, seen to oversleep 26 ms on a busy machine, and a stall of 50 ms
/// must still be a fault.
pub const PATIENCE: [&str; 4] = ["--hold", "8", "--fade", "32"];

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
    /// The recording to write.
    pub record: &'a Path,
    /// Where viewers come in, if they may.
    pub viewers: Option<&'a str>,
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
            .args(PATIENCE)
            .arg("--record")
            .arg(plan.record);
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

//! The simulated device as a child process that serves a pseudo-terminal.

use std::io::{BufRead, BufReader};
use std::process::Command;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use super::drill::Drill;
use crate::failure::Failure;
use crate::programs::{self, Child};

/// What the simulated device prints before the path of its pseudo-terminal.
const SERVING: &str = "serving pty ";

/// Milliseconds without an answer until it brakes: longer than an ordinary process was seen to oversleep (26 ms), shorter than a
/// stall that must be a fault (50 ms).
const WATCHDOG_MS: &str = "45";

/// Longest wait for that line: the program only opens a pseudo-terminal, the rest is a loaded machine.
const PATIENCE: Duration = Duration::from_secs(10);

/// A simulated device and where it listens.
#[derive(Debug)]
pub struct SimulatedDevice {
    /// The running program.
    pub child: Child,
    /// Path of the pseudo-terminal.
    pub port: String,
}

impl SimulatedDevice {
    /// Starts it with faults on purpose, if any; it ends by itself after `seconds`.
    ///
    /// # Errors
    /// [`Failure::Problem`] when it is missing, does not start or serves nothing; with its last words.
    pub fn start(preset: &str, script: &str, seconds: f64, drills: &[Drill]) -> Result<Self, Failure> {
        let mut command = Command::new(programs::find(programs::FIRMWARE_SIM)?);
        command.args(["--until-stdin-closes", "--watchdog-ms", WATCHDOG_MS]);
        command.args(["--serve", "pty", "--preset", preset, "--script", script, "--seconds", &seconds.to_string()]);
        command.args(drills.iter().flat_map(|drill| ["--fault", &drill.text]));
        let mut child = Child::start(&mut command)?;
        let port = child.stdout().map(BufReader::new).map_or(Err(RecvTimeoutError::Disconnected), first_port);
        match port {
            Ok(port) => Ok(Self { child, port }),
            Err(why) => {
                // its last words come with its end
                child.wait(Duration::from_millis(500));
                let why = if why == RecvTimeoutError::Timeout { "does not say where it serves" } else { "ended at once" };
                Err(Failure::problem(format!("{} {why}{}", programs::FIRMWARE_SIM, child.last_words())))
            }
        }
    }
}

/// The port that the device names; what it says later is read and dropped, so that it never waits for this program.
fn first_port(output: impl BufRead + Send + 'static) -> Result<String, RecvTimeoutError> {
    let (found, port) = mpsc::channel();
    thread::spawn(move || {
        for line in output.lines().map_while(Result::ok) {
            if let Some(path) = line.strip_prefix(SERVING) {
                // the receiver may have given up
                let _ = found.send(path.trim().to_owned());
            }
        }
    });
    port.recv_timeout(PATIENCE)
}

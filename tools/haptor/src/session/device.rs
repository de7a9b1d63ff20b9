//! The simulated device as a child process that serves a pseudo-terminal or a TCP port.

use std::io::{BufRead, BufReader};
use std::process::Command;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use super::drill::Drill;
use crate::failure::Failure;
use crate::programs::{self, Child};

/// What the simulated device prints before the kind and place of its link.
const SERVING: &str = "serving ";

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
    /// Where it is, as the host spells it: `serial:PATH`, `tcp:ADDRESS`.
    pub address: String,
}

impl SimulatedDevice {
    /// Starts it on a pseudo-terminal with faults on purpose, if any; it ends by itself after `seconds`.
    ///
    /// # Errors
    /// [`Failure::Problem`] when it is missing, does not start or serves nothing; with its last words.
    pub fn start(preset: &str, script: &str, seconds: f64, drills: &[Drill]) -> Result<Self, Failure> {
        let drills: Vec<_> = drills.iter().flat_map(|drill| ["--fault".to_owned(), drill.text.clone()]).collect();
        Self::serve("pty", preset, script, seconds, &drills)
    }

    /// The same at `pty` or `tcp:ADDRESS`, with further arguments.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn serve(at: &str, preset: &str, script: &str, seconds: f64, more: &[String]) -> Result<Self, Failure> {
        let mut command = Command::new(programs::find(programs::FIRMWARE_SIM)?);
        command.args(["--until-stdin-closes", "--watchdog-ms", WATCHDOG_MS]);
        command.args(["--serve", at, "--preset", preset, "--script", script, "--seconds", &seconds.to_string()]).args(more);
        let mut child = Child::start(&mut command)?;
        let address = child.stdout().map(BufReader::new).map_or(Err(RecvTimeoutError::Disconnected), first_address);
        match address {
            Ok(address) => Ok(Self { child, address }),
            Err(why) => {
                // its last words come with its end
                child.wait(Duration::from_millis(500));
                let why = if why == RecvTimeoutError::Timeout { "does not say where it serves" } else { "ended at once" };
                Err(Failure::problem(format!("{} {why}{}", programs::FIRMWARE_SIM, child.last_words())))
            }
        }
    }

    /// Ends it; times that it was too late to catch up.
    pub fn stood_still(mut self) -> u64 {
        self.child.release();
        self.child.wait(FAREWELL);
        // the pipe may lag behind the end
        thread::sleep(LAG);
        stood_still_in(&self.child.last_words())
    }
}

/// How the device says, at its end, how often it was too late.
const STOOD_STILL: &str = " times stood still";

/// Time that its last words may take.
const LAG: Duration = Duration::from_millis(50);

/// Longest wait for its end once its standard input is closed.
const FAREWELL: Duration = Duration::from_secs(5);

/// The number before [`STOOD_STILL`] in what it said.
fn stood_still_in(words: &str) -> u64 {
    let before = words.split(STOOD_STILL).next().filter(|before| before.len() < words.len());
    before.and_then(|before| before.rsplit(' ').next()?.parse().ok()).unwrap_or(0)
}

/// The place that the device names; what it says later is read and dropped, so that it never waits for this program.
fn first_address(output: impl BufRead + Send + 'static) -> Result<String, RecvTimeoutError> {
    let (found, address) = mpsc::channel();
    thread::spawn(move || {
        for line in output.lines().map_while(Result::ok) {
            if let Some((kind, place)) = line.strip_prefix(SERVING).and_then(|place| place.split_once(' ')) {
                let kind = if kind == "pty" { "serial" } else { kind };
                // the receiver may have given up
                let _ = found.send(format!("{kind}:{}", place.trim()));
            }
        }
    });
    address.recv_timeout(PATIENCE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_names_its_place_and_says_how_often_it_was_late() {
        for (line, address) in
            [("serving pty /dev/pts/3\n", "serial:/dev/pts/3"), ("x\nserving tcp 127.0.0.1:4\n", "tcp:127.0.0.1:4")]
        {
            assert_eq!(first_address(line.as_bytes()).unwrap(), address);
        }
        let said = "\n  haptor-firmware-sim: 1000 turns, 17 times stood still; 900 messages";
        assert_eq!((stood_still_in(said), stood_still_in("nothing")), (17, 0));
    }
}

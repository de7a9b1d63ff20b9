//! The other programs of the project, which lie beside this one, and their lives as children.
//!
//! A child is killed and waited for when its [`Child`] is dropped, so no exit path leaves one running. What it says on standard
//! error is kept, bounded, for messages.

use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{self, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::failure::Failure;

/// The real-time host.
pub const HOST: &str = "haptor-host";
/// The simulated device.
pub const FIRMWARE_SIM: &str = "haptor-firmware-sim";

/// The option by which a program ends with its standard input, and so with us.
pub const TIED: &str = "--until-stdin-closes";

/// Lines kept of what a child says on standard error: enough for its last words.
const LAST_WORDS: usize = 20;

/// How often a child that should end is looked at.
const POLL: Duration = Duration::from_millis(10);

/// The path of a program beside this one.
///
/// # Errors
/// [`Failure::Problem`] naming what to build.
pub fn find(name: &str) -> Result<PathBuf, Failure> {
    let here = std::env::current_exe().context("the path of this program is unknown")?;
    let path = here.with_file_name(name);
    if path.is_file() {
        return Ok(path);
    }
    Err(Failure::problem(format!(
        "{} is missing: build the three programs with `cargo build --release -p haptor -p haptor-host -p haptor-firmware-sim`, \
         or run `cargo xtask demo`, which does that",
        path.display()
    )))
}

/// From now on Ctrl-C, SIGTERM and a closed terminal do not end this program but set the flag: children end in order, and what they
/// have to say is still heard.
///
/// # Errors
/// When the system refuses.
pub fn note_interrupts() -> anyhow::Result<Arc<AtomicBool>> {
    let interrupted = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(&interrupted)).context("cannot watch for Ctrl-C")?;
    }
    Ok(interrupted)
}

/// A running program.
#[derive(Debug)]
pub struct Child {
    process: process::Child,
    said: Arc<Mutex<Vec<String>>>,
}

impl Child {
    /// Starts a program with its standard output readable and its standard error kept. Its standard input stays open as long as
    /// this program lives, so a program that watches it learns of our death, whatever the cause.
    ///
    /// # Errors
    /// When the system would not start it.
    pub fn start(command: &mut Command) -> anyhow::Result<Self> {
        let program = command.get_program().to_string_lossy().into_owned();
        let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = piped.spawn().with_context(|| format!("{program} cannot be started"))?;
        let said = Arc::new(Mutex::new(Vec::new()));
        if let Some(stderr) = process.stderr.take() {
            let kept = Arc::clone(&said);
            thread::spawn(move || keep_lines(stderr, &kept));
        }
        Ok(Self { process, said })
    }

    /// Starts a program that talks to the user itself: what it says passes through. Its standard input is ours to close, as in
    /// [`Self::start`].
    ///
    /// # Errors
    /// When the system would not start it.
    pub fn attached(command: &mut Command) -> anyhow::Result<Self> {
        let program = command.get_program().to_string_lossy().into_owned();
        let process = command.stdin(Stdio::piped()).spawn().with_context(|| format!("{program} cannot be started"))?;
        Ok(Self { process, said: Arc::default() })
    }

    /// Closes its standard input, which ends a program that was started with [`TIED`].
    pub fn release(&mut self) {
        drop(self.process.stdin.take());
    }

    /// Waits for its end, however long; releases it when interrupted.
    pub fn wait_for_end(&mut self, interrupted: &AtomicBool) -> ExitStatus {
        loop {
            if let Some(status) = self.ended() {
                return status;
            }
            if interrupted.load(Ordering::Relaxed) {
                self.release();
            }
            thread::sleep(POLL);
        }
    }

    /// Its standard output; once.
    pub fn stdout(&mut self) -> Option<ChildStdout> {
        self.process.stdout.take()
    }

    /// How it ended, if it has.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.process.try_wait().ok().flatten()
    }

    /// Waits for its end.
    pub fn wait(&mut self, at_most: Duration) -> Option<ExitStatus> {
        let until = Instant::now() + at_most;
        while self.ended().is_none() && Instant::now() < until {
            thread::sleep(POLL);
        }
        self.ended()
    }

    /// The last lines of its standard error, on lines of their own; empty when it said nothing.
    pub fn last_words(&self) -> String {
        let lines = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        lines.iter().map(|line| format!("\n  {line}")).collect()
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // both fail only when it has ended already
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn keep_lines(stream: impl Read, kept: &Mutex<Vec<String>>) {
    for line in BufReader::new(stream).lines().map_while(Result::ok) {
        let mut lines = kept.lock().unwrap_or_else(PoisonError::into_inner);
        if lines.len() == LAST_WORDS {
            lines.remove(0);
        }
        lines.push(line);
    }
}

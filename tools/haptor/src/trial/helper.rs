//! Programs of others that a trial needs: found in the path, started in a process group of their own, and ended with all that they started, whatever becomes of the
//! trial.

use std::env;
use std::io::Read;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::Context;
use rustix::process::{Pid, Signal, kill_process_group};

use super::interrupted;
use crate::failure::Failure;

/// How often a program is looked at.
const LOOK: Duration = Duration::from_millis(20);

/// A program and where it comes from.
#[derive(Clone, Copy, Debug)]
pub struct Tool {
    /// Its name.
    pub name: &'static str,
    /// Debian's and most others' package of it.
    pub package: &'static str,
}

/// Measures wake-up latency.
pub const CYCLICTEST: Tool = Tool { name: "cyclictest", package: "rt-tests" };

/// Makes load.
pub const STRESS_NG: Tool = Tool { name: "stress-ng", package: "stress-ng" };

impl Tool {
    /// Where it lies.
    fn path(self) -> Option<PathBuf> {
        let folders = env::var_os("PATH").unwrap_or_default();
        env::split_paths(&folders).map(|folder| folder.join(self.name)).find(|path| path.is_file())
    }
}

/// All of these are there.
///
/// # Errors
/// Those that are not, and how to get them.
pub fn need(tools: &[Tool]) -> Result<(), Failure> {
    let missing: Vec<_> = tools.iter().filter(|tool| tool.path().is_none()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let list = |of: fn(&Tool) -> &'static str| missing.iter().map(|tool| of(tool)).collect::<Vec<_>>();
    Err(Failure::problem(format!(
        "missing: {}; install with `apt-get install {}` (Fedora calls rt-tests realtime-tests); `haptor doctor` alone needs neither",
        list(|tool| tool.name).join(", "),
        list(|tool| tool.package).join(" ")
    )))
}

/// A running program; it and its children end with this value.
#[derive(Debug)]
pub struct Helper {
    process: Child,
    name: &'static str,
}

impl Helper {
    /// Starts it; what it prints is read at its end.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(tool: Tool, args: &[String]) -> anyhow::Result<Self> {
        let mut command = Command::new(tool.name);
        command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let process = command.process_group(0).spawn().with_context(|| format!("{} cannot be started", tool.name))?;
        Ok(Self { process, name: tool.name })
    }

    /// Waits for its end; yields what it printed.
    ///
    /// # Errors
    /// When it fails, with its last words, or somebody interrupts.
    pub fn output(mut self, stop: &AtomicBool) -> Result<String, Failure> {
        let mut pipe = self.process.stdout.take().context("its standard output")?;
        let reader = thread::spawn(move || {
            let mut text = String::new();
            pipe.read_to_string(&mut text).map(|_| text)
        });
        let status = loop {
            if let Some(status) = self.process.try_wait().context("it cannot be waited for")? {
                break status;
            }
            if stop.load(Ordering::Relaxed) {
                return Err(interrupted());
            }
            thread::sleep(LOOK);
        };
        let mut said = String::new();
        if let Some(mut errors) = self.process.stderr.take() {
            // what cannot be read is not said
            let _ = errors.read_to_string(&mut said);
        }
        if !status.success() {
            return Err(Failure::problem(format!("{} ended with {status}: {}", self.name, said.trim())));
        }
        let text = reader.join().ok().and_then(Result::ok);
        text.ok_or_else(|| Failure::problem(format!("what {} printed cannot be read", self.name)))
    }
}

impl Drop for Helper {
    fn drop(&mut self) {
        // fails only when all of the group have ended
        let _ = kill_process_group(Pid::from_child(&self.process), Signal::KILL);
        let _ = self.process.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const SHELL: Tool = Tool { name: "sh", package: "dash" };

    #[test]
    fn what_is_missing_is_named_with_its_package() {
        let nobody = Tool { name: "no-such-program", package: "no-such-package" };
        need(&[SHELL]).unwrap();
        let said = need(&[SHELL, nobody]).unwrap_err().error().to_string();
        assert!(said.contains("missing: no-such-program;") && said.contains("apt-get install no-such-package"), "{said}");
    }

    #[test]
    fn output_is_read_failure_is_told_and_an_interrupt_ends_it() {
        let run = |script: &str, stop: bool| {
            Helper::start(SHELL, &["-c".into(), script.into()]).unwrap().output(&AtomicBool::new(stop))
        };
        assert_eq!(run("echo ten", false).unwrap(), "ten\n");
        let said = run("echo why >&2; exit 3", false).unwrap_err().error().to_string();
        assert!(said.contains("sh ended with exit status: 3: why"), "{said}");
        assert!(run("sleep 1000", true).unwrap_err().error().to_string().contains("interrupted"));
    }

    #[test]
    fn children_of_a_program_end_with_it() {
        let mut helper = Helper::start(SHELL, &["-c".into(), "sleep 1000 & echo $!; wait".into()]).unwrap();
        let mut id = Vec::new();
        let mut pipe = helper.process.stdout.take().unwrap();
        while !id.ends_with(b"\n") {
            let mut byte = [0];
            pipe.read_exact(&mut byte).unwrap();
            id.extend(byte);
        }
        drop(helper);
        let status = format!("/proc/{}/status", String::from_utf8(id).unwrap().trim());
        // gone, or dead and waiting for whoever adopts it
        while fs::read_to_string(&status).is_ok_and(|status| !status.contains("State:\tZ")) {
            thread::sleep(LOOK);
        }
    }
}

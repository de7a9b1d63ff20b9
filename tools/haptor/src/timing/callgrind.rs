//! Exact instruction counts by valgrind's callgrind: a program with marked functions is run, every call of one is written as a dump, dumps are read.
//!
//! A dump attributes each instruction to the source line it was compiled from, inlined or not. Needs nothing but the standard library: tests and developer
//! commands that count include this file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What counts, and the Debian package it comes from.
pub const VALGRIND: &str = "valgrind";

/// Name and version of the counter; `None` where it is not installed.
pub fn version() -> Option<String> {
    let output = Command::new(VALGRIND).arg("--version").output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// What is to be counted.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The program.
    pub program: &'a Path,
    /// Its arguments.
    pub args: &'a [&'a str],
    /// Variables of the environment that it needs; it gets no others, see [`run`](Self::run).
    pub keep: &'a [&'a str],
    /// Pattern of the marked functions.
    pub pattern: &'a str,
    /// Their full names.
    pub marked: &'a [&'a str],
    /// With source lines, by which stages and files are told apart; without them a dump is a tenth as long.
    pub lines: bool,
    /// Takes the dumps; empty.
    pub folder: &'a Path,
}

impl Job<'_> {
    /// Runs the program under the counter; yields what it printed.
    ///
    /// # Errors
    /// What is missing or did not end well, and what to do.
    pub fn run(&self) -> Result<String, String> {
        let home = self.program.parent().unwrap_or(Path::new("."));
        let name = self.program.file_name().unwrap_or_default().to_string_lossy();
        let mut command = Command::new(VALGRIND);
        // environment and the program's path lie on the stack, and copies cost by its alignment: the same of both everywhere
        command.env_clear().env("PATH", "/usr/bin:/bin").current_dir(home);
        command.envs(self.keep.iter().filter_map(|name| Some((name, std::env::var_os(name)?))));
        command.args(["--tool=callgrind", "--collect-atstart=no", &format!("--toggle-collect={}", self.pattern)]);
        command.arg(format!("--dump-line={}", if self.lines { "yes" } else { "no" }));
        command.args(self.marked.iter().map(|name| format!("--dump-after={name}")));
        command.arg(format!("--callgrind-out-file={}", self.folder.join("dump").display()));
        let output = command.arg(format!("./{name}")).args(self.args).output().map_err(|error| missing(&error))?;
        if !output.status.success() {
            return Err(format!("{VALGRIND}: {}", String::from_utf8_lossy(&output.stderr)));
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// The dump of a call, in order from 0.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn dump(&self, call: usize) -> Result<String, String> {
        let dump: PathBuf = self.folder.join(format!("dump.{}", call + 1));
        fs::read_to_string(&dump).map_err(|error| format!("{}: {error}", dump.display()))
    }
}

/// Why valgrind cannot be started, and what to do.
pub fn missing(error: &std::io::Error) -> String {
    format!("{VALGRIND}: {error}; install Debian's package {VALGRIND}")
}

/// Instructions of a dump; `None` when it has no total.
pub fn total(dump: &str) -> Option<u64> {
    dump.lines().rev().find_map(|line| line.strip_prefix("totals:"))?.trim().parse().ok()
}

/// Cost of a line of the form `position cost`; positions are numbers, differences or `*`.
pub fn cost(line: &str) -> Option<u64> {
    let (position, cost) = line.split_once(' ')?;
    position.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '*')).then(|| cost.trim().parse().ok())?
}

/// A file of the core by its path in `src`, any other as `libraries`.
pub fn short(path: &str) -> String {
    let own = path.split_once("core/contact/src/").map(|(_, rest)| rest.to_owned());
    own.unwrap_or_else(|| "libraries".to_owned())
}

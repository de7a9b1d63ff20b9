//! Exact instruction counts of ticks: `haptor-counts` under valgrind's callgrind, read back scene by scene and file by file.
//!
//! Callgrind counts every instruction of a marked call and writes one dump for each. A dump attributes each instruction to the source
//! line it was compiled from, inlined or not, so that what a feature costs where it is not used can be shown to be nothing. Needs nothing
//! but the standard library: the test and the developer command that writes the table both include this file.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program whose ticks are counted, a package and its binary.
pub const PROGRAM: &str = "haptor-counts";

/// What counts, and the Debian package it comes from.
pub const VALGRIND: &str = "valgrind";

/// The marked functions.
const MARKED: [&str; 2] = ["haptor_counts::bench::measured_tick", "haptor_counts::bench::measured_surface"];

/// Where the table lies; `root` is the repository's.
pub fn table_file(root: &Path) -> PathBuf {
    root.join("tests/bench/COUNTS.md")
}

/// Counts of one scene.
#[derive(Clone, Debug, Default)]
pub struct Counted {
    /// Name of the scene.
    pub name: String,
    /// Calls that were counted.
    pub calls: u64,
    /// Instructions of all calls.
    pub total: u64,
    /// Instructions of the dearest call.
    pub worst: u64,
    /// Instructions of all calls by source file; ours by their path in the core's `src`, others under `libraries`.
    pub files: BTreeMap<String, u64>,
}

impl Counted {
    /// Instructions per call, rounded.
    pub fn mean(&self) -> u64 {
        (self.total + self.calls / 2) / self.calls.max(1)
    }

    /// Instructions of all calls in files whose path starts with one of these.
    pub fn within(&self, starts: &[&str]) -> u64 {
        self.files.iter().filter(|(file, _)| starts.iter().any(|start| file.starts_with(start))).map(|(_, count)| count).sum()
    }
}

/// Counts every scene. `folder` is empty and takes the dumps.
///
/// # Errors
/// What is missing or did not end well, and what to do.
pub fn count(program: &Path, folder: &Path) -> Result<Vec<Counted>, String> {
    let (home, out) = (program.parent().unwrap_or(Path::new(".")), folder.join("dump"));
    let mut command = Command::new(VALGRIND);
    // environment and the program's path lie on the stack, and copies cost by its alignment: the same of both everywhere
    command.env_clear().env("PATH", "/usr/bin:/bin").current_dir(home).args([
        "--tool=callgrind",
        "--collect-atstart=no",
        "--toggle-collect=*measured_*",
    ]);
    command.args(MARKED.map(|name| format!("--dump-after={name}"))).arg(format!("--callgrind-out-file={}", out.display()));
    let output = command
        .arg(format!("./{PROGRAM}"))
        .output()
        .map_err(|error| format!("{VALGRIND}: {error}; install Debian's package {VALGRIND}"))?;
    if !output.status.success() {
        return Err(format!("{VALGRIND}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let names = String::from_utf8_lossy(&output.stdout);
    let (mut counted, mut files): (Vec<Counted>, _) = (Vec::new(), HashMap::new());
    for (index, name) in names.lines().enumerate() {
        let dump = folder.join(format!("dump.{}", index + 1));
        let text = fs::read_to_string(&dump).map_err(|error| format!("{}: {error}", dump.display()))?;
        if counted.last().is_none_or(|last| last.name != name) {
            counted.push(Counted { name: name.to_owned(), ..Counted::default() });
        }
        if let Some(last) = counted.last_mut() {
            add(last, &text, &mut files);
        }
    }
    if counted.is_empty() { Err(format!("{} said nothing", program.display())) } else { Ok(counted) }
}

/// Adds one dump. Names are written once as `(number) name`, then as `(number)`; `files` keeps the numbers from dump to dump.
fn add(counted: &mut Counted, dump: &str, files: &mut HashMap<String, String>) {
    let (mut file, mut total, mut is_call) = (String::new(), 0, false);
    for line in dump.lines() {
        match line.split_once('=') {
            Some(("fl" | "fi" | "fe", name)) => file = known(name, files),
            // a callee's file may be named here first
            Some(("cfi" | "cfl", name)) => drop(known(name, files)),
            Some(("calls", _)) => is_call = true,
            Some(_) => {}
            // what a callee cost is counted in its own lines
            None if std::mem::take(&mut is_call) => {}
            None => total += own(line).inspect(|cost| *counted.files.entry(file.clone()).or_default() += cost).unwrap_or(0),
        }
    }
    counted.files.retain(|_, cost| *cost > 0);
    counted.calls += 1;
    counted.total += total;
    counted.worst = counted.worst.max(total);
}

/// Cost of a line of the form `position cost`; positions are numbers, differences or `*`.
fn own(line: &str) -> Option<u64> {
    let (position, cost) = line.split_once(' ')?;
    position.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '*')).then(|| cost.trim().parse().ok())?
}

fn known(name: &str, files: &mut HashMap<String, String>) -> String {
    let (number, path) = name.split_once(' ').unwrap_or((name, ""));
    if !path.is_empty() {
        files.insert(number.to_owned(), short(path));
    }
    files.get(number).cloned().unwrap_or_default()
}

/// A file of the core by its path in `src`, any other as a library's.
fn short(path: &str) -> String {
    let own = path.split_once("core/contact/src/").map(|(_, rest)| rest.to_owned());
    own.unwrap_or_else(|| "libraries".to_owned())
}

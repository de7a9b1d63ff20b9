//! Exact instruction counts of ticks: `haptor-counts` under valgrind's callgrind, read back scene by scene, file by file and stage by stage.
//!
//! What counts and how dumps are read is the host tool's `callgrind.rs` and `stages.rs`. Needs nothing but the standard library: the test and the developer command
//! that writes the table both include this file.

use std::path::{Path, PathBuf};

#[path = "by_file.rs"]
pub mod by_file;
#[allow(dead_code, reason = "the counter's version is a table's, which the test does not write")]
#[path = "../../tools/haptor/src/timing/callgrind.rs"]
pub mod callgrind;
#[path = "../../tools/haptor/src/timing/stages.rs"]
pub mod stages;

use by_file::{ByFile, by_file, within};
use callgrind::Job;
use stages::{Names, STAGES, by_stage};

/// The program whose ticks are counted, a package and its binary.
pub const PROGRAM: &str = "haptor-counts";

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
    pub files: ByFile,
    /// Instructions of all calls by stage, what is in none of them last.
    pub stages: [u64; STAGES.len() + 1],
}

impl Counted {
    /// Instructions per call, rounded.
    pub fn mean(&self) -> u64 {
        (self.total + self.calls / 2) / self.calls.max(1)
    }

    /// Instructions of all calls in files whose path starts with one of these.
    #[allow(dead_code, reason = "the test asks, the table has stages")]
    pub fn within(&self, starts: &[&str]) -> u64 {
        within(&self.files, starts)
    }
}

/// Counts every scene. `folder` is empty and takes the dumps.
///
/// # Errors
/// What is missing or did not end well, and what to do.
pub fn count(program: &Path, folder: &Path) -> Result<Vec<Counted>, String> {
    let job = Job { program, args: &[], keep: &[], pattern: "*measured_*", marked: &MARKED, lines: true, folder };
    let said = job.run()?;
    let (mut counted, mut names): (Vec<Counted>, _) = (Vec::new(), Names::default());
    for (call, name) in said.lines().enumerate() {
        let dump = job.dump(call)?;
        if counted.last().is_none_or(|last| last.name != name) {
            counted.push(Counted { name: name.to_owned(), ..Counted::default() });
        }
        if let Some(last) = counted.last_mut() {
            let total = by_file(&dump, &mut names, &mut last.files);
            let (of, rest) = by_stage(&dump, &mut names);
            last.stages.iter_mut().zip(of.into_iter().chain([rest])).for_each(|(sum, count)| *sum += count);
            last.calls += 1;
            last.total += total;
            last.worst = last.worst.max(total);
        }
    }
    if counted.is_empty() { Err(format!("{} said nothing", program.display())) } else { Ok(counted) }
}

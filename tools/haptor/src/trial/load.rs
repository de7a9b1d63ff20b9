//! Load by stress-ng: processors, memory, context switches and writing out, as a busy desktop has them, only all the time.

use std::thread;
use std::time::Duration;

use super::helper::{Helper, STRESS_NG};

/// What it does on a CPU each, in words for the tables.
pub const WORDS: &str = "stress-ng: a processor hog a CPU, memory, context switches, sync";

/// Memory that it fills again and again.
const MEMORY: &str = "64M";

/// Time it gets to have all its workers at work.
const WARM: Duration = Duration::from_millis(500);

/// Starts it for a trial of so many seconds; it ends with the value, and by itself should this program be killed.
///
/// # Errors
/// When it cannot be started.
pub fn start(cpus: usize, seconds: u64) -> anyhow::Result<Helper> {
    let most = (seconds + 30).to_string();
    let args = ["--quiet", "--cpu", &cpus.to_string(), "--vm", "1", "--vm-bytes", MEMORY, "--switch", "1", "--io", "1"];
    let args = args.iter().chain(&["--timeout", &most]).map(|&arg| arg.to_owned()).collect::<Vec<_>>();
    let load = Helper::start(STRESS_NG, &args)?;
    thread::sleep(WARM);
    Ok(load)
}

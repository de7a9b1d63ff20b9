//! The processor: CPUs that may be used, how deep they sleep, whether they keep their speed.

use std::fs;
use std::path::Path;
use std::thread;

use super::{Finding, Mark, read};

/// Where the kernel tells of CPUs.
const FOLDER: &str = "/sys/devices/system/cpu";

/// Cores that leave one to the tick: the tick, and everything else.
const CORES: usize = 2;

/// CPUs that this process may use, in order.
pub fn allowed() -> Vec<usize> {
    let status = read("/proc/self/status");
    let line = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    line.map(list).unwrap_or_default()
}

/// Numbers of a list as the kernel prints it: `0-2,7`.
pub fn list(text: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.trim().parse::<usize>().ok()?..=last.trim().parse().ok()?)
    };
    text.trim().split(',').filter_map(range).flatten().collect()
}

/// Cores that this process may use.
pub fn cores() -> Finding {
    match thread::available_parallelism().map_or(1, usize::from) {
        count if count >= CORES => Finding::ok("cores", count.to_string()),
        count => {
            Finding::bad("cores", Mark::Warn, count.to_string(), "with one core everything else delays the tick; use two or more")
        }
    }
}

/// Does the processor keep its speed?
pub fn governor() -> Finding {
    let mut found: Vec<_> = governors(Path::new(FOLDER));
    found.sort();
    found.dedup();
    match found.as_slice() {
        [] => Finding::ok("CPU governor", "none (fixed by firmware or virtual machine)"),
        [one] if one == "performance" => Finding::ok("CPU governor", one.clone()),
        _ => Finding::bad("CPU governor", Mark::Warn, found.join(", "), "`cpupower frequency-set -g performance` while running"),
    }
}

fn governors(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let files = entries.flatten().map(|entry| entry.path().join("cpufreq/scaling_governor"));
    files.filter_map(|file| fs::read_to_string(file).ok()).map(|text| text.trim().to_owned()).collect()
}

/// May the host hold off deep CPU sleep, and how deep is it? Opening the file asks for nothing until something is written.
pub fn sleep() -> Finding {
    let path = "/dev/cpu_dma_latency";
    let deepest = deepest(&Path::new(FOLDER).join("cpu0/cpuidle"));
    judge_sleep(path, fs::OpenOptions::new().write(true).open(path).map(drop).map_err(|error| error.to_string()), deepest)
}

fn judge_sleep(path: &str, writes: Result<(), String>, deepest: Option<(String, u32)>) -> Finding {
    let depth =
        deepest.map_or("no sleep states are told".to_owned(), |(name, us)| format!("deepest is {name}, {us} us to leave"));
    match writes {
        Ok(()) => Finding::ok("deep sleep", format!("{path} can be written; {depth}")),
        Err(error) => {
            let advice = "a udev rule `KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"` lets the host hold it off";
            Finding::bad("deep sleep", Mark::Warn, format!("{path}: {error}; {depth}"), advice)
        }
    }
}

/// Name and wake-up time \[us\] of the state that takes longest to leave.
fn deepest(folder: &Path) -> Option<(String, u32)> {
    let states = fs::read_dir(folder).ok()?.flatten().filter_map(|entry| {
        let told = |name: &str| Some(fs::read_to_string(entry.path().join(name)).ok()?.trim().to_owned());
        Some((told("name")?, told("latency")?.parse().ok()?))
    });
    states.max_by_key(|(_, us)| *us)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_cpus_are_read_as_the_kernel_prints_them() {
        for (text, expected) in [("0-2,7\n", &[0, 1, 2, 7][..]), ("3", &[3]), ("", &[]), ("(null)", &[])] {
            assert_eq!(list(text), expected, "{text}");
        }
        assert!(!allowed().is_empty());
    }

    #[test]
    fn the_deepest_state_is_the_slowest_to_leave() {
        let folder = tempfile::tempdir().unwrap();
        for (state, name, latency) in [("state0", "POLL", "0\n"), ("state3", "C6", "133\n"), ("state1", "C1", "2\n")] {
            let path = folder.path().join(state);
            fs::create_dir_all(&path).unwrap();
            fs::write(path.join("name"), name).unwrap();
            fs::write(path.join("latency"), latency).unwrap();
        }
        assert_eq!(deepest(folder.path()), Some(("C6".to_owned(), 133)));
        let finding = judge_sleep("p", Err("no".to_owned()), deepest(folder.path()));
        assert!(finding.mark == Mark::Warn && finding.found.contains("C6, 133 us"), "{finding:?}");
        assert_eq!(judge_sleep("p", Ok(()), None).mark, Mark::Ok);
    }
}

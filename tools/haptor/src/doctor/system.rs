//! What the kernel says about itself, this process's rights and the processor.

use std::fs;
use std::path::Path;
use std::thread;

use super::{Finding, Mark};

/// Memory that the host locks \[bytes\], with room: code, stacks, queues and recording buffers.
const LOCKED_BYTES: u64 = 256 << 20;

/// Real-time priority that the host asks for, below the kernel's own threads.
const PRIORITY: u64 = 80;

/// Bits of the capabilities that grant what the limits would (capabilities(7)).
const CAP_IPC_LOCK: u32 = 14;
const CAP_SYS_NICE: u32 = 23;

/// Cores that leave one to the tick: the tick, and everything else.
const CORES: usize = 2;

/// Flavour of the kernel.
pub fn kernel() -> Finding {
    let release = read("/proc/sys/kernel/osrelease");
    let version = read("/proc/sys/kernel/version");
    let flavour = flavour(&version, &read("/sys/kernel/realtime"));
    let found = format!("{release} ({})", if flavour.is_empty() { "preemption unknown" } else { flavour });
    match flavour {
        "PREEMPT_RT" => Finding::ok("kernel", found),
        _ => Finding::bad(
            "kernel",
            Mark::Warn,
            found,
            "a PREEMPT_RT kernel bounds the worst case; e.g. Debian's linux-image-rt-amd64",
        ),
    }
}

/// `/sys/kernel/realtime` is missing on some real-time kernels, so the version text counts too.
fn flavour(version: &str, realtime: &str) -> &'static str {
    let names = ["PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT", "VOLUNTARY"];
    if realtime == "1" {
        return "PREEMPT_RT";
    }
    names.into_iter().find(|name| version.contains(name)).unwrap_or("")
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

/// May the host run under SCHED_FIFO?
pub fn rtprio() -> Finding {
    let limit = limit("Max realtime priority");
    if capable(CAP_SYS_NICE) || limit.is_some_and(|limit| limit >= PRIORITY) {
        return Finding::ok("real-time priority", "granted");
    }
    let advice = "add `@realtime - rtprio 90` to /etc/security/limits.d/, join the group and log in again";
    Finding::bad("real-time priority", Mark::Warn, format!("limit {}, {PRIORITY} wanted", limit.unwrap_or(0)), advice)
}

/// May the host lock its memory?
pub fn memlock() -> Finding {
    let limit = limit("Max locked memory");
    if capable(CAP_IPC_LOCK) || limit.is_some_and(|limit| limit >= LOCKED_BYTES) {
        return Finding::ok("locked memory", "granted");
    }
    let advice = "add `@realtime - memlock unlimited` to /etc/security/limits.d/, join the group and log in again";
    let found = format!("limit {} MiB, {} MiB wanted", limit.unwrap_or(0) >> 20, LOCKED_BYTES >> 20);
    Finding::bad("locked memory", Mark::Warn, found, advice)
}

/// Does the processor keep its speed?
pub fn governor() -> Finding {
    let mut found: Vec<_> = governors(Path::new("/sys/devices/system/cpu"));
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

/// May the host hold off deep CPU sleep? Opening the file asks for nothing until something is written.
pub fn dma_latency() -> Finding {
    let path = "/dev/cpu_dma_latency";
    match fs::OpenOptions::new().write(true).open(path) {
        Ok(_) => Finding::ok("deep sleep", format!("{path} can be written")),
        Err(error) => {
            let advice = "a udev rule `KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"` lets the host hold it off";
            Finding::bad("deep sleep", Mark::Warn, format!("{path}: {error}"), advice)
        }
    }
}

fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default().trim().to_owned()
}

fn limit(name: &str) -> Option<u64> {
    soft_limit(&read("/proc/self/limits"), name)
}

/// The soft limit of a line of `/proc/self/limits`; `None` when there is no such line.
fn soft_limit(limits: &str, name: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    match line.split_whitespace().next()? {
        "unlimited" => Some(u64::MAX),
        number => number.parse().ok(),
    }
}

fn capable(bit: u32) -> bool {
    let status = read("/proc/self/status");
    let set = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    set.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok()).is_some_and(|set| set >> bit & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flavour_is_read_from_either_place() {
        let table = [
            ("#1 SMP PREEMPT_RT Debian 6.1.1", "", "PREEMPT_RT"),
            ("#1 SMP PREEMPT_DYNAMIC Debian", "1", "PREEMPT_RT"),
            ("#1 SMP PREEMPT_DYNAMIC Debian", "", "PREEMPT_DYNAMIC"),
            ("#1 SMP", "", ""),
        ];
        for (version, realtime, expected) in table {
            assert_eq!(flavour(version, realtime), expected, "{version}");
        }
    }

    #[test]
    fn limits_are_read_as_the_kernel_prints_them() {
        let text = "Limit                     Soft Limit           Hard Limit           Units\n\
                    Max locked memory         8388608              unlimited            bytes\n\
                    Max realtime priority     0                    0\n\
                    Max cpu time              unlimited            unlimited            seconds\n";
        assert_eq!(soft_limit(text, "Max locked memory"), Some(8 << 20));
        assert_eq!(soft_limit(text, "Max realtime priority"), Some(0));
        assert_eq!(soft_limit(text, "Max cpu time"), Some(u64::MAX));
        assert_eq!(soft_limit(text, "Max other"), None);
    }
}

//! The rights of this process, which the host inherits.

use super::{Finding, Mark, read};

/// Memory that the host locks \[bytes\], with room: code, stacks, queues and recording buffers.
const LOCKED_BYTES: u64 = 256 << 20;

/// Real-time priority that the host asks for, below the kernel's own threads.
const PRIORITY: u64 = 80;

/// Bits of the capabilities that grant what the limits would (capabilities(7)).
const CAP_IPC_LOCK: u32 = 14;
const CAP_SYS_NICE: u32 = 23;

/// Is the real-time class granted?
pub fn has_rights() -> bool {
    capable(CAP_SYS_NICE) || limit("Max realtime priority").is_some_and(|limit| limit >= PRIORITY)
}

/// May the host run under SCHED_FIFO?
pub fn rtprio() -> Finding {
    let limit = limit("Max realtime priority");
    if has_rights() {
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

//! What this program runs in: a container, which takes rights and time away unless told not to, and a virtual machine, whose CPUs are somebody else's threads.

use std::path::Path;

use super::{Finding, Mark, read, system};

/// Files that engines of containers leave.
const MARKS: [&str; 2] = ["/.dockerenv", "/run/.containerenv"];

/// Words in the control groups of a container.
const WORDS: [&str; 4] = ["docker", "kubepods", "lxc", "libpod"];

/// Are we in a container, and does it get in the way?
pub fn container() -> Finding {
    let inside =
        MARKS.iter().any(|mark| Path::new(mark).exists()) || WORDS.iter().any(|word| read("/proc/1/cgroup").contains(word));
    judge_container(inside, system::has_rights(), &read("/sys/fs/cgroup/cpu.max"))
}

/// `quota`: `cpu.max` of the control group, `max 100000` where there is no limit.
fn judge_container(inside: bool, rights: bool, quota: &str) -> Finding {
    let what = "container";
    let limited = !quota.is_empty() && !quota.starts_with("max");
    if limited {
        let found = format!("CPU time is limited (cpu.max {quota})");
        return Finding::bad(
            what,
            Mark::Warn,
            found,
            "a limit stops every thread for tens of milliseconds: run without --cpus and CPU quotas",
        );
    }
    match (inside, rights) {
        (false, _) => Finding::ok(what, "none"),
        (true, true) => Finding::ok(what, "in one, with real-time rights"),
        (true, false) => Finding::bad(
            what,
            Mark::Warn,
            "in one, without real-time rights",
            "start it with --cap-add SYS_NICE --cap-add IPC_LOCK --ulimit rtprio=90 --ulimit memlock=-1 --device /dev/cpu_dma_latency",
        ),
    }
}

/// Share of stolen time above which a virtual machine is told to be squeezed.
const STEAL: f64 = 0.01;

/// Are the CPUs those of a virtual machine, and are they taken away?
pub fn machine() -> Finding {
    let is_virtual = read("/proc/cpuinfo").lines().any(|line| line.starts_with("flags") && line.contains(" hypervisor"));
    judge_machine(is_virtual, stolen(&read("/proc/stat")))
}

fn judge_machine(is_virtual: bool, stolen: f64) -> Finding {
    let what = "machine";
    if !is_virtual {
        return Finding::ok(what, "not virtual");
    }
    let found = format!("virtual, {:.2} % of the time since boot was taken by others", 100.0 * stolen);
    let advice = "worst cases are the hypervisor's: give it whole cores (pinned), or measure on the machine that will be used";
    Finding::bad(what, if stolen > STEAL { Mark::Warn } else { Mark::Ok }, found, advice)
}

/// Share of time stolen since boot: the eighth figure of the first line to the sum of the first eight.
fn stolen(stat: &str) -> f64 {
    let line = stat.lines().next().unwrap_or_default();
    let figures: Vec<f64> = line.split_whitespace().skip(1).take(8).filter_map(|word| word.parse().ok()).collect();
    figures.get(7).map_or(0.0, |steal| steal / figures.iter().sum::<f64>().max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_container_is_judged_by_what_it_takes_away() {
        for (inside, rights, quota, mark, part) in [
            (false, true, "", Mark::Ok, "none"),
            (true, true, "max 100000", Mark::Ok, "with real-time rights"),
            (true, false, "", Mark::Warn, "without real-time rights"),
            (true, true, "150000 100000", Mark::Warn, "limited"),
        ] {
            let finding = judge_container(inside, rights, quota);
            assert!(finding.mark == mark && finding.found.contains(part), "{finding:?}");
        }
    }

    #[test]
    fn stolen_time_tells_a_squeezed_machine() {
        let stat = "cpu  50 10 20 880 10 0 10 20 0 0\ncpu0 1 1\n";
        assert!((stolen(stat) - 0.02).abs() < 1.0e-9);
        assert_eq!((judge_machine(true, 0.02).mark, judge_machine(true, 0.001).mark), (Mark::Warn, Mark::Ok));
        assert_eq!(judge_machine(false, stolen("")).found, "not virtual");
    }
}

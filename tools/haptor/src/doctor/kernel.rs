//! What the kernel is and how it is set: its preemption, its clock, what it grants to real-time threads, and on which CPUs.

use std::fs;
use std::path::Path;

use super::{Finding, Mark, read};

/// Names of a kernel's preemption in its version text, the most telling first.
const FLAVOURS: [&str; 4] = ["PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT", "VOLUNTARY"];

/// Threads that only a PREEMPT_RT kernel has: they run what other kernels run in interrupts.
const RT_THREADS: [&str; 2] = ["ktimers/", "ktimersd/"];

/// What tells a kernel's flavour.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Signs {
    /// `/proc/sys/kernel/version`.
    version: String,
    /// `/sys/kernel/realtime`, missing on some real-time kernels.
    realtime: String,
    /// `/boot/config-RELEASE`, where it is installed.
    config: String,
    /// A thread of [`RT_THREADS`] runs; not to be seen from a container.
    threads: bool,
}

impl Signs {
    fn gather(release: &str) -> Self {
        Self {
            version: read("/proc/sys/kernel/version"),
            realtime: read("/sys/kernel/realtime"),
            config: read(&format!("/boot/config-{release}")),
            threads: has_rt_threads(Path::new("/proc")),
        }
    }

    /// The signs that say PREEMPT_RT.
    fn of_rt(&self) -> Vec<&'static str> {
        let all = [
            ("version text", self.version.contains("PREEMPT_RT")),
            ("/sys/kernel/realtime", self.realtime == "1"),
            ("configuration", self.config.lines().any(|line| line == "CONFIG_PREEMPT_RT=y")),
            ("timer threads", self.threads),
        ];
        all.into_iter().filter(|(_, says)| *says).map(|(sign, _)| sign).collect()
    }
}

/// Flavour of the kernel, by whatever sign tells it.
pub fn flavour() -> Finding {
    let release = read("/proc/sys/kernel/osrelease");
    judge_flavour(&release, &Signs::gather(&release))
}

fn judge_flavour(release: &str, signs: &Signs) -> Finding {
    let of_rt = signs.of_rt();
    if !of_rt.is_empty() {
        return Finding::ok("kernel", format!("{release} (PREEMPT_RT by {})", of_rt.join(", ")));
    }
    let named = FLAVOURS.into_iter().find(|name| signs.version.contains(name)).unwrap_or("preemption unknown");
    let advice = "a PREEMPT_RT kernel bounds the worst case; e.g. Debian's linux-image-rt-amd64";
    Finding::bad("kernel", Mark::Warn, format!("{release} ({named})"), advice)
}

fn has_rt_threads(proc: &Path) -> bool {
    let Ok(entries) = fs::read_dir(proc) else { return false };
    let names = entries.flatten().filter_map(|entry| fs::read_to_string(entry.path().join("comm")).ok());
    names.into_iter().any(|name| RT_THREADS.iter().any(|thread| name.starts_with(thread)))
}

/// Clocks that cost no system call and no bus to read.
const GOOD_CLOCKS: [&str; 4] = ["tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page"];

/// Is the clock read in some tens of nanoseconds? The tick reads it five times.
pub fn clock() -> Finding {
    let name = read("/sys/devices/system/clocksource/clocksource0/current_clocksource");
    if name.is_empty() || GOOD_CLOCKS.contains(&name.as_str()) {
        return Finding::ok("clock", if name.is_empty() { "unknown".to_owned() } else { name });
    }
    let advice = "boot with clocksource=tsc if the processor's is stable: other clocks cost microseconds a reading";
    Finding::bad("clock", Mark::Warn, name, advice)
}

/// Share of a period below which throttled real-time threads lose ticks: the tick and its link take less, a scene that fills its period does not.
const RUNTIME_LOW: f64 = 0.9;

/// How much of each second may real-time threads run?
pub fn throttling() -> Finding {
    let number = |name: &str| read(&format!("/proc/sys/kernel/sched_rt_{name}_us")).parse::<f64>().ok();
    judge_throttling(number("runtime"), number("period"))
}

fn judge_throttling(runtime_us: Option<f64>, period_us: Option<f64>) -> Finding {
    let what = "real-time throttling";
    match (runtime_us, period_us) {
        (Some(runtime_us), _) if runtime_us < 0.0 => Finding::ok(what, "off"),
        (Some(runtime_us), Some(period_us)) => {
            let share = runtime_us / period_us.max(1.0);
            let found = format!("real-time threads may take {:.0} % of {:.1} s", 100.0 * share, period_us / 1.0e6);
            if share < RUNTIME_LOW {
                return Finding::bad(what, Mark::Warn, found, "`sysctl kernel.sched_rt_runtime_us=950000`");
            }
            Finding::ok(what, found)
        }
        _ => Finding::ok(what, "unknown"),
    }
}

/// Are there CPUs that nothing else is scheduled on?
pub fn isolation() -> Finding {
    let [isolated, tickless] = ["isolated", "nohz_full"].map(|name| read(&format!("/sys/devices/system/cpu/{name}")));
    judge_isolation(&isolated, &tickless)
}

fn judge_isolation(isolated: &str, tickless: &str) -> Finding {
    let what = "isolated CPUs";
    // the kernel prints (null) where it has none
    let [isolated, tickless] = [isolated, tickless].map(|list| list.trim_matches(['(', ')']).replace("null", ""));
    if isolated.is_empty() {
        let advice = "optional: boot with isolcpus=N nohz_full=N rcu_nocbs=N and run the host with --cpu N, so that nothing else is on the tick's CPU";
        return Finding { advice: Some(advice.to_owned()), ..Finding::ok(what, "none") };
    }
    let tickless = if tickless.is_empty() { "none".to_owned() } else { tickless };
    let advice = Some(format!("give the host one of them: --cpu {}", isolated.split([',', '-']).next_back().unwrap_or("N")));
    Finding { advice, ..Finding::ok(what, format!("{isolated}, without a scheduling tick: {tickless}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_sign_of_a_real_time_kernel_tells_it_and_is_named() {
        let signs = |version: &str, realtime: &str, config: &str, threads| Signs {
            version: version.to_owned(),
            realtime: realtime.to_owned(),
            config: config.to_owned(),
            threads,
        };
        let table = [
            (signs("#1 SMP PREEMPT_RT Debian", "", "", false), Mark::Ok, "PREEMPT_RT by version text"),
            (signs("#1 SMP PREEMPT_DYNAMIC", "1", "", false), Mark::Ok, "by /sys/kernel/realtime"),
            (signs("#1 SMP", "", "CONFIG_PREEMPT_RT=y\n", false), Mark::Ok, "by configuration"),
            (signs("#1 SMP", "", "# CONFIG_PREEMPT_RT is not set\n", true), Mark::Ok, "by timer threads"),
            (signs("#1 SMP PREEMPT_RT", "1", "", true), Mark::Ok, "by version text, /sys/kernel/realtime, timer threads"),
            (signs("#1 SMP PREEMPT_DYNAMIC Debian", "", "CONFIG_PREEMPT=y\n", false), Mark::Warn, "6.1 (PREEMPT_DYNAMIC)"),
            (signs("#1 SMP", "0", "", false), Mark::Warn, "preemption unknown"),
        ];
        for (signs, mark, part) in table {
            let finding = judge_flavour("6.1", &signs);
            assert!(finding.mark == mark && finding.found.contains(part), "{signs:?}: {finding:?}");
        }
    }

    #[test]
    fn throttling_is_a_share_of_a_period() {
        let table = [
            (Some(950_000.0), Some(1.0e6), Mark::Ok, "95 % of 1.0 s"),
            (Some(-1.0), Some(1.0e6), Mark::Ok, "off"),
            (Some(500_000.0), Some(1.0e6), Mark::Warn, "50 % of 1.0 s"),
            (None, None, Mark::Ok, "unknown"),
        ];
        for (runtime_us, period_us, mark, part) in table {
            let finding = judge_throttling(runtime_us, period_us);
            assert!(finding.mark == mark && finding.found.contains(part), "{finding:?}");
        }
    }

    #[test]
    fn an_isolated_cpu_is_named_as_the_host_wants_it() {
        for (isolated, tickless, found, advice) in [
            ("2-3", "3", "2-3, without a scheduling tick: 3", "--cpu 3"),
            ("3", "(null)", "without a scheduling tick: none", "--cpu 3"),
            ("", "", "none", "isolcpus"),
        ] {
            let finding = judge_isolation(isolated, tickless);
            assert!(finding.found.contains(found) && finding.advice.as_deref().unwrap().contains(advice), "{finding:?}");
        }
    }
}

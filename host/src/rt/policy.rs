//! What the process asks of the system so that the loop runs when it should; one of two files with `unsafe`.
//!
//! Asked for, in this order: the real-time class (`SCHED_FIFO`), locked memory, a CPU of its own, no deep CPU sleep. Under
//! [`RtPolicy::Enforce`] a refusal of the first three ends the start with the missing right and what to do about it; under
//! [`RtPolicy::Ignore`] the loop runs with what it got and the [`RtReport`] says so. The last, `/dev/cpu_dma_latency`, is often absent
//! (containers, virtual machines) and only ever reported.
//!
//! Signals are part of it: blocked in every thread and taken by one that waits for them, they cannot cut into a tick.

use std::fs::{File, OpenOptions};
use std::hint::black_box;
use std::io::Write;
use std::mem::MaybeUninit;

use haptor_wire::RtReport;
use rustix::io::Errno;
use rustix::mm::MlockAllFlags;
use rustix::thread::CpuSet;

/// Priority under `SCHED_FIFO`, 1 to 99: above the threads that serve interrupts (50 on a PREEMPT_RT kernel), below the kernel's
/// watchdogs and migration (99).
pub const FIFO_PRIORITY: i32 = 80;

/// Bytes of stack touched before the loop: many times what a tick uses, so that none of its pages is missing later.
const PREFAULT_STACK_BYTES: usize = 256 * 1024;

/// Where the kernel takes the longest CPU wake-up one accepts; the request lasts while the file is open.
const DMA_LATENCY: &str = "/dev/cpu_dma_latency";

/// What to do when the system refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RtPolicy {
    /// Do not start.
    Enforce,
    /// Run with what there is and say so.
    Ignore,
}

/// What is asked of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Right {
    /// The real-time class.
    Fifo,
    /// Locked memory.
    Lock,
    /// A CPU of its own.
    Pin,
    /// No deep CPU sleep.
    Awake,
}

/// A right that [`RtPolicy::Enforce`] needs and the system refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("real-time start refused: {what} ({reason}). {remedy} Or run with --rt ignore, without promises about time")]
pub struct MissingRight {
    /// What was asked for.
    pub what: String,
    /// The system's reason.
    pub reason: Errno,
    /// What to do about it.
    pub remedy: &'static str,
}

const FIFO_REMEDY: &str = "Add `@realtime - rtprio 90` to /etc/security/limits.conf, join the group and log in again, \
    or `sudo setcap cap_sys_nice,cap_ipc_lock+ep` on the program.";
const LOCK_REMEDY: &str = "Add `@realtime - memlock unlimited` to /etc/security/limits.conf, join the group and log in again, \
    or `sudo setcap cap_sys_nice,cap_ipc_lock+ep` on the program.";
const PIN_REMEDY: &str = "Choose a CPU that exists and that this process may use (`taskset -p $$`).";

/// What was obtained, and what must stay open for it to last.
#[derive(Debug, Default)]
pub struct Obtained {
    /// For the summary.
    pub report: RtReport,
    dma_latency: Option<File>,
}

/// Applies the policy to the calling thread (and locks the memory of the process), but for what is in `without`. Call it last before
/// the loop: memory that is mapped later is not locked, because a limit on locked memory would then make other threads' allocations
/// fail.
///
/// # Errors
/// Under [`RtPolicy::Enforce`] the first [`MissingRight`]; under [`RtPolicy::Ignore`] none.
pub fn apply(policy: RtPolicy, cpu: Option<usize>, without: &[Right]) -> Result<Obtained, MissingRight> {
    let mut obtained = Obtained::default();
    let report = &mut obtained.report;
    prefault_stack();
    let wanted = |right| !without.contains(&right);
    if wanted(Right::Fifo) {
        report.fifo = granted(policy, set_fifo(), || format!("SCHED_FIFO priority {FIFO_PRIORITY}"), FIFO_REMEDY)?;
    }
    if wanted(Right::Lock) {
        report.locked = granted(policy, lock_memory(), || "locked memory".into(), LOCK_REMEDY)?;
    }
    let own = cpu.or_else(|| report.fifo.then(last_allowed_cpu).flatten());
    if let Some(cpu) = own.filter(|_| wanted(Right::Pin)) {
        report.pinned = granted(policy, pin(cpu), || format!("CPU {cpu} for the real-time thread"), PIN_REMEDY)?;
    }
    obtained.dma_latency = wanted(Right::Awake).then(hold_dma_latency).flatten();
    report.dma_latency = obtained.dma_latency.is_some();
    Ok(obtained)
}

/// Whether the system granted it; a refusal is an error under [`RtPolicy::Enforce`].
fn granted(
    policy: RtPolicy,
    result: Result<(), Errno>,
    what: impl FnOnce() -> String,
    remedy: &'static str,
) -> Result<bool, MissingRight> {
    match (result, policy) {
        (Ok(()), _) => Ok(true),
        (Err(_), RtPolicy::Ignore) => Ok(false),
        (Err(reason), RtPolicy::Enforce) => Err(MissingRight { what: what(), reason, remedy }),
    }
}

/// Writes to every page of the stack the loop may come to use.
#[inline(never)]
fn prefault_stack() {
    let mut pages = [0_u8; PREFAULT_STACK_BYTES];
    black_box(&mut pages);
}

fn set_fifo() -> Result<(), Errno> {
    let param = libc::sched_param { sched_priority: FIFO_PRIORITY };
    // SAFETY: 0 names the calling thread; `param` lives through the call, which only reads it
    let result = unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const param) };
    if result == 0 { Ok(()) } else { Err(last_errno()) }
}

fn lock_memory() -> Result<(), Errno> {
    rustix::mm::mlockall(MlockAllFlags::CURRENT)
}

fn last_errno() -> Errno {
    Errno::from_io_error(&std::io::Error::last_os_error()).unwrap_or(Errno::PERM)
}

/// A thread of the real-time class alone on the last CPU: interrupts and other programs gather on the first. A thread without the
/// class is not pinned unasked, it would only lose the choice of an idle CPU.
fn last_allowed_cpu() -> Option<usize> {
    let allowed = rustix::thread::sched_getaffinity(None).ok()?;
    (0..CpuSet::MAX_CPU).rev().find(|&cpu| allowed.is_set(cpu))
}

fn pin(cpu: usize) -> Result<(), Errno> {
    if cpu >= CpuSet::MAX_CPU {
        return Err(Errno::INVAL);
    }
    let mut set = CpuSet::new();
    set.set(cpu);
    rustix::thread::sched_setaffinity(None, &set)
}

fn hold_dma_latency() -> Option<File> {
    let mut file = OpenOptions::new().write(true).open(DMA_LATENCY).ok()?;
    file.write_all(&0_i32.to_ne_bytes()).ok()?;
    Some(file)
}

/// Signals that end a session: the keyboard, a service manager, a terminal that closes.
const ENDING_SIGNALS: [libc::c_int; 3] = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP];

fn ending_signals() -> libc::sigset_t {
    let mut set = MaybeUninit::uninit();
    // SAFETY: sigemptyset initialises the set, sigaddset takes it initialised; the signals exist
    unsafe {
        libc::sigemptyset(set.as_mut_ptr());
        for signal in ENDING_SIGNALS {
            libc::sigaddset(set.as_mut_ptr(), signal);
        }
        set.assume_init()
    }
}

/// Blocks the signals that end a session, in this thread and those it starts from now on.
pub fn block_ending_signals() {
    let set = ending_signals();
    // SAFETY: `set` is initialised and only read; no old mask is asked for
    unsafe { libc::pthread_sigmask(libc::SIG_BLOCK, &raw const set, std::ptr::null_mut()) };
}

/// Waits for one of the blocked signals; false when waiting is impossible.
#[must_use]
pub fn wait_for_ending_signal() -> bool {
    let set = ending_signals();
    let mut signal = 0;
    // SAFETY: `set` is initialised and only read, `signal` is a place for the answer
    unsafe { libc::sigwait(&raw const set, &raw mut signal) == 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignore_always_starts_and_reports() {
        let obtained = std::thread::spawn(|| apply(RtPolicy::Ignore, Some(CpuSet::MAX_CPU), &[])).join().unwrap().unwrap();
        assert!(!obtained.report.pinned);
    }

    #[test]
    fn what_is_not_wanted_is_not_asked_for() {
        let all = [Right::Fifo, Right::Lock, Right::Pin, Right::Awake];
        let asked = std::thread::spawn(move || apply(RtPolicy::Enforce, Some(CpuSet::MAX_CPU), &all)).join().unwrap();
        assert_eq!(asked.unwrap().report, RtReport::default());
    }

    #[test]
    fn enforce_names_what_is_missing_and_what_to_do() {
        let asked = std::thread::spawn(|| apply(RtPolicy::Enforce, Some(CpuSet::MAX_CPU), &[])).join().unwrap();
        let text = asked.unwrap_err().to_string();
        assert!(text.contains("limits.conf") || text.contains("taskset"), "{text}");
        assert!(text.contains("--rt ignore"), "{text}");
    }
}

//! Time for the loop: nanoseconds that never run backwards, and sleep until a point in time.
//!
//! Absolute sleeps, so that a late tick does not push all later ones back. Behind a trait because sessions in tests run on a
//! clock of their own, as fast as the machine can.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

const NS_PER_S: u64 = 1_000_000_000;

/// A clock the loop runs by.
pub trait Clock {
    /// Nanoseconds since some fixed point.
    fn now_ns(&self) -> u64;

    /// Returns at `time_ns` or as soon after as the system allows; at once when that has passed.
    fn sleep_until_ns(&self, time_ns: u64);
}

/// The system's monotonic clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct Monotonic;

impl Clock for Monotonic {
    fn now_ns(&self) -> u64 {
        let now = clock_gettime(ClockId::Monotonic);
        // since boot: neither part is negative
        now.tv_sec as u64 * NS_PER_S + now.tv_nsec as u64
    }

    fn sleep_until_ns(&self, time_ns: u64) {
        let until = Timespec { tv_sec: (time_ns / NS_PER_S) as i64, tv_nsec: (time_ns % NS_PER_S) as i64 };
        // a signal may cut it short; any other refusal would come back at once for ever, so it is not retried
        while clock_nanosleep_absolute(ClockId::Monotonic, &until) == Err(rustix::io::Errno::INTR) {}
    }
}

/// A clock that moves when somebody sleeps on it or advances it. Clones show the same time.
#[derive(Clone, Debug, Default)]
pub struct Virtual {
    now_ns: Arc<AtomicU64>,
}

impl Virtual {
    /// Moves the time on.
    pub fn advance_ns(&self, by_ns: u64) {
        self.now_ns.fetch_add(by_ns, Ordering::Relaxed);
    }
}

impl Clock for Virtual {
    fn now_ns(&self) -> u64 {
        self.now_ns.load(Ordering::Relaxed)
    }

    fn sleep_until_ns(&self, time_ns: u64) {
        self.now_ns.fetch_max(time_ns, Ordering::Relaxed);
    }
}

/// A clock on which every look takes as long, so that what is measured by it is known.
#[cfg(test)]
#[derive(Debug)]
pub struct Steady {
    now_ns: std::cell::Cell<u64>,
    look_ns: u64,
}

#[cfg(test)]
impl Steady {
    /// From zero; a look takes so long.
    pub const fn new(look_ns: u64) -> Self {
        Self { now_ns: std::cell::Cell::new(0), look_ns }
    }
}

#[cfg(test)]
impl Clock for Steady {
    fn now_ns(&self) -> u64 {
        self.now_ns.replace(self.now_ns.get() + self.look_ns)
    }

    fn sleep_until_ns(&self, _: u64) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_clock_runs_backwards_and_none_wakes_early() {
        let clocks: [&dyn Clock; 2] = [&Monotonic, &Virtual::default()];
        for clock in clocks {
            let until = clock.now_ns() + 200_000;
            clock.sleep_until_ns(until);
            let woke = clock.now_ns();
            assert!(woke >= until);
            clock.sleep_until_ns(until - 100_000);
            assert!(clock.now_ns() >= woke);
        }
    }
}

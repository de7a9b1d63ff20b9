//! Turns of a given length, by absolute sleeps.

use std::io;

use rustix::io::Errno;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

/// Lateness that is caught up by turns without sleep [ns]: three of 1 ms. Beyond it the device's time stands still instead: hardware
/// does not stop when a computer is busy, and a burst of old reports would be the simulator's fault and not the device's.
const CATCH_UP_NS: i64 = 3_000_000;

/// When the next turn begins.
#[derive(Debug)]
pub struct Clock {
    start_ns: i64,
    next_ns: i64,
    turns: u64,
    stood_still: u64,
}

impl Clock {
    /// The turn before the first begins now.
    pub fn start() -> Self {
        Self { start_ns: now_ns(), next_ns: now_ns(), turns: 0, stood_still: 0 }
    }

    /// Time since the start \[s\].
    pub fn elapsed_s(&self) -> f64 {
        (now_ns() - self.start_ns) as f64 * 1e-9
    }

    /// Turns so far.
    pub fn turns(&self) -> u64 {
        self.turns
    }

    /// Times it was too late to catch up.
    pub fn stood_still(&self) -> u64 {
        self.stood_still
    }

    /// Sleeps until the next turn begins, one length after the last.
    pub fn wait(&mut self, turn_us: u32) -> io::Result<()> {
        self.next_ns += i64::from(turn_us) * 1000;
        self.turns += 1;
        let now = now_ns();
        if now - self.next_ns > CATCH_UP_NS {
            self.next_ns = now;
            self.stood_still += 1;
        }
        let until = Timespec { tv_sec: self.next_ns / 1_000_000_000, tv_nsec: self.next_ns % 1_000_000_000 };
        loop {
            match clock_nanosleep_absolute(ClockId::Monotonic, &until) {
                Ok(()) => return Ok(()),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}

fn now_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

//! When ticks begin and until when their command counts as in time.
//!
//! Paced by the **clock**, tick k is due at a fixed time; the thread sleeps until then, and a pose that has not come by half the
//! period is not waited for. Paced by the **device**, a tick begins when a pose arrives, but not sooner than half a period after the one before: the
//! core counts in periods, and a device that floods must not keep the thread from sleeping; when none has come for a period and a
//! half, the tick begins without one. Either way a tick is in time when its command leaves within a period of when it was due.

use super::clock::Clock;

/// What ticks follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// The host's clock.
    Clock,
    /// The device's reports.
    Device,
}

/// One tick's times. All in nanoseconds of the loop's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Periods since the pace began; the number of this tick.
    pub tick: u64,
    /// Periods that went by without a tick, since the tick before.
    pub slept_through: u64,
    /// How late the thread was \[ns\].
    pub wake_ns: u64,
    /// Until when to wait for a pose.
    pub receive_until_ns: u64,
    /// Until when the command must have left.
    pub deadline_ns: u64,
}

/// The pace of a loop.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    follow: Follow,
    period_ns: u64,
    /// When the next tick is due.
    due_ns: u64,
    tick: u64,
}

impl Pace {
    /// Begins now: the first tick is due at once.
    pub fn new(follow: Follow, period_ns: u64, clock: &impl Clock) -> Self {
        Self { follow, period_ns, due_ns: clock.now_ns(), tick: 0 }
    }

    /// Number of the next tick: periods since the pace began.
    #[must_use]
    pub const fn tick(&self) -> u64 {
        self.tick
    }

    /// Waits for the next tick; paced by the device it begins as soon as a pose may count, and [`Self::arrived`] completes its times.
    pub fn begin(&mut self, clock: &impl Clock) -> Slot {
        match self.follow {
            Follow::Clock => {
                clock.sleep_until_ns(self.due_ns);
                let slot = self.slot(clock.now_ns());
                Slot { receive_until_ns: slot.deadline_ns - self.period_ns / 2, ..slot }
            }
            Follow::Device => {
                clock.sleep_until_ns(self.due_ns.saturating_sub(self.period_ns / 2));
                let receive_until_ns = self.due_ns + self.period_ns / 2;
                Slot {
                    tick: self.tick,
                    slept_through: 0,
                    wake_ns: 0,
                    receive_until_ns,
                    deadline_ns: receive_until_ns + self.period_ns,
                }
            }
        }
    }

    /// A pose has come, or has not come in time.
    pub fn arrived(&mut self, slot: Slot, clock: &impl Clock) -> Slot {
        match self.follow {
            Follow::Clock => slot,
            Follow::Device => {
                let now_ns = clock.now_ns();
                let slot = self.slot(now_ns);
                // the next report is expected a period from this one, not from when this one should have come
                self.due_ns = now_ns + self.period_ns;
                Slot { deadline_ns: now_ns + self.period_ns, ..slot }
            }
        }
    }

    /// Takes the tick that is due, and those that went by.
    fn slot(&mut self, now_ns: u64) -> Slot {
        let wake_ns = now_ns.saturating_sub(self.due_ns);
        let slept_through = wake_ns / self.period_ns;
        let due_ns = self.due_ns + slept_through * self.period_ns;
        let tick = self.tick + slept_through;
        self.tick = tick + 1;
        self.due_ns = due_ns + self.period_ns;
        Slot { tick, slept_through, wake_ns, receive_until_ns: now_ns, deadline_ns: self.due_ns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rt::clock::Virtual;

    const MS: u64 = 1_000_000;

    #[test]
    fn the_clock_s_ticks_keep_their_times_whatever_a_tick_takes() {
        let clock = Virtual::default();
        let mut pace = Pace::new(Follow::Clock, MS, &clock);
        // (what the tick before took, expected tick, periods slept through, lateness, deadline)
        let table = [
            (0, 0, 0, 0, MS),
            (300_000, 1, 0, 0, 2 * MS),
            (1_200_000, 2, 0, 200_000, 3 * MS),
            (5_000_000, 7, 4, 4_200_000, 8 * MS),
        ];
        for (took, tick, slept_through, wake_ns, deadline_ns) in table {
            clock.advance_ns(took);
            let slot = pace.begin(&clock);
            let expected = Slot { tick, slept_through, wake_ns, receive_until_ns: deadline_ns - MS / 2, deadline_ns };
            assert_eq!(slot, expected);
            assert_eq!(pace.arrived(slot, &clock), slot);
        }
    }

    #[test]
    fn the_device_s_ticks_follow_the_poses() {
        let clock = Virtual::default();
        let mut pace = Pace::new(Follow::Device, MS, &clock);
        for tick in 0..3 {
            let slot = pace.begin(&clock);
            assert_eq!(slot.receive_until_ns, clock.now_ns() + if tick == 0 { MS / 2 } else { MS });
            clock.advance_ns(if tick == 0 { 1_100_000 } else { 600_000 });
            let slot = pace.arrived(slot, &clock);
            assert_eq!((slot.tick, slot.deadline_ns), (if tick == 0 { 1 } else { tick + 1 }, clock.now_ns() + MS));
        }
    }

    #[test]
    fn a_device_that_floods_gets_no_more_than_two_ticks_a_period() {
        let clock = Virtual::default();
        let mut pace = Pace::new(Follow::Device, MS, &clock);
        for _ in 0..21 {
            let slot = pace.begin(&clock);
            // a pose is always there
            pace.arrived(slot, &clock);
        }
        assert_eq!((clock.now_ns(), pace.tick()), (10 * MS, 21));
    }
}

//! How many ticks were in time, and what share is good enough.
//!
//! A tick is **in time** when its command left before its period ended. A period that the thread slept through is a late tick as
//! well. The marks are libfranka's (`communication_test`): above 0.95 good, below 0.90 unfit.

use super::scale::ticks_at;

/// Share of ticks in time below which a session ends with a warning.
pub const WARN_SHARE: f64 = 0.95;

/// Share of ticks in time below which a session counts as failed.
pub const REFUSE_SHARE: f64 = 0.90;

/// Ticks run one after another, all late, that mean the machine cannot keep up, at the default rate ([`super::scale`]); libfranka
/// stops a robot after as many lost commands. A stall, however long, is one late wake-up: the device's watchdog judges that.
pub const OVERRUN_TICKS: u32 = 20;

/// What the marks say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// At or above [`WARN_SHARE`].
    Good,
    /// Between the marks.
    Warn,
    /// Below [`REFUSE_SHARE`].
    Refuse,
}

/// Ticks of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Ticks whose command left in time.
    pub in_time: u64,
    /// Ticks whose command did not, slept-through periods included.
    pub late: u64,
    late_in_a_row: u32,
    /// Late ticks in a row that are too many.
    overrun_after: u32,
}

impl Budget {
    /// Empty, at so many ticks a second.
    #[must_use]
    pub const fn new(rate_hz: u32) -> Self {
        Self { in_time: 0, late: 0, late_in_a_row: 0, overrun_after: ticks_at(rate_hz, OVERRUN_TICKS) }
    }

    /// Counts a tick that ran, and the periods slept through before it.
    pub fn count(&mut self, in_time: bool, slept_through: u64) {
        self.late += slept_through + u64::from(!in_time);
        self.in_time += u64::from(in_time);
        self.late_in_a_row = if in_time { 0 } else { self.late_in_a_row.saturating_add(1) };
    }

    /// All ticks.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.in_time + self.late
    }

    /// Share of ticks in time, 0 to 1; 1 before the first.
    #[must_use]
    pub fn share(&self) -> f64 {
        if self.ticks() == 0 { 1.0 } else { self.in_time as f64 / self.ticks() as f64 }
    }

    /// What the marks say of the share.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        verdict(self.share())
    }

    /// True while the last ticks, [`OVERRUN_TICKS`] at the default rate or more, were all late.
    #[must_use]
    pub const fn overrun(&self) -> bool {
        self.late_in_a_row >= self.overrun_after
    }
}

/// What the marks say of a share of ticks in time.
#[must_use]
pub fn verdict(share: f64) -> Verdict {
    match share {
        s if s >= WARN_SHARE => Verdict::Good,
        s if s >= REFUSE_SHARE => Verdict::Warn,
        _ => Verdict::Refuse,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_marks() {
        let table = [
            (100, 0, Verdict::Good),
            (95, 5, Verdict::Good),
            (94, 6, Verdict::Warn),
            (90, 10, Verdict::Warn),
            (89, 11, Verdict::Refuse),
        ];
        for (in_time, late, expected) in table {
            assert_eq!(Budget { in_time, late, ..Budget::new(1000) }.verdict(), expected, "{in_time} of 100");
        }
        assert_eq!(Budget::new(1000).verdict(), Verdict::Good);
    }

    #[test]
    fn a_stall_is_many_late_ticks_but_no_overrun() {
        let mut budget = Budget::new(1000);
        budget.count(false, 500);
        assert_eq!((budget.late, budget.overrun()), (501, false));
        (1..OVERRUN_TICKS).for_each(|_| budget.count(false, 0));
        assert!(budget.overrun());
        budget.count(true, 0);
        assert!(!budget.overrun());
        let mut fast = Budget::new(8000);
        (1..8 * OVERRUN_TICKS).for_each(|_| fast.count(false, 0));
        assert!(!fast.overrun(), "the same time, not the same count");
        fast.count(false, 0);
        assert!(fast.overrun());
    }
}

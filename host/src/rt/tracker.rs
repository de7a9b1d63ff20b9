//! Which pose reports are news: each number once, in order, gaps counted; and each pose once, by the time it was taken.

/// Reports back in count that still pass for late or repeated. A device that begins its count anew is further back than this
/// unless it had only just begun; then its mode tells.
const REORDER_WINDOW: u32 = 64;

/// What a report's number says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Newer than all before; so many between them never came (yet).
    New {
        /// Numbers left out.
        lost: u32,
    },
    /// Already seen, or older than the newest.
    Old,
    /// A new number on a pose that was there before: what talks to the host lives, what reads the sensors does not.
    Stuck {
        /// Numbers left out.
        lost: u32,
    },
    /// The count began anew.
    Restarted,
}

/// The newest report seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracker {
    newest: Option<u32>,
    /// When the newest pose was taken [us of the device's clock].
    taken_us: Option<u32>,
}

/// How far `new` is ahead of `old`, both of which wrap; `None` = it is not.
fn ahead(new: u32, old: u32) -> Option<u32> {
    let by = new.wrapping_sub(old);
    (by != 0 && by <= u32::MAX / 2).then_some(by)
}

impl Tracker {
    /// Judges a report's number, and when its pose was taken. Both wrap.
    pub fn judge(&mut self, seq: u32, taken_us: u32) -> Order {
        let before = *self;
        let begun = Self { newest: Some(seq), taken_us: Some(taken_us) };
        let lost = match before.newest.map(|newest| (ahead(seq, newest), newest.wrapping_sub(seq))) {
            None => 0,
            Some((Some(by), _)) => by - 1,
            Some((None, back)) if back <= REORDER_WINDOW => return Order::Old,
            Some((None, _)) => {
                *self = begun;
                return Order::Restarted;
            }
        };
        if before.taken_us.is_some_and(|before_us| ahead(taken_us, before_us).is_none()) {
            self.newest = Some(seq);
            return Order::Stuck { lost };
        }
        *self = begun;
        Order::New { lost }
    }

    /// The device has begun a session: its clock may stand anywhere.
    pub const fn forget_time(&mut self) {
        self.taken_us = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_judged_in_turn() {
        let mut tracker = Tracker::default();
        let table = [
            (100, Order::New { lost: 0 }),
            (101, Order::New { lost: 0 }),
            (101, Order::Old),
            (105, Order::New { lost: 3 }),
            (103, Order::Old),
            (41, Order::Old),
            (40, Order::Restarted),
            (41, Order::New { lost: 0 }),
        ];
        for (k, (seq, expected)) in table.into_iter().enumerate() {
            assert_eq!(tracker.judge(seq, k as u32), expected, "{seq}");
        }
    }

    #[test]
    fn a_pose_is_news_once_whatever_its_number() {
        let mut tracker = Tracker::default();
        let table = [
            (1, 70, Order::New { lost: 0 }),
            (2, 70, Order::Stuck { lost: 0 }),
            (4, 70, Order::Stuck { lost: 1 }),
            (3, 69, Order::Old),
            (5, 71, Order::New { lost: 0 }),
            (6, 70, Order::Stuck { lost: 0 }),
            (7, 71, Order::Stuck { lost: 0 }),
            (8, 0x7000_0000, Order::New { lost: 0 }),
            (9, 0xE000_0000, Order::New { lost: 0 }),
            (10, 5, Order::New { lost: 0 }),
        ];
        for (seq, taken_us, expected) in table {
            assert_eq!(tracker.judge(seq, taken_us), expected, "{seq}");
        }
        tracker.forget_time();
        assert_eq!(tracker.judge(12, 1), Order::New { lost: 1 }, "a clock that was set anew");
    }

    #[test]
    fn numbers_wrap() {
        let mut tracker = Tracker { newest: Some(u32::MAX), taken_us: Some(7) };
        assert_eq!(tracker.judge(1, 8), Order::New { lost: 1 });
        assert_eq!(tracker.judge(u32::MAX, 7), Order::Old);
    }
}

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
    /// A new number on the pose of the report before: what talks to the host lives, what reads the sensors does not.
    Stuck,
    /// The count began anew.
    Restarted,
}

/// The newest report seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracker {
    newest: Option<u32>,
    /// When its pose was taken [us of the device's clock].
    taken_us: u32,
}

impl Tracker {
    /// Judges a report's number, and when its pose was taken. Both wrap.
    pub fn judge(&mut self, seq: u32, taken_us: u32) -> Order {
        let before = std::mem::replace(self, Self { newest: Some(seq), taken_us });
        let Some(newest) = before.newest else { return Order::New { lost: 0 } };
        let ahead = seq.wrapping_sub(newest);
        if ahead != 0 && ahead <= u32::MAX / 2 {
            return if taken_us == before.taken_us { Order::Stuck } else { Order::New { lost: ahead - 1 } };
        }
        if newest.wrapping_sub(seq) <= REORDER_WINDOW {
            *self = before;
            return Order::Old;
        }
        Order::Restarted
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
            (2, 70, Order::Stuck),
            (4, 70, Order::Stuck),
            (3, 69, Order::Old),
            (5, 71, Order::New { lost: 0 }),
        ];
        for (seq, taken_us, expected) in table {
            assert_eq!(tracker.judge(seq, taken_us), expected, "{seq}");
        }
    }

    #[test]
    fn numbers_wrap() {
        let mut tracker = Tracker { newest: Some(u32::MAX), taken_us: 7 };
        assert_eq!(tracker.judge(1, 8), Order::New { lost: 1 });
        assert_eq!(tracker.judge(u32::MAX, 7), Order::Old);
    }
}

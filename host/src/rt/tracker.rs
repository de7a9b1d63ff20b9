//! Which pose reports are news: each number once, in order, gaps counted.

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
    /// The count began anew.
    Restarted,
}

/// The newest number seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracker {
    newest: Option<u32>,
}

impl Tracker {
    /// Judges a report's number. Numbers wrap.
    pub fn judge(&mut self, seq: u32) -> Order {
        let Some(newest) = self.newest else {
            self.newest = Some(seq);
            return Order::New { lost: 0 };
        };
        let ahead = seq.wrapping_sub(newest);
        if ahead != 0 && ahead <= u32::MAX / 2 {
            self.newest = Some(seq);
            return Order::New { lost: ahead - 1 };
        }
        if newest.wrapping_sub(seq) <= REORDER_WINDOW {
            return Order::Old;
        }
        self.newest = Some(seq);
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
        for (seq, expected) in table {
            assert_eq!(tracker.judge(seq), expected, "{seq}");
        }
    }

    #[test]
    fn numbers_wrap() {
        let mut tracker = Tracker { newest: Some(u32::MAX) };
        assert_eq!(tracker.judge(1), Order::New { lost: 1 });
        assert_eq!(tracker.judge(u32::MAX), Order::Old);
    }
}

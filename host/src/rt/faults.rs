//! The latch: the first fault of a session stays its fault, each later one is counted and told.

use haptor_wire::{FaultRecord, HostFault};

/// Faults of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    first: Option<FaultRecord>,
    count: u32,
}

impl Faults {
    /// Latches a fault.
    pub fn latch(&mut self, fault: FaultRecord) {
        self.first.get_or_insert(fault);
        self.count = self.count.saturating_add(1);
    }

    /// The fault of the session.
    #[must_use]
    pub fn cause(&self) -> Option<HostFault> {
        self.first.map(|fault| fault.cause)
    }

    /// Faults so far.
    #[must_use]
    pub const fn count(&self) -> u32 {
        self.count
    }
}

/// What to call it when no usable pose has come for too long.
#[must_use]
pub const fn stale_cause(nonsense: bool, refused: bool) -> HostFault {
    match (nonsense, refused) {
        (true, _) => HostFault::Garbage,
        (false, true) => HostFault::NonFinite,
        (false, false) => HostFault::Stale,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_stays() {
        let mut faults = Faults::default();
        for (tick, cause) in [(7, HostFault::Stale), (9, HostFault::LinkLost)] {
            faults.latch(FaultRecord { cause, tick, after_ticks: 0 });
        }
        assert_eq!((faults.cause(), faults.count()), (Some(HostFault::Stale), 2));
    }
}

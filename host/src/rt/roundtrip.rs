//! How long a command takes to come back: from sending command n to the first report that echoes n or a later one.

use super::histogram::Durations;

/// Commands on their way that are remembered: a quarter of a second at the fastest rate, after which a device counts as silent.
const IN_FLIGHT: usize = 2048;

/// Send time of a command that the link did not take.
const NEVER: u64 = u64::MAX;

/// Send times of the commands not yet echoed.
#[derive(Debug)]
pub struct RoundTrips {
    sent_ns: [u64; IN_FLIGHT],
    newest: u32,
    echoed: u32,
    /// The last one measured \[ns\]; 0 = none since it was asked for.
    last_ns: u32,
    durations: Durations,
}

impl Default for RoundTrips {
    fn default() -> Self {
        Self::new()
    }
}

impl RoundTrips {
    /// None on its way; the first command is number 1.
    #[must_use]
    pub fn new() -> Self {
        Self { sent_ns: [0; IN_FLIGHT], newest: 0, echoed: 0, last_ns: 0, durations: Durations::new() }
    }

    /// Command `seq` was sent; numbers rise, and those left out were never sent.
    pub fn sent(&mut self, seq: u32, now_ns: u64) {
        let left_out = seq.wrapping_sub(self.newest).saturating_sub(1).min(IN_FLIGHT as u32);
        (1..=left_out).for_each(|back| self.sent_ns[seq.wrapping_sub(back) as usize % IN_FLIGHT] = NEVER);
        self.sent_ns[seq as usize % IN_FLIGHT] = now_ns;
        self.newest = seq;
    }

    /// A report came that echoes `echo`. An echo of a number never sent, or seen before, says nothing.
    pub fn echoed(&mut self, echo: u32, now_ns: u64) {
        let waiting = self.newest.wrapping_sub(self.echoed);
        let answered = echo.wrapping_sub(self.echoed);
        if answered == 0 || answered > waiting {
            return;
        }
        // those beyond memory were overwritten: they are not measured
        let forgotten = waiting.saturating_sub(IN_FLIGHT as u32);
        for n in forgotten.min(answered)..answered {
            let seq = self.echoed.wrapping_add(n + 1);
            let sent_ns = self.sent_ns[seq as usize % IN_FLIGHT];
            if sent_ns == NEVER {
                continue;
            }
            let took = now_ns.saturating_sub(sent_ns);
            self.durations.record_ns(took);
            self.last_ns = u32::try_from(took).unwrap_or(u32::MAX);
        }
        self.echoed = echo;
    }

    /// Forgets what is on its way: the link, or the session on it, is new.
    pub fn forget(&mut self) {
        self.echoed = self.newest;
    }

    /// The newest one measured since this was last asked \[ns\]; 0 = none.
    pub fn take_last_ns(&mut self) -> u32 {
        std::mem::take(&mut self.last_ns)
    }

    /// All of the session.
    #[must_use]
    pub const fn durations(&self) -> &Durations {
        &self.durations
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_later_echo_answers_all_before_it() {
        let mut trips = RoundTrips::new();
        (1..=3).for_each(|seq| trips.sent(seq, u64::from(seq) * 100));
        trips.echoed(2, 1000);
        assert_eq!((trips.durations().count(), trips.take_last_ns(), trips.take_last_ns()), (2, 800, 0));
        trips.echoed(2, 1100);
        trips.echoed(4, 1100);
        assert_eq!(trips.durations().count(), 2, "seen before, never sent");
        trips.echoed(3, 1300);
        assert_eq!((trips.durations().count(), trips.take_last_ns()), (3, 1000));
    }

    #[test]
    fn commands_that_were_never_sent_are_not_measured() {
        let mut trips = RoundTrips::new();
        (1..=3000).for_each(|seq| trips.sent(seq, u64::from(seq)));
        trips.echoed(3000, 3000);
        trips.sent(3004, 3004);
        trips.echoed(3004, 3010);
        assert_eq!((trips.durations().count(), trips.take_last_ns()), (IN_FLIGHT as u64 + 1, 6));
    }

    #[test]
    fn commands_beyond_memory_are_not_measured() {
        let mut trips = RoundTrips::new();
        (1..=IN_FLIGHT as u32 + 5).for_each(|seq| trips.sent(seq, 7));
        trips.echoed(IN_FLIGHT as u32 + 5, 10);
        assert_eq!(trips.durations().count(), IN_FLIGHT as u64);
        trips.sent(IN_FLIGHT as u32 + 6, 20);
        trips.forget();
        trips.echoed(IN_FLIGHT as u32 + 6, 30);
        assert_eq!(trips.durations().count(), IN_FLIGHT as u64);
    }
}

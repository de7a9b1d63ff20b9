//! What goes to the device when no fresh wrench does: hold, fade, zero; and when forces may come back.
//!
//! ```text
//!            no pose: hold the last wrench, `hold` ticks; fade it to zero, `fade` ticks; fault
//!   Open ────────────────────────────────────────────────────────────────────────────────► Closed (zero)
//!     ▲                       any other fault: at once                                        │
//!     └──────── the contact's wrench was small in CALM poses in a row ◄───────────────────────┘
//! ```
//! A tick is a period: those that the thread slept through count too, from the first look that found no pose on.
//!
//! The last rule is CHAI3D's (`cGenericTool`, "wait for small force"): after a fault a hand that is deep in the object is not hit by
//! the full force at once, it has to come out first. The fault stays latched for the session's end; only the output opens again.

use haptor_contact::Wrench;

use super::scale::ticks_at;
use haptor_engine::DeviceBase;

// Counts of ticks at the default rate ([`super::scale`]).

/// Ticks without a fresh pose through which the last wrench is repeated: a late or lost report or three is normal on USB and TCP.
pub const HOLD_TICKS: u32 = 4;

/// Ticks over which it then fades to zero: fast enough that 20 ms after the last pose nothing pushes, slow enough for no click.
pub const FADE_TICKS: u32 = 16;

/// How long a wrench outlives the pose it came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StaleRule {
    /// Ticks without a fresh pose through which the last wrench is repeated.
    pub hold: u32,
    /// Ticks over which it then fades to zero, 1 or more.
    pub fade: u32,
    /// Ticks in a row of small wrench before a closed output opens.
    pub calm: u32,
}

impl StaleRule {
    /// The usual rule at so many ticks a second.
    #[must_use]
    pub const fn at(rate_hz: u32) -> Self {
        let [hold, fade, calm] = [HOLD_TICKS, FADE_TICKS, CALM_TICKS];
        Self { hold: ticks_at(rate_hz, hold), fade: ticks_at(rate_hz, fade), calm: ticks_at(rate_hz, calm) }
    }

    /// Ticks from the last fresh pose to zero wrench.
    #[must_use]
    pub const fn zero_after(&self) -> u32 {
        self.hold + self.fade
    }
}

/// Contact force under which the output may open again \[N\]: what a hand barely notices, 1 % of a desktop device's range.
pub const SMALL_FORCE: f32 = 0.1;

/// Contact torque under which the output may open again \[N m\]: likewise.
pub const SMALL_TORQUE: f32 = 0.002;

/// Fresh poses in a row of small wrench before the output opens: longer than a bounce. A pose that is late or lost neither counts nor breaks
/// the row, else forces would stay away on a link that loses one report in a hundred; a silence that would have closed the output breaks it.
pub const CALM_TICKS: u32 = 100;

/// What a tick has to offer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offer {
    /// A wrench from a fresh pose.
    Fresh {
        /// The wrench after the guard.
        wrench: Wrench<DeviceBase>,
        /// The contact's wrench is small.
        small: bool,
    },
    /// No fresh pose.
    Missing,
}

/// What the rule made of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Served {
    /// The fresh wrench.
    Fresh,
    /// The last one, whole or faded.
    Held,
    /// The last one has just faded to zero: the output closes with this tick.
    Expired {
        /// Ticks without a fresh pose, this one among them.
        after_ticks: u32,
    },
    /// Zero: the output is closed.
    Closed,
}

/// The output's state.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    rule: StaleRule,
    open: bool,
    calm: u32,
    missing: u32,
    last: Wrench<DeviceBase>,
}

impl Output {
    /// Closed, as before a session.
    #[must_use]
    pub const fn new(rule: StaleRule) -> Self {
        Self { rule, open: false, calm: 0, missing: 0, last: Wrench::ZERO }
    }

    /// Opens at the start of a session. A start inside the object is the guard's, which ramps the wrench in.
    pub const fn open(&mut self) {
        *self = Self { open: true, ..Self::new(self.rule) };
    }

    /// Closes: from this tick on the wrench is zero.
    pub const fn close(&mut self) {
        *self = Self::new(self.rule);
    }

    /// True while wrenches go out.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.open
    }

    /// The wrench to send in this tick, and why that one; `slept_through` = periods without a tick since the tick before.
    pub fn serve(&mut self, offer: &Offer, slept_through: u64) -> (Wrench<DeviceBase>, Served) {
        if !self.open {
            self.count_calm(offer, slept_through);
            return (Wrench::ZERO, Served::Closed);
        }
        match *offer {
            Offer::Fresh { wrench, .. } => {
                self.missing = 0;
                self.last = wrench;
                (wrench, Served::Fresh)
            }
            Offer::Missing => self.hold_or_fade(slept_through),
        }
    }

    fn hold_or_fade(&mut self, slept_through: u64) -> (Wrench<DeviceBase>, Served) {
        self.count_missing(slept_through);
        if self.missing >= self.rule.zero_after() {
            let after_ticks = self.missing;
            self.close();
            return (Wrench::ZERO, Served::Expired { after_ticks });
        }
        let left = self.rule.zero_after() - self.missing.max(self.rule.hold);
        let share = left as f32 / self.rule.fade as f32;
        (Wrench::new(self.last.force * share, self.last.torque * share), Served::Held)
    }

    fn count_calm(&mut self, offer: &Offer, slept_through: u64) {
        match offer {
            Offer::Fresh { small: true, .. } => (self.calm, self.missing) = (self.calm + 1, 0),
            Offer::Fresh { small: false, .. } => (self.calm, self.missing) = (0, 0),
            Offer::Missing => self.count_missing(slept_through),
        }
        if self.missing >= self.rule.zero_after() {
            self.calm = 0;
        }
        if self.calm >= self.rule.calm {
            self.open();
        }
    }

    fn count_missing(&mut self, slept_through: u64) {
        // a thread that slept before its first look without a pose cannot say that the device was silent meanwhile
        let silent = if self.missing == 0 { 0 } else { u32::try_from(slept_through).unwrap_or(u32::MAX) };
        self.missing = self.missing.saturating_add(1).saturating_add(silent);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_contact::Vec3;

    fn fresh(force: f32) -> Offer {
        Offer::Fresh { wrench: Wrench::new(Vec3::new(0.0, 0.0, force), Vec3::ZERO), small: force < SMALL_FORCE }
    }

    fn opened() -> Output {
        let mut output = Output::new(StaleRule::at(1000));
        output.open();
        output
    }

    #[test]
    fn hold_then_fade_then_zero_and_closed() {
        let mut output = opened();
        assert_eq!(output.serve(&fresh(8.0), 0).1, Served::Fresh);
        let served: Vec<_> = (0..HOLD_TICKS + FADE_TICKS).map(|_| output.serve(&Offer::Missing, 0)).collect();
        let force: Vec<f32> = served.iter().map(|(wrench, _)| wrench.force.z).collect();
        assert_eq!(force[..4], [8.0; 4]);
        assert_eq!(force[4..], (0..16).rev().map(|i| i as f32 * 0.5).collect::<Vec<_>>());
        assert_eq!(served.last().unwrap().1, Served::Expired { after_ticks: 20 });
        assert_eq!(output.serve(&fresh(8.0), 0), (Wrench::ZERO, Served::Closed));
    }

    #[test]
    fn the_shortest_rule_is_zero_at_the_second_tick() {
        let mut output = Output::new(StaleRule { hold: 1, fade: 1, calm: CALM_TICKS });
        output.open();
        output.serve(&fresh(8.0), 0);
        assert_eq!(output.serve(&Offer::Missing, 0).0.force.z.to_bits(), 8.0_f32.to_bits());
        assert_eq!(output.serve(&Offer::Missing, 0), (Wrench::ZERO, Served::Expired { after_ticks: 2 }));
    }

    #[test]
    fn periods_slept_through_count_once_the_device_is_known_to_be_silent() {
        let mut output = opened();
        output.serve(&fresh(8.0), 0);
        // slept for long, then nothing there: the device may have been about to speak
        assert_eq!(output.serve(&Offer::Missing, 1_000).1, Served::Held);
        // 1 + 1 + 9 of 20 gone, 4 of them the hold's: 9 of 16 are left
        assert_eq!(output.serve(&Offer::Missing, 9).0.force.z.to_bits(), (8.0_f32 * 9.0 / 16.0).to_bits());
        assert_eq!(output.serve(&Offer::Missing, u64::MAX), (Wrench::ZERO, Served::Expired { after_ticks: u32::MAX }));
        output.open();
        output.serve(&fresh(8.0), 1_000);
        assert_eq!(output.serve(&Offer::Missing, 0).1, Served::Held, "a pose makes all of it good");
    }

    #[test]
    fn a_pose_in_time_starts_the_hold_anew() {
        let mut output = opened();
        for _ in 0..100 {
            output.serve(&fresh(2.0), 0);
            for _ in 1..HOLD_TICKS + FADE_TICKS {
                assert_eq!(output.serve(&Offer::Missing, 0).1, Served::Held);
            }
        }
    }

    #[test]
    fn only_calm_in_a_row_opens_again() {
        let silence = vec![Offer::Missing; (HOLD_TICKS + FADE_TICKS) as usize];
        for interruption in [vec![fresh(5.0)], silence] {
            let mut output = opened();
            output.close();
            (1..CALM_TICKS).for_each(|_| assert_eq!(output.serve(&fresh(0.0), 0).1, Served::Closed));
            interruption.iter().for_each(|offer| assert_eq!(output.serve(offer, 0).1, Served::Closed));
            (0..CALM_TICKS).for_each(|_| assert_eq!(output.serve(&fresh(0.05), 0).1, Served::Closed));
            assert!(output.is_open());
            assert_eq!(output.serve(&fresh(1.0), 0).1, Served::Fresh);
        }
    }

    #[test]
    fn poses_that_are_lost_now_and_then_do_not_keep_forces_away() {
        let mut output = opened();
        output.close();
        for _ in 0..CALM_TICKS {
            assert_eq!(output.serve(&Offer::Missing, 3).1, Served::Closed);
            assert_eq!(output.serve(&fresh(0.05), 0).1, Served::Closed);
        }
        assert!(output.is_open());
    }
}

//! Counts of ticks that stand for a time, at any rate.
//!
//! They are chosen at the default rate. Above it they stand for the same time: a hand, an operating system and a cable get no faster because ticks are shorter.
//! Below it they stay the same count: what matters there is how many reports are missing.

/// The rate at which counts of ticks are chosen \[Hz\].
pub const REFERENCE_HZ: u32 = 1000;

/// What `ticks` at [`REFERENCE_HZ`] become at `rate_hz`.
#[must_use]
pub const fn ticks_at(rate_hz: u32, ticks: u32) -> u32 {
    if rate_hz <= REFERENCE_HZ {
        return ticks;
    }
    // rates go to 8 kHz and counts to some thousands: no overflow
    (ticks * rate_hz).div_ceil(REFERENCE_HZ)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn above_the_reference_a_time_below_it_a_count() {
        for (rate_hz, ticks, expected) in [(100, 20, 20), (1000, 20, 20), (1500, 1, 2), (4000, 4, 16), (8000, 4096, 32_768)] {
            assert_eq!(ticks_at(rate_hz, ticks), expected, "{ticks} at {rate_hz} Hz");
        }
    }
}

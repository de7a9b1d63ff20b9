//! A search for the share at which a difference that only grows changes its sign, where each trial also yields a point: the **lead**. On smooth parts it is continuous and
//! secants find its zero; where a flat lies on the normal it jumps, and the trials on both sides are what is looked for.

use crate::math::{clamp, max};

/// One trial.
#[derive(Clone, Copy, Debug)]
struct End<T> {
    at: f32,
    /// Of this sign; less than what was seen where the other end stands still (Illinois).
    lead: f32,
    seen: T,
}

/// The bracket of a share.
#[derive(Clone, Copy, Debug)]
pub struct Share<T> {
    low: f32,
    high: f32,
    before: Option<End<T>>,
    after: Option<End<T>>,
    /// The last trial led.
    led: Option<bool>,
}

/// How near an end of the bracket a secant may come, as a share of it.
const MARGIN: f32 = 0.01;

/// The same of a first guess.
const FIRST_MARGIN: f32 = 0.1;

/// Secants that place a tie, at most, whose values cost no trial.
const TIE_STEPS: usize = 16;

/// Two places of a tie that are as good as one: flats of 40 mm lean by less than a micrometre.
const NARROW: f32 = 1.0e-6;

impl<T: Copy> Share<T> {
    /// Between two shares.
    pub fn new(low: f32, high: f32) -> Self {
        Self { low, high, before: None, after: None, led: None }
    }

    /// Where the secant of the two ends vanishes; the guess until there are two.
    pub fn next(&self, guess: f32) -> f32 {
        let width = self.high - self.low;
        let kept = |at: f32, margin: f32| clamp(at, self.low + margin * width, self.high - margin * width);
        self.secant().map_or_else(|| kept(guess, FIRST_MARGIN), |at| kept(at, MARGIN))
    }

    /// Where the secant of the two ends vanishes, when there are both.
    fn secant(&self) -> Option<f32> {
        let (before, after) = (self.before?, self.after?);
        Some(before.at - before.lead * (after.at - before.at) / max(after.lead - before.lead, f32::MIN_POSITIVE))
    }

    /// Middle of the bracket.
    pub fn middle(&self) -> f32 {
        0.5 * (self.low + self.high)
    }

    /// The trials before and after the change of sign, when there are both.
    pub fn ends(&self) -> Option<(T, T)> {
        Some((self.before?.seen, self.after?.seen))
    }

    /// Where a difference of values that falls from the first end to the last is even, when there are both ends.
    pub fn tie(&self, difference: impl Fn(f32) -> f32) -> Option<f32> {
        self.ends()?;
        let mut tie = Share::new(self.low, self.high);
        tie.take(self.low, -difference(self.low), ());
        tie.take(self.high, -difference(self.high), ());
        tie.ends()?;
        let mut at = tie.next(self.low);
        for _ in 0..TIE_STEPS {
            tie.take(at, -difference(at), ());
            let last = at;
            at = tie.secant().unwrap_or(last);
            if (at - last).abs() <= NARROW {
                break;
            }
        }
        Some(at)
    }

    /// Takes what was seen at a share into the bracket.
    pub fn take(&mut self, at: f32, lead: f32, seen: T) {
        let (end, led) = (Some(End { at, lead, seen }), lead > 0.0);
        let again = self.led == Some(led);
        let (moved, still) = if led { (&mut self.after, &mut self.before) } else { (&mut self.before, &mut self.after) };
        *moved = end;
        if let Some(still) = still.as_mut().filter(|_| again) {
            still.lead *= 0.5;
        }
        let bound = if led { &mut self.high } else { &mut self.low };
        *bound = at;
        self.led = Some(led);
    }
}

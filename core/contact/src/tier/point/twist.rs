//! The share of T_max that a patch holds over x = K_theta phi / T_max, and the way back (theory.md, equation 6.2).
//!
//! Each of three profiles has a closed curve with a closed inverse; between two of them the curve is linear in the fullness. Its inverse starts from a guess
//! between theirs and takes one or two steps of third order, inside a bracket that theirs make.
//!
//! Rest: what a twist leaves of the capacity, 1 - T/T_max.

use crate::math::{clamp, exp, ln, max, min, root};
use crate::profile::{FULLNESS_CONE, FULLNESS_HERTZ, FULLNESS_PUNCH};

/// Twist, in units of T_max / K_theta, beyond which nothing is left to slip: 4e-6 for the cone, less than f32 can tell for the others.
pub const REACH: f32 = 24.0;

/// Rest below which a share counts as full.
const LEAST_REST: f32 = 1.0e-9;

/// The curve of a profile: x up to the first slip, then the rest falls as (1 - `first`) exp[-z (k + a z)/(1 + c z)] with z = x - `first`.
#[derive(Debug)]
struct Fit {
    first: f32,
    /// ln(1 - `first`).
    ease: f32,
    k: f32,
    a: f32,
    c: f32,
}

/// 2.1e-4 of T_max.
const CONE: Fit = Fit { first: 0.0, ease: 0.0, k: 1.0, a: 0.053_906, c: 0.141_638 };

/// Lubkin's curve, 2.6e-4 of T_max.
const HERTZ: Fit = Fit { first: 0.0, ease: 0.0, k: 1.0, a: 0.1029, c: 0.0427 };

/// No slip up to `first`, then 6e-6 of T_max.
const PUNCH: Fit = Fit { first: 0.848_848, ease: -1.889_469_3, k: 6.618, a: 6.137, c: 1.162 };

impl Fit {
    fn share(&self, x: f32) -> f32 {
        if x <= self.first {
            return x;
        }
        let z = x - self.first;
        1.0 - (1.0 - self.first) * exp(-z * (self.k + self.a * z) / (1.0 + self.c * z))
    }

    /// Where the curve leaves `left`: a quadratic in z.
    fn inverse(&self, left: Left) -> f32 {
        let y = left.depth + self.ease;
        if y <= 0.0 {
            return 1.0 - left.rest;
        }
        let b = self.k - self.c * y;
        min(self.first + 2.0 * y / (b + root(b * b + 4.0 * self.a * y)), REACH)
    }

    /// The rest at `x` over the rest `left`, how fast it falls with x, and its second derivative. None is larger than 1e12, as `left` is no less than [`LEAST_REST`].
    fn falls(&self, x: f32, left: Left) -> (f32, f32, f32) {
        let z = x - self.first;
        if z <= 0.0 {
            let unit = 1.0 / left.rest;
            return ((1.0 - x) * unit, unit, 0.0);
        }
        let i = 1.0 / (1.0 + self.c * z);
        let slope = (self.k + self.a * z * (2.0 + self.c * z)) * i * i;
        let rest = exp(left.depth + self.ease - z * (self.k + self.a * z) * i);
        (rest, rest * slope, rest * (slope * slope - 2.0 * (self.a - self.c * self.k) * i * i * i))
    }
}

/// A rest and minus its logarithm.
#[derive(Clone, Copy, Debug)]
struct Left {
    rest: f32,
    depth: f32,
}

/// Two profiles and the fullnesses between.
#[derive(Debug)]
struct Span {
    slack: Fit,
    full: Fit,
    from: f32,
    to: f32,
    /// How the guess bends away from a line between the two inverses: over the depth of the rest, and over its square. Fitted to the least error.
    bend: [f32; 2],
    /// Steps of the inverse that bring it to 1e-6 of T_max or f32's own grain.
    steps: usize,
}

/// A guess within 1.3e-3 of T_max.
const CONE_TO_HERTZ: Span =
    Span { slack: CONE, full: HERTZ, from: FULLNESS_CONE, to: FULLNESS_HERTZ, bend: [-0.265, 0.08], steps: 1 };

/// A guess within 2.6e-2 of T_max: the punch's curve has a corner in its second derivative.
const HERTZ_TO_PUNCH: Span =
    Span { slack: HERTZ, full: PUNCH, from: FULLNESS_HERTZ, to: FULLNESS_PUNCH, bend: [-0.95, 0.35], steps: 2 };

impl Span {
    /// The span around `fullness`, and how far along it that is, 0 to 1.
    fn around(fullness: f32) -> (&'static Self, f32) {
        let span = if fullness <= FULLNESS_HERTZ { &CONE_TO_HERTZ } else { &HERTZ_TO_PUNCH };
        (span, clamp((fullness - span.from) / (span.to - span.from), 0.0, 1.0))
    }

    /// Where the curve `blend` of the way along leaves `left`.
    fn inverse(&self, blend: f32, left: Left) -> f32 {
        // at the same rest the fuller profile has turned less
        let (near, far) = (self.full.inverse(left), self.slack.inverse(left));
        let bend = 1.0 + (1.0 - blend) * left.depth * (self.bend[0] + self.bend[1] * left.depth);
        let mut x = far - (far - near) * blend / bend;
        for _ in 0..self.steps {
            x = min(max(x + self.step(blend, x, left), near), far);
        }
        x
    }

    /// Halley's step for ln f = 0, where f is the rest over the wanted one and ln f ~ 2 (f - 1)/(f + 1).
    fn step(&self, blend: f32, x: f32, left: Left) -> f32 {
        let (slack, full) = (self.slack.falls(x, left), self.full.falls(x, left));
        let between = |slack: f32, full: f32| slack + blend * (full - slack);
        let (f, f1, f2) = (between(slack.0, full.0), between(slack.1, full.1), between(slack.2, full.2));
        let (over, steep) = (f - 1.0, f1 * f1);
        // near the root the second is half of the first; it is more than nothing as long as the slack profile leaves anything
        2.0 * over * f1 * f / max((f + 1.0) * steep + over * (steep - f2 * f), f * steep)
    }
}

/// T / T_max at `x`, for a fullness between the cone's and the punch's.
pub fn share(fullness: f32, x: f32) -> f32 {
    let (span, blend) = Span::around(fullness);
    if blend >= 1.0 {
        return span.full.share(x);
    }
    let slack = span.slack.share(x);
    if blend > 0.0 { slack + blend * (span.full.share(x) - slack) } else { slack }
}

/// Where [`share`] is `share`, 0 to 1: to 1e-6 of T_max, and no farther than [`REACH`].
pub fn inverse(fullness: f32, share: f32) -> f32 {
    let rest = max(1.0 - share, LEAST_REST);
    let (left, (span, blend)) = (Left { rest, depth: -ln(rest) }, Span::around(fullness));
    if blend >= 1.0 {
        span.full.inverse(left)
    } else if blend > 0.0 {
        span.inverse(blend, left)
    } else {
        span.slack.inverse(left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fullnesses from end to end with all three profiles, and what lies next to each and beyond the ends.
    fn fullnesses() -> impl Iterator<Item = f32> {
        let near = [FULLNESS_CONE, FULLNESS_HERTZ, FULLNESS_PUNCH].into_iter().flat_map(|f| [f.next_down(), f, f.next_up()]);
        near.chain((0..=120).map(|i| 0.5 + 0.5 * i as f32 / 120.0)).chain([0.0, 0.499, 1.001, 2.0])
    }

    /// Shares from nothing to full: even steps, and closer and closer to both ends.
    fn shares() -> impl Iterator<Item = f32> {
        let tiny = (1..40).map(|i| 1.0e-38 * 9.0_f32.powi(i)).take_while(|share| *share < 1.0e-3);
        let even = (1..1000).map(|i| i as f32 / 1000.0);
        [0.0].into_iter().chain(tiny).chain(even).chain((10..=24).map(|k| 1.0 - 0.5_f32.powi(k))).chain([1.0])
    }

    #[test]
    fn the_inverse_inverts_to_a_millionth_and_rises() {
        for fullness in fullnesses() {
            let mut last = 0.0;
            for wanted in shares() {
                let x = inverse(fullness, wanted);
                assert!((0.0..=REACH).contains(&x), "fullness {fullness}, share {wanted:e}: {x}");
                let found = share(fullness, x);
                // beyond the reach is what the cone leaves there
                let close = if x < REACH { 1.2e-6 } else { 4.0e-6 };
                assert!((found - wanted).abs() < close, "fullness {fullness}, share {wanted:e}: {x}, there {found:e}");
                assert!(x >= last - 1.0e-6, "fullness {fullness}, share {wanted:e}: {x} after {last}");
                last = x;
            }
        }
    }

    #[test]
    fn profiles_agree_with_their_closed_inverses_where_they_meet() {
        for wanted in shares() {
            for (below, at) in [(0.500_001, FULLNESS_CONE), (0.666_666, FULLNESS_HERTZ), (0.999_999, FULLNESS_PUNCH)] {
                let (x, closed) = (inverse(below, wanted), inverse(at, wanted));
                assert!((share(at, x) - share(at, closed)).abs() < 4.0e-6, "fullness {at}, share {wanted:e}: {x} and {closed}");
            }
        }
    }

    #[test]
    fn what_is_no_number_has_a_finite_inverse() {
        for (fullness, share) in
            [(f32::NAN, 0.5), (0.6, f32::NAN), (0.8, f32::NAN), (0.8, 2.0), (0.6, -1.0), (0.8, f32::INFINITY)]
        {
            assert!(inverse(fullness, share).is_finite(), "fullness {fullness}, share {share}");
        }
    }
}

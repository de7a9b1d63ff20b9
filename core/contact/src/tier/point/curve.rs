//! The two monotone curves of tier `point`: friction force over drag, friction torque over twist (theory.md, equations 6.1 and 6.2).

use crate::math::{cbrt, clamp, exp, max, min, pow, root};
use crate::profile::{FULLNESS_CONE, FULLNESS_HERTZ, FULLNESS_PUNCH};
use crate::tier::Hold;

/// A loading curve from zero to full slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// Cattaneo for the profile f = A r^n: Q = mu P [1 - (1 - s/s0)^(1/rho)].
    Drag {
        /// mu P \[N\].
        full: f32,
        /// Full-slip shift s0 = mu P / (rho K_t) \[m\].
        reach: f32,
        /// Fullness rho.
        fullness: f32,
    },
    /// Lubkin, or its relatives for other profiles.
    Twist {
        /// T_max \[N m\].
        full: f32,
        /// T_max / K_theta \[rad\].
        unit: f32,
        /// Fullness rho.
        fullness: f32,
    },
}

/// Twist, in units of T_max / K_theta, beyond which the curve is 1 to f32.
const TWIST_REACH: f32 = 24.0;

/// Halvings of the numeric inverse: 24 units to 1.5e-6.
const INVERSE_STEPS: usize = 24;

impl Curve {
    /// The drag curve of a patch with friction `mu`.
    pub fn drag(hold: &Hold, mu: f32) -> Self {
        let (full, fullness) = (mu * hold.load, hold.profile.fullness());
        Self::Drag { full, reach: full / (fullness * hold.drag_stiffness), fullness }
    }

    /// The twist curve of a patch with friction `mu`.
    pub fn twist(hold: &Hold, mu: f32) -> Self {
        let full = hold.profile.full_slip_torque() * mu * hold.load * hold.arm;
        Self::Twist { full, unit: full / hold.twist_stiffness, fullness: hold.profile.fullness() }
    }

    /// Load at full slip.
    pub fn full(&self) -> f32 {
        match *self {
            Self::Drag { full, .. } | Self::Twist { full, .. } => full,
        }
    }

    /// Displacement at which slip is full.
    pub fn reach(&self) -> f32 {
        match *self {
            Self::Drag { reach, .. } => reach,
            Self::Twist { unit, .. } => TWIST_REACH * unit,
        }
    }

    /// Displacement at which the initial slope would meet the full load.
    pub fn slope_reach(&self) -> f32 {
        match *self {
            Self::Drag { reach, fullness, .. } => reach * fullness,
            Self::Twist { unit, .. } => unit,
        }
    }

    /// Load at displacement `x` >= 0.
    pub fn load(&self, x: f32) -> f32 {
        match *self {
            Self::Drag { full, reach, fullness } => full * (1.0 - one_minus(x / reach, inverse(fullness))),
            Self::Twist { full, unit, fullness } => full * twist_share(fullness, x / unit),
        }
    }

    /// Displacement at load `y` >= 0.
    pub fn inverse(&self, y: f32) -> f32 {
        match *self {
            Self::Drag { full, reach, fullness } => reach * (1.0 - one_minus(y / full, fullness)),
            Self::Twist { full, unit, fullness } => unit * inverse_twist(fullness, clamp(y / full, 0.0, 1.0)),
        }
    }

    /// Stick radius over contact radius at displacement `x` on a fresh load.
    pub fn stick_radius(&self, x: f32) -> f32 {
        match *self {
            // s_lim(c) = s0 (1 - c^n), n = rho / (1 - rho)
            Self::Drag { reach, fullness, .. } => one_minus(x / reach, inverse(fullness) - 1.0),
            Self::Twist { unit, .. } => {
                let x = min(x / unit, TWIST_REACH);
                exp(-0.2902 * x * (1.0 + 0.2066 * x) / (1.0 + 0.1046 * x))
            }
        }
    }
}

/// (1 - x)^e for x held to 0..1, and 0 at x = 1 for every e.
fn one_minus(x: f32, e: f32) -> f32 {
    let rest = 1.0 - clamp(x, 0.0, 1.0);
    if rest <= 0.0 {
        0.0
    } else if e == 1.5 {
        rest * root(rest)
    } else if e == FULLNESS_HERTZ {
        cbrt(rest * rest)
    } else if e == 0.5 {
        root(rest)
    } else {
        pow(rest, e)
    }
}

/// 1 / rho; exact for Hertz, whose powers then have short cuts.
fn inverse(fullness: f32) -> f32 {
    if fullness == FULLNESS_HERTZ { 1.5 } else { 1.0 / fullness }
}

/// T / T_max over x = K_theta phi / T_max, between the three profiles linear in the fullness.
fn twist_share(fullness: f32, x: f32) -> f32 {
    if fullness <= FULLNESS_HERTZ {
        let blend = (fullness - FULLNESS_CONE) / (FULLNESS_HERTZ - FULLNESS_CONE);
        if blend >= 1.0 { hertz_twist(x) } else { cone_twist(x) + blend * (hertz_twist(x) - cone_twist(x)) }
    } else {
        let blend = (fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ);
        hertz_twist(x) + blend * (punch_twist(x) - hertz_twist(x))
    }
}

/// Fit of Lubkin's curve, 2.6e-4 of T_max.
fn hertz_twist(x: f32) -> f32 {
    1.0 - exp(-x * (1.0 + 0.1029 * x) / (1.0 + 0.0427 * x))
}

/// Fit of the cone's curve, 2.1e-4 of T_max.
fn cone_twist(x: f32) -> f32 {
    1.0 - exp(-x * (1.0 + 0.053_906 * x) / (1.0 + 0.141_638 * x))
}

/// Flat punch: no slip up to x1, then the fit, 6e-6 of T_max.
fn punch_twist(x: f32) -> f32 {
    const FIRST_SLIP: f32 = 0.848_848;
    if x <= FIRST_SLIP {
        return x;
    }
    let y = x - FIRST_SLIP;
    1.0 - (1.0 - FIRST_SLIP) * exp(-y * (6.618 + 6.137 * y) / (1.0 + 1.162 * y))
}

fn inverse_twist(fullness: f32, share: f32) -> f32 {
    if fullness == FULLNESS_HERTZ {
        return inverse_hertz(share);
    }
    let (mut low, mut high) = (0.0, TWIST_REACH);
    for _ in 0..INVERSE_STEPS {
        let middle = 0.5 * (low + high);
        if twist_share(fullness, middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Closed inverse of `hertz_twist`: a quadratic in x.
fn inverse_hertz(share: f32) -> f32 {
    let y = -crate::math::ln(max(1.0 - share, LEAST_REST));
    let b = 1.0 - 0.0427 * y;
    min(2.0 * y / (b + root(b * b + 4.0 * 0.1029 * y)), TWIST_REACH)
}

/// Rest of the capacity below which a share counts as full.
const LEAST_REST: f32 = 1.0e-9;

#[cfg(test)]
mod tests {
    use super::*;

    fn curves() -> impl Iterator<Item = Curve> {
        [FULLNESS_CONE, 0.6, FULLNESS_HERTZ, 0.8, FULLNESS_PUNCH].into_iter().flat_map(|fullness| {
            [Curve::Drag { full: 2.0, reach: 3.0e-4, fullness }, Curve::Twist { full: 0.03, unit: 0.02, fullness }]
        })
    }

    #[test]
    fn inverses_invert_and_curves_rise() {
        for curve in curves() {
            let mut last = 0.0;
            for step in 1..=40 {
                let y = curve.full() * step as f32 / 41.0;
                let x = curve.inverse(y);
                assert!((curve.load(x) - y).abs() < 2.0e-3 * curve.full(), "{curve:?} {y}");
                assert!(x >= last);
                last = x;
            }
            assert!(curve.load(curve.reach()) >= curve.full() * 0.999_99, "{curve:?}");
        }
    }

    #[test]
    fn every_curve_starts_with_the_stick_stiffness() {
        for curve in curves() {
            let x = 1.0e-3 * curve.slope_reach();
            assert!((curve.load(x) / (1.0e-3 * curve.full()) - 1.0).abs() < 2.0e-3, "{curve:?}");
        }
    }
}

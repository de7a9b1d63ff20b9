//! The two monotone curves of tier `point`: friction force over drag, friction torque over twist (theory.md, equations 6.1 and 6.2).

use crate::math::{cbrt, clamp, exp, min, pow, root};
use crate::profile::FULLNESS_HERTZ;
use crate::tier::Hold;
use crate::tier::point::twist;

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
            Self::Twist { unit, .. } => twist::REACH * unit,
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
            Self::Twist { full, unit, fullness } => full * twist::share(fullness, x / unit),
        }
    }

    /// Displacement at load `y` >= 0.
    pub fn inverse(&self, y: f32) -> f32 {
        match *self {
            Self::Drag { full, reach, fullness } => reach * (1.0 - one_minus(y / full, fullness)),
            Self::Twist { full, unit, fullness } => unit * twist::inverse(fullness, clamp(y / full, 0.0, 1.0)),
        }
    }

    /// Stick radius over contact radius at displacement `x` on a fresh load.
    pub fn stick_radius(&self, x: f32) -> f32 {
        match *self {
            // s_lim(c) = s0 (1 - c^n), n = rho / (1 - rho)
            Self::Drag { reach, fullness, .. } => one_minus(x / reach, inverse(fullness) - 1.0),
            Self::Twist { unit, .. } => {
                let x = min(x / unit, twist::REACH);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{FULLNESS_CONE, FULLNESS_PUNCH};

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
                assert!((curve.load(x) - y).abs() < 2.0e-6 * curve.full(), "{curve:?} {y}");
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

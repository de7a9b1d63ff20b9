//! Pressure profiles: how the load of a patch is spread over its radius, and what slips when.
//!
//! A profile is one number, the **fullness** rho = P / (2 E* a delta): 1/2 for a cone, 2/3 for a paraboloid (Hertz), 1 for a
//! flat punch, and n/(n+1) for f(r) = A r^n. Between the three tabulated profiles everything is linear in rho (theory.md, 5).

pub mod table;

use crate::math::{clamp, root};
use table::{CONE, HERTZ, INTERVALS, PUNCH, Row, Table};

/// Fullness of a cone.
pub const FULLNESS_CONE: f32 = 0.5;
/// Fullness of a paraboloid.
pub const FULLNESS_HERTZ: f32 = 2.0 / 3.0;
/// Fullness of a flat punch.
pub const FULLNESS_PUNCH: f32 = 1.0;

/// A pressure profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    fullness: f32,
}

/// Figures at the radius r = q a.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct At {
    /// Shift, in units of mu P / K_t, at which a bristle slips.
    pub drag_softness: f32,
    /// Hoop shift over a, in units of mu P a / K_theta, at which a bristle slips.
    pub twist_softness: f32,
    /// Share of the load inside r.
    pub load: f32,
    /// Torque capacity inside r over mu P a.
    pub torque: f32,
    /// Radius over a that sticks in pure drag when bristles beyond r slip.
    pub drag_stick: f32,
    /// The same in pure twist.
    pub twist_stick: f32,
}

/// Shares of the elastic compliance 1/K that all bristles of a patch have in common, in drag and in twist: each pulls the surface along
/// under its neighbours. The rest is each bristle's own. Fitted on paths that turn (theory.md, equation 5.4); the tables belong to them.
pub const COMMON_DRAG: f32 = 0.65;
/// See [`COMMON_DRAG`].
pub const COMMON_TWIST: f32 = 0.43;

impl Profile {
    /// Profile of fullness `fullness`, held to the tabulated range.
    pub fn new(fullness: f32) -> Self {
        Self { fullness: clamp(fullness, FULLNESS_CONE, FULLNESS_PUNCH) }
    }

    /// The fullness rho.
    pub fn fullness(self) -> f32 {
        self.fullness
    }

    /// Full-slip torque over mu P a: pi/6 (cone), 3 pi/16 (Hertz), pi/4 (flat punch).
    pub fn full_slip_torque(self) -> f32 {
        self.row(1.0)[3]
    }

    /// Figures at r = `q` a, q in 0..=1.
    pub fn at(self, q: f32) -> At {
        let [drag_softness, twist_softness, load, torque, drag_stick, twist_stick] = self.row(q);
        At { drag_softness, twist_softness, load, torque, drag_stick, twist_stick }
    }

    fn row(self, q: f32) -> Row {
        let place = INTERVALS as f32 * root(1.0 - q * q);
        let index = (place as usize).min(INTERVALS - 1);
        let blend = place - index as f32;
        let read = |table: &Table| mix(&table[index], &table[index + 1], blend);
        if self.fullness == FULLNESS_HERTZ {
            read(&HERTZ)
        } else if self.fullness < FULLNESS_HERTZ {
            mix(&read(&CONE), &read(&HERTZ), (self.fullness - FULLNESS_CONE) / (FULLNESS_HERTZ - FULLNESS_CONE))
        } else {
            mix(&read(&HERTZ), &read(&PUNCH), (self.fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ))
        }
    }
}

fn mix(a: &Row, b: &Row, blend: f32) -> Row {
    core::array::from_fn(|i| a[i] + (b[i] - a[i]) * blend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::PI;

    #[test]
    fn closed_forms_of_load_and_torque() {
        for step in 0..=50 {
            let q = step as f32 / 50.0;
            let x = root(1.0 - q * q);
            let hertz = Profile::new(FULLNESS_HERTZ).at(q);
            assert!((hertz.load - (1.0 - x * x * x)).abs() < 3.0e-4, "{q} {hertz:?}");
            let punch = Profile::new(FULLNESS_PUNCH).at(q);
            assert!((punch.load - (1.0 - x)).abs() < 1.0e-6, "{q} {punch:?}");
        }
        for (fullness, torque) in [(FULLNESS_CONE, PI / 6.0), (FULLNESS_HERTZ, 3.0 * PI / 16.0), (FULLNESS_PUNCH, PI / 4.0)] {
            assert!((Profile::new(fullness).full_slip_torque() - torque).abs() < 1.0e-6);
        }
    }
}

//! Pressure profiles: how the load of a patch is spread over its radius, and what slips when.
//!
//! A profile is one number, the **fullness** rho = P / (2 E* a delta): 1/2 for a cone, 2/3 for a paraboloid (Hertz), 1 for a
//! flat punch, and n/(n+1) for f(r) = A r^n. Between the three tabulated profiles everything is linear in rho (theory.md, 5).

pub mod table;

use crate::math::{clamp, floor, root};
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

/// Cumulative figures from the centre to a radius r = q a.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Within {
    /// Radius over a that still sticks in pure drag when bristles beyond r slip.
    pub drag_stick: f32,
    /// The same in pure twist, cubed.
    pub twist_stick_cubed: f32,
    /// Share of the load inside r.
    pub load: f32,
    /// Torque capacity inside r over mu P a.
    pub torque: f32,
}

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
        self.within(1.0).torque
    }

    /// Cumulative figures inside r = `q` a, q in 0..=1.
    pub fn within(self, q: f32) -> Within {
        let place = INTERVALS as f32 * root(1.0 - q * q);
        let row = floor(place);
        let index = if row >= INTERVALS as f32 { INTERVALS - 1 } else { row as usize };
        let blend = place - index as f32;
        let [drag_stick, twist_stick_cubed, load, torque] = self.blended(|table| mix(table[index], table[index + 1], blend));
        Within { drag_stick, twist_stick_cubed, load, torque }
    }

    fn blended(self, read: impl Fn(&Table) -> Row) -> Row {
        if self.fullness <= FULLNESS_HERTZ {
            let blend = (self.fullness - FULLNESS_CONE) / (FULLNESS_HERTZ - FULLNESS_CONE);
            if blend >= 1.0 { read(&HERTZ) } else { mix(read(&CONE), read(&HERTZ), blend) }
        } else {
            let blend = (self.fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ);
            mix(read(&HERTZ), read(&PUNCH), blend)
        }
    }
}

fn mix(a: Row, b: Row, blend: f32) -> Row {
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
            let hertz = Profile::new(FULLNESS_HERTZ).within(q);
            assert!((hertz.load - (1.0 - x * x * x)).abs() < 3.0e-4, "{q} {hertz:?}");
            let punch = Profile::new(FULLNESS_PUNCH).within(q);
            assert!((punch.load - (1.0 - x)).abs() < 1.0e-6, "{q} {punch:?}");
        }
        for (fullness, torque) in [(FULLNESS_CONE, PI / 6.0), (FULLNESS_HERTZ, 3.0 * PI / 16.0), (FULLNESS_PUNCH, PI / 4.0)] {
            assert!((Profile::new(fullness).full_slip_torque() - torque).abs() < 1.0e-6);
        }
    }
}

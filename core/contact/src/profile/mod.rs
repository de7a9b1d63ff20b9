//! Pressure profiles: how the load of a patch is spread over its radius, and what slips when.
//!
//! A profile is one number, the **fullness** rho = P / (2 E* a delta): 1/2 for a cone, 2/3 for a paraboloid (Hertz), 1 for a
//! flat punch, and n/(n+1) for f(r) = A r^n. Between the three tabulated profiles everything is linear in rho (theory.md, 5).

pub mod table;

use crate::lanes::{LANES, Lanes};
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

/// What lies inside the radius r = q a.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inside {
    /// Share of the load.
    pub load: f32,
    /// Torque capacity over mu P a.
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
        self.columns::<3, 1>(1.0)[0]
    }

    /// Softness in drag and in twist of four bristles at r = `q` a, q in 0..=1: the shift at which one slips in units of mu P/K_t, and the hoop shift
    /// over a in units of mu P a/K_theta.
    #[inline(always)]
    pub fn softness_of_four(self, q: Lanes) -> (Lanes, Lanes) {
        let [a, b, c, d] = self.columns_of_four::<0, 2>(q);
        (Lanes([a[0], b[0], c[0], d[0]]), Lanes([a[1], b[1], c[1], d[1]]))
    }

    /// What lies inside four radii r = `q` a, q in 0..=1, to the bits of [`inside`](Self::inside): load, torque, and what sticks in drag and in twist.
    #[inline(always)]
    pub fn inside_four(self, q: Lanes) -> [Lanes; 4] {
        let [a, b, c, d] = self.columns_of_four::<2, 4>(q);
        [
            Lanes([a[0], b[0], c[0], d[0]]),
            Lanes([a[1], b[1], c[1], d[1]]),
            Lanes([a[2], b[2], c[2], d[2]]),
            Lanes([a[3], b[3], c[3], d[3]]),
        ]
    }

    /// [`columns`](Self::columns) at four places: their roots, whole steps and shares side by side.
    #[inline(always)]
    fn columns_of_four<const FIRST: usize, const N: usize>(self, q: Lanes) -> [[f32; N]; LANES] {
        let place = (1.0 - q * q).larger(Lanes::default()).roots() * INTERVALS as f32;
        let at = place.steps::<{ INTERVALS - 1 }>();
        if self.fullness == FULLNESS_HERTZ {
            four_rows::<FIRST, N>(&HERTZ, at)
        } else if self.fullness < FULLNESS_HERTZ {
            let share = (self.fullness - FULLNESS_CONE) / (FULLNESS_HERTZ - FULLNESS_CONE);
            mix_four(four_rows::<FIRST, N>(&CONE, at), four_rows::<FIRST, N>(&HERTZ, at), share)
        } else {
            let share = (self.fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ);
            mix_four(four_rows::<FIRST, N>(&HERTZ, at), four_rows::<FIRST, N>(&PUNCH, at), share)
        }
    }

    /// What lies inside r = `q` a, q in 0..=1.
    #[inline(always)]
    pub fn inside(self, q: f32) -> Inside {
        let [load, torque, drag_stick, twist_stick] = self.columns::<2, 4>(q);
        Inside { load, torque, drag_stick, twist_stick }
    }

    /// `N` columns of the tables from column `FIRST` on. In line, as its callers are: a call for every ring cost more than what it reads.
    #[inline(always)]
    fn columns<const FIRST: usize, const N: usize>(self, q: f32) -> [f32; N] {
        let place = INTERVALS as f32 * root(1.0 - q * q);
        // by way of 32 bits, to which a float goes in fewer instructions
        let index = (place as u32 as usize).min(INTERVALS - 1);
        let blend = place - index as f32;
        let part = |row: &Row| core::array::from_fn(|i| row[FIRST + i]);
        let read = |table: &Table| mix(&part(&table[index]), &part(&table[index + 1]), blend);
        if self.fullness == FULLNESS_HERTZ {
            read(&HERTZ)
        } else if self.fullness < FULLNESS_HERTZ {
            mix(&read(&CONE), &read(&HERTZ), (self.fullness - FULLNESS_CONE) / (FULLNESS_HERTZ - FULLNESS_CONE))
        } else {
            mix(&read(&HERTZ), &read(&PUNCH), (self.fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ))
        }
    }
}

/// `N` columns of a table from column `FIRST` on, so many rows and this share of the next one down.
#[inline(always)]
fn row<const FIRST: usize, const N: usize>(table: &Table, index: usize, blend: f32) -> [f32; N] {
    // as the index is a step already, this only tells the compiler
    let index = index & (INTERVALS - 1);
    let part = |row: &Row| core::array::from_fn(|i| row[FIRST + i]);
    mix(&part(&table[index]), &part(&table[index + 1]), blend)
}

#[inline(always)]
fn four_rows<const FIRST: usize, const N: usize>(table: &Table, at: ([usize; LANES], Lanes)) -> [[f32; N]; LANES] {
    let ([i, j, k, l], Lanes([a, b, c, d])) = at;
    [row::<FIRST, N>(table, i, a), row::<FIRST, N>(table, j, b), row::<FIRST, N>(table, k, c), row::<FIRST, N>(table, l, d)]
}

#[inline(always)]
fn mix_four<const N: usize>(low: [[f32; N]; LANES], high: [[f32; N]; LANES], share: f32) -> [[f32; N]; LANES] {
    let ([a, b, c, d], [e, f, g, h]) = (low, high);
    [mix(&a, &e, share), mix(&b, &f, share), mix(&c, &g, share), mix(&d, &h, share)]
}

#[inline(always)]
fn mix<const N: usize>(a: &[f32; N], b: &[f32; N], blend: f32) -> [f32; N] {
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
            let hertz = Profile::new(FULLNESS_HERTZ).inside(q);
            assert!((hertz.load - (1.0 - x * x * x)).abs() < 3.0e-4, "{q} {hertz:?}");
            let punch = Profile::new(FULLNESS_PUNCH).inside(q);
            assert!((punch.load - (1.0 - x)).abs() < 1.0e-6, "{q} {punch:?}");
        }
        for (fullness, torque) in [(FULLNESS_CONE, PI / 6.0), (FULLNESS_HERTZ, 3.0 * PI / 16.0), (FULLNESS_PUNCH, PI / 4.0)] {
            assert!((Profile::new(fullness).full_slip_torque() - torque).abs() < 1.0e-6);
        }
    }
}

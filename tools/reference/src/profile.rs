//! Pressure profiles of circular patches, and the closed curves of twist and drag that go with them.
//!
//! A profile is told by its cumulative load L(q): the share of P carried within q = r/a. Units: a = 1, G = 1, mu P = 1.

use crate::lattice::Lattice;
use std::f64::consts::PI;

/// Points per cell edge used to integrate the load over a cell: 16 x 16 puts the rim cells' load within 0.1 %.
const SUBDIVISIONS: usize = 16;

/// Which body presses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// Sphere or paraboloid.
    Hertz,
    /// Cone, tip down.
    Cone,
    /// Flat-ended cylinder.
    Punch,
}

impl Profile {
    /// Every profile.
    pub const ALL: [Self; 3] = [Self::Hertz, Self::Cone, Self::Punch];

    /// Name in tables and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hertz => "hertz",
            Self::Cone => "cone",
            Self::Punch => "punch",
        }
    }

    /// Pressure at `q`, in mu P / a^2; zero outside.
    #[must_use]
    pub fn pressure(self, q: f64) -> f64 {
        if q >= 1.0 {
            return 0.0;
        }
        match self {
            Self::Hertz => 1.5 / PI * (1.0 - q * q).sqrt(),
            Self::Cone => (1.0 / q).acosh() / PI,
            Self::Punch => 0.5 / (PI * (1.0 - q * q).sqrt()),
        }
    }

    /// Largest friction torque, in mu P a.
    #[must_use]
    pub fn torque_limit(self) -> f64 {
        match self {
            Self::Hertz => 3.0 * PI / 16.0,
            Self::Cone => PI / 6.0,
            Self::Punch => PI / 4.0,
        }
    }

    /// Mean pressure of every cell of `lattice` for a contact of `radius` that carries `load`, scaled to carry it exactly; of the cells on the
    /// lattice's own inscribed disc, which is `Lattice::over_disc`'s, no other touches.
    ///
    /// # Panics
    /// If `radius` is so small that no cell lies in the contact.
    #[must_use]
    pub fn pressures(self, lattice: &Lattice, radius: f64, load: f64) -> Vec<f64> {
        let mut field = vec![0.0; lattice.len()];
        let rim = 0.5 * lattice.columns as f64 * lattice.edge;
        for (index, [x, y]) in lattice.cells().filter(|(_, [x, y])| x.hypot(*y) < rim) {
            field[index] = self.mean_pressure([x / radius, y / radius], lattice.edge / radius);
        }
        let total: f64 = field.iter().sum::<f64>() * lattice.area();
        assert!(total > 0.0, "radius = {radius}, allowed: at least a cell");
        field.iter_mut().for_each(|p| *p *= load / total);
        field
    }

    /// Mean pressure over a cell, by midpoints.
    fn mean_pressure(self, centre: [f64; 2], edge: f64) -> f64 {
        let part = edge / SUBDIVISIONS as f64;
        let at = |c: f64, i: usize| c - 0.5 * edge + (i as f64 + 0.5) * part;
        let mut sum = 0.0;
        for i in 0..SUBDIVISIONS {
            for j in 0..SUBDIVISIONS {
                sum += self.pressure(at(centre[0], i).hypot(at(centre[1], j)));
            }
        }
        sum / (SUBDIVISIONS * SUBDIVISIONS) as f64
    }
}

/// Cattaneo and Mindlin: drag force of a sphere over mu P after a steady shift of `s` units of s0.
#[must_use]
pub fn cattaneo(s: f64) -> f64 {
    1.0 - (1.0 - s.min(1.0)).powf(1.5)
}

/// Lubkin: torque of a sphere over T_max after a steady twist of `x` units of phi0.
///
/// Uses T = 16 G int s^2 min(phi, phi_lim(s)) ds with phi_lim = 3 mu P/(4 pi G a^2) [K(k) - E(k)], k^2 = 1 - s^2.
#[must_use]
pub fn lubkin(x: f64) -> f64 {
    /// Midpoints of the integral; its error is below 1e-5 of T_max.
    const POINTS: usize = 2000;
    let phi = x * 9.0 * PI / 256.0;
    let step = 1.0 / POINTS as f64;
    let sum: f64 = (0..POINTS)
        .map(|i| {
            let s = (i as f64 + 0.5) * step;
            let limit = 0.75 / PI * elliptic_difference((1.0 - s * s).sqrt());
            s * s * phi.min(limit) * step
        })
        .sum();
    16.0 * sum / Profile::Hertz.torque_limit()
}

/// Complete elliptic integrals K(k) - E(k), by the arithmetic-geometric mean.
fn elliptic_difference(k: f64) -> f64 {
    /// The mean doubles its digits at each pass; eight exceed `f64` for any k below 1 - 1e-12.
    const PASSES: usize = 8;
    let (mut a, mut b, mut c) = (1.0, (1.0 - k * k).sqrt(), k);
    let mut weight = 0.5;
    let mut sum = weight * c * c;
    for _ in 0..PASSES {
        (a, b, c) = (0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b));
        weight *= 2.0;
        sum += weight * c * c;
    }
    PI / (2.0 * a) * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_reach_their_ends() {
        assert!((cattaneo(1.0) - 1.0).abs() < 1e-12);
        // the table of truth: x = 0.02 -> 0.0198240734, x = 10 -> 0.999997846
        assert!((lubkin(0.02) - 0.019_824).abs() < 2e-5);
        assert!((lubkin(1.0) - 0.646_1).abs() < 0.02);
        assert!((lubkin(10.0) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn cells_carry_the_profile_s_torque() {
        let lattice = Lattice::over_disc(40, 1.0);
        for (profile, tolerance) in [(Profile::Hertz, 2e-3), (Profile::Cone, 2e-3), (Profile::Punch, 3e-2)] {
            let p = profile.pressures(&lattice, 1.0, 1.0);
            let torque: f64 = lattice.cells().map(|(index, [x, y])| p[index] * lattice.area() * x.hypot(y)).sum();
            assert!((torque / profile.torque_limit() - 1.0).abs() < tolerance, "{profile:?} {torque}");
        }
    }
}

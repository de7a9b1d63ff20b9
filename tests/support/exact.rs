//! Exact answers in f64: elliptic integrals, quadrature, and the closed forms of contact mechanics built on them.
//!
//! Units are SI. Sources: K. L. Johnson, Contact Mechanics, 1985 (Hertz, chapter 4; Cattaneo and Mindlin, chapter 7); I. N. Sneddon,
//! Int. J. Eng. Sci. 3, 1965 (cone, sphere); J. L. Lubkin, J. Appl. Mech. 18, 1951 (torsion).

use std::f64::consts::PI;

/// Complete elliptic integrals K(k) and E(k), by the arithmetic-geometric mean; k is the modulus, below 1.
pub fn elliptic(k: f64) -> (f64, f64) {
    // the mean doubles its digits at each pass; ten exceed f64 for any k below 1 - 1e-14
    let (mut a, mut b, mut c) = (1.0, (1.0 - k * k).sqrt(), k);
    let (mut weight, mut sum) = (0.5, 0.5 * c * c);
    for _ in 0..10 {
        (a, b, c) = (0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b));
        weight *= 2.0;
        sum += weight * c * c;
    }
    let first = PI / (2.0 * a);
    (first, first * (1.0 - sum))
}

/// Integral of `f` over `from..to` by Gauss-Legendre with five points in each of `pieces` equal pieces.
pub fn integral(from: f64, to: f64, pieces: usize, f: impl Fn(f64) -> f64) -> f64 {
    const POINTS: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = 0.5 * (to - from) / pieces as f64;
    let piece = |i: usize| {
        let middle = from + half * (2 * i + 1) as f64;
        POINTS.iter().map(|(x, w)| w * f(middle + half * x)).sum::<f64>() * half
    };
    (0..pieces).map(piece).sum()
}

/// Zero of the rising function `f` between `low` and `high`, by halving to the last bit.
pub fn zero(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Rigid sphere of radius `r` pressed `depth` deep (true sphere, Sneddon): load over E* \[m^2\] and contact radius \[m\].
pub fn sphere(r: f64, depth: f64) -> (f64, f64) {
    let log = |a: f64| ((r + a) / (r - a)).ln();
    let a = zero(0.0, r * (1.0 - 1e-9), |a| 0.5 * a * log(a) - depth);
    (0.5 * (a * a + r * r) * log(a) - a * r, a)
}

/// Elliptic Hertz contact of principal relative curvatures `large` >= `small` \[1/m\]: load over E* \[m^2\] and radius of equal area
/// sqrt(ab) \[m\] at `depth`.
///
/// Johnson, equations 4.25 to 4.32: with b <= a the semi-axes and e^2 = 1 - b^2/a^2, the curvatures' ratio is
/// small = 2 p0 b (K - E)/(E* e^2 a^2), large = 2 p0 b (a^2/b^2 E - K)/(E* e^2 a^2), p0 = depth E*/(b K), P = 2/3 pi a b p0.
pub fn ellipse(large: f64, small: f64, depth: f64) -> (f64, f64) {
    if large / small < 1.0 + 1e-9 {
        let r = 1.0 / large;
        return (4.0 / 3.0 * r.sqrt() * depth.powf(1.5), (r * depth).sqrt());
    }
    let along = |ratio: f64| {
        let e2 = 1.0 - ratio * ratio;
        let (k, e) = elliptic(e2.sqrt());
        ((k - e) / e2, (e / (ratio * ratio) - k) / e2, k)
    };
    let ratio = zero(1e-6, 1.0 - 1e-9, |ratio| {
        let (long, short, _) = along(ratio);
        long / short - small / large
    });
    let (long, _, k) = along(ratio);
    let a = (2.0 * depth * long / (k * small)).sqrt();
    let b = ratio * a;
    (2.0 / 3.0 * PI * a * depth / k, (a * b).sqrt())
}

/// Torque of a circular contact after a steady twist, from the twist `limit(s)` at which the ring s slips:
/// T = 16 G int_0^a s^2 min(phi, limit(s)) ds, split where the two meet.
pub fn torsion(shear_modulus: f64, a: f64, phi: f64, limit: impl Fn(f64) -> f64) -> f64 {
    let stuck = if limit(0.0) <= phi { 0.0 } else { zero(0.0, a, |s| phi - limit(s)) };
    // s = a sin t takes out the square root that `limit` has at the rim
    let slipped = integral((stuck / a).min(1.0).asin(), 0.5 * PI, 200, |t| {
        let s = a * t.sin();
        s * s * limit(s) * a * t.cos()
    });
    16.0 * shear_modulus * (phi * stuck * stuck * stuck / 3.0 + slipped)
}

/// Twist at which the ring s of a sphere's contact slips, with m = mu P (Lubkin): 3 m/(4 pi G a^2) [K(k) - E(k)], k^2 = 1 - s^2/a^2.
pub fn lubkin_limit(m: f64, shear_modulus: f64, a: f64, s: f64) -> f64 {
    let (k, e) = elliptic((1.0 - s * s / (a * a)).max(0.0).sqrt().min(1.0 - 1e-15));
    3.0 * m / (4.0 * PI * shear_modulus * a * a) * (k - e)
}

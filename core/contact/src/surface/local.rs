//! Closed forms of a half space loaded on a disc, as shares of the patch's own motion (theory.md, section 9).
//!
//! `q` is the distance from the patch's centre over the contact radius a. Each form is continuous at the rim and joins its series
//! far out, where the closed form loses its digits to cancellation.

use crate::math::{PI, asin, root};

/// Radius over distance below which the series are used: there both agree to f32.
pub(super) const FAR: f32 = 0.3;

/// A far series by three coefficients, of s, s^3 and s^5; s^7 is counted as `FAR`^2 s^5, so that the series meets the closed form where they join
/// and is within 3e-6 below.
const fn economised(series: [f32; 4]) -> [f32; 3] {
    [series[0] / PI, series[1] / PI, (series[2] + series[3] * FAR * FAR) / PI]
}

/// The far `bowl`.
pub(super) const FAR_BOWL: [f32; 3] = economised([4.0 / 3.0, 2.0 / 15.0, 3.0 / 70.0, 5.0 / 252.0]);

/// The far `disc`.
pub(super) const FAR_DISC: [f32; 3] = economised([2.0, 1.0 / 3.0, 3.0 / 20.0, 5.0 / 56.0]);

/// The far `bowl_across`.
pub(super) const FAR_BOWL_ACROSS: [f32; 3] = economised([4.0 / 3.0, -4.0 / 10.0, -4.0 / 56.0, -4.0 / 144.0]);

/// The far `disc_across`.
pub(super) const FAR_DISC_ACROSS: [f32; 3] = economised([2.0, -1.0, -0.25, -0.125]);

/// The far `turned_disc`, of s^3, s^5 and s^7.
pub(super) const FAR_TURNED: [f32; 3] = economised([4.0 / 3.0, 2.0 / 5.0, 3.0 / 14.0, 5.0 / 36.0]);

/// acos(s)/sqrt(1 - s^2) over 0..1 by powers of s, so that pi/2 - sqrt(1 - s^2) times it is asin s to 7e-8. The quotient has no
/// singularity at s = 1, where acos has one.
const ACOS_OVER_ROOT: [f32; 9] =
    [0.5 * PI, -0.999_988_5, 0.785_041_65, -0.662_369_25, 0.562_508_1, -0.437_247_3, 0.269_380_4, -0.108_613_01, 0.020_492_44];

/// acos(s)/sqrt(1 - s^2).
#[inline(always)]
pub(super) fn acos_over_root(s: f32) -> f32 {
    let c = &ACOS_OVER_ROOT;
    // in two halves: shorter chains than one
    let s2 = s * s;
    let s4 = s2 * s2;
    let low = (c[0] + c[1] * s) + s2 * (c[2] + c[3] * s);
    let high = (c[4] + c[5] * s) + s2 * (c[6] + c[7] * s);
    low + s4 * (high + s4 * c[8])
}

/// c_0 + c_1 x + c_2 x^2.
#[inline(always)]
pub(super) fn quadratic(c: &[f32; 3], x: f32) -> f32 {
    c[0] + x * (c[1] + x * c[2])
}

/// Lift of a paraboloid's dent, 1 at the centre and 1/2 at the rim. Integral of `disc` over discs of growing radius.
pub fn bowl(q: f32) -> f32 {
    paraboloid(1.0, 1.0, q * q)
}

/// Dent \[m\] of the paraboloid that has the contact radius `a` \[m\] and the curvature `curvature` = 1/R \[1/m\], at the distance whose square is `r2`:
/// a^2/R times the bowl.
pub fn paraboloid(curvature: f32, a: f32, r2: f32) -> f32 {
    let a2 = a * a;
    if r2 <= a2 {
        return curvature * (a2 - 0.5 * r2);
    }
    let r = root(r2);
    let ratio = a / r;
    if ratio < FAR {
        return curvature * a2 / PI * far_bowl(ratio);
    }
    curvature / PI * ((2.0 * a2 - r2) * asin(ratio) + a * root(r2 - a2))
}

/// (2 - 1/s^2) asin s + sqrt(1 - s^2)/s for small s: its series to s^7.
fn far_bowl(s: f32) -> f32 {
    let s2 = s * s;
    s * (4.0 / 3.0 + s2 * (2.0 / 15.0 + s2 * (3.0 / 70.0 + s2 * (5.0 / 252.0))))
}

/// Displacement around a disc that moves as one, along its motion: (2/pi) asin(a/r).
pub fn disc(q: f32) -> f32 {
    if q <= 1.0 { 1.0 } else { 2.0 / PI * asin(1.0 / q) }
}

/// What turns with twice the angle around a dragged disc, without nu/(2 - nu): (2/pi) (a/r) sqrt(1 - a^2/r^2).
pub fn disc_across(q: f32) -> f32 {
    if q <= 1.0 {
        return 0.0;
    }
    let s = 1.0 / q;
    2.0 / PI * s * root(1.0 - s * s)
}

/// `disc_across` for the paraboloid's discs, as `bowl` is for `disc`.
pub fn bowl_across(q: f32) -> f32 {
    if q <= 1.0 {
        return 0.25 * q * q;
    }
    let s = 1.0 / q;
    if s < FAR {
        let s2 = s * s;
        return 4.0 / PI * s * (1.0 / 3.0 - s2 * (1.0 / 10.0 + s2 * (1.0 / 56.0 + s2 / 144.0)));
    }
    let q2 = q * q;
    4.0 / PI * (0.125 * (2.0 - q2) * root(q2 - 1.0) + 0.125 * q2 * q2 * asin(s)) / q2
}

/// Rotation around a disc twisted as one, over its own: (2/pi) [asin(1/q) - sqrt(q^2 - 1)/q^2] (Reissner and Sagoci). The same function times the distance is the rise around a tilted flat disc.
pub fn turned_disc(q: f32) -> f32 {
    if q <= 1.0 {
        return 1.0;
    }
    let s = 1.0 / q;
    if s < FAR {
        // asin s - s sqrt(1 - s^2) = 2/3 s^3 + s^5/5 + 3/28 s^7 + 5/72 s^9
        let s2 = s * s;
        return 2.0 / PI * s * s2 * (2.0 / 3.0 + s2 * (0.2 + s2 * (3.0 / 28.0 + s2 * (5.0 / 72.0))));
    }
    2.0 / PI * (asin(s) - s * root(1.0 - s * s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_continuous_and_falls() {
        let forms: [fn(f32) -> f32; 5] = [bowl, disc, disc_across, bowl_across, turned_disc];
        for form in forms {
            for place in [1.0, 1.0 / FAR] {
                let (before, after) = (form(place * (1.0 - 1.0e-6)), form(place * (1.0 + 1.0e-6)));
                assert!((before - after).abs() < 2.0e-3, "{place}: {before} {after}");
            }
            assert!(form(50.0) < 0.03 && form(1.0e4) < 1.0e-4 && form(1.0e4) >= 0.0);
        }
    }

    #[test]
    fn series_meet_the_closed_forms() {
        for s in [0.1_f64, 0.2, 0.299] {
            let q2 = 1.0 / (s * s);
            let pi = core::f64::consts::PI;
            let bowl_exact = ((2.0 - q2) * libm::asin(s) + libm::sqrt(q2 - 1.0)) / pi;
            let across = 0.5 / pi * ((2.0 - q2) * libm::sqrt(q2 - 1.0) + q2 * q2 * libm::asin(s)) / q2;
            let turn = 2.0 / pi * (libm::asin(s) - s * libm::sqrt(1.0 - s * s));
            let q = (1.0 / s) as f32;
            for (found, exact) in [(bowl(q), bowl_exact), (bowl_across(q), across), (turned_disc(q), turn)] {
                assert!((f64::from(found) / exact - 1.0).abs() < 1.0e-5, "{s}: {found} {exact}");
            }
        }
    }

    #[test]
    fn far_fields_carry_the_same_resultant() {
        // a disc moved by Q/K and a bowl with the same Q look alike from afar: 1.5 x bowl = disc
        assert!((1.5 * bowl(100.0) / disc(100.0) - 1.0).abs() < 1.0e-3);
        assert!((1.5 * bowl_across(100.0) / disc_across(100.0) - 1.0).abs() < 1.0e-3);
        // 4/(3 pi) (a/r)^3 of any torque
        assert!((turned_disc(50.0) * 125_000.0 * 3.0 * PI / 4.0 - 1.0).abs() < 1.0e-3);
    }
}

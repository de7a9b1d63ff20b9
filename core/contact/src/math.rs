//! The only file that may name libm. One implementation of each function on every platform, so that bits agree.
//!
//! `min` and `max` are our own: the sign of `min(+0, -0)` differs between compilers.

use glam::Vec3;

pub(crate) use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

pub(crate) fn sqrt(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// Square root of what should not be negative: rounding below zero counts as zero.
pub(crate) fn root(x: f32) -> f32 {
    if x > 0.0 { libm::sqrtf(x) } else { 0.0 }
}

pub(crate) fn asin(x: f32) -> f32 {
    libm::asinf(clamp(x, -1.0, 1.0))
}

pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

pub(crate) fn exp(x: f32) -> f32 {
    libm::expf(x)
}

pub(crate) fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// `x` to the power `y` for x >= 0 and y > 0 or x > 0; to 1e-6, which is what fits and limit surfaces are good for, at a third of powf's cost.
pub(crate) fn pow(x: f32, y: f32) -> f32 {
    if x > 0.0 { exp(y * ln(x)) } else { 0.0 }
}

pub(crate) fn sin(x: f32) -> f32 {
    libm::sinf(x)
}

pub(crate) fn cos(x: f32) -> f32 {
    libm::cosf(x)
}

pub(crate) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

pub(crate) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

pub(crate) fn clamp(x: f32, low: f32, high: f32) -> f32 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

/// `x` to the power 1.5 for x >= 0.
pub(crate) fn pow_3_2(x: f32) -> f32 {
    x * root(x)
}

/// Componentwise clamp to the box of half edges `half`.
pub(crate) fn clamp_to_box(p: Vec3, half: Vec3) -> Vec3 {
    Vec3::new(clamp(p.x, -half.x, half.x), clamp(p.y, -half.y, half.y), clamp(p.z, -half.z, half.z))
}

/// Unit vector along `v`, or `fallback` where `v` has no direction. Scales first, so that neither 1e-30 nor 1e30 is lost.
pub(crate) fn direction(v: Vec3, fallback: Vec3) -> Vec3 {
    let largest = max(v.x.abs(), max(v.y.abs(), v.z.abs()));
    if largest <= 0.0 || !largest.is_finite() {
        return fallback;
    }
    let scaled = v / largest;
    let length = sqrt(scaled.length_squared());
    if length.is_finite() { scaled / length } else { fallback }
}

/// Any unit vector at right angles to the unit vector `n`; continuous in `n` but at n = -z.
pub(crate) fn perpendicular(n: Vec3) -> Vec3 {
    let seed = if n.x.abs() < 0.9 { Vec3::X } else { Vec3::Y };
    direction(seed - n * seed.dot(n), Vec3::X)
}

/// Cube root of x >= 0, within one unit in the last place of the true one and exact at 0 and 1; below the smallest normal number 0. libm's counts in f64,
/// which a processor with single precision only does in software.
pub(crate) fn cbrt(x: f32) -> f32 {
    if x < f32::MIN_POSITIVE {
        return 0.0;
    }
    // a third of the exponent, and a line for the mantissa: good to 1/30
    let guess = f32::from_bits(x.to_bits() / 3 + CBRT_BIAS);
    let cube = guess * guess * guess;
    // Halley's step takes the error to the third power, Newton's to the second
    let near = guess * ((cube + x + x) / (cube + cube + x));
    near + (x / (near * near) - near) * (1.0 / 3.0)
}

/// Two thirds of the bias of an exponent, less what balances the error of the line over an octave, as bits of an f32 (Kahan).
const CBRT_BIAS: u32 = 709_958_130;

/// Abscissae and weights of the four-point Gauss rule on 0..1: exact to the seventh power.
pub(crate) const GAUSS_4: [(f32, f32); 4] =
    [(0.069_431_84, 0.173_927_42), (0.330_009_5, 0.326_072_57), (0.669_990_5, 0.326_072_57), (0.930_568_16, 0.173_927_42)];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_lie_between_the_neighbours() {
        // three octaves: every mantissa with every rest of its exponent by three
        for bits in 0.125_f32.to_bits()..=1.0_f32.to_bits() {
            let x = f32::from_bits(bits);
            let root = cbrt(x);
            let cube = |root: f32| f64::from(root) * f64::from(root) * f64::from(root);
            assert!(cube(root.next_down()) < f64::from(x) && f64::from(x) < cube(root.next_up()), "{x:e}: {root:e}");
        }
        assert_eq!((cbrt(0.0), cbrt(1.0)), (0.0, 1.0));
        for exponent in -41..42 {
            let (x, root) =
                (f32::from_bits((127 + 3 * exponent) as u32 * (1 << 23)), f32::from_bits((127 + exponent) as u32 * (1 << 23)));
            assert_eq!(cbrt(x), root);
        }
    }
}

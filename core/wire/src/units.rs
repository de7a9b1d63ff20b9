//! Between the host's numbers (f32, SI) and the device link's (i32, small units).
//!
//! The device link carries integers so that firmware without a floating-point unit can speak it and so that equal poses are
//! equal bytes. One rule for all four pairs: scale, round half away from zero, saturate at ±[`i32::MAX`]. Not-a-number becomes
//! [`NOT_A_NUMBER`], the one integer that saturation never yields; a device refuses a command that holds it.
//!
//! | quantity | unit on the wire | range |
//! |---|---|---|
//! | position | nanometre | ±2.147 m |
//! | rotation | 2^-30 of a unit quaternion's component | ±2 |
//! | force | micronewton | ±2147 N |
//! | torque | micronewton metre | ±2147 N m |

/// The integer that says "not a number" on the device link, in any component of a position, rotation, force or torque.
pub const NOT_A_NUMBER: i32 = i32::MIN;

const NM_PER_METRE: f64 = 1e9;
const UN_PER_NEWTON: f64 = 1e6;
const UNM_PER_NEWTON_METRE: f64 = 1e6;
const Q30_PER_UNIT: f64 = 1_073_741_824.0;

/// Position component \[m\] to nanometres, saturating; NaN becomes [`NOT_A_NUMBER`].
#[must_use]
pub fn metres_to_nm(metres: f32) -> i32 {
    to_wire(metres, NM_PER_METRE)
}

/// Nanometres to a position component \[m\]; [`NOT_A_NUMBER`] becomes NaN.
#[must_use]
pub fn nm_to_metres(nm: i32) -> f32 {
    from_wire(nm, NM_PER_METRE)
}

/// Component of a unit quaternion to multiples of 2^-30, saturating; NaN becomes [`NOT_A_NUMBER`].
#[must_use]
pub fn unit_to_q30(component: f32) -> i32 {
    to_wire(component, Q30_PER_UNIT)
}

/// Multiples of 2^-30 to a quaternion's component; [`NOT_A_NUMBER`] becomes NaN.
///
/// The result is off unit length by at most the rounding of 2^-31 a component: normalise it before use.
#[must_use]
pub fn q30_to_unit(q30: i32) -> f32 {
    from_wire(q30, Q30_PER_UNIT)
}

/// Force component \[N\] to micronewtons, saturating; NaN becomes [`NOT_A_NUMBER`].
#[must_use]
pub fn newtons_to_un(newtons: f32) -> i32 {
    to_wire(newtons, UN_PER_NEWTON)
}

/// Micronewtons to a force component \[N\]; [`NOT_A_NUMBER`] becomes NaN.
#[must_use]
pub fn un_to_newtons(un: i32) -> f32 {
    from_wire(un, UN_PER_NEWTON)
}

/// Torque component \[N m\] to micronewton metres, saturating; NaN becomes [`NOT_A_NUMBER`].
#[must_use]
pub fn newton_metres_to_unm(newton_metres: f32) -> i32 {
    to_wire(newton_metres, UNM_PER_NEWTON_METRE)
}

/// Micronewton metres to a torque component \[N m\]; [`NOT_A_NUMBER`] becomes NaN.
#[must_use]
pub fn unm_to_newton_metres(unm: i32) -> f32 {
    from_wire(unm, UNM_PER_NEWTON_METRE)
}

/// In f64, where both the scaled value and the half added to it are exact enough to round once.
fn to_wire(value: f32, per_unit: f64) -> i32 {
    if value.is_nan() {
        return NOT_A_NUMBER;
    }
    let scaled = f64::from(value) * per_unit;
    let rounded = if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 };
    // `as` truncates towards zero and saturates; only the lower end needs help to stay clear of the mark
    (rounded as i32).max(-i32::MAX)
}

fn from_wire(value: i32, per_unit: f64) -> f32 {
    if value == NOT_A_NUMBER {
        return f32::NAN;
    }
    (f64::from(value) / per_unit) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_round_half_away_from_zero() {
        let table = [(0.0, 0), (-0.0, 0), (1.0, 1_000_000), (-8.5, -8_500_000), (0.4e-6, 0), (0.6e-6, 1), (-0.6e-6, -1)];
        for (newtons, un) in table {
            assert_eq!(newtons_to_un(newtons), un, "{newtons} N");
        }
    }

    #[test]
    fn too_large_saturates_and_never_reads_as_not_a_number() {
        for convert in [metres_to_nm, unit_to_q30, newtons_to_un, newton_metres_to_unm] {
            assert_eq!(convert(f32::MAX), i32::MAX);
            assert_eq!(convert(f32::INFINITY), i32::MAX);
            assert_eq!(convert(f32::MIN), -i32::MAX);
            assert_eq!(convert(f32::NEG_INFINITY), -i32::MAX);
            assert_eq!(convert(f32::NAN), NOT_A_NUMBER);
        }
    }

    #[test]
    fn not_a_number_survives_both_ways() {
        for convert in [nm_to_metres, q30_to_unit, un_to_newtons, unm_to_newton_metres] {
            assert!(convert(NOT_A_NUMBER).is_nan());
        }
    }

    #[test]
    fn there_and_back_is_within_half_a_step_or_a_float_step() {
        for i in -1000..=1000 {
            let metres = i as f32 * 1.2345e-4;
            let back = nm_to_metres(metres_to_nm(metres));
            let step = 0.5e-9 + metres.abs() * f32::EPSILON;
            assert!((back - metres).abs() <= step, "{metres} m came back {back} m");
        }
        assert_eq!(q30_to_unit(unit_to_q30(1.0)).to_bits(), 1.0_f32.to_bits());
        assert_eq!(unit_to_q30(1.0), 1 << 30);
    }
}

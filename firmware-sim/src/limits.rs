//! Shortening a vector to a device's limit without turning it.
//!
//! Clamping each component by itself would change the direction of the force, which a hand feels as a wrong surface normal.
//! Integers throughout: the result is the same on every machine.

/// `vector` scaled down to at most `limit` in length, direction kept to rounding; and whether it was shortened.
///
/// Any unit, the same for both. Components must not be [`i32::MIN`] (not a number); refuse those first.
#[must_use]
pub fn shorten(vector: [i32; 3], limit: u32) -> ([i32; 3], bool) {
    let squared: u64 = vector.iter().map(|&c| u64::from(c.unsigned_abs()).pow(2)).sum();
    let limit = u64::from(limit);
    if squared <= limit * limit {
        return (vector, false);
    }
    // rounded up, so that the scaled vector is never longer than the limit; not zero, since it is above the limit
    let length = squared.isqrt() + 1;
    let scaled = vector.map(|c| (i64::from(c) * limit as i64 / length as i64) as i32);
    (scaled, true)
}

/// `vector` times `share` / `whole`, towards zero; `share` is at most `whole`, which is not zero.
#[must_use]
pub fn scale(vector: [i32; 3], share: u32, whole: u32) -> [i32; 3] {
    vector.map(|c| (i64::from(c) * i64::from(share) / i64::from(whole.max(1))) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(v: [i32; 3]) -> f64 {
        v.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt()
    }

    #[test]
    fn within_the_limit_nothing_changes() {
        for v in [[0, 0, 0], [3, 4, 0], [-5, 0, 0], [0, 0, 5]] {
            assert_eq!(shorten(v, 5), (v, false));
        }
    }

    #[test]
    fn beyond_it_the_direction_stays_and_the_length_is_the_limit() {
        let limit = 8_500_000;
        for v in [[20_000_000, 0, 0], [0, -9_000_000, 1], [8_000_000, 8_000_000, -8_000_000], [i32::MAX, -i32::MAX, i32::MAX]] {
            let (short, shortened) = shorten(v, limit);
            assert!(shortened);
            let (l, s) = (length(v), length(short));
            assert!(s <= f64::from(limit) && s > f64::from(limit) - 3.0, "{s}");
            for (a, b) in v.iter().zip(&short) {
                let error = f64::from(*b) / s - f64::from(*a) / l;
                assert!(error.abs() < 1e-6, "{v:?} turned: {short:?}");
            }
        }
    }

    #[test]
    fn a_limit_of_zero_leaves_nothing() {
        assert_eq!(shorten([1, 2, 3], 0), ([0, 0, 0], true));
    }

    #[test]
    fn scaling_goes_from_all_to_nothing() {
        assert_eq!(scale([i32::MAX, -7, 0], 80, 80), [i32::MAX, -7, 0]);
        assert_eq!(scale([100, -100, 3], 40, 80), [50, -50, 1]);
        assert_eq!(scale([100, -100, 3], 0, 80), [0, 0, 0]);
    }
}

//! Figures for people: a unit that fits, round ends of scales, ticks between them.

/// What a figure measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Length, from m.
    Length,
    /// Pressure, from Pa.
    Pressure,
    /// Force, from N.
    Force,
    /// Torque, from N m.
    Torque,
}

/// A unit to write values in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its sign.
    pub name: &'static str,
    /// Units in one SI unit.
    pub per_si: f64,
}

impl Quantity {
    /// The unit in which `most` (SI) has one to three figures before the point, as far as there is one; for zero the largest.
    pub fn unit(self, most: f64) -> Unit {
        let units: &[(&'static str, f64)] = match self {
            Self::Length => &[("m", 1.0), ("mm", 1.0e3), ("\u{b5}m", 1.0e6)],
            Self::Pressure => &[("MPa", 1.0e-6), ("kPa", 1.0e-3), ("Pa", 1.0)],
            Self::Force => &[("N", 1.0), ("mN", 1.0e3)],
            Self::Torque => &[("N\u{b7}m", 1.0), ("mN\u{b7}m", 1.0e3), ("\u{b5}N\u{b7}m", 1.0e6)],
        };
        let fits = units.iter().find(|(_, per_si)| most == 0.0 || most * per_si >= 0.999);
        let &(name, per_si) = fits.unwrap_or(&units[units.len() - 1]);
        Unit { name, per_si }
    }

    /// A value with its unit, three figures.
    pub fn words(self, value: f64) -> String {
        let unit = self.unit(value.abs());
        format!("{} {}", figure(value * unit.per_si), unit.name)
    }

    /// A round value with its unit, without trailing zeros.
    pub fn words_round(self, value: f64) -> String {
        let unit = self.unit(value.abs());
        // three figures are enough for 1, 2, 5 times a power of ten; more would show the rounding of the product
        let figures = (value * unit.per_si * 1.0e3).round() / 1.0e3;
        format!("{figures} {}", unit.name)
    }
}

/// From here on a figure is written with its power of ten: more digits say nothing.
const MOST_WRITTEN_OUT: f64 = 1.0e6;

/// Three figures, as many as a picture can be read to.
pub fn figure(value: f64) -> String {
    if value.abs() >= MOST_WRITTEN_OUT {
        return format!("{value:.2e}");
    }
    let decimals = match value.abs() {
        v if v >= 99.95 => 0,
        v if v >= 9.995 => 1,
        0.0 => 0,
        _ => 2,
    };
    format!("{value:.decimals$}")
}

/// Ends of scales within a decade, each with the step of its ticks.
const ENDS: [(f64, f64); 9] =
    [(1.0, 0.2), (1.2, 0.2), (1.5, 0.5), (2.0, 0.5), (2.5, 0.5), (3.0, 1.0), (4.0, 1.0), (6.0, 2.0), (8.0, 2.0)];

/// The power of ten at or below a value above zero, in products alone: the same on every machine.
fn decade(value: f64) -> f64 {
    let mut decade = 1.0;
    while decade * 10.0 <= value {
        decade *= 10.0;
    }
    while decade > value {
        decade /= 10.0;
    }
    decade
}

/// Values come from single precision: what is above a round end by its rounding alone has that end.
const SINGLE: f64 = 1.0e-6;

/// The least round number from `value` up, and a round step that divides it into 3 to 6. (1, 0.2) for what is not above zero.
pub fn round_end(value: f64) -> (f64, f64) {
    if !(value.is_finite() && value > f64::MIN_POSITIVE) {
        return ENDS[0];
    }
    let decade = decade(value);
    let fits = ENDS.iter().find(|(end, _)| end * decade >= value * (1.0 - SINGLE));
    fits.map_or((10.0 * decade, 2.0 * decade), |&(end, step)| (end * decade, step * decade))
}

/// The largest of 1, 2, 5 times a power of ten that is not above `value`; 1 for what is not above zero.
pub fn round_step(value: f64) -> f64 {
    if !(value.is_finite() && value > f64::MIN_POSITIVE) {
        return 1.0;
    }
    let decade = decade(value);
    [5.0, 2.0, 1.0].map(|part| part * decade).into_iter().find(|&step| step <= value * (1.0 + 1.0e-9)).unwrap_or(decade)
}

/// The least of 1, 2, 5 times a power of ten that is not below `value`, then `up` steps further on that ladder; 1 for what is not above zero.
pub fn round_rung(value: f64, up: i32) -> f64 {
    if !(value.is_finite() && value > f64::MIN_POSITIVE) {
        return 1.0;
    }
    let mut rung = [1.0, 2.0, 5.0, 10.0]
        .map(|part| part * decade(value))
        .into_iter()
        .find(|&r| r >= value * (1.0 - 1.0e-9))
        .unwrap_or(value);
    for _ in 0..up.unsigned_abs() {
        let leading = (rung / decade(rung * (1.0 + 1.0e-9))).round() as u32;
        rung *= match (leading, up > 0) {
            (2, true) | (5, false) => {
                if up > 0 {
                    2.5
                } else {
                    0.4
                }
            }
            (_, true) => 2.0,
            (_, false) => 0.5,
        };
    }
    rung
}

/// Places behind the point that figures `step` apart need, up to 9.
pub fn decimals(step: f64) -> usize {
    (0..9).find(|&places| step * 10.0_f64.powi(places) >= 0.999).unwrap_or(9) as usize
}

/// A scale from zero to `end`, as shares and words of its ticks in `unit`.
pub fn ticks(end: f64, step: f64, unit: Unit) -> Vec<(f64, String)> {
    let count = (end / step + 1.0e-6).floor().max(1.0) as u32;
    let shown = step * unit.per_si;
    let decimals = decimals(shown);
    (0..=count).map(|k| ((f64::from(k) * step / end).min(1.0), format!("{:.decimals$}", f64::from(k) * shown))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_units_that_fit() {
        let table = [
            (Quantity::Force, 23.71, "23.7 N"),
            (Quantity::Force, 0.0123, "12.3 mN"),
            (Quantity::Torque, 0.0438, "43.8 mN\u{b7}m"),
            (Quantity::Length, 1.02e-3, "1.02 mm"),
            (Quantity::Length, 0.01, "10.0 mm"),
            (Quantity::Length, 3.0e-6, "3.00 \u{b5}m"),
            (Quantity::Pressure, 4.2e5, "420 kPa"),
            (Quantity::Pressure, 0.0, "0 MPa"),
        ];
        for (quantity, value, words) in table {
            assert_eq!(quantity.words(value), words);
        }
    }

    #[test]
    fn ends_are_round_and_not_below() {
        let table =
            [(0.93, 1.0), (1.0, 1.0), (1.01, 1.2), (8.1, 10.0), (0.00126, 0.0015), (5.0e5, 6.0e5), (0.0, 1.0), (f64::NAN, 1.0)];
        for (value, end) in table {
            let (found, step) = round_end(value);
            assert!((found / end - 1.0).abs() < 1.0e-9, "{value}: {found}");
            assert!((2.9..=6.1).contains(&(found / step)), "{value}: {step}");
        }
        for (value, step) in [(0.019, 0.01), (0.02, 0.02), (7.0, 5.0), (0.0, 1.0)] {
            assert!((round_step(value) / step - 1.0).abs() < 1.0e-9, "{value}");
        }
    }

    #[test]
    fn ticks_are_written_as_finely_as_they_step() {
        let words = |end, step, quantity: Quantity| -> Vec<String> {
            ticks(end, step, quantity.unit(end)).into_iter().map(|(_, words)| words).collect()
        };
        assert_eq!(words(1.0e-3, 2.0e-4, Quantity::Length), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(words(6.0e5, 2.0e5, Quantity::Pressure), ["0", "200", "400", "600"]);
        assert_eq!(ticks(1.2, 0.2, Quantity::Force.unit(1.2)).last().unwrap().0, 1.0);
    }
}

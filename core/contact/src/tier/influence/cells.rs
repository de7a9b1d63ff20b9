//! Which cells of a window lie in the contact, and what load each carries.

use crate::math::{ln, min, root};
use crate::profile::{FULLNESS_CONE, FULLNESS_HERTZ, FULLNESS_PUNCH};
use crate::tier::Hold;

/// Midpoints along a cell's edge that its load is summed from: 16 per cell put the rim cells within 2 % and the rest within 0.1 %.
const POINTS: usize = 4;

/// Distance of a cell's centre from the rim, in cell widths, from which on it carries its whole load: nearer, it enters or leaves the contact by and by.
const ENTERING: f32 = 0.25;

/// The cells of a window, row by row.
#[derive(Clone, Debug)]
pub struct Cells<const W: usize> {
    /// Normal load \[N\]; 0 outside the contact.
    pub load: [[f32; W]; W],
    /// Factor on the places of cells as arms of a twist, so that the torque of full slip is exact.
    pub arm: f32,
}

impl<const W: usize> Cells<W> {
    /// Cells of `width` \[m\] under the load of `hold`. A cell is in contact when its centre is, with less than its load next to the rim.
    pub fn new(hold: &Hold, width: f32) -> Self {
        let mut load = [[0.0; W]; W];
        let (mut total, mut torque) = (0.0, 0.0);
        let half = W / 2;
        let step = width / hold.radius;
        for j in 0..half {
            for i in 0..=j {
                let (x, y) = (step * (i as f32 + 0.5), step * (j as f32 + 0.5));
                let r2 = x * x + y * y;
                if r2 >= 1.0 {
                    break;
                }
                let entering = min((1.0 - root(r2)) / (ENTERING * step), 1.0);
                let share = around(hold.profile.fullness(), x, y, step) * entering;
                let copies = if i == j { 4.0 } else { 8.0 };
                total += copies * share;
                torque += copies * share * root(r2);
                spread(&mut load, half, i, j, share);
            }
        }
        let scale = hold.load / total;
        load.as_flattened_mut().iter_mut().for_each(|cell| *cell *= scale);
        Self { load, arm: hold.profile.full_slip_torque() * total / torque }
    }
}

/// The eight cells that mirror (i, j).
fn spread<const W: usize>(load: &mut [[f32; W]; W], half: usize, i: usize, j: usize, value: f32) {
    let (left, right, low, high) = (half - 1 - i, half + i, half - 1 - j, half + j);
    for column in [left, right] {
        for row in [low, high] {
            for (row, column) in [(row, column), (column, row)] {
                if let Some(cell) = load.get_mut(row).and_then(|row| row.get_mut(column)) {
                    *cell = value;
                }
            }
        }
    }
}

/// Load of the square cell of edge `step` about (x, y), up to a factor common to all cells; lengths in contact radii.
fn around(fullness: f32, x: f32, y: f32, step: f32) -> f32 {
    let part = step / POINTS as f32;
    let at = |k: usize| (k as f32 + 0.5) * part - 0.5 * step;
    let mut sum = 0.0;
    for i in 0..POINTS {
        for j in 0..POINTS {
            let (px, py) = (x + at(i), y + at(j));
            sum += pressure(fullness, px * px + py * py);
        }
    }
    sum
}

/// Pressure over P/(pi a^2) at the square of r/a: the mixture of cone, paraboloid and punch of the profile's fullness.
fn pressure(fullness: f32, q2: f32) -> f32 {
    if q2 >= 1.0 {
        return 0.0;
    }
    let x = root(1.0 - q2);
    let hertz = 1.5 * x;
    if fullness == FULLNESS_HERTZ {
        return hertz;
    }
    if fullness < FULLNESS_HERTZ {
        let cone = ln((1.0 + x) / root(q2));
        return cone + (hertz - cone) * (fullness - FULLNESS_CONE) / (FULLNESS_HERTZ - FULLNESS_CONE);
    }
    let punch = 0.5 / x;
    hertz + (punch - hertz) * (fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ)
}

//! The influence of cells on cells, four mirror images at a time.
//!
//! The grid is its own image in both axes. A **place** is a cell of the quarter x, y > 0 with its three images; what the four of them have are
//! **lanes**: the cell itself, its image across the y axis, across the x axis, across both. Sums of the lanes with the signs of the four
//! **classes** (even or odd along x, even or odd along y) do not mix: a force of one class moves every place in that class alone, so that
//! a place's influence on another is one number per class where the cells' would be sixteen (theory.md, section 6.4).
//!
//! An influence that is odd along both axes, that of x on y, takes a class to the opposite one: even to odd along both axes.

use crate::lanes::{LANES, Lanes};
use crate::tier::influence::table::{ALONG, CROSS};

/// Images of a cell, itself among them: in this order cell, image along x, image along y, both. Of classes: even, odd along x, odd along y, odd along both.
pub const IMAGES: usize = LANES;

/// Signs of the images along x.
pub const SIGN_X: Lanes = Lanes([1.0, -1.0, 1.0, -1.0]);

/// Signs of the images along y.
pub const SIGN_Y: Lanes = Lanes([1.0, 1.0, -1.0, -1.0]);

impl Lanes {
    /// Sums of the images by class; of the classes by image, times four.
    pub fn crossed(self) -> Self {
        let [a, b, c, d] = self.0;
        let [s, t, u, v] = (Self([b, a, d, c]) + self * SIGN_X).0;
        Self([u, v, s, t]) + Self([s, t, u, v]) * SIGN_Y
    }

    /// The opposite class of each.
    pub fn opposite(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([d, c, b, a])
    }
}

/// Cells from the middle to the side of the widest square.
pub const HALF: usize = 7;

/// A cell of the quarter x, y > 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Column, counted from the middle.
    pub column: usize,
    /// Row, counted from the middle.
    pub row: usize,
}

impl Place {
    /// Centre of the cell, in cell widths.
    pub const fn centre(&self) -> (f32, f32) {
        (self.column as f32 + 0.5, self.row as f32 + 0.5)
    }

    /// Square of the distance of its centre from the middle, in cell widths.
    pub const fn distance2(&self) -> f32 {
        let (x, y) = self.centre();
        x * x + y * y
    }

    /// Four times the square of that distance, a whole number.
    pub const fn distance2_4(&self) -> usize {
        let (x, y) = (2 * self.column + 1, 2 * self.row + 1);
        x * x + y * y
    }

    /// What the order goes by: the distance, among equals the longer side, then the column; a cell is next to its image in the diagonal.
    const fn rank(&self) -> usize {
        let (i, j) = (self.column, self.row);
        let longer = if i > j { i } else { j };
        ((i * (i + 1) + j * (j + 1)) * HALF + longer) * HALF + i
    }
}

/// Places whose centres are less than `half` cells from the middle: what a contact that fits the square can reach.
pub const fn within(half: usize) -> usize {
    let (mut count, mut k) = (0, 0);
    // bound: HALF squared places
    while k < HALF * HALF {
        let place = Place { column: k % HALF, row: k / HALF };
        if place.distance2() < (half * half) as f32 {
            count += 1;
        }
        k += 1;
    }
    count
}

/// Places of the widest grid.
pub const PLACES: usize = within(HALF);

/// The places, from the middle outwards: those of a narrower contact come first.
pub const ORDER: [Place; PLACES] = order();

/// Centres of the places, in cell widths.
pub static CENTRES: [(f32, f32); PLACES] = centres();

const fn centres() -> [(f32, f32); PLACES] {
    let mut centres = [(0.0, 0.0); PLACES];
    let mut k = 0;
    // bound: PLACES, when the program is built
    while k < PLACES {
        centres[k] = ORDER[k].centre();
        k += 1;
    }
    centres
}

const fn order() -> [Place; PLACES] {
    let mut sorted = [Place { column: 0, row: 0 }; PLACES];
    let (mut n, mut last) = (0, None);
    // bound: PLACES, when the program is built
    while n < PLACES {
        let next = following(last);
        sorted[n] = next;
        last = Some(next.rank());
        n += 1;
    }
    sorted
}

/// The place of the lowest rank above `last`.
const fn following(last: Option<usize>) -> Place {
    let mut best = Place { column: HALF, row: HALF };
    let mut k = 0;
    // bound: HALF squared places
    while k < HALF * HALF {
        let place = Place { column: k % HALF, row: k / HALF };
        let above = match last {
            Some(last) => place.rank() > last,
            None => true,
        };
        if above && place.rank() < best.rank() {
            best = place;
        }
        k += 1;
    }
    best
}

/// Influence of one place on another by class, of a unit width of cell. With nu Poisson's ratio, a = 1 - nu/2 and b = nu/2: x from x is
/// a `round` + b `long`, y from y a `round` - b `long`, and either from the opposite class of the other b `cross`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Integral of 1/r.
    pub round: Lanes,
    /// Integral of (x^2 - y^2)/r^3.
    pub long: Lanes,
    /// Integral of 2 x y/r^3.
    pub cross: Lanes,
}

/// What moves the place of a row from the place of a column.
pub static PAIRS: [[Pair; PLACES]; PLACES] = pairs();

const fn pairs() -> [[Pair; PLACES]; PLACES] {
    let none = Lanes([0.0; IMAGES]);
    let mut pairs = [[Pair { round: none, long: none, cross: none }; PLACES]; PLACES];
    let mut k = 0;
    // bound: PLACES squared, when the program is built
    while k < PLACES * PLACES {
        pairs[k / PLACES][k % PLACES] = pair(ORDER[k / PLACES], ORDER[k % PLACES]);
        k += 1;
    }
    pairs
}

const fn pair(to: Place, from: Place) -> Pair {
    let none = [0.0; IMAGES];
    let (mut round, mut long, mut cross) = (none, none, none);
    let mut image = 0;
    // bound: IMAGES, when the program is built
    while image < IMAGES {
        let (dx, back) = offset(to.column, from.column, image % 2 == 1);
        let (dy, down) = offset(to.row, from.row, image / 2 == 1);
        let (x2, y2, xy) = (ALONG[dy][dx], ALONG[dx][dy], 2.0 * CROSS[dy][dx]);
        round[image] = x2 + y2;
        long[image] = x2 - y2;
        cross[image] = if back != down { -xy } else { xy };
        image += 1;
    }
    let [a, b, c, d] = by_class(cross);
    Pair { round: Lanes(by_class(round)), long: Lanes(by_class(long)), cross: Lanes([d, c, b, a]) }
}

/// As [`Lanes::crossed`], before the program runs.
const fn by_class([a, b, c, d]: [f32; IMAGES]) -> [f32; IMAGES] {
    let (s, t, u, v) = (a + b, a - b, c + d, c - d);
    [s + u, t + v, s - u, t - v]
}

/// Distance from cell `from`, or its image beyond the middle, to cell `to` along an axis, and whether it points back.
const fn offset(to: usize, from: usize, mirrored: bool) -> (usize, bool) {
    if mirrored { (to + from + 1, false) } else { (to.abs_diff(from), to < from) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_go_outwards_and_next_to_their_image_in_the_diagonal() {
        assert_eq!((within(5), PLACES), (20, 39));
        for (k, place) in ORDER.iter().enumerate() {
            assert!(k == 0 || ORDER[k - 1].distance2() <= place.distance2(), "{k}");
            let (i, j) = (place.column, place.row);
            assert!(i >= j || ORDER[k + 1] == Place { column: j, row: i }, "{k}");
        }
    }

    /// Every image of every place against every other, cell by cell.
    #[test]
    fn classes_move_what_cells_move() {
        let at = |place: &Place, image: usize, back: [i32; 2]| {
            let [i, j] = [place.column as i32, place.row as i32];
            [if image % 2 == 1 { back[0] - i } else { i }, if image / 2 == 1 { back[1] - j } else { j }]
        };
        for (to, row) in ORDER.iter().zip(&PAIRS) {
            for (from, pair) in ORDER.iter().zip(row) {
                for image in 0..IMAGES {
                    // a force on one image of the source alone, along x
                    let mut force = [0.0; IMAGES];
                    force[image] = 0.25;
                    let force = Lanes(force).crossed();
                    let along = (pair.round * force + pair.long * force).crossed();
                    let across = (pair.cross * force.opposite()).crossed();
                    for end in 0..IMAGES {
                        let (a, b) = (at(to, end, [-1, -1]), at(from, image, [-1, -1]));
                        let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
                        let (i, j) = (dx.unsigned_abs() as usize, dy.unsigned_abs() as usize);
                        let sign = (dx.signum() * dy.signum()) as f32;
                        assert!((along.0[end] - 2.0 * ALONG[j][i]).abs() < 2.0e-6, "{to:?} {from:?} {image} {end}");
                        assert!((across.0[end] - 2.0 * sign * CROSS[j][i]).abs() < 2.0e-6, "{to:?} {from:?} {image} {end}");
                    }
                }
            }
        }
    }
}

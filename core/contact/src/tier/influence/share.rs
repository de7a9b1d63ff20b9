//! Forces move from a grid to the one that is laid anew over it: each cell hands its force to the cells that overlap it, by the overlap.
//!
//! A cell lies in the same quarter as the cells that overlap it, so that the four images of a place are shared out alike. The share of an overlap is its
//! share along x times that along y, so that the two axes are done one after the other.

use glam::Vec2;

use crate::lanes::Lanes;
use crate::math::{clamp, max, min};
use crate::tier::bristle::Bristle;
use crate::tier::influence::grid::{Layout, centred};
use crate::tier::influence::mirror::{HALF, IMAGES, ORDER, Place};

/// The quarter of the square, row by row from the middle.
type Quarter = [[Lanes; HALF]; HALF];

/// Moves the forces from cells of width `old` to cells of width `new` \[m\]; what lies beyond the new grid goes to its nearest cells.
pub fn share_out(layout: &Layout, old: f32, new: f32, cells: &mut [Bristle]) {
    let cells = cells.get_mut(..IMAGES * layout.places()).unwrap_or_default();
    let before = torque(old, cells);
    let shares = Shares::new(layout.half, old / new);
    let adds = |to: &mut Lanes, value: Lanes, share: f32| *to += value * share;
    let keeps_most = |to: &mut Lanes, value: Lanes, _: f32| *to = to.larger(value);
    let [x, y, slipped] = quarters(cells);
    let x = shares.along_rows(&shares.along_rows(&x, adds), adds);
    let y = shares.along_rows(&shares.along_rows(&y, adds), adds);
    let slipped = shares.along_rows(&shares.along_rows(&slipped, keeps_most), keeps_most);
    gather([x, y, slipped], cells);
    restore_torque(new, before, cells);
}

/// Force along x, along y, and the slip of the cells that hold a force.
fn quarters(cells: &[Bristle]) -> [Quarter; 3] {
    let mut quarters = [[[Lanes::default(); HALF]; HALF]; 3];
    for (place, images) in ORDER.iter().zip(cells.as_chunks::<IMAGES>().0) {
        let slipped = images.map(|cell| if cell.force == Vec2::ZERO { 0.0 } else { cell.slipped });
        let of = [images.map(|cell| cell.force.x), images.map(|cell| cell.force.y), slipped];
        for (quarter, values) in quarters.iter_mut().zip(of) {
            if let Some(at) = quarter.get_mut(place.row).and_then(|row| row.get_mut(place.column)) {
                *at = Lanes(values);
            }
        }
    }
    quarters
}

/// The cells of what was shared out. A corner of the square that is no place goes to its neighbour towards the middle.
fn gather([x, y, slipped]: [Quarter; 3], cells: &mut [Bristle]) {
    let images = cells.as_chunks_mut::<IMAGES>().0;
    let reach = ORDER.get(images.len().saturating_sub(1)).map_or(0.0, Place::distance2);
    for (place, cells) in ORDER.iter().zip(images) {
        let mut sum = at([&x, &y, &slipped], place.row, place.column);
        let (mut row, mut column) = (place.row + 1, place.column + 1);
        // bound: HALF steps along the diagonal
        while row < HALF && column < HALF && (Place { column, row }).distance2() > reach {
            let [of_x, of_y, most] = at([&x, &y, &slipped], row, column);
            sum = [sum[0] + of_x, sum[1] + of_y, sum[2].larger(most)];
            (row, column) = (row + 1, column + 1);
        }
        for (image, cell) in cells.iter_mut().enumerate() {
            *cell = Bristle { force: Vec2::new(sum[0].0[image], sum[1].0[image]), slipped: sum[2].0[image] };
        }
    }
}

fn at(of: [&Quarter; 3], row: usize, column: usize) -> [Lanes; 3] {
    of.map(|quarter| quarter.get(row).and_then(|row| row.get(column)).copied().unwrap_or_default())
}

/// Which new cells of a half an old one overlaps along an axis, and by how much.
struct Shares {
    half: usize,
    first: [usize; HALF],
    last: [usize; HALF],
    share: [[f32; HALF]; HALF],
}

impl Shares {
    /// Overlaps of `half` cells with as many whose width is theirs over `ratio`. The outermost new cell counts as endless.
    fn new(half: usize, ratio: f32) -> Self {
        let mut shares = Self { half, first: [0; HALF], last: [0; HALF], share: [[0.0; HALF]; HALF] };
        let cell = |edge: f32| clamp(edge, 0.0, half as f32 - 1.0) as usize;
        let ends = shares.first.iter_mut().zip(&mut shares.last).zip(&mut shares.share);
        for (k, ((first, last), share)) in ends.enumerate().take(half) {
            let (low, high) = (k as f32 * ratio, (k as f32 + 1.0) * ratio);
            (*first, *last) = (cell(low), cell(high));
            let from = *first;
            for (to, share) in share.iter_mut().enumerate().take(*last + 1).skip(from) {
                let end = if to + 1 == half { high } else { min(high, to as f32 + 1.0) };
                *share = max(end - max(low, to as f32), 0.0) / ratio;
            }
        }
        shares
    }

    /// Shares rows out over new rows; rows and columns then change places.
    fn along_rows(&self, quarter: &Quarter, combine: impl Fn(&mut Lanes, Lanes, f32)) -> Quarter {
        let mut next = [[Lanes::default(); HALF]; HALF];
        let ends = self.first.iter().zip(&self.last).zip(&self.share);
        for (row, ((&first, &last), shares)) in quarter.iter().zip(ends).take(self.half) {
            for (to, &share) in next.iter_mut().zip(shares).take(last + 1).skip(first) {
                to.iter_mut().zip(row).take(self.half).for_each(|(to, &value)| combine(to, value, share));
            }
        }
        core::array::from_fn(|row| core::array::from_fn(|column| next[column][row]))
    }
}

/// Torque about the centre with every cell's force at its centre \[N m\].
fn torque(width: f32, cells: &mut [Bristle]) -> f32 {
    width * centred(cells).map(|(at, cell)| at.perp_dot(cell.force)).sum::<f32>()
}

/// Turns the lost or gained torque back in as a hoop force that grows with the radius, in the cells that hold anything.
fn restore_torque(width: f32, before: f32, cells: &mut [Bristle]) {
    let missing = before - torque(width, cells);
    let holding = |(_, cell): &(Vec2, &mut Bristle)| cell.force != Vec2::ZERO;
    let arms = width * centred(cells).filter(holding).map(|(at, _)| at.length_squared()).sum::<f32>();
    if arms > 0.0 {
        centred(cells).filter(holding).for_each(|(at, cell)| cell.force += at.perp() * (missing / arms));
    }
}

//! Forces move from a grid to the one that is laid anew over it: each cell hands its force to the cells that overlap it, by the overlap.
//!
//! A cell lies in the same quarter as the cells that overlap it, so that the four images of a place are shared out alike. The share of an overlap is its
//! share along x times that along y, so that the two axes are done one after the other.

use glam::Vec2;

use crate::lanes::Lanes;
use crate::math::{clamp, max, min};
use crate::tier::bristle::Bristle;
use crate::tier::influence::grid::Layout;
use crate::tier::influence::mirror::{CENTRES, HALF, IMAGES, ORDER, Place, SIGN_X, SIGN_Y};

/// The quarter of the square, row by row from the middle.
type Quarter = [[Lanes; HALF]; HALF];

/// Moves the forces from cells of width `old` to cells of width `new` \[m\]; what lies beyond the new grid goes to its nearest cells.
pub fn share_out(layout: &Layout, old: f32, new: f32, cells: &mut [Bristle]) {
    let cells = cells.get_mut(..IMAGES * layout.places()).unwrap_or_default().as_chunks_mut::<IMAGES>().0;
    let before = old * torque(cells);
    let shares = Shares::new(layout.half, old / new);
    let adds = |to: &mut Lanes, value: Lanes, share: f32| *to += value * share;
    let keeps_most = |to: &mut Lanes, value: Lanes, _: f32| *to = to.larger(value);
    let x = shares.over_both(&quarter(cells, |cell| cell.force.x), adds);
    let y = shares.over_both(&quarter(cells, |cell| cell.force.y), adds);
    let slip = |cell: &Bristle| if cell.force == Vec2::ZERO { 0.0 } else { cell.slipped };
    let slipped = shares.over_both(&quarter(cells, slip), keeps_most);
    gather([&x, &y, &slipped], cells);
    restore_torque(new, before, cells);
}

/// A figure of the cells where they lie.
fn quarter(cells: &[[Bristle; IMAGES]], figure: impl Fn(&Bristle) -> f32) -> Quarter {
    let mut quarter = [[Lanes::default(); HALF]; HALF];
    for (place, [a, b, c, d]) in ORDER.iter().zip(cells) {
        if let Some(at) = quarter.get_mut(place.row).and_then(|row| row.get_mut(place.column)) {
            *at = Lanes([figure(a), figure(b), figure(c), figure(d)]);
        }
    }
    quarter
}

/// The cells of what was shared out: force along x, along y, and slip. A corner of the square that is no place goes to its neighbour towards the middle.
fn gather(shared: [&Quarter; 3], cells: &mut [[Bristle; IMAGES]]) {
    let reach = ORDER.get(cells.len().saturating_sub(1)).map_or(0, Place::distance2_4);
    for (place, cells) in ORDER.iter().zip(cells) {
        let mut sum = at(shared, place.row, place.column);
        let (mut row, mut column) = (place.row + 1, place.column + 1);
        // bound: HALF steps along the diagonal
        while row < HALF && column < HALF && (Place { column, row }).distance2_4() > reach {
            let [of_x, of_y, most] = at(shared, row, column);
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

    /// Shares a quarter out along both axes.
    fn over_both(&self, quarter: &Quarter, combine: impl Fn(&mut Lanes, Lanes, f32) + Copy) -> Quarter {
        let (mut rows, mut next) = ([[Lanes::default(); HALF]; HALF], [[Lanes::default(); HALF]; HALF]);
        self.over(quarter, &mut rows, |to, from, share| {
            to.iter_mut().zip(from).take(self.half).for_each(|(to, &value)| combine(to, value, share));
        });
        for (from, to) in rows.iter().zip(&mut next).take(self.half) {
            self.over(from, to, |to, &value, share| combine(to, value, share));
        }
        next
    }

    /// Shares what lies along an axis out over it.
    fn over<T>(&self, from: &[T; HALF], to: &mut [T; HALF], combine: impl Fn(&mut T, &T, f32)) {
        let ends = self.first.iter().zip(&self.last).zip(&self.share);
        for (from, ((&first, &last), shares)) in from.iter().zip(ends).take(self.half) {
            for (to, &share) in to.iter_mut().zip(shares).take(last + 1).skip(first) {
                combine(to, from, share);
            }
        }
    }
}

/// Torque about the centre with every cell's force at its centre, over the width of a cell \[N\].
fn torque(cells: &[[Bristle; IMAGES]]) -> f32 {
    let (mut along_x, mut along_y) = (Lanes::default(), Lanes::default());
    for (&(x, y), cells) in CENTRES.iter().zip(cells) {
        along_x += Lanes(cells.map(|cell| cell.force.x)) * y;
        along_y += Lanes(cells.map(|cell| cell.force.y)) * x;
    }
    (along_y * SIGN_X - along_x * SIGN_Y).total()
}

/// Turns the lost or gained torque back in as a hoop force that grows with the radius, in the cells that hold anything.
fn restore_torque(width: f32, before: f32, cells: &mut [[Bristle; IMAGES]]) {
    let missing = before - width * torque(cells);
    let mut arms = Lanes::default();
    for (&(x, y), cells) in CENTRES.iter().zip(cells.iter()) {
        arms += holding(cells) * (x * x + y * y);
    }
    let arms = width * arms.total();
    if arms <= 0.0 {
        return;
    }
    for (&(x, y), cells) in CENTRES.iter().zip(cells) {
        let hoop = holding(cells) * (missing / arms);
        let (hoop_x, hoop_y) = (hoop * SIGN_Y * -y, hoop * SIGN_X * x);
        for (image, cell) in cells.iter_mut().enumerate() {
            cell.force += Vec2::new(hoop_x.0[image], hoop_y.0[image]);
        }
    }
}

/// 1 for a cell that holds a force, 0 for others.
fn holding(cells: &[Bristle; IMAGES]) -> Lanes {
    Lanes(cells.map(|cell| if cell.force == Vec2::ZERO { 0.0 } else { 1.0 }))
}

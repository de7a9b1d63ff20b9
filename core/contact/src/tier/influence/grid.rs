//! The square grid of a patch, and how tractions move to a new one.
//!
//! Cells have the width h and keep their place in the material while the contact radius a stays within a range of h: a growing contact
//! enters new, free cells and a shrinking one leaves cells behind. When a leaves the range the grid is laid anew and the forces are shared
//! out by overlap, so that force and torque of the patch are kept.

use glam::Vec2;

use crate::math::{PI, clamp, max, min, root, sqrt};
use crate::patch::{Grip, Shift};
use crate::tier::bristle::Bristle;
use crate::tier::influence::{Stored, Trace};

/// How many cells a patch is cut into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Cells in a contact on a fresh grid.
    pub cells: usize,
    /// Cells along the side of the square that is kept: room for the contact to grow.
    pub side: usize,
}

impl Layout {
    /// 52 cells: 8 across a fresh contact.
    pub const COARSE: Self = Self { cells: 52, side: 10 };
    /// 112 cells: 12 across.
    pub const FINE: Self = Self { cells: 112, side: 14 };

    /// The finest layout of at most `cells` cells that `room` samples can keep.
    pub fn fitting(cells: usize, room: usize) -> Option<Self> {
        [Self::FINE, Self::COARSE].into_iter().find(|layout| layout.cells <= cells && layout.slots() <= room)
    }

    /// Samples of the state that are used.
    pub const fn slots(&self) -> usize {
        self.side * self.side
    }

    /// Places along the side of the widest window that is looked at: the smallest of the solver's that holds the square.
    pub const fn widest_window(&self) -> usize {
        if self.side <= 12 { 12 } else { 16 }
    }

    /// Cells whose centres a contact holds at most: on the square's inscribed circle the grid is laid anew.
    pub const fn most_cells(&self) -> usize {
        if self.side <= 12 { MOST_OF_10 } else { MOST_OF_14 }
    }

    /// Contact radius over cell width of a fresh grid: the cells whose centre lies in the contact have its area.
    fn fresh(&self) -> f32 {
        sqrt(self.cells as f32 / PI)
    }
}

/// Cell centres within a circle of 5 cell widths about the corner of four cells.
const MOST_OF_10: usize = 80;

/// The same within 7.
const MOST_OF_14: usize = 156;

/// Most samples of any layout.
const MOST_SLOTS: usize = Layout::FINE.slots();

/// Smallest contact radius, as a share of a fresh grid's, before the grid is laid anew.
const FEWEST: f32 = 0.8;

/// The grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grid {
    /// Width of a cell \[m\]; 0 before the first load.
    pub width: f32,
    /// Contact radius that the forces were last solved for \[m\].
    pub radius: f32,
    /// Cells along the side of the square.
    pub side: usize,
    /// Shift of the last tick.
    pub wanted: Shift,
}

impl Grid {
    /// Lays the grid anew when `radius` has left its range; a first grid takes up what another tier `held`.
    pub fn fit(&mut self, layout: &Layout, radius: f32, held: &Grip, cells: &mut Stored<'_>) {
        let width = radius / layout.fresh();
        if self.width <= 0.0 || self.side != layout.side {
            cells.clear();
            *self = Self { width, radius, side: layout.side, wanted: Shift::default() };
            seed(layout, self, held, cells.force);
        } else if radius > 0.5 * self.width * layout.side as f32 || radius < FEWEST * self.width * layout.fresh() {
            share_out(layout, self.width, width, cells.force);
            cells.trace.fill(Trace::default());
            (self.width, self.wanted) = (width, Shift::default());
        }
    }
}

/// Place of the centre of cell `k` along an axis, in cell widths.
fn place(side: usize, k: usize) -> f32 {
    k as f32 + 0.5 - 0.5 * side as f32
}

/// Place of a cell's centre \[m\].
fn centre(layout: &Layout, width: f32, k: usize) -> Vec2 {
    Vec2::new(place(layout.side, k % layout.side), place(layout.side, k / layout.side)) * width
}

/// Spreads a grip over the cells in contact by the load of a round contact, force and hoop force alike: as a contact in full slip holds it, so that no
/// cap cuts what was held.
fn seed(layout: &Layout, grid: &Grid, held: &Grip, cells: &mut [Bristle]) {
    if held.force == Vec2::ZERO && held.torque == 0.0 {
        return;
    }
    let load = |arm: Vec2| root(max(1.0 - arm.length_squared() / (grid.radius * grid.radius), 0.0));
    let (mut loads, mut arms) = (0.0, 0.0);
    for arm in (0..layout.slots()).map(|k| centre(layout, grid.width, k)) {
        loads += load(arm);
        arms += load(arm) * root(arm.length_squared());
    }
    for (k, cell) in cells.iter_mut().enumerate().take(layout.slots()) {
        let arm = centre(layout, grid.width, k);
        // no cell is centred on the patch: sides are even
        let hoop = arm.perp() * (held.torque / (arms * root(arm.length_squared())));
        cell.force = (held.force / loads + hoop) * load(arm);
    }
}

/// Moves every cell's force to the cells of the new grid that overlap it; what lies beyond the new square goes to its nearest cells.
fn share_out(layout: &Layout, old: f32, new: f32, cells: &mut [Bristle]) {
    let side = layout.side;
    let before = torque(layout, old, cells);
    let mut next = [Bristle::default(); MOST_SLOTS];
    for (k, from) in cells.iter().take(layout.slots()).enumerate() {
        if from.force == Vec2::ZERO {
            continue;
        }
        let (columns, rows) = (overlap(side, k % side, old / new), overlap(side, k / side, old / new));
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                let share = part(side, k % side, column, old / new) * part(side, k / side, row, old / new);
                if let Some(to) = next.get_mut(row * side + column) {
                    to.force += from.force * share;
                    to.slipped = max(to.slipped, from.slipped);
                }
            }
        }
    }
    cells.iter_mut().zip(next).take(layout.slots()).for_each(|(cell, next)| *cell = next);
    restore_torque(layout, new, before, cells);
}

/// First and last new cell that old cell `k` overlaps along an axis; `ratio` is the old width over the new.
fn overlap(side: usize, k: usize, ratio: f32) -> (usize, usize) {
    let at = |edge: f32| {
        let place = edge * ratio + 0.5 * side as f32;
        clamp(place, 0.0, side as f32 - 1.0) as usize
    };
    let middle = place(side, k);
    (at(middle - 0.5), at(middle + 0.5))
}

/// Share of old cell `k` that lies in new cell `to` along an axis. The outermost new cells count as endless.
fn part(side: usize, k: usize, to: usize, ratio: f32) -> f32 {
    let (from, into) = (place(side, k) * ratio, place(side, to));
    let low = if to == 0 { f32::NEG_INFINITY } else { into - 0.5 };
    let high = if to + 1 == side { f32::INFINITY } else { into + 0.5 };
    max(min(from + 0.5 * ratio, high) - max(from - 0.5 * ratio, low), 0.0) / ratio
}

/// Torque about the centre with every cell's force at its centre \[N m\].
fn torque(layout: &Layout, width: f32, cells: &[Bristle]) -> f32 {
    cells.iter().take(layout.slots()).enumerate().map(|(k, cell)| centre(layout, width, k).perp_dot(cell.force)).sum()
}

/// Turns the lost or gained torque back in as a hoop force that grows with the radius, in the cells that hold anything.
fn restore_torque(layout: &Layout, width: f32, before: f32, cells: &mut [Bristle]) {
    let missing = before - torque(layout, width, cells);
    let holds = |cell: &Bristle| cell.force != Vec2::ZERO;
    let held = cells.iter().take(layout.slots()).enumerate().filter(|(_, cell)| holds(cell));
    let arms: f32 = held.map(|(k, _)| centre(layout, width, k).length_squared()).sum();
    if arms <= 0.0 {
        return;
    }
    for (k, cell) in cells.iter_mut().take(layout.slots()).enumerate() {
        if holds(cell) {
            cell.force += centre(layout, width, k).perp() * (missing / arms);
        }
    }
}

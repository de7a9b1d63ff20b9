//! The polar grid of a patch, and how tractions move to a new one.
//!
//! Rings have equal width h and keep it while the contact radius a stays within a range of h, so that a growing contact enters
//! new, free rings and a shrinking one leaves rings behind. When a leaves the range the grid is laid anew and the forces are
//! shared out by overlap, so that force and torque of the patch are kept.

use glam::Vec2;

use crate::math::{clamp, max, min};
use crate::patch::Grip;
use crate::tier::Hold;
use crate::tier::bristle::ring::Rings;
use crate::tier::bristle::{AROUND, Bristle, Layout, MAX_RINGS};

/// The grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grid {
    /// Width of a ring \[m\]; 0 before the first load.
    pub width: f32,
    /// Contact radius the bristles were last fitted to \[m\].
    pub radius: f32,
    /// Rings the grid was laid with.
    pub rings: usize,
}

/// Rings in contact on a fresh grid, as a share of the layout's rings: room to grow by a quarter.
const FRESH: f32 = 0.8;

/// Fewest rings in contact, as a share of the layout's rings, before the grid is laid anew.
const FEWEST: f32 = 0.6;

impl Grid {
    /// Lays the grid anew when `radius` has left its range or the number of rings has changed; a new grid takes up what is `held`.
    pub fn fit(&mut self, layout: &Layout, hold: &Hold, held: &Grip, bristles: &mut [Bristle]) {
        let radius = hold.radius;
        let rings = layout.rings as f32;
        let fresh = radius / (FRESH * rings);
        if self.width <= 0.0 {
            bristles.fill(Bristle::default());
            self.width = fresh;
            seed(layout, fresh, hold, held, bristles);
        } else if self.rings != layout.rings || radius > self.width * rings || radius < self.width * FEWEST * rings {
            share_out(layout, self, fresh, bristles);
            self.width = fresh;
        }
        (self.radius, self.rings) = (radius, layout.rings);
    }
}

/// Spreads a grip that another tier held by the load, force and hoop force alike: as a contact in full slip holds it, so that no cap cuts what was held.
fn seed(layout: &Layout, width: f32, hold: &Hold, held: &Grip, bristles: &mut [Bristle]) {
    if held.force == Vec2::ZERO && held.torque == 0.0 {
        return;
    }
    let inside = |k: usize| hold.profile.inside(min(width * k as f32 / hold.radius, 1.0)).load;
    let share = |k: usize| (inside(k + 1) - inside(k)) / AROUND as f32;
    let arms: f32 = (0..layout.rings).map(|k| share(k) * middle(width, k)).sum::<f32>() * AROUND as f32;
    for (k, cells) in bristles.chunks_exact_mut(AROUND).take(layout.rings).enumerate() {
        for (j, cell) in cells.iter_mut().enumerate() {
            let hoop = layout.direction(k, j).perp() * (held.torque / arms);
            cell.force = (held.force + hoop) * share(k);
        }
    }
}

/// Moves every cell's force to the cells of the new grid that overlap it. The part beyond the last new ring is lost: it lies outside
/// the contact, where the cap is zero.
fn share_out(layout: &Layout, grid: &Grid, new_width: f32, bristles: &mut [Bristle]) {
    let before = moments(layout, grid.rings, grid.width, bristles);
    let mut next = [[Bristle::default(); AROUND]; MAX_RINGS];
    for k in 0..grid.rings {
        let (inner, outer) = (grid.width * k as f32, min(grid.width * (k + 1) as f32, max(grid.radius, grid.width * k as f32)));
        let area = outer * outer - inner * inner;
        if area <= 0.0 {
            continue;
        }
        let first = (inner / new_width) as usize;
        for to in first..layout.rings {
            let (low, high) = (max(inner, new_width * to as f32), min(outer, new_width * (to + 1) as f32));
            if low >= high {
                break;
            }
            let share = (high * high - low * low) / area;
            let turn = layout.turn(k, to);
            if let (Some(from), Some(into)) = (pair(bristles, k), next.get_mut(to)) {
                hand_over(share, turn, from, into);
            }
        }
    }
    for (cell, new) in bristles.iter_mut().zip(next.as_flattened()) {
        *cell = *new;
    }
    restore_torque(layout, new_width, before, bristles);
}

/// Hands `share` of a pair to a pair that stands `turn` further round. What the two have in common is a drag and keeps its direction; what
/// they have opposite is a twist and turns with them.
fn hand_over(share: f32, turn: Vec2, from: &[Bristle; AROUND], to: &mut [Bristle; AROUND]) {
    let common = (from[0].force + from[1].force) * 0.5;
    let opposite = turn.rotate((from[0].force - from[1].force) * 0.5);
    to[0].force += (common + opposite) * share;
    to[1].force += (common - opposite) * share;
    to[0].slipped = max(to[0].slipped, from[0].slipped);
    to[1].slipped = max(to[1].slipped, from[1].slipped);
}

/// The pair of ring `k`.
fn pair(bristles: &[Bristle], k: usize) -> Option<&[Bristle; AROUND]> {
    bristles.get(k * AROUND..)?.first_chunk()
}

/// Torque about the centre with every cell's force at the middle of its ring \[N m\].
fn moments(layout: &Layout, rings: usize, width: f32, bristles: &[Bristle]) -> f32 {
    let mut torque = 0.0;
    for (k, cells) in bristles.chunks_exact(AROUND).take(rings).enumerate() {
        for (j, cell) in cells.iter().enumerate() {
            torque += middle(width, k) * layout.direction(k, j).perp_dot(cell.force);
        }
    }
    torque
}

fn middle(width: f32, k: usize) -> f32 {
    width * (k as f32 + 0.5)
}

/// Turns the lost or gained torque back in as a hoop force that grows with the radius.
fn restore_torque(layout: &Layout, width: f32, before: f32, bristles: &mut [Bristle]) {
    let missing = before - moments(layout, layout.rings, width, bristles);
    let arms: f32 = (0..layout.rings).map(|k| middle(width, k) * middle(width, k)).sum::<f32>() * AROUND as f32;
    for (k, cells) in bristles.chunks_exact_mut(AROUND).take(layout.rings).enumerate() {
        for (j, cell) in cells.iter_mut().enumerate() {
            cell.force += layout.direction(k, j).perp() * (missing * middle(width, k) / arms);
        }
    }
}

/// Takes away the traction that rolled out of the contact, and what lies outside it.
pub fn thin(layout: &Layout, rings: &Rings, bristles: &mut [Bristle], kept: f32) {
    let kept = clamp(kept, 0.0, 1.0);
    let inside = rings.len() * AROUND;
    if kept < 1.0 {
        bristles.iter_mut().take(inside).for_each(|bristle| bristle.force *= kept);
    }
    bristles.iter_mut().take(layout.rings * AROUND).skip(inside).for_each(|bristle| *bristle = Bristle::default());
}

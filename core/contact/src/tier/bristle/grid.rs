//! The polar grid of a patch, and how tractions move to a new one.
//!
//! Rings have equal width h and keep it while the contact radius a stays within a range of h, so that a growing contact enters
//! new, free rings and a shrinking one leaves rings behind. When a leaves the range the grid is laid anew and the forces are
//! shared out by overlap, so that force and torque of the patch are kept.

use glam::Vec2;

use crate::math::{clamp, max, min};
use crate::tier::bristle::ring::Rings;
use crate::tier::bristle::{AROUND, Bristle, Layout, MAX_RINGS};

/// The grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grid {
    /// Width of a ring \[m\]; 0 before the first load.
    pub width: f32,
    /// Contact radius the bristles were last fitted to \[m\].
    pub radius: f32,
}

/// Rings in contact on a fresh grid, as a share of the layout's rings: room to grow by a quarter.
const FRESH: f32 = 0.8;

/// Fewest rings in contact, as a share of the layout's rings, before the grid is laid anew.
const FEWEST: f32 = 0.6;

impl Grid {
    /// Lays the grid anew when `radius` has left its range.
    pub fn fit(&mut self, layout: &Layout, radius: f32, bristles: &mut [Bristle]) {
        let rings = layout.rings as f32;
        if self.width <= 0.0 {
            bristles.fill(Bristle::default());
            self.width = radius / (FRESH * rings);
        } else if radius > self.width * rings || radius < self.width * FEWEST * rings {
            let width = radius / (FRESH * rings);
            share_out(layout, self, width, bristles);
            self.width = width;
        }
        self.radius = radius;
    }
}

/// Moves every cell's force to the cells of the new grid that overlap it. The part beyond the last new ring is lost: it lies outside
/// the contact, where the cap is zero.
fn share_out(layout: &Layout, grid: &Grid, new_width: f32, bristles: &mut [Bristle]) {
    let before = moments(layout, grid.width, bristles);
    let mut next = [Bristle::default(); MAX_RINGS * AROUND];
    for k in 0..layout.rings {
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
            hand_over(share, turn, &bristles[k * AROUND..][..AROUND], &mut next[to * AROUND..][..AROUND]);
        }
    }
    let used = layout.rings * AROUND;
    bristles[..used].copy_from_slice(&next[..used]);
    restore_torque(layout, new_width, before, bristles);
}

/// Hands `share` of a pair to a pair that stands `turn` further round. What the two have in common is a drag and keeps its direction; what
/// they have opposite is a twist and turns with them.
fn hand_over(share: f32, turn: Vec2, from: &[Bristle], to: &mut [Bristle]) {
    let common = (from[0].force + from[1].force) * 0.5;
    let opposite = turn.rotate((from[0].force - from[1].force) * 0.5);
    to[0].force += (common + opposite) * share;
    to[1].force += (common - opposite) * share;
    to[0].slipped = max(to[0].slipped, from[0].slipped);
    to[1].slipped = max(to[1].slipped, from[1].slipped);
}

/// Torque about the centre with every cell's force at the middle of its ring \[N m\].
fn moments(layout: &Layout, width: f32, bristles: &[Bristle]) -> f32 {
    let mut torque = 0.0;
    for k in 0..layout.rings {
        for j in 0..AROUND {
            torque += middle(width, k) * layout.direction(k, j).perp_dot(bristles[k * AROUND + j].force);
        }
    }
    torque
}

fn middle(width: f32, k: usize) -> f32 {
    width * (k as f32 + 0.5)
}

/// Turns the lost or gained torque back in as a hoop force that grows with the radius.
fn restore_torque(layout: &Layout, width: f32, before: f32, bristles: &mut [Bristle]) {
    let missing = before - moments(layout, width, bristles);
    let arms: f32 = (0..layout.rings).map(|k| middle(width, k) * middle(width, k)).sum::<f32>() * AROUND as f32;
    for k in 0..layout.rings {
        for j in 0..AROUND {
            let hoop = layout.direction(k, j).perp();
            bristles[k * AROUND + j].force += hoop * (missing * middle(width, k) / arms);
        }
    }
}

/// Takes away the traction that rolled out of the contact, and what lies outside it.
pub fn thin(layout: &Layout, rings: &Rings, bristles: &mut [Bristle], kept: f32) {
    let kept = clamp(kept, 0.0, 1.0);
    if kept < 1.0 {
        for bristle in &mut bristles[..rings.len() * AROUND] {
            bristle.force *= kept;
        }
    }
    for bristle in &mut bristles[rings.len() * AROUND..layout.rings * AROUND] {
        *bristle = Bristle::default();
    }
}

//! What a bristle of each ring can hold and how stiff it is: exact integrals of the profile over the ring.

use crate::math::min;
use crate::patch::Grip;
use crate::profile::Within;
use crate::tier::Hold;
use crate::tier::bristle::{AROUND, Bristle, Grid, Layout, MAX_RINGS};

/// One bristle's figures; the same for all bristles of a ring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ring {
    /// Normal load of the cell \[N\]; its cap is mu times this.
    pub load: f32,
    /// Force per drag \[N/m\].
    pub drag: f32,
    /// Hoop force per twist \[N/rad\].
    pub twist: f32,
    /// Arm of the cell's force about the centre, so that the torque capacity is exact \[m\].
    pub arm: f32,
    /// Area that counts as stuck with this cell in pure drag and in pure twist, shares of the contact area.
    pub stuck: (f32, f32),
}

/// The rings inside the contact.
#[derive(Clone, Debug)]
pub struct Rings {
    rings: [Ring; MAX_RINGS],
    len: usize,
}

impl Rings {
    /// Rings of `grid` under the load of `hold`.
    pub fn new(hold: &Hold, layout: &Layout, grid: &Grid) -> Self {
        let mut rings = [Ring::default(); MAX_RINGS];
        let share = 1.0 / AROUND as f32;
        let (mut inner, mut inner_squares, mut len) = (Within::default(), (0.0, 0.0), 0);
        for (k, ring) in rings.iter_mut().enumerate().take(layout.rings) {
            if grid.width * k as f32 >= hold.radius {
                break;
            }
            let q = min(grid.width * (k + 1) as f32 / hold.radius, 1.0);
            let outer = hold.profile.within(q);
            let squares = (outer.drag_stick * outer.drag_stick, two_thirds(outer.twist_stick_cubed));
            *ring = between(hold, share, &inner, &outer);
            ring.stuck = ((squares.0 - inner_squares.0) * share, (squares.1 - inner_squares.1) * share);
            (inner, inner_squares, len) = (outer, squares, k + 1);
        }
        Self { rings, len }
    }

    /// Rings in contact.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True when no ring is in contact.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The rings, innermost first.
    pub fn as_slice(&self) -> &[Ring] {
        &self.rings[..self.len]
    }

    /// Resultant of the bristles.
    pub fn sum(&self, layout: &Layout, bristles: &[Bristle]) -> Grip {
        let mut grip = Grip::default();
        for (k, (ring, cells)) in self.as_slice().iter().zip(bristles.chunks(AROUND)).enumerate() {
            for (j, cell) in cells.iter().enumerate() {
                grip.force += cell.force;
                grip.torque += ring.arm * layout.direction(k, j).perp_dot(cell.force);
            }
        }
        grip
    }
}

fn between(hold: &Hold, share: f32, inner: &Within, outer: &Within) -> Ring {
    let load = hold.load * (outer.load - inner.load);
    let torque = hold.load * hold.radius * (outer.torque - inner.torque);
    let arm = if load > 0.0 { torque / load } else { hold.radius };
    let drag = hold.drag_stiffness * (outer.drag_stick - inner.drag_stick);
    let twist = hold.twist_stiffness * (outer.twist_stick_cubed - inner.twist_stick_cubed) / arm;
    Ring { load: load * share, drag: drag * share, twist: twist * share, arm, stuck: (0.0, 0.0) }
}

/// x^(2/3).
fn two_thirds(x: f32) -> f32 {
    let root = crate::math::cbrt(x);
    root * root
}

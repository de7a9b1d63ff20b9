//! Tier `bristle`: independent bristles on a polar grid, each with Coulomb's cap of its own place.
//!
//! Caps are the true pressure; stiffness is chosen so that pure drag and pure twist are exact for any axisymmetric pressure in the
//! limit of fine rings (theory.md, section 5). Rings keep their place in the material while the contact radius changes: traction belongs to a material
//! place, new contact enters free, and what a falling pressure sheds does not come back.

pub mod grid;
pub mod quad;
pub mod ring;
pub mod slip;
pub mod stiffness;

pub use grid::Grid;

use glam::Vec2;

use crate::limits::MAX_BRISTLES;
use crate::math::{cos, sin};
use crate::patch::{Grip, Patch, Shift};
use crate::profile::{COMMON_DRAG, COMMON_TWIST};
use crate::tier::{Hold, carried, rolled_away};
use ring::Rings;
use slip::Common;

/// One bristle: what its cell of the contact holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bristle {
    /// Tangential force of the cell in c, in the sense of the shift that loaded it \[N\].
    pub force: Vec2,
    /// Distance slipped since it left stick \[m\]; 0 while it sticks.
    pub slipped: f32,
}

/// Bristles of a ring: two, opposite each other, so that a twist makes no net force and a drag no net torque.
pub const AROUND: usize = 2;

/// Most rings of any layout.
pub const MAX_RINGS: usize = MAX_BRISTLES / AROUND;

/// How the bristles lie: thin rings of two, each ring turned against the one before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Most rings.
    pub rings: usize,
    /// Unit vector from the centre to the first bristle of each ring.
    directions: [Vec2; MAX_RINGS],
}

/// Turn from ring to ring \[rad\]: pi times the golden section, which spreads the pairs of any run of rings evenly.
const GOLDEN_TURN: f32 = 1.941_611;

impl Layout {
    /// Layout of at most `samples` bristles.
    pub fn new(samples: usize) -> Self {
        let directions = core::array::from_fn(|k| {
            let angle = GOLDEN_TURN * k as f32;
            Vec2::new(cos(angle), sin(angle))
        });
        Self { rings: Self::rings_of(samples), directions }
    }

    /// Rings of at most `samples` bristles.
    pub const fn rings_of(samples: usize) -> usize {
        if samples / AROUND < MAX_RINGS { samples / AROUND } else { MAX_RINGS }
    }

    /// The same with `rings` rings.
    pub const fn with(&self, rings: usize) -> Self {
        Self { rings, ..*self }
    }

    /// Unit vector to bristle `j` of ring `k`.
    pub fn direction(&self, k: usize, j: usize) -> Vec2 {
        let first = self.directions.get(k).copied().unwrap_or_default();
        if j == 0 { first } else { -first }
    }
}

/// Advances the patch by its motion of this tick.
pub fn advance(hold: &Hold, layout: &Layout, patch: &mut Patch, bristles: &mut [Bristle]) {
    if hold.load <= 0.0 || hold.radius <= 0.0 {
        return let_go(patch, bristles);
    }
    patch.grid.fit(layout, hold, &patch.grip, bristles);
    let rings = Rings::new(hold, layout, &patch.grid);
    let kept = 1.0 - rolled_away(patch.motion.rolled, hold.radius);
    grid::thin(layout, &rings, bristles, kept);
    // traction that left with the rolling material is gone for the contact; only the body springs back by it
    let before = Grip { force: patch.grip.force * kept, torque: patch.grip.torque * kept, stick: patch.grip.stick };
    let left = Grip { force: patch.grip.force - before.force, torque: patch.grip.torque - before.torque, stick: 0.0 };
    let wanted = hold.wanted + Shift { drag: left.force * hold.body.drag, twist: left.torque * hold.body.twist };
    let answer = slip::shift(hold, layout, &rings, bristles, &common(hold), wanted, &before);
    // what is left is carried on, so that nothing drifts
    (patch.grip, patch.pending) = (answer.grip, carried(hold, answer.rest));
}

/// Common share of the local compliance, with the body in series.
fn common(hold: &Hold) -> Common {
    Common {
        drag: COMMON_DRAG / hold.drag_stiffness + hold.body.drag,
        twist: COMMON_TWIST / hold.twist_stiffness + hold.body.twist,
    }
}

fn let_go(patch: &mut Patch, bristles: &mut [Bristle]) {
    patch.grid = Grid::default();
    bristles.fill(Bristle::default());
    patch.pending = Shift::default();
    patch.grip = Grip::default();
}

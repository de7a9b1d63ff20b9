//! Tier `bristle`: independent bristles on a polar grid, each with Coulomb's cap of its own place.
//!
//! The stiffness of the bristles inside a radius is that of the disc which truly sticks when everything beyond slips, and their caps
//! are the true pressure: pure drag and pure twist are then exact for any axisymmetric pressure in the limit of fine rings
//! (theory.md, section 5). Rings keep their place in the material while the contact radius changes: traction belongs to a material
//! place, new contact enters free, and what a falling pressure sheds does not come back.

pub mod grid;
pub mod ring;
pub mod slip;

pub use grid::Grid;

use glam::Vec2;

use crate::limits::MAX_BRISTLES;
use crate::math::{cos, sin};
use crate::params::Params;
use crate::patch::{Grip, Patch, Shift};
use crate::tier::{Hold, rolled_away};
use ring::Rings;

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
        let rings = if samples / AROUND < MAX_RINGS { samples / AROUND } else { MAX_RINGS };
        let directions = core::array::from_fn(|k| {
            let angle = GOLDEN_TURN * k as f32;
            Vec2::new(cos(angle), sin(angle))
        });
        Self { rings, directions }
    }

    /// Rotation from the place of ring `from` to that of ring `to`, as the unit complex number (cos, sin).
    pub fn turn(&self, from: usize, to: usize) -> Vec2 {
        let (a, b) = (self.directions[from], self.directions[to]);
        Vec2::new(a.dot(b), a.perp_dot(b))
    }

    /// Unit vector to bristle `j` of ring `k`.
    pub fn direction(&self, k: usize, j: usize) -> Vec2 {
        if j == 0 { self.directions[k] } else { -self.directions[k] }
    }
}

/// Passes that share a shift between contact and body. The first takes the stuck stiffness, so it never overshoots; the others
/// use the stiffness that the pass before left.
const PASSES: usize = 4;

/// Share of the target below which the rest of a shift is left to the next tick: what f32 resolves.
const SETTLED: f32 = 1.0e-6;

/// Advances the patch to `hold.target`.
pub fn advance(hold: &Hold, params: &Params, patch: &mut Patch, bristles: &mut [Bristle]) {
    let layout = &params.layout;
    if hold.load <= 0.0 || hold.radius <= 0.0 {
        return let_go(hold, patch, bristles);
    }
    patch.grid.fit(layout, hold.radius, bristles);
    let rings = Rings::new(hold, layout, &patch.grid);
    grid::thin(layout, &rings, bristles, 1.0 - rolled_away(patch.motion.rolled, hold.radius));
    let mut tangent = (hold.drag_stiffness, hold.twist_stiffness);
    let mut grip = rings.sum(layout, bristles);
    let passes = if hold.body.drag > 0.0 || hold.body.twist > 0.0 { PASSES } else { 1 };
    for _ in 0..passes {
        let step = local_step(hold, patch.local, &grip, tangent);
        patch.local = patch.local + step;
        (grip, tangent) = slip::apply(hold, layout, &rings, bristles, step);
        if is_settled(hold, &patch.local, &grip) {
            break;
        }
    }
    patch.grip = grip;
}

fn let_go(hold: &Hold, patch: &mut Patch, bristles: &mut [Bristle]) {
    patch.grid = Grid::default();
    bristles.fill(Bristle::default());
    patch.local = hold.target;
    patch.grip = Grip::default();
}

/// The contact's share of what is left of the shift: rest / (1 + K_tan C).
fn local_step(hold: &Hold, local: Shift, grip: &Grip, tangent: (f32, f32)) -> Shift {
    let rest = rest(hold, &local, grip);
    Shift { drag: rest.drag / (1.0 + tangent.0 * hold.body.drag), twist: rest.twist / (1.0 + tangent.1 * hold.body.twist) }
}

fn rest(hold: &Hold, local: &Shift, grip: &Grip) -> Shift {
    Shift {
        drag: hold.target.drag - local.drag - grip.force * hold.body.drag,
        twist: hold.target.twist - local.twist - grip.torque * hold.body.twist,
    }
}

fn is_settled(hold: &Hold, local: &Shift, grip: &Grip) -> bool {
    let rest = rest(hold, local, grip);
    rest.drag.length() <= SETTLED * hold.target.drag.length() && rest.twist.abs() <= SETTLED * hold.target.twist.abs()
}

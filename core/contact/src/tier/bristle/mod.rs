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

use crate::limits::MAX_SAMPLES;
use crate::math::{clamp, floor, sqrt};
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

/// Most bristles around a ring; more than 24 changes no digit of a turning path.
pub const MAX_AROUND: usize = 24;

/// Fewest bristles around a ring that resolve a direction in the plane.
const MIN_AROUND: usize = 4;

/// How many bristles go around, and how many rings there can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Bristles around a ring.
    pub around: usize,
    /// Most rings.
    pub rings: usize,
    /// Unit vectors every half step around: even rings use the even ones, odd rings the odd ones.
    pub directions: [Vec2; 2 * MAX_AROUND],
}

impl Layout {
    /// Layout of at most `samples` bristles: cells about as wide as long at two thirds of the radius.
    pub fn new(samples: usize) -> Self {
        let around = clamp(floor(sqrt(0.6 * samples as f32) + 0.5), MIN_AROUND as f32, MAX_AROUND as f32) as usize;
        let half_step = crate::math::PI / around as f32;
        let directions = core::array::from_fn(|i| {
            let angle = half_step * i as f32;
            Vec2::new(crate::math::cos(angle), crate::math::sin(angle))
        });
        Self { around, rings: samples / around, directions }
    }

    /// Unit vector to bristle `j` of ring `k`.
    pub fn direction(&self, k: usize, j: usize) -> Vec2 {
        self.directions[(2 * j + (k & 1)) % (2 * MAX_AROUND)]
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

const _: () = assert!(MAX_SAMPLES / MAX_AROUND <= ring::MAX_RINGS);

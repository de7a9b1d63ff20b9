//! Tier `influence`: tractions of square cells that move the whole surface, with Coulomb's cap at each cell.
//!
//! **Words.** *Cell*: a square of the contact with uniform tangential traction. *Influence*: displacement of one cell per force on another, of the
//! elastic half space (Cerruti). *Sweep*: one visit of every cell. *Lack*: displacement a cell would still need in order not to have
//! slipped. Unlike bristles, cells know each other, so that what one sheds its neighbours take over where elasticity says so. The work
//! is bounded: `sweeps` + 1 times a quarter of the cells squared, from the tractions of the last tick (theory.md, section 6.4).

pub mod cells;
pub mod grid;
pub mod mirror;
pub mod share;
pub mod solve;
pub mod table;

pub use grid::{Grid, Layout};

use glam::Vec2;

use crate::math::max;
use crate::model::{Compliance, Material};
use crate::patch::{Grip, Patch, Shift};
use crate::tier::bristle::Bristle;
use crate::tier::{Hold, rolled_away};

/// What the cells of a patch are elastic by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Shear modulus G \[Pa\].
    pub shear_modulus: f32,
    /// Poisson's ratio.
    pub poisson_ratio: f32,
    /// Compliance all cells share: the body's, and what a convex object yields more than a half space.
    pub common: Compliance,
}

impl Elastic {
    /// Elasticity of `material` under the patch of `hold`.
    pub fn new(hold: &Hold, material: &Material) -> Self {
        let shear_modulus = material.shear_modulus();
        // the arms of a long patch are longer, and its twist stiffer by their square
        let flat = 16.0 / 3.0 * shear_modulus * hold.radius * hold.arm * hold.arm;
        let convex = max(1.0 / hold.twist_stiffness - 1.0 / flat, 0.0);
        let common = Compliance { drag: hold.body.drag, twist: hold.body.twist + convex, ..hold.body };
        Self { shear_modulus, poisson_ratio: material.poisson_ratio, common }
    }
}

/// What a cell remembers besides its force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trace {
    /// What a sticking cell still lacks of its displacement after the last tick's few sweeps \[m\]; carried on, so that nothing drifts.
    pub lack: Vec2,
    /// Change of its force in the last tick \[N\]: the next tick's first guess.
    pub change: Vec2,
}

/// The cells of a patch as the state keeps them.
#[derive(Debug)]
pub struct Stored<'a> {
    /// Forces and slips.
    pub force: &'a mut [Bristle],
    /// Lacks and changes.
    pub trace: &'a mut [Trace],
}

impl Stored<'_> {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.force.fill(Bristle::default());
        self.trace.fill(Trace::default());
    }
}

/// Advances the patch by its motion of this tick.
pub fn advance(hold: &Hold, material: &Material, layout: &Layout, sweeps: usize, patch: &mut Patch, cells: &mut Stored<'_>) {
    if hold.load <= 0.0 || hold.radius <= 0.0 {
        return let_go(patch, cells);
    }
    patch.cells.fit(layout, hold.radius, &patch.grip, cells);
    let kept = 1.0 - rolled_away(patch.motion.rolled, hold.radius);
    if kept < 1.0 {
        cells.force.iter_mut().take(layout.slots()).for_each(|cell| cell.force *= kept);
    }
    // traction that left with the rolling material is gone for the contact; only the body springs back by it
    let (left_force, left_torque) = (patch.grip.force * (1.0 - kept), patch.grip.torque * (1.0 - kept));
    let wanted = hold.wanted + Shift { drag: left_force * hold.body.drag, twist: left_torque * hold.body.twist };
    let elastic = Elastic::new(hold, material);
    patch.grip = solve::shift(hold, &elastic, layout, &patch.cells, sweeps, wanted, cells);
    (patch.cells.radius, patch.cells.wanted) = (hold.radius, wanted);
    patch.pending = Shift::default();
}

fn let_go(patch: &mut Patch, cells: &mut Stored<'_>) {
    patch.cells = Grid::default();
    cells.clear();
    patch.pending = Shift::default();
    patch.grip = Grip::default();
}

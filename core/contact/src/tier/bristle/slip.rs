//! The slip rule: what the bristles of a patch do when it shifts (theory.md, section 6.2).
//!
//! Every bristle feels the shift less what all of them together pull the surface along: C dF with the resultant F = (Q, T) of the patch
//! and C = diag(c_t, c_t, c_theta), the common share of the elastic compliance plus the body's. Against that remainder each is an
//! elastic spring with Coulomb's cap. The few unknowns (the remainder d, a drag and a twist) are found by Newton's method in a fixed
//! number of passes, always from the bristles' old forces, starting from the stiffness of full stick so that it cannot overshoot.

use glam::Vec2;

use crate::lanes::Lanes;
use crate::math::{max, min};
use crate::patch::{Grip, Shift};
use crate::tier::Hold;
use crate::tier::bristle::quad::{self, BRISTLES, Lost, Moved, Quads};
use crate::tier::bristle::ring::Rings;
use crate::tier::bristle::stiffness::Stiffness;
use crate::tier::bristle::{Bristle, Layout};

/// Compliance that all bristles of a patch share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Common {
    /// c_t \[m/N\].
    pub drag: f32,
    /// c_theta \[rad/(N m)\].
    pub twist: f32,
}

impl Common {
    /// Compliance times a change of grip.
    pub fn yields(&self, force: Vec2, torque: f32) -> Shift {
        Shift { drag: force * self.drag, twist: torque * self.twist }
    }
}

/// Passes of Newton's method. Two reach the limit of fine steps at 1 kHz; the third serves coarse ones.
const PASSES: usize = 3;

/// Answer of [`shift`].
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// The new grip.
    pub grip: Grip,
    /// What is left of the shift for the next tick.
    pub rest: Shift,
}

/// Shifts the patch by `wanted`; `before` is the grip that the remainder is counted from.
pub fn shift(
    hold: &Hold,
    layout: &Layout,
    rings: &Rings,
    bristles: &mut [Bristle],
    common: &Common,
    wanted: Shift,
    before: &Grip,
) -> Answer {
    let stuck = Stiffness::all_stuck(rings);
    let mut quads = Quads::new();
    quad::lay_out(hold, layout, rings, bristles, &mut quads);
    let mut felt = stuck.solve(common, wanted);
    for pass in 1..PASSES {
        let trial = probe(&quads, felt, stuck);
        let rest = rest_of(common, wanted, felt, trial.force - before.force, trial.torque - before.torque);
        felt = felt + trial.stiffness.solve(common, rest);
        if pass == 1 && !trial.slides {
            // both steps were those of full stick, which is linear
            break;
        }
    }
    let grip = settle(hold, &quads, bristles, felt);
    Answer { grip, rest: rest_of(common, wanted, felt, grip.force - before.force, grip.torque - before.torque) }
}

/// What a shift still lacks once the bristles felt `felt` and all together yielded to their change of grip.
fn rest_of(common: &Common, wanted: Shift, felt: Shift, force: Vec2, torque: f32) -> Shift {
    let yielded = common.yields(force, torque);
    Shift { drag: wanted.drag - felt.drag - yielded.drag, twist: wanted.twist - felt.twist - yielded.twist }
}

/// Resultant and tangent stiffness at a trial shift.
struct Trial {
    force: Vec2,
    torque: f32,
    /// Some bristle slides.
    slides: bool,
    stiffness: Stiffness,
}

/// What the bristles would hold if the patch shifted by `felt`; changes nothing.
fn probe(quads: &Quads, felt: Shift, stuck: Stiffness) -> Trial {
    let (mut sum, mut lost, mut slides) = (Sum::default(), Lost::default(), false);
    for quad in quads {
        let moved = quad.moved(felt);
        sum.add(&moved);
        if moved.slides {
            lost += quad.lost(&moved);
            slides = true;
        }
    }
    let mut stiffness = stuck;
    if slides {
        stiffness.soften(&lost);
    }
    let (force, torque) = sum.total();
    Trial { force, torque, slides, stiffness }
}

/// What bristles hold, the first of all quads side by side with the second, the third and the fourth.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    force: (Lanes, Lanes),
    torque: Lanes,
}

impl Sum {
    fn add(&mut self, moved: &Moved) {
        self.force.0 += moved.force.0;
        self.force.1 += moved.force.1;
        self.torque += moved.torque;
    }

    fn total(&self) -> (Vec2, f32) {
        (Vec2::new(self.force.0.total(), self.force.1.total()), self.torque.total())
    }
}

/// Moves the bristles for good.
fn settle(hold: &Hold, quads: &Quads, bristles: &mut [Bristle], felt: Shift) -> Grip {
    let (mut sum, mut stuck) = (Sum::default(), (Lanes::default(), Lanes::default()));
    for (quad, cells) in quads.iter().zip(bristles.chunks_mut(BRISTLES)) {
        let moved = quad.moved(felt);
        sum.add(&moved);
        // what the cap cut off a trial, over the stiffness
        let cut = moved.trial * (Lanes::splat(1.0) - moved.scale) / quad.drag;
        let sticks = Lanes(moved.trial.0.map(|trial| if trial > 0.0 { 0.0 } else { 1.0 }));
        stuck = (stuck.0 + quad.stuck.0 * sticks, stuck.1 + quad.stuck.1 * sticks);
        for (i, cell) in cells.iter_mut().enumerate().take(BRISTLES) {
            cell.force = Vec2::new(moved.force.0.0[i], moved.force.1.0[i]);
            if moved.trial.0[i] > 0.0 {
                cell.slipped = max(cell.slipped + cut.0[i], LEAST_SLIP);
            } else if cell.slipped > 0.0 && cell.force.length_squared() < square(quad.dynamic.0[i]) {
                cell.slipped = 0.0;
            }
        }
    }
    let (force, torque) = sum.total();
    let grip = Grip { force, torque, stick: 0.0 };
    Grip { stick: stick_share(hold, &grip, (stuck.0.total(), stuck.1.total())), ..grip }
}

/// The stuck share of the area lies between its pure-drag and its pure-twist reading, by how much of each is used.
fn stick_share(hold: &Hold, grip: &Grip, stuck: (f32, f32)) -> f32 {
    let drag = grip.force.length_squared() / square(hold.mu_s * hold.load);
    let twist = square(grip.torque / (hold.mu_s * hold.load * hold.arm * hold.profile.full_slip_torque()));
    let blend = if drag + twist > 0.0 { twist / (drag + twist) } else { 1.0 };
    min(stuck.0 + (stuck.1 - stuck.0) * blend, 1.0)
}

fn square(x: f32) -> f32 {
    x * x
}

/// A bristle or a cell that has left stick is marked by a slip above zero, however small the step was: far below what the least contact slips over, and a normal number still \[m\].
pub const LEAST_SLIP: f32 = 1.0e-30;

/// Friction of a cell of this load \[N\] and drag stiffness \[N/m\] that slipped by `slipped`. Sharp: dynamic at once. Smooth: falls over a length on which the bristle would shed
/// twice the difference, so that force over shift falls at half the stuck slope and nothing snaps.
pub fn friction(hold: &Hold, load: f32, drag: f32, slipped: f32) -> f32 {
    let excess = hold.mu_s - hold.mu_d;
    if excess <= 0.0 || slipped <= 0.0 {
        return hold.mu_s;
    }
    if hold.sharp {
        return hold.mu_d;
    }
    let fall = 2.0 * excess * load / drag;
    hold.mu_s - excess * min(slipped / fall, 1.0)
}

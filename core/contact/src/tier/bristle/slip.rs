//! The slip rule: what one bristle does when its patch shifts (theory.md, section 6.2).

use glam::Vec2;

use crate::math::{min, root};
use crate::patch::{Grip, Shift};
use crate::tier::Hold;
use crate::tier::bristle::ring::{Ring, Rings};
use crate::tier::bristle::{AROUND, Bristle, Layout};

/// How strongly the slip direction turns the traction of a slipping bristle.
const TURNING: f32 = 1.4;

/// Moves every bristle by `step` and returns the new grip with the tangent stiffness (drag, twist) of what still sticks.
pub fn apply(hold: &Hold, layout: &Layout, rings: &Rings, bristles: &mut [Bristle], step: Shift) -> (Grip, (f32, f32)) {
    let mut sum = Sum::default();
    for (k, (ring, cells)) in rings.as_slice().iter().zip(bristles.chunks_mut(AROUND)).enumerate() {
        for (j, cell) in cells.iter_mut().enumerate() {
            let radial = layout.direction(k, j);
            let sticks = move_bristle(hold, ring, radial, step, cell);
            sum.add(ring, radial, cell.force, sticks);
        }
    }
    sum.finish(hold)
}

/// Resultants gathered over the bristles.
#[derive(Default)]
struct Sum {
    force: Vec2,
    torque: f32,
    tangent: (f32, f32),
    stuck: (f32, f32),
}

impl Sum {
    fn add(&mut self, ring: &Ring, radial: Vec2, force: Vec2, sticks: bool) {
        self.force += force;
        self.torque += ring.arm * radial.perp_dot(force);
        if sticks {
            self.tangent.0 += ring.drag;
            self.tangent.1 += ring.twist * ring.arm;
            self.stuck.0 += ring.stuck.0;
            self.stuck.1 += ring.stuck.1;
        }
    }

    /// The stuck share of the area lies between its pure-drag and its pure-twist reading, by how much of each is used.
    fn finish(self, hold: &Hold) -> (Grip, (f32, f32)) {
        let drag = self.force.length_squared() / square(hold.mu_s * hold.load);
        let twist = square(self.torque / (hold.mu_s * hold.load * hold.radius * hold.profile.full_slip_torque()));
        let blend = if drag + twist > 0.0 { twist / (drag + twist) } else { 1.0 };
        let stick = min(self.stuck.0 + (self.stuck.1 - self.stuck.0) * blend, 1.0);
        (Grip { force: self.force, torque: self.torque, stick }, self.tangent)
    }
}

fn square(x: f32) -> f32 {
    x * x
}

/// Moves one bristle; true while it sticks.
fn move_bristle(hold: &Hold, ring: &Ring, radial: Vec2, step: Shift, cell: &mut Bristle) -> bool {
    let hoop = radial.perp();
    let trial = cell.force + step.drag * ring.drag + hoop * (ring.twist * step.twist);
    let cap = friction(hold, ring, cell.slipped) * ring.load;
    let size2 = trial.length_squared();
    if size2 <= cap * cap {
        cell.force = trial;
        if cell.slipped > 0.0 && size2 < square(hold.mu_d * ring.load) {
            cell.slipped = 0.0;
        }
        return true;
    }
    let slip = step.drag + hoop * (ring.arm * step.twist);
    let slipped = cell.slipped + root(slip.length_squared());
    cell.slipped = if slipped > LEAST_SLIP { slipped } else { LEAST_SLIP };
    let cap = friction(hold, ring, cell.slipped) * ring.load;
    cell.force = along(cell.force + slip * (TURNING * ring.drag), trial) * cap;
    false
}

/// A bristle that has left stick is marked by a slip above zero, however small the step was \[m\].
const LEAST_SLIP: f32 = 1.0e-12;

fn along(v: Vec2, otherwise: Vec2) -> Vec2 {
    let size = root(v.length_squared());
    if size > 0.0 {
        return v / size;
    }
    let size = root(otherwise.length_squared());
    if size > 0.0 { otherwise / size } else { Vec2::ZERO }
}

/// Friction of a cell that slipped by `slipped`. Sharp: dynamic at once. Smooth: falls over a length on which the bristle would shed
/// twice the difference, so that force over shift keeps at least half the stuck slope's size and nothing snaps.
fn friction(hold: &Hold, ring: &Ring, slipped: f32) -> f32 {
    let excess = hold.mu_s - hold.mu_d;
    if excess <= 0.0 || slipped <= 0.0 {
        return hold.mu_s;
    }
    if hold.sharp {
        return hold.mu_d;
    }
    let fall = 2.0 * excess * ring.load / ring.drag;
    hold.mu_s - excess * min(slipped / fall, 1.0)
}

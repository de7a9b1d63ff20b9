//! Time-domain passivity at the handle (Hannaford and Ryu 2002; theory.md, equations 10.10 and 10.11).
//!
//! The observer sums what the hand has put in, for force and for torque apart: the wrench that was held while the handle moved, times that motion. With the
//! link's delay given it is exact for a device that holds each wrench for a tick. When more has come out than went in, the controller adds just the damping that takes the
//! excess back over the next tick if the handle moves on as it did, at most as much as the device can render.
//!
//! **What it cannot do.** It acts after the fact; damping is as late as the wrench, so a late loop may not be given much; at an encoder's single steps speed is known
//! to one step. Energy lost to friction would be a credit without end that blinds the observer: it is capped at `reserve`.

use glam::Vec3;

use crate::World;
use crate::error::{Invalid, require};
use crate::frames::{Pose, ProbeFrame};
use crate::math::min;
use crate::report::Flags;
use crate::stage::regions::rotation_vector;
use crate::wrench::Wrench;

/// Settings of the passivity observer and controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passivity {
    /// Most damping \[N s/m\], 0 to 1e3.
    pub max_damping: f32,
    /// Most angular damping \[N m s/rad\], 0 to 10.
    pub max_spin_damping: f32,
    /// Energy that may come out before it acts \[J\], 0 to 1, for force and torque each.
    pub allowance: f32,
    /// Most credit \[J\], above 0, infinity for no cap, for force and torque each. Give at least what coupling or contact store when pressed to the device's limit, F^2/(2 K).
    pub reserve: f32,
    /// Ticks from the report of a pose to the wrench that answers it taking effect, beyond the tick itself, 0 to [`MAX_DELAY`].
    pub delay_ticks: usize,
}

impl Default for Passivity {
    /// Damping as the CHAI3D library allows it on a Premium (5 N s/m, 0.004 N m s/rad), a microjoule of rounding, the energy of 8.5 N on 800 N/m twice over.
    fn default() -> Self {
        Self { max_damping: 5.0, max_spin_damping: 0.004, allowance: 1.0e-6, reserve: 0.1, delay_ticks: 0 }
    }
}

/// Longest delay of the link that the observer can be told: 8 ms at 1 kHz, beyond which no contact closes anyway.
pub const MAX_DELAY: usize = 8;

impl Passivity {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let Self { max_damping: b, max_spin_damping: b_spin, allowance, reserve, delay_ticks } = *self;
        require((0.0..=1.0e3).contains(&b), "guard.passivity.max_damping", b, "0 to 1e3 N s/m")?;
        require((0.0..=10.0).contains(&b_spin), "guard.passivity.max_spin_damping", b_spin, "0 to 10 N m s/rad")?;
        require((0.0..=1.0).contains(&allowance), "guard.passivity.allowance", allowance, "0 to 1 J")?;
        if reserve != f32::INFINITY {
            require(reserve > 0.0, "guard.passivity.reserve", reserve, "above 0 J, or infinity for no cap")?;
        }
        require(delay_ticks <= MAX_DELAY, "guard.passivity.delay_ticks", delay_ticks as f32, "0 to 8")
    }
}

/// What the observer remembers of the handle's port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Port {
    /// Handle of the last tick; `None` after a tick without one, whose energy is not known.
    last: Option<Pose<World, ProbeFrame>>,
    /// Wrenches sent, latest first.
    sent: [Wrench<World>; MAX_DELAY + 1],
    /// What the hand has put in, less what came out \[J\]: by force, by torque.
    energy: (f32, f32),
}

/// Motion of the handle in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moved {
    /// \[m\]
    shift: Vec3,
    /// \[rad\]
    turn: Vec3,
}

impl Port {
    pub const START: Self = Self { last: None, sent: [Wrench::ZERO; MAX_DELAY + 1], energy: (0.0, 0.0) };

    /// Counts the energy of the tick that ends with the handle at `handle`.
    pub fn observe(&mut self, spec: &Passivity, handle: Option<&Pose<World, ProbeFrame>>) -> Moved {
        let still = Moved { shift: Vec3::ZERO, turn: Vec3::ZERO };
        let before = self.last;
        self.last = handle.copied();
        let (Some(before), Some(now)) = (before, handle) else { return still };
        let moved =
            Moved { shift: now.position - before.position, turn: rotation_vector(now.rotation * before.rotation.conjugate()) };
        let held = self.sent.get(spec.delay_ticks).copied().unwrap_or(Wrench::ZERO);
        let credit = |energy: f32, work: f32| {
            let sum = min(energy - work, spec.reserve);
            if sum.is_finite() { sum } else { 0.0 }
        };
        self.energy = (credit(self.energy.0, held.force.dot(moved.shift)), credit(self.energy.1, held.torque.dot(moved.turn)));
        moved
    }

    /// Adds damping to `wrench` where more came out than went in.
    pub fn damp(&self, spec: &Passivity, moved: &Moved, wrench: &Wrench<World>, dt: f32) -> (Wrench<World>, Flags) {
        let brake = |energy: f32, motion: Vec3, most: f32| {
            let (excess, square) = (-energy - spec.allowance, motion.length_squared());
            if !(excess > 0.0 && square > 0.0 && dt > 0.0) {
                return Vec3::ZERO;
            }
            motion * (min(excess * dt / square, most) / dt)
        };
        let force = brake(self.energy.0, moved.shift, spec.max_damping);
        let torque = brake(self.energy.1, moved.turn, spec.max_spin_damping);
        if (force == Vec3::ZERO && torque == Vec3::ZERO) || !(force.is_finite() && torque.is_finite()) {
            return (*wrench, Flags::CLEAN);
        }
        (Wrench::new(wrench.force - force, wrench.torque - torque), Flags::PASSIVITY_DAMPED)
    }

    /// Keeps what was sent.
    pub fn keep(&mut self, sent: &Wrench<World>) {
        self.sent.rotate_right(1);
        if let Some(latest) = self.sent.first_mut() {
            *latest = *sent;
        }
    }
}

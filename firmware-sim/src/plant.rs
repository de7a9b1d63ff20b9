//! Handle and hand as one rigid body on a spring and a damper.
//!
//! ```text
//!  m dv/dt = f_device + k_hand (target - x) + b_hand (target' - v) - b_handle v         (1)
//!  J dw/dt = t_device + k_spin rotvec(q_target q^-1) + b_spin (w_target - w) - b w      (2)
//! ```
//! solved by semi-implicit Euler in steps of 125 us: first the speeds from the forces, then the pose from the speeds, which keeps
//! the energy of an undamped spring bounded. Frame `d`, SI. Rotation vectors make (2) exact for any angle below half a turn.
//!
//! **Why this hand.** A ball of 20 mm radius pressed 0.4 mm into 3 MPa rubber is a spring of 23 to 26 kN/m, and the loop that
//! renders it is late by 1.5 ms: a tick of 1 ms from report to wrench, and half a tick because the wrench is held. A delayed spring
//! gives energy away; in `m s^2 + b s + k exp(-s T)` it takes roughly `b > k T = 38 N s/m` to swallow it, and several times that for
//! a comfortable margin with a kilogram. A light finger grip (0.1 kg, 5 N s/m) buzzes there, as it would on the real machines, which
//! their makers allow to render some 1 to 5 kN/m. So the hand here is a firm grip of the whole arm: 0.7 kg, 150 N s/m, and 2 kN/m,
//! which puts 6 N on the ball for a wish of 3.4 mm and gives way by the rest. Closed on a stiff wall over the real bytes (tests of
//! `closed_loop_tests.rs`) the force then ripples by one encoder step and no more, also with answers five ticks late and with
//! rubber of four times the modulus; ripple sets in at about seven ticks late or eight times.

use glam::{Quat, Vec3};

use crate::preset::Preset;
use crate::script::Target;

/// Step of the integration \[s\]: the firmware's tick.
pub const STEP: f32 = 125e-6;

/// Damping of the handle when the motors are shorted [N s/m]: a slow creep under a hand's push, without hitting a wall.
pub const BRAKE_DAMPING: f32 = 60.0;

/// Angular damping of the handle when the motors are shorted \[N m s/rad\].
pub const BRAKE_SPIN_DAMPING: f32 = 0.1;

/// The hand that holds the handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Mass that moves with the handle \[kg\].
    pub mass: f32,
    /// Inertia that turns with it \[kg m^2\].
    pub inertia: f32,
    /// Stiffness of the arm \[N/m\].
    pub stiffness: f32,
    /// Damping of the grip \[N s/m\].
    pub damping: f32,
    /// Stiffness of the wrist \[N m/rad\].
    pub spin_stiffness: f32,
    /// Damping of the wrist \[N m s/rad\].
    pub spin_damping: f32,
}

/// A firm grip with the arm's weight behind it; the module's text says why.
pub const FIRM_GRIP: Hand =
    Hand { mass: 0.7, inertia: 2e-3, stiffness: 2_000.0, damping: 150.0, spin_stiffness: 3.0, spin_damping: 0.15 };

/// Wrench on the handle about its origin, in `d`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force \[N\].
    pub force: Vec3,
    /// Torque \[N m\].
    pub torque: Vec3,
    /// The motors are shorted.
    pub braked: bool,
}

/// Handle and hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    mass: f32,
    inertia: f32,
    damping: f32,
    spin_damping: f32,
    hand: Hand,
    /// Position `p_dh` \[m\].
    pub position: Vec3,
    /// Rotation `q_dh`.
    pub rotation: Quat,
    /// Velocity \[m/s\].
    pub velocity: Vec3,
    /// Angular velocity, in `d` \[rad/s\].
    pub spin: Vec3,
}

impl Plant {
    /// At rest at the origin of `d`.
    #[must_use]
    pub const fn new(preset: &Preset, hand: Hand) -> Self {
        Self {
            mass: preset.mass + hand.mass,
            inertia: preset.inertia + hand.inertia,
            damping: preset.damping,
            spin_damping: preset.spin_damping,
            hand,
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            velocity: Vec3::ZERO,
            spin: Vec3::ZERO,
        }
    }

    /// Moves on by [`STEP`].
    pub fn step(&mut self, target: &Target, load: &Load) {
        let (brake, spin_brake) = if load.braked { (BRAKE_DAMPING, BRAKE_SPIN_DAMPING) } else { (0.0, 0.0) };
        let hand = &self.hand;
        let force =
            load.force + (target.position - self.position) * hand.stiffness + (target.velocity - self.velocity) * hand.damping
                - self.velocity * (self.damping + brake);
        let torque = load.torque
            + turn_between(self.rotation, target.rotation) * hand.spin_stiffness
            + (target.spin - self.spin) * hand.spin_damping
            - self.spin * (self.spin_damping + spin_brake);

        self.velocity += force * (STEP / self.mass);
        self.spin += torque * (STEP / self.inertia);
        self.position += self.velocity * STEP;
        self.rotation = (Quat::from_scaled_axis(self.spin * STEP) * self.rotation).normalize();
    }

    /// Kinetic energy and what the hand's springs hold against `target` \[J\].
    #[must_use]
    pub fn energy(&self, target: &Target) -> f32 {
        let stretch = (target.position - self.position).length_squared();
        let turn = turn_between(self.rotation, target.rotation).length_squared();
        0.5 * (self.mass * self.velocity.length_squared()
            + self.inertia * self.spin.length_squared()
            + self.hand.stiffness * stretch
            + self.hand.spin_stiffness * turn)
    }
}

/// Rotation vector, in `d`, that turns `from` into `to` the short way \[rad\].
fn turn_between(from: Quat, to: Quat) -> Vec3 {
    let turn = to * from.conjugate();
    let short = if turn.w < 0.0 { -turn } else { turn };
    short.to_scaled_axis()
}

/// Steps of the encoders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoders {
    /// Step of position \[m\].
    pub step: f32,
    /// Step of each component of the rotation vector \[rad\].
    pub spin_step: f32,
}

impl Encoders {
    /// The preset's own steps.
    ///
    /// A step of 30 um on a spring of 25 kN/m is 0.75 N: the loop toggles between two steps and the hand feels a buzz.
    #[must_use]
    pub const fn of(preset: &Preset) -> Self {
        Self { step: preset.encoder, spin_step: preset.spin_encoder }
    }

    /// Interpolated encoders: 1 um is 25 mN on the same spring, below what a finger can tell (about 60 mN).
    pub const FINE: Self = Self { step: 1e-6, spin_step: 2e-5 };

    /// A pose as the encoders give it.
    #[must_use]
    pub fn read(&self, position: Vec3, rotation: Quat) -> (Vec3, Quat) {
        let turn = turn_between(Quat::IDENTITY, rotation);
        (nearest(position, self.step), Quat::from_scaled_axis(nearest(turn, self.spin_step)))
    }
}

fn nearest(v: Vec3, step: f32) -> Vec3 {
    (v / step).round() * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::PREMIUM15;

    const AT_HOME: Target = Target { position: Vec3::ZERO, rotation: Quat::IDENTITY, velocity: Vec3::ZERO, spin: Vec3::ZERO };

    fn displaced(hand: Hand) -> Plant {
        Plant {
            position: Vec3::new(0.01, -0.02, 0.03),
            rotation: Quat::from_scaled_axis(Vec3::new(0.5, -1.0, 2.0)),
            ..Plant::new(&PREMIUM15, hand)
        }
    }

    #[test]
    fn left_alone_it_loses_energy_until_it_rests() {
        let mut plant = displaced(FIRM_GRIP);
        let mut before = plant.energy(&AT_HOME);
        for step in 0..16_000 {
            plant.step(&AT_HOME, &Load::default());
            let energy = plant.energy(&AT_HOME);
            // a symplectic step wobbles by dt times the power exchanged
            assert!(energy <= before * 1.02 + 1e-9, "step {step}: {before} J to {energy} J");
            before = energy;
        }
        assert!(before < 1e-8, "{before} J left");
    }

    #[test]
    fn without_damping_energy_neither_grows_nor_fades() {
        let hand = Hand { damping: 0.0, spin_damping: 0.0, ..FIRM_GRIP };
        let mut plant = Plant { damping: 0.0, spin_damping: 0.0, ..displaced(hand) };
        let begin = plant.energy(&AT_HOME);
        for step in 0..80_000 {
            plant.step(&AT_HOME, &Load::default());
            let drift = plant.energy(&AT_HOME) / begin - 1.0;
            assert!(drift.abs() < 0.02, "step {step}: {drift}");
        }
    }

    #[test]
    fn a_steady_wrench_is_balanced_by_the_hand_s_springs() {
        let mut plant = Plant::new(&PREMIUM15, FIRM_GRIP);
        let load = Load { force: Vec3::new(4.0, 0.0, -2.0), torque: Vec3::new(0.0, 0.3, 0.0), braked: false };
        for _ in 0..16_000 {
            plant.step(&AT_HOME, &load);
        }
        let error = plant.position - load.force / FIRM_GRIP.stiffness;
        assert!(error.length() < 1e-6, "{error} m");
        let turn = turn_between(Quat::IDENTITY, plant.rotation);
        let error = turn - load.torque / FIRM_GRIP.spin_stiffness;
        assert!(error.length() < 1e-4, "{error} rad");
    }

    #[test]
    fn the_brake_slows_a_push() {
        let slow = |braked| {
            let mut plant = Plant::new(&PREMIUM15, FIRM_GRIP);
            plant.velocity = Vec3::X;
            for _ in 0..80 {
                plant.step(&AT_HOME, &Load { braked, ..Load::default() });
            }
            plant.velocity.length()
        };
        assert!(slow(true) < 0.8 * slow(false));
    }

    #[test]
    fn encoders_read_in_steps_and_are_off_by_half_a_step_at_most() {
        let encoders = Encoders::of(&PREMIUM15);
        for i in 0..2000 {
            let x = i as f32 * 1.7e-6;
            let turn = Vec3::new(0.0, i as f32 * 1e-4, -0.1);
            let (position, rotation) = encoders.read(Vec3::new(x, -x, 0.0), Quat::from_scaled_axis(turn));
            let steps = position.x / encoders.step;
            assert!((steps - steps.round()).abs() < 1e-3, "{steps}");
            assert!((position.x - x).abs() <= 0.501 * encoders.step);
            assert_eq!(position.y.to_bits(), (-position.x).to_bits());
            let error = turn_between(Quat::from_scaled_axis(turn), rotation).length();
            assert!(error < encoders.spin_step, "{error} rad");
        }
    }
}

//! The session that every axis is judged by, in the contact's own units.
//!
//! A ball (or a flat end) is laid on, dragged and twisted to one and a half times what slips fully, and back. Told in the units of a contact (load P, radius a, shift s0 and angle phi0 that
//! take it to full slip, all in f64 from Hertz and Mindlin), the session and its answers are the same for every size, modulus, friction and depth: what differs from the session in the middle of the box is the
//! core's loss of digits.

use std::f64::consts::PI;

use glam::{DQuat, DVec3, Quat};
use haptor_contact::{Flags, Invalid, Material, Output};

use super::rig::{Rig, Scene, is_warned};

/// Ticks out, and back.
const HALF: u32 = 48;

/// How far out, in the units of full slip.
const OUT: f64 = 1.5;

/// Load, radius, shift and angle of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// Normal load \[N\].
    pub load: f64,
    /// Contact radius \[m\].
    pub radius: f64,
    /// Shift of full slip \[m\].
    pub shift: f64,
    /// Angle of full slip \[rad\].
    pub angle: f64,
    /// Friction.
    pub mu: f64,
}

impl Units {
    /// A ball of radius `r` pressed `depth` deep on a half space.
    pub fn ball(r: f64, depth: f64, material: &Material, mu: f64) -> Self {
        let (stiff, share) = (contact_modulus(material), depth / r);
        let load = 4.0 / 3.0 * stiff * r.sqrt() * depth.powf(1.5) * (1.0 - share / 10.0);
        Self::of(load, (r * depth).sqrt() * (1.0 - share / 6.0), 3.0 * PI / 16.0, material, mu)
    }

    /// A flat end of radius `a`.
    pub fn punch(a: f64, depth: f64, material: &Material, mu: f64) -> Self {
        Self::of(2.0 * contact_modulus(material) * a * depth, a, PI / 4.0, material, mu)
    }

    fn of(load: f64, a: f64, full: f64, material: &Material, mu: f64) -> Self {
        let (e, nu) = (f64::from(material.young_modulus), f64::from(material.poisson_ratio));
        let g = e / (2.0 * (1.0 + nu));
        let angle = full * mu * load * a / (16.0 / 3.0 * g * a * a * a);
        Self { load, radius: a, shift: 3.0 * mu * load * (2.0 - nu) / (16.0 * a * g), angle, mu }
    }

    /// Forces in mu P along the surface and P across it, torque in mu P a; without friction the force along the surface and the torque count in P.
    fn told(&self, output: &Output) -> [f64; 4] {
        let (f, t) = (output.contact.force.as_dvec3(), f64::from(output.contact.torque.z));
        let friction = if self.mu > 0.0 { self.mu * self.load } else { self.load };
        [f.x / friction, f.y / friction, f.z / self.load, t / (friction * self.radius)]
    }
}

fn contact_modulus(material: &Material) -> f64 {
    let (e, nu) = (f64::from(material.young_modulus), f64::from(material.poisson_ratio));
    e / (1.0 - nu * nu)
}

/// What a session is, beside its scene.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Units of the contact.
    pub units: Units,
    /// Place of the probe when laid on \[m\].
    pub place: DVec3,
    /// Time of a tick \[s\].
    pub dt: f32,
    /// Ticks of rest before the drag.
    pub rest: u64,
    /// Whole turns before the drag, tenths of them ticks.
    pub turns: f64,
}

/// Answers of a session.
#[derive(Clone, Debug, Default)]
pub struct Felt {
    answers: Vec<[f64; 4]>,
    /// Some tick warned of itself.
    pub warned: bool,
    /// Some pose was refused.
    pub refused: bool,
    /// There was contact.
    pub touched: bool,
    /// Ticks.
    pub steps: u64,
}

impl Felt {
    /// Largest difference in any component; `normal` compares the force across the surface only.
    pub fn off(&self, other: &Self, normal: bool) -> f64 {
        let pairs = self.answers.iter().zip(&other.answers);
        let off = |(a, b): (&[f64; 4], &[f64; 4])| {
            let one = |i: usize| (a[i] - b[i]).abs();
            if normal { one(2) } else { (0..4).map(one).fold(0.0, f64::max) }
        };
        pairs.map(off).fold(0.0, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
    }

    fn take(&mut self, units: &Units, output: &Output) {
        self.note(output);
        self.answers.push(units.told(output));
    }

    fn note(&mut self, output: &Output) {
        self.warned |= is_warned(output.report.flags);
        self.touched |= output.report.regions > 0;
        self.refused |= output.report.flags.contains(Flags::POSE_REFUSED);
    }
}

/// Runs a session.
///
/// # Errors
/// What construction refuses.
pub fn felt(scene: &Scene, plan: &Plan) -> Result<Felt, Invalid> {
    let mut rig = scene.rig()?;
    let mut felt = Felt::default();
    let still = |rig: &mut Rig<'_>| rig.tick(plan.place.as_vec3(), Quat::IDENTITY, plan.dt);
    let births = scene.parts.len();
    (0..births).for_each(|_| felt.note(&still(&mut rig)));
    for tick in 1..=(10.0 * plan.turns).ceil() as u64 {
        let turned = (tick as f64 / 10.0).min(plan.turns);
        felt.note(&rig.tick(plan.place.as_vec3(), about_z(2.0 * PI * turned.fract()), plan.dt));
    }
    for _ in 0..plan.rest {
        felt.note(&rig.tick(plan.place.as_vec3(), about_z(2.0 * PI * plan.turns.fract()), plan.dt));
    }
    for tick in 0..=2 * HALF {
        let share = OUT * f64::from(if tick <= HALF { tick } else { 2 * HALF - tick }) / f64::from(HALF);
        let shift = DVec3::new(0.8, 0.6, 0.0) * (share * plan.units.shift);
        // after turns, back against them: the way on is full slip already
        let sense = if plan.turns > 0.0 { -1.0 } else { 1.0 };
        let angle = 2.0 * PI * plan.turns.fract() + sense * share * plan.units.angle;
        let output = rig.tick((plan.place + shift).as_vec3(), about_z(angle), plan.dt);
        felt.take(&plan.units, &output);
    }
    felt.steps = rig.seen.steps;
    if rig.seen.fault.is_some() {
        // off from every other session
        felt.answers[0] = [f64::NAN; 4];
    }
    Ok(felt)
}

fn about_z(angle: f64) -> Quat {
    let q = DQuat::from_rotation_z(angle);
    Quat::from_xyzw(q.x as f32, q.y as f32, q.z as f32, q.w as f32)
}

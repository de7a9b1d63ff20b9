//! Where a case's probe begins, small motions about it, and how far two wrenches are apart.

use std::f32::consts::TAU;

use fastrand::Rng;
use glam::{Quat, Vec3};
use haptor_contact::{Invalid, MAX_TICK, ObjectShape, Output, ParamsSpec, Tier, Wrench};

use super::Outcome;
use crate::extremes::cases::{Case, any_vector};
use crate::extremes::rig::{Rig, Scene, is_warned, length};

/// Time between poses that no speed limit minds \[s\].
pub const AGES: f32 = MAX_TICK;

/// Halvings of the way from far to touching.
const HALVINGS: usize = 30;

/// Where the probe of `scene` is when it is `depth` deep, seen from `side`; `None` where it touches nothing from there.
pub fn place(case: &Case, scene: &Scene, outcome: &mut Outcome) -> Result<Option<Vec3>, Invalid> {
    let params = ParamsSpec { tier: Tier::Point, friction_static: Some(0.0), friction_dynamic: 0.0, samples: 64, ..scene.params };
    let smooth = Scene { params, ..scene.clone() };
    let mut rig = smooth.rig()?;
    let side = if scene.object == ObjectShape::HalfSpace { Vec3::Z } else { case.side };
    let middle = Vec3::Z * (0.5 * scene.object.height());
    let reach = scene.parts.iter().map(|part| part.position.length() + 2.0 * size_of(part)).fold(0.0, f32::max);
    let (mut inside, mut outside) = (0.0, reach + 2.0 * largest(&scene.object));
    let mut deepest = 0.0_f32;
    for _ in 0..HALVINGS {
        let between = 0.5 * (inside + outside);
        let depth = rig.tick(middle + side * between, case.rotation, AGES).report.depth;
        deepest = deepest.max(depth);
        if depth > 0.0 { inside = between } else { outside = between }
    }
    outcome.add(&rig.seen);
    Ok((deepest > 0.0).then(|| middle + side * (inside - case.depth)))
}

fn size_of(part: &haptor_contact::ProbePart<'_>) -> f32 {
    haptor_contact::geometry::support::reach(&part.shape)
}

fn largest(object: &ObjectShape<'_>) -> f32 {
    match *object {
        ObjectShape::HalfSpace => 0.0,
        ObjectShape::Box { size } => size.length(),
        ObjectShape::Sphere { radius } => radius,
        ObjectShape::Ellipsoid { semi_axes } => semi_axes.max_element(),
        ObjectShape::Cylinder { radius, height } => radius + height,
        ObjectShape::Mesh(mesh) => (mesh.bounds().1 - mesh.bounds().0).length(),
    }
}

/// A closed motion: shifts in units of an amplitude and spins in radians of it, zero at the beginning and every `ticks` ticks.
pub struct Loop {
    phases: [(Vec3, Vec3, f32); 2],
    ticks: u32,
}

impl Loop {
    /// A random loop of `ticks` ticks.
    pub fn new(rng: &mut Rng, ticks: u32) -> Self {
        let mut one = |rate: f32| (any_vector(rng), any_vector(rng), rate);
        Self { phases: [one(1.0), one(2.0)], ticks }
    }

    /// Shift and spin at a tick.
    pub fn at(&self, tick: u32) -> (Vec3, Vec3) {
        let share = (tick % self.ticks) as f32 / self.ticks as f32;
        let [(a, b, rate), (c, d, twice)] = self.phases;
        let (one, two) = ((TAU * rate * share).sin(), 1.0 - (TAU * twice * share).cos());
        (a * one + c * (0.5 * two), b * one + d * (0.5 * two))
    }
}

/// A pose of the twin: `shift` in metres and `spin` in radians from where the case begins.
pub fn moved(case: &Case, at: Vec3, shift: Vec3, spin: Vec3) -> (Vec3, Quat) {
    (at + shift, (Quat::from_scaled_axis(spin) * case.rotation).normalize())
}

/// A tick at a pose of the twin, taken to the corner.
pub fn tick_at(rig: &mut Rig<'_>, case: &Case, (position, rotation): (Vec3, Quat), dt: f32) -> Output {
    rig.tick(position * case.length(), rotation, dt)
}

/// Waits until every part in contact is born: at most one is, in a tick.
pub fn settle(rig: &mut Rig<'_>, position: Vec3, rotation: Quat) -> Output {
    for _ in 0..rig.model.probe().len() {
        rig.tick(position, rotation, AGES);
    }
    rig.tick(position, rotation, AGES)
}

/// Forces below this are not compared \[N\], nor torques \[N m\]: friction is followed from [`haptor_contact::LEAST_FRICTION`] on, and the least friction coefficient of a case is a thousandth.
pub const LEAST_COMPARED: f64 = 1.0e-10;

/// Differences between wrenches, against the largest there were.
#[derive(Default)]
pub struct Apart {
    force: (f64, f64),
    torque: (f64, f64),
}

impl Apart {
    /// Takes a pair. The largest torque counts at least as the force on a lever of `lever`, the contact's radius.
    pub fn take(&mut self, a: &Wrench, b: &Wrench, lever: f64) {
        self.take_scaled(a, b, (1.0, 1.0), lever);
    }

    /// Takes a pair of which the second is told in other units: `unit` are its force and torque in those of the first.
    pub fn take_scaled(&mut self, a: &Wrench, b: &Wrench, unit: (f64, f64), lever: f64) {
        let (force, torque) = (length(a.force), length(a.torque));
        let off = (a.force.as_dvec3() - b.force.as_dvec3() / unit.0).length();
        let turned = (a.torque.as_dvec3() - b.torque.as_dvec3() / unit.1).length();
        self.force = (self.force.0.max(force), self.force.1.max(off));
        self.torque = (self.torque.0.max(torque).max(force * lever), self.torque.1.max(turned));
    }

    /// The larger of the two shares; `None` where there was nothing to compare.
    pub fn share(&self) -> Option<f64> {
        let share = |(most, off): (f64, f64)| if most > 0.0 { off / most } else { 0.0 };
        (self.force.0 > LEAST_COMPARED).then(|| share(self.force).max(share(self.torque)))
    }
}

/// Whether a tick's figures count: it touches and does not warn of itself.
pub fn counts(output: &Output) -> bool {
    output.report.depth > 0.0 && !is_warned(output.report.flags)
}

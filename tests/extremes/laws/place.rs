//! Where a case's probe begins, small motions about it, and how far two sessions along one of them are apart.

use std::f32::consts::TAU;

use fastrand::Rng;
use glam::{DVec3, Quat, Vec3};
use haptor_contact::{Invalid, MAX_TICK, ObjectShape, Output, ParamsSpec, Tier, Wrench};

use super::Outcome;
use crate::extremes::cases::{Case, any_vector, decades};
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

/// A random loop about the place where a case begins.
pub struct Walk<'a> {
    case: &'a Case,
    at: Vec3,
    path: Loop,
    amplitude: f32,
}

impl<'a> Walk<'a> {
    /// A loop of `ticks` ticks about `at`, as large as a power of ten of the depth: `low` to `high`.
    pub fn new(case: &'a Case, at: Vec3, rng: &mut Rng, ticks: u32, (low, high): (f32, f32)) -> Self {
        let path = Loop::new(rng, ticks);
        Self { case, at, path, amplitude: case.depth * decades(rng, low, high) }
    }

    /// The pose of the twin at a tick.
    pub fn pose(&self, tick: u32) -> (Vec3, Quat) {
        let (shift, spin) = self.path.at(tick);
        moved(self.case, self.at, shift * self.amplitude, spin * (self.amplitude / self.case.size))
    }

    /// Two sessions once around, until a tick warns of itself. `tick` takes both to a pose and gives their outputs, of which `told` tells the second's wrench as the first has it.
    /// Figure: largest difference over the largest wrench.
    pub fn compare<'m>(
        &self,
        outcome: &mut Outcome,
        mut rigs: [Rig<'m>; 2],
        mut tick: impl FnMut(&mut [Rig<'m>; 2], (Vec3, Quat)) -> [Output; 2],
        told: impl Fn(&Wrench) -> Told,
    ) {
        let mut apart = Apart::default();
        for at in 0..self.path.ticks {
            let outputs = tick(&mut rigs, self.pose(at));
            if outputs.iter().any(is_spoilt) {
                break;
            }
            let [one, other] = outputs;
            apart.take(&one.contact, told(&other.contact), f64::from(one.report.radius));
        }
        apart.share().into_iter().for_each(|share| outcome.figure(share));
        rigs.iter().for_each(|rig| outcome.add(&rig.seen));
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

/// A wrench told in the units and the frame of another session: force \[N\] and torque \[N m\], in f64 because the product with a unit may leave the range of an f32.
pub type Told = (DVec3, DVec3);

/// A wrench of a session that has the units and the frame of the other.
pub fn as_it_is(wrench: &Wrench) -> Told {
    (wrench.force.as_dvec3(), wrench.torque.as_dvec3())
}

/// Differences between wrenches, against the largest there were.
#[derive(Default)]
struct Apart {
    force: (f64, f64),
    torque: (f64, f64),
}

impl Apart {
    /// Takes a pair. The largest torque counts at least as the force on a lever of `lever`, the contact's radius.
    fn take(&mut self, wrench: &Wrench, (other_force, other_torque): Told, lever: f64) {
        let (force, torque) = (length(wrench.force), length(wrench.torque));
        let off = (wrench.force.as_dvec3() - other_force).length();
        let turned = (wrench.torque.as_dvec3() - other_torque).length();
        self.force = (self.force.0.max(force), self.force.1.max(off));
        self.torque = (self.torque.0.max(torque).max(force * lever), self.torque.1.max(turned));
    }

    /// The larger of the two shares; `None` where there was nothing to compare.
    fn share(&self) -> Option<f64> {
        let share = |(most, off): (f64, f64)| if most > 0.0 { off / most } else { 0.0 };
        (self.force.0 > LEAST_COMPARED).then(|| share(self.force).max(share(self.torque)))
    }
}

/// Whether a tick touches and warns of itself: neither its figures count nor what comes of its state.
pub fn is_spoilt(output: &Output) -> bool {
    output.report.depth > 0.0 && is_warned(output.report.flags)
}

/// Whether a tick's figures count: it touches and does not warn of itself.
pub fn counts(output: &Output) -> bool {
    output.report.depth > 0.0 && !is_warned(output.report.flags)
}

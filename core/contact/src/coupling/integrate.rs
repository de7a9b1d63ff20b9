//! One semi-implicit step of the probe (theory.md, equations 10.8 and 10.9).
//!
//! With dt the tick and the contact linearised at the probe's last pose, one symmetric 6x6 system gives the speeds at the tick's end; the pose follows
//! from them. Mass may be zero: the step is then Newton's step to equilibrium. Angular momentum is what is carried from tick to tick, so that a free probe keeps it
//! to the bit and its spin cannot grow.

use glam::{Quat, Vec3};

use super::spring::Spring;
use super::sym::{Sym3, Sym6};
use super::{Coupled, VirtualCoupling};
use crate::World;
use crate::frames::{Pose, ProbeFrame};
use crate::limits::{MAX_DISTANCE, MAX_SPEED, MAX_TURN_RATE};
use crate::math::{FRAC_PI_2, cos, max, min, root, sin};
use crate::model::Model;
use crate::report::Flags;
use crate::stage::regions::{rotation_vector, turn_between};
use crate::wrench::Wrench;

/// The two kinds of motion of one tick.
struct Tick {
    linear: Axis,
    angular: Axis,
    mass: f32,
    inertia: Sym3,
    dt: f32,
}

/// What one kind of motion starts from.
struct Axis {
    spring: Spring,
    /// Stretch from probe to handle if the probe stood still.
    stretch: Vec3,
    /// Motion of the handle in this tick.
    moved: Vec3,
}

/// Speeds at the end of a tick.
#[derive(Clone, Copy)]
struct Speeds {
    velocity: Vec3,
    spin: Vec3,
}

/// Moves the probe on. `contact` is the wrench that acted on it at its last pose.
pub fn advance(
    model: &Model<'_>,
    spec: &VirtualCoupling,
    coupled: &mut Coupled,
    handle: &Pose<World, ProbeFrame>,
    contact: &Wrench<World>,
    dt: f32,
) -> Flags {
    let tick = Tick::new(model, spec, coupled, handle, dt);
    let still = *handle == coupled.handle;
    let speeds = bounded(solve(&tick, coupled, contact), dt);
    coupled.handle = *handle;
    coupled.at_rest = still && rests(&tick, coupled, contact, &speeds);
    if coupled.at_rest {
        settle(&tick, coupled, contact);
        return Flags::CLEAN;
    }
    follow(&tick, coupled, &speeds);
    catch_if_lost(coupled)
}

impl Tick {
    fn new(model: &Model<'_>, spec: &VirtualCoupling, coupled: &Coupled, handle: &Pose<World, ProbeFrame>, dt: f32) -> Self {
        let inertia = model.inertia.tensor().rotated(coupled.probe.rotation);
        let springs = spec.springs(model.mass, inertia.trace() / 3.0);
        let turn = |from: Quat| rotation_vector(handle.rotation * from.conjugate());
        Self {
            linear: Axis {
                spring: springs.0,
                stretch: handle.position - coupled.probe.position - coupled.lag.0,
                moved: handle.position - coupled.handle.position,
            },
            angular: Axis {
                spring: springs.1,
                stretch: turn(coupled.probe.rotation) - coupled.lag.1,
                moved: turn(coupled.handle.rotation),
            },
            mass: model.mass,
            inertia,
            dt,
        }
    }
}

/// Solves (10.8). Friction that the step would unload is as stiff as when stuck; then the step is taken again with that.
fn solve(tick: &Tick, coupled: &Coupled, contact: &Wrench<World>) -> Speeds {
    let Tick { linear, angular, dt, .. } = tick;
    let pull = linear.spring.tick(linear.stretch, linear.moved, coupled.held.0, *dt);
    let twist = angular.spring.tick(angular.stretch, angular.moved, coupled.held.1, *dt);
    let square = dt * dt;
    let (known, known_turn) = (tick.mass + square * pull.implicit, square * twist.implicit);
    let impulse = coupled.velocity * tick.mass + (pull.now + contact.force) * *dt;
    let angular_impulse = coupled.angular_momentum + (twist.now + contact.torque) * *dt;
    let with = |stiffness: &Sym6| {
        let floors = (known, known_turn);
        let system = stiffness
            .scaled_within(square, floors)
            .plus(&Sym6::blocks(Sym3::splat(known), tick.inertia + Sym3::splat(known_turn)));
        system.solve(impulse, angular_impulse, floors)
    };
    let (velocity, spin) = with(&coupled.contact.loading);
    let (force, torque) = coupled.contact.friction;
    let unloads = force.dot(velocity) + torque.dot(spin) > 0.0;
    let (velocity, spin) = if unloads { with(&coupled.contact.unloading) } else { (velocity, spin) };
    Speeds { velocity, spin }
}

/// No probe moves faster than a pose may, nor turns by more than a quarter turn in a tick, where a chord stops being an arc.
fn bounded(speeds: Speeds, dt: f32) -> Speeds {
    let shorten = |v: Vec3, most: f32| {
        let length = root(v.length_squared());
        if length > most { v * (most / length) } else { v }
    };
    Speeds { velocity: shorten(speeds.velocity, MAX_SPEED), spin: shorten(speeds.spin, min(MAX_TURN_RATE, FRAC_PI_2 / dt)) }
}

/// Steps of the pose's own resolution within which the probe counts as at rest: rounding of the pose moves the contact's force by one or two.
const REST: f32 = 4.0 * f32::EPSILON;

/// Resolution of a pose near the world's origin \[m\]: an ulp at a millimetre.
const LEAST_LENGTH: f32 = 1.0e-3;

/// The handle stands, the probe hardly moves, the damper has let go, and equilibrium is not farther than the pose can tell.
fn rests(tick: &Tick, coupled: &Coupled, contact: &Wrench<World>, speeds: &Speeds) -> bool {
    let Tick { linear, angular, dt, .. } = tick;
    let largest = |v: Vec3| max(v.x.abs(), max(v.y.abs(), v.z.abs()));
    let length = REST * max(max(largest(coupled.probe.position), largest(coupled.handle.position)), LEAST_LENGTH);
    let near = |shift: Vec3, turn: Vec3| largest(shift) <= length && largest(turn) <= REST;
    if !near(speeds.velocity * *dt, speeds.spin * *dt) {
        return false;
    }
    let (k, k_turn) = (linear.spring.stiffness, angular.spring.stiffness);
    if !near(coupled.held.0 / k, coupled.held.1 / k_turn) {
        return false;
    }
    let floors = (linear.spring.floor(linear.stretch), angular.spring.floor(angular.stretch));
    let system =
        coupled.contact.loading.scaled_within(1.0, floors).plus(&Sym6::blocks(Sym3::splat(floors.0), Sym3::splat(floors.1)));
    let force = linear.spring.pull(linear.stretch) + contact.force;
    let (shift, turn) = system.solve(force, angular.spring.pull(angular.stretch) + contact.torque, floors);
    near(shift, turn)
}

/// Stops the probe where it is. Without a contact the hand then feels nothing at all.
fn settle(tick: &Tick, coupled: &mut Coupled, contact: &Wrench<World>) {
    (coupled.velocity, coupled.angular_momentum) = (Vec3::ZERO, Vec3::ZERO);
    coupled.held = (Vec3::ZERO, Vec3::ZERO);
    coupled.moved = (Vec3::ZERO, Vec3::ZERO);
    let free = *contact == Wrench::ZERO;
    let pull = |axis: &Axis| if free { Vec3::ZERO } else { axis.spring.pull(axis.stretch) };
    coupled.pull = Wrench::new(pull(&tick.linear), pull(&tick.angular));
}

/// Pose, momentum and pull at the end of the tick.
fn follow(tick: &Tick, coupled: &mut Coupled, speeds: &Speeds) {
    let Tick { linear, angular, dt, .. } = tick;
    let (shift, turn) = (speeds.velocity * *dt, speeds.spin * *dt);
    coupled.velocity = speeds.velocity;
    coupled.angular_momentum = tick.inertia.times(speeds.spin);
    let pull = linear.spring.tick(linear.stretch, linear.moved, coupled.held.0, *dt);
    let twist = angular.spring.tick(angular.stretch, angular.moved, coupled.held.1, *dt);
    coupled.held = (
        linear.spring.held(&pull, coupled.held.0, linear.moved, shift),
        angular.spring.held(&twist, coupled.held.1, angular.moved, turn),
    );
    coupled.pull = Wrench::new(
        linear.spring.pull(linear.stretch - shift) + coupled.held.0,
        angular.spring.pull(angular.stretch - turn) + coupled.held.1,
    );
    let before = coupled.probe;
    let (wanted, wanted_turn) = (coupled.lag.0 + shift, coupled.lag.1 + turn);
    coupled.probe = Pose::new(before.position + wanted, turned(before.rotation, wanted_turn));
    coupled.moved = (coupled.probe.position - before.position, turn_between(before.rotation, coupled.probe.rotation));
    // what the pose was too coarse for is owed to the next tick
    coupled.lag = (wanted - coupled.moved.0, wanted_turn - coupled.moved.1);
}

/// `q` turned by the rotation vector `v`; `q` itself, to the bit, for a turn below its resolution.
fn turned(q: Quat, v: Vec3) -> Quat {
    let angle = root(v.length_squared());
    if angle < 0.5 * f32::EPSILON {
        return q;
    }
    let (sine, cosine) = (sin(0.5 * angle), cos(0.5 * angle));
    let axis = v * (sine / angle);
    let next = Quat::from_xyzw(axis.x, axis.y, axis.z, cosine) * q;
    next * (1.0 / root(next.length_squared()))
}

/// A probe that is not finite or has left the world goes back to the handle, at rest.
fn catch_if_lost(coupled: &mut Coupled) -> Flags {
    let finite = coupled.velocity.is_finite() && coupled.angular_momentum.is_finite() && coupled.pull.is_finite();
    let probe = &coupled.probe;
    if finite && probe.rotation.is_finite() && probe.position.length() <= MAX_DISTANCE {
        return Flags::CLEAN;
    }
    *coupled = Coupled::at(coupled.handle, coupled.handle);
    Flags::NON_FINITE
}

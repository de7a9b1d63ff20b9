//! The last stage: what leaves a tick is finite, bounded, changes no faster than stated, and where asked gives out no more energy than it took.

use glam::Vec3;

use crate::coupling::passivity::{Passivity, Port};
use crate::error::{Invalid, require};
use crate::frames::{Pose, ProbeFrame, World};
use crate::math::{max, min, root};
use crate::report::Flags;
use crate::wrench::Wrench;

/// Limits of the last stage. A limit of `f32::INFINITY` is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardSpec {
    /// Largest force \[N\]; direction is kept.
    pub max_force: f32,
    /// Largest torque \[N m\]; direction is kept, the force is not touched.
    pub max_torque: f32,
    /// Largest rate of change of the force \[N/s\].
    pub max_force_rate: f32,
    /// Largest rate of change of the torque \[N m/s\].
    pub max_torque_rate: f32,
    /// Time over which the wrench is ramped in when the first pose is inside the object \[s\].
    pub ramp_in: f32,
    /// Passivity observer and controller at the handle; `None` is off.
    pub passivity: Option<Passivity>,
}

impl Default for GuardSpec {
    /// Limits of a PHANTOM Premium 1.5/6DOF (8.5 N, 0.188 N m), full scale in 20 ms, half a second of ramp.
    fn default() -> Self {
        Self { max_force: 8.5, max_torque: 0.188, max_force_rate: 425.0, max_torque_rate: 9.4, ramp_in: 0.5, passivity: None }
    }
}

impl GuardSpec {
    /// No limit, no ramp, no damping: what goes in comes out.
    pub const OPEN: Self = Self {
        max_force: f32::INFINITY,
        max_torque: f32::INFINITY,
        max_force_rate: f32::INFINITY,
        max_torque_rate: f32::INFINITY,
        ramp_in: 0.0,
        passivity: None,
    };

    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let positive = |name, value: f32| {
            if value == f32::INFINITY { Ok(()) } else { require(value > 0.0, name, value, "above 0, or infinity for none") }
        };
        positive("guard.max_force [N]", self.max_force)?;
        positive("guard.max_torque [N m]", self.max_torque)?;
        positive("guard.max_force_rate [N/s]", self.max_force_rate)?;
        positive("guard.max_torque_rate [N m/s]", self.max_torque_rate)?;
        require((0.0..=60.0).contains(&self.ramp_in), "guard.ramp_in", self.ramp_in, "0 to 60 s")?;
        self.passivity.as_ref().map_or(Ok(()), Passivity::check)
    }
}

/// Memory of the last stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardState {
    /// Last wrench that left.
    pub wrench: Wrench<World>,
    /// Share of the wrench let through, 0..1; below 1 only after a start inside the object.
    pub ramp: f32,
    /// Energy at the handle; not touched while passivity is off.
    pub port: Port,
}

impl GuardState {
    pub const START: Self = Self { wrench: Wrench::ZERO, ramp: 1.0, port: Port::START };
}

/// Makes a wrench fit for the device: finite, ramped, limited, slewed, damped, in this order. `handle` is this tick's pose, `None` if it was refused.
pub(crate) fn guard(
    spec: &GuardSpec,
    state: &mut GuardState,
    wanted: &Wrench<World>,
    handle: Option<&Pose<World, ProbeFrame>>,
    dt: f32,
) -> (Wrench<World>, Flags) {
    let flags = shape(spec, state, wanted, dt);
    let Some(passivity) = &spec.passivity else { return (state.wrench, flags) };
    let damped = keep_passive(spec, passivity, state, handle, dt);
    (state.wrench, flags | damped)
}

/// Observes the port and damps what leaves; the limits hold for the sum. Not inlined, so that a guard without it pays nothing for it.
#[inline(never)]
fn keep_passive(
    spec: &GuardSpec,
    passivity: &Passivity,
    state: &mut GuardState,
    handle: Option<&Pose<World, ProbeFrame>>,
    dt: f32,
) -> Flags {
    let moved = state.port.observe(passivity, handle);
    let (damped, mut flags) = state.port.damp(passivity, &moved, &state.wrench, dt);
    if flags != Flags::CLEAN {
        let force = limit(damped.force, spec.max_force, Flags::FORCE_LIMITED, &mut flags);
        let torque = limit(damped.torque, spec.max_torque, Flags::TORQUE_LIMITED, &mut flags);
        state.wrench = Wrench::new(force, torque);
    }
    state.port.keep(&state.wrench);
    flags
}

/// Finite, ramped, limited, slewed.
fn shape(spec: &GuardSpec, state: &mut GuardState, contact: &Wrench<World>, dt: f32) -> Flags {
    let mut flags = Flags::CLEAN;
    let mut wanted = *contact;
    if !wanted.is_finite() {
        wanted = Wrench::ZERO;
        flags |= Flags::NON_FINITE;
    }
    if state.ramp < 1.0 && spec.ramp_in > 0.0 {
        state.ramp = min(state.ramp + dt / spec.ramp_in, 1.0);
        wanted = Wrench::new(wanted.force * state.ramp, wanted.torque * state.ramp);
        flags |= Flags::RAMPING_IN;
    }
    let force = limit(wanted.force, spec.max_force, Flags::FORCE_LIMITED, &mut flags);
    let torque = limit(wanted.torque, spec.max_torque, Flags::TORQUE_LIMITED, &mut flags);
    let last = state.wrench;
    // without time nothing changes, whatever the rate: infinity times zero is not a number
    let most = |rate: f32| if dt > 0.0 { rate * dt } else { 0.0 };
    let force = last.force + limit(force - last.force, most(spec.max_force_rate), Flags::FORCE_SLEWED, &mut flags);
    let torque = last.torque + limit(torque - last.torque, most(spec.max_torque_rate), Flags::TORQUE_SLEWED, &mut flags);
    // a limit lowered between ticks holds at once
    let force = limit(force, spec.max_force, Flags::FORCE_LIMITED, &mut flags);
    let torque = limit(torque, spec.max_torque, Flags::TORQUE_LIMITED, &mut flags);
    state.wrench = Wrench::new(force, torque);
    flags
}

/// Shortens `v` to `largest`, direction kept. Scales first: the square of 1e30 is not finite.
fn limit(v: Vec3, largest: f32, flag: Flags, flags: &mut Flags) -> Vec3 {
    let component = max(v.x.abs(), max(v.y.abs(), v.z.abs()));
    if component <= 0.0 || component * 2.0 <= largest {
        return v;
    }
    let unit = v / component;
    let length = component * root(unit.length_squared());
    if length <= largest {
        return v;
    }
    *flags |= flag;
    unit * (largest / root(unit.length_squared()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEC: GuardSpec = GuardSpec {
        max_force: 8.0,
        max_torque: 0.2,
        max_force_rate: 1000.0,
        max_torque_rate: f32::INFINITY,
        ramp_in: 0.01,
        passivity: None,
    };

    #[test]
    fn directions_are_kept_and_each_limit_is_its_own() {
        let mut state = GuardState::START;
        let contact = Wrench::new(Vec3::new(30.0, 0.0, 40.0), Vec3::new(0.0, 0.1, 0.0));
        let (first, flags) = guard(&SPEC, &mut state, &contact, None, 1.0e-3);
        assert!((first.force - Vec3::new(0.6, 0.0, 0.8)).length() < 1.0e-5, "{first:?}");
        assert_eq!(flags, Flags::FORCE_LIMITED | Flags::FORCE_SLEWED);
        assert_eq!(first.torque, contact.torque);
        for _ in 0..20 {
            let _ = guard(&SPEC, &mut state, &contact, None, 1.0e-3);
        }
        assert!((state.wrench.force - Vec3::new(4.8, 0.0, 6.4)).length() < 1.0e-5);
    }

    #[test]
    fn what_is_not_finite_becomes_zero_and_huge_values_keep_their_direction() {
        let open = GuardSpec { max_force_rate: f32::INFINITY, ..SPEC };
        let mut state = GuardState::START;
        let (out, flags) = guard(&open, &mut state, &Wrench::new(Vec3::new(f32::NAN, 0.0, 1.0), Vec3::ZERO), None, 1.0e-3);
        assert_eq!((out, flags), (Wrench::ZERO, Flags::NON_FINITE));
        let (out, _) = guard(&open, &mut state, &Wrench::new(Vec3::new(3.0e37, 0.0, 4.0e37), Vec3::ZERO), None, 1.0e-3);
        assert!((out.force - Vec3::new(4.8, 0.0, 6.4)).length() < 1.0e-4, "{out:?}");
    }

    #[test]
    fn no_time_no_change_even_without_a_rate_limit() {
        let open = GuardSpec { max_force_rate: f32::INFINITY, ..SPEC };
        let mut state = GuardState::START;
        let (out, _) = guard(&open, &mut state, &Wrench::new(Vec3::Z, Vec3::ZERO), None, 0.0);
        assert_eq!(out, Wrench::ZERO);
    }

    #[test]
    fn a_start_inside_is_ramped() {
        let mut state = GuardState { ramp: 0.0, ..GuardState::START };
        let contact = Wrench::new(Vec3::Z * 1.0, Vec3::ZERO);
        let (out, flags) = guard(&SPEC, &mut state, &contact, None, 1.0e-3);
        assert!((out.force.z - 0.1).abs() < 1.0e-5 && flags == Flags::RAMPING_IN, "{out:?} {flags:?}");
    }
}

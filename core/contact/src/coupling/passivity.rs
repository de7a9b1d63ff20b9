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
use crate::stage::regions::turn_between;
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
        let moved = Moved { shift: now.position - before.position, turn: turn_between(before.rotation, now.rotation) };
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

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::guard::{GuardSpec, GuardState, guard};
    use crate::math::max;
    use crate::stage::regions::rotation_vector;

    const DT: f32 = 1.0e-3;

    /// A guard without limits, passive or not.
    fn spec(passivity: Option<Passivity>) -> GuardSpec {
        GuardSpec { passivity, ..GuardSpec::OPEN }
    }

    /// The number `i` of a fixed sequence in -1..1.
    fn noise(i: u32) -> f32 {
        let mut x = i.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
        x = (x ^ (x >> 15)).wrapping_mul(0x2C1B_3C6D);
        x = (x ^ (x >> 12)).wrapping_mul(0x297A_2D39);
        x ^= x >> 15;
        (x >> 8) as f32 / 8_388_608.0 - 1.0
    }

    /// Smooth motion within +-1: between the sequence's numbers at every 64th tick.
    fn wave(channel: u32, tick: u32) -> f32 {
        let (knot, part) = (tick / 64, (tick % 64) as f32 / 64.0);
        let (a, b) = (noise(channel * 7919 + knot), noise(channel * 7919 + knot + 1));
        a + (b - a) * part * part * (3.0 - 2.0 * part)
    }

    fn handle(seed: u32, tick: u32) -> Pose<World, ProbeFrame> {
        let at = |channel: u32| wave(16 * seed + channel, tick);
        let turn = Quat::from_xyzw(0.1 * at(3), 0.1 * at(4), 0.1 * at(5), 1.0);
        Pose::new(Vec3::new(5.0e-3 * at(0), 5.0e-3 * at(1), 5.0e-3 * at(2)), turn.normalize())
    }

    /// Springs of 1 kN/m and 0.5 N m/rad about the origin.
    fn spring(handle: &Pose<World, ProbeFrame>) -> Wrench<World> {
        Wrench::new(handle.position * -1.0e3, rotation_vector(handle.rotation) * -0.5)
    }

    /// Energy that force and torque gave out over a run at worst, and the most they gave in one tick \[J\]. The wrench asked for is `wanted`, and takes
    /// effect `delay` ticks late.
    fn given(guarded: &GuardSpec, seed: u32, delay: usize, wanted: impl Fn(u32) -> Wrench<World>) -> [(f64, f64); 2] {
        let mut state = GuardState::START;
        let mut link = [Wrench::ZERO; MAX_DELAY + 1];
        let mut out = [(0.0, 0.0, 0.0); 2];
        let mut before = handle(seed, 0);
        for tick in 0..6000 {
            let now = handle(seed, tick);
            let held = link[delay];
            let work =
                [held.force.dot(now.position - before.position), held.torque.dot(turn_between(before.rotation, now.rotation))];
            for ((sum, worst, tick_s), work) in out.iter_mut().zip(work) {
                *sum += f64::from(work);
                (*worst, *tick_s) = (f64::max(*worst, *sum), f64::max(*tick_s, f64::from(work)));
            }
            let (sent, _) = guard(guarded, &mut state, &wanted(tick), Some(&now), DT);
            link.rotate_right(1);
            link[0] = sent;
            before = now;
        }
        out.map(|(_, worst, tick)| (worst, tick))
    }

    /// A late spring is active: it gives out more on the way back than it took on the way in.
    #[test]
    fn what_comes_out_is_bounded_by_what_a_few_ticks_can_give() {
        for seed in 0..12 {
            for delay in [0, 1, 2, 4, 8] {
                let strong = Passivity { max_damping: 1.0e3, max_spin_damping: 10.0, delay_ticks: delay, ..Passivity::default() };
                let law = |tick: u32| spring(&handle(seed, tick));
                let active = given(&spec(None), seed, delay, law);
                let damped = given(&spec(Some(strong)), seed, delay, law);
                for ((free, _), (worst, in_a_tick)) in active.into_iter().zip(damped) {
                    // the brake is as late as the wrench, and knows the last speed, not the next
                    let bound = 2.0 * (delay + 1) as f64 * in_a_tick;
                    assert!(worst <= bound, "seed {seed}, {delay} late: {worst} J came out, a tick gives {in_a_tick}");
                    assert!(worst < 0.5 * free, "seed {seed}, {delay} late: {worst} J with, {free} J without");
                }
            }
        }
    }

    /// Springs with a damper that is worth more than half a tick of the spring take energy on any path: nothing is added, to the bit.
    #[test]
    fn a_passive_stroke_is_left_as_it_is() {
        for seed in 0..12 {
            let law = |tick: u32| {
                let (now, before) = (handle(seed, tick), handle(seed, tick.saturating_sub(1)));
                let spin = turn_between(before.rotation, now.rotation);
                // at rest where the path begins: nothing is stored that was not put in
                let start = handle(seed, 0);
                let Wrench { force, torque, .. } =
                    spring(&Pose::new(now.position - start.position, now.rotation * start.rotation.conjugate()));
                Wrench::new(force - (now.position - before.position) * (20.0 / DT), torque - spin * (0.01 / DT))
            };
            let (mut with, mut without) = (GuardState::START, GuardState::START);
            for tick in 0..6000 {
                let now = handle(seed, tick);
                let (a, flags) = guard(&spec(Some(Passivity::default())), &mut with, &law(tick), Some(&now), DT);
                let (b, _) = guard(&spec(None), &mut without, &law(tick), Some(&now), DT);
                assert_eq!((a, flags), (b, Flags::CLEAN), "seed {seed}, tick {tick}");
            }
        }
    }

    #[test]
    fn damping_keeps_to_its_limit_and_to_the_device_s() {
        let weak = Passivity { max_damping: 3.0, max_spin_damping: 0.002, ..Passivity::default() };
        let limited = GuardSpec { max_force: 2.0, ..spec(Some(weak)) };
        let mut state = GuardState::START;
        let mut acted = 0;
        for tick in 0..3000 {
            let (before, now) = (handle(3, tick), handle(3, tick + 1));
            let wanted = Wrench::new((now.position - before.position) * 5.0e3, Vec3::ZERO);
            let (sent, flags) = guard(&limited, &mut state, &wanted, Some(&before), DT);
            let earlier = handle(3, tick.saturating_sub(1));
            let most = 3.0 * (before.position - earlier.position).length() / DT;
            assert!((sent.force - wanted.force).length() <= most * 1.001 + 1.0e-6, "tick {tick}: {sent:?} {wanted:?}");
            assert!(sent.force.length() <= 2.0 * 1.000_01);
            acted += u32::from(flags.contains(Flags::PASSIVITY_DAMPED));
        }
        assert!(acted > 1000, "a force along the motion gives energy all the time: {acted}");
    }

    #[test]
    fn whatever_comes_in_numbers_go_out() {
        let odd = [0.0, -0.0, 1.0e-40, 1.0e30, -3.0e38, f32::NAN, f32::INFINITY, 1.0];
        for passivity in [Passivity::default(), Passivity { reserve: f32::INFINITY, allowance: 0.0, ..Passivity::default() }] {
            let limited = GuardSpec { max_force: 8.5, max_torque: 0.2, ..spec(Some(passivity)) };
            let mut state = GuardState::START;
            for i in 0..20_000_u32 {
                let pick = |channel: u32| odd[(noise(7 * i + channel).abs() * 7.99) as usize];
                let wanted = Wrench::new(Vec3::new(pick(0), pick(1), 0.0), Vec3::new(0.0, pick(2), pick(3)));
                let at = Vec3::new(1.0e3 * noise(i), 1.0e-30 * noise(i + 1), 0.0);
                let pose = Pose::new(at, Quat::from_xyzw(noise(i), noise(i + 2), 0.3, 1.0).normalize());
                let dt = [0.0, 1.0e-6, 1.0e-3, 1.0][i as usize % 4];
                let (out, _) = guard(&limited, &mut state, &wanted, (i % 9 != 0).then_some(&pose), dt);
                assert!(out.is_finite() && max(out.force.length(), 40.0 * out.torque.length()) <= 8.501, "{i}: {out:?}");
            }
        }
    }
}

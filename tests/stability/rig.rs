//! One closed loop: hand and handle of the simulated device, encoders, core, link delay.
//!
//! ```text
//!  handle (8 kHz) ─ encoders ─► tick of the core ─► delay of n ticks ─► held until the next ─► handle
//! ```
//! The hand approaches, presses on a half space with a ball of 20 mm, twists, holds, and lifts, in a second. Judged is the handle's **tremble** in the
//! second half of the hold: its speed above [`CORNER_HZ`], spin counted at a lever of 20 mm, so that a heavy probe that swings to rest on soft ground does not count.
//!
//! - **quiet**: the tremble is below [`QUIET`];
//! - **toggles**: it is not, and the handle stays within [`TOGGLE`] encoder steps: the encoder's own buzz on a stiff contact, which cannot grow;
//! - **shakes**: anything else, a limit cycle that grows until the device's force limit stops it.

use std::collections::VecDeque;

use glam::{Quat, Vec3};
use haptor_contact::{
    CouplingSpec, Flags, GuardSpec, Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Passivity, Pose,
    ProbePart, ProbeShape, Report, Scratch, State, VirtualCoupling, Wrench, step,
};
use haptor_firmware_sim::Preset;
use haptor_firmware_sim::plant::{Encoders, Hand, Load, Plant};
use haptor_firmware_sim::script::Target;

/// Steps of the handle's integration per second: `haptor_firmware_sim::plant::STEP` is 125 us.
const STEPS_PER_SECOND: u32 = 8000;

/// Radius of the ball \[m\].
const RADIUS: f32 = 0.02;

/// Gap before the approach \[m\].
const CLEARANCE: f32 = 1.0e-3;

/// Speed (root mean square) below which a hold counts as quiet \[m/s\]: a micrometre at 100 Hz, where a finger begins to feel vibration, is 0.4 mm/s.
pub const QUIET: f32 = 0.5e-3;

/// Corner of the two high passes in a row that tell tremble from motion \[Hz\]: above a hand's own 10 Hz, below what a late loop of 10 ms shakes at.
pub const CORNER_HZ: f32 = 20.0;

/// Encoder steps within which a handle toggles: one to each side of where it wants to be, and one of rounding.
pub const TOGGLE: f32 = 3.0;

/// Lever at which the handle's spin counts as speed \[m\]: the radius of a grip.
const LEVER: f32 = 0.02;

/// Ends of the motions \[s\]: approach and press, twist, hold, lift, rest.
const PRESSED: f32 = 0.3;
const TWISTED: f32 = 0.45;
const HELD: f32 = 0.75;
const LIFTED: f32 = 0.9;
const END: f32 = 1.0;

/// How far the hand twists \[rad\].
const TWIST: f32 = 0.05;

/// A device with what its maker says it closes.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// Limits, masses, encoders.
    pub preset: Preset,
    /// Stiffness \[N/m\] and rotational stiffness \[N m/rad\] that CHAI3D's tables give; where they give none for rotation, a share of the Premium's.
    pub closes: (f32, f32),
    /// Damping \[N s/m\] and rotational damping \[N m s/rad\] of the same tables.
    pub damps: (f32, f32),
}

/// One point of the map.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The device.
    pub machine: Machine,
    /// The hand.
    pub hand: Hand,
    /// Young's modulus of the object \[Pa\].
    pub young_modulus: f32,
    /// Ticks per second; divides 8000.
    pub rate_hz: u32,
    /// Ticks between a pose and the wrench that answers it, beyond the tick itself.
    pub delay: usize,
    /// Virtual coupling at the device's closable stiffness, or direct.
    pub coupled: bool,
    /// With the passivity controller.
    pub passive: bool,
    /// Mass of the probe \[kg\].
    pub mass: f32,
}

/// What a run shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Tremble in the first and in the second half of the hold, root mean square \[m/s\].
    pub speed: (f32, f32),
    /// Way of the trembling handle in the second half, end to end, in encoder steps; the larger of translation and rotation.
    pub steps: f32,
    /// Largest change of the force from tick to tick, at any time \[N\].
    pub force_step: f32,
    /// Largest force \[N\].
    pub peak: f32,
    /// Force in the hold, mean \[N\].
    pub force: f32,
    /// Energy that the device gave the hand over the whole stroke, less what it took \[J\].
    pub energy: f32,
    /// Largest speed of the handle against the hand's wish in the last 0.1 s, when it is free again \[m/s\].
    pub kick: f32,
    /// Ticks in which the controller acted.
    pub damped: u32,
    /// What damping like that of hand and handle takes out of the handle's motion \[J\].
    pub spent: f32,
    /// Largest speed of the handle \[m/s\].
    pub fastest: f32,
    /// Largest contact radius \[m\].
    pub radius: f32,
}

impl Seen {
    /// No buzz, no growth.
    pub fn is_quiet(&self) -> bool {
        self.speed.1 < QUIET
    }

    /// Quiet, or a buzz of the encoder's own size.
    pub fn is_bounded(&self) -> bool {
        self.is_quiet() || self.steps <= TOGGLE
    }
}

/// Two first-order high passes in a row, over the velocity and the spin.
#[derive(Clone, Copy, Debug, Default)]
struct HighPass {
    stages: [(Vec3, Vec3); 2],
}

impl HighPass {
    fn take(&mut self, input: Vec3) -> Vec3 {
        let keep = 1.0 / (1.0 + std::f32::consts::TAU * CORNER_HZ / STEPS_PER_SECOND as f32);
        self.stages.iter_mut().fold(input, |x, (last, out)| {
            *out = (*out + x - *last) * keep;
            *last = x;
            *out
        })
    }
}

/// Smallest and largest of three coordinates.
#[derive(Clone, Copy, Debug)]
struct Span(Vec3, Vec3);

impl Default for Span {
    fn default() -> Self {
        Self(Vec3::INFINITY, Vec3::NEG_INFINITY)
    }
}

impl Span {
    fn take(&mut self, x: Vec3) {
        *self = Self(self.0.min(x), self.1.max(x));
    }

    fn width(&self) -> f32 {
        (self.1 - self.0).max_element().max(0.0)
    }
}

impl Case {
    fn model(self) -> ModelSpec<'static> {
        const BALL: &[ProbePart<'_>] = &[ProbePart::at_origin(ProbeShape::Sphere { radius: RADIUS })];
        let material = Material { young_modulus: self.young_modulus, poisson_ratio: 0.5, density: 1100.0 };
        ModelSpec { mass: self.mass, ..ModelSpec::new(ObjectShape::HalfSpace, material, BALL) }
    }

    fn params(self) -> ParamsSpec {
        let Machine { preset, closes, damps } = self.machine;
        let passivity =
            Passivity { max_damping: damps.0, max_spin_damping: damps.1, delay_ticks: self.delay, ..Passivity::default() };
        // the loop itself, not the slew limit, is under test
        let guard = GuardSpec {
            max_force: preset.max_force,
            max_torque: if preset.max_torque > 0.0 { preset.max_torque } else { f32::INFINITY },
            passivity: self.passive.then_some(passivity),
            ..GuardSpec::OPEN
        };
        let coupling = if self.coupled {
            CouplingSpec::Virtual(VirtualCoupling::closable(closes.0, closes.1))
        } else {
            CouplingSpec::Direct
        };
        ParamsSpec { guard, coupling, ..ParamsSpec::default() }
    }

    /// Runs the loop.
    pub fn run(self) -> Seen {
        let model = Model::new(&self.model()).expect("valid model");
        let params = Params::new(&self.params()).expect("valid parameters");
        let (mut state, mut scratch) = (Box::new(State::<16, 64>::new()), Scratch::<16>::new());
        let preset = &self.machine.preset;
        let (mut plant, encoders) = (Plant::new(preset, self.hand), Encoders::of(preset));
        let per_tick = STEPS_PER_SECOND / self.rate_hz;
        let dt = 1.0 / self.rate_hz as f32;
        let mut link = VecDeque::from(vec![Wrench::ZERO; self.delay]);
        let mut held: Wrench = Wrench::ZERO;
        let mut seen = Tally { encoders: (encoders.step, encoders.spin_step), ..Tally::default() };
        for i in 0..(END * STEPS_PER_SECOND as f32) as u32 {
            let time = i as f32 / STEPS_PER_SECOND as f32;
            if i % per_tick == 0 {
                let (position, rotation) = encoders.read(plant.position, plant.rotation);
                let pose = Pose::new(position + Vec3::Z * (RADIUS + CLEARANCE), rotation);
                let output = step(&model, &params, &mut state, &mut scratch, Input { pose, dt });
                link.push_back(output.wrench);
                let next = link.pop_front().expect("one was pushed");
                seen.tick(&held, &next, &output.report);
                held = next;
            }
            let torque = if preset.max_torque > 0.0 { held.torque } else { Vec3::ZERO };
            let target = self.target(time);
            let before = plant;
            plant.step(&target, &Load { force: held.force, torque, braked: false });
            seen.step(time, &before, &plant, &target, held.force, torque);
            seen.spend(&plant, self.damping(), self.spin_damping());
        }
        seen.done()
    }

    /// Stiffness that the loop closes \[N/m\], \[N m/rad\]: the coupling's, or with a direct one the contact's, `seen` saying how wide it became. A ball stuck to the object
    /// resists turning by its drag at its radius.
    pub fn stiffness(self, seen: &Seen) -> (f32, f32) {
        if self.coupled {
            return self.machine.closes;
        }
        let (e, a) = (self.young_modulus, seen.radius);
        (2.0 * e / 0.75 * a, 8.0 * e / 3.0 * a / 1.5 * RADIUS * RADIUS)
    }

    /// K (n + 1/2) T / b, the larger of translation and rotation: that stiffness times the loop's mean delay, over the damping of hand and handle. One is where a delayed spring gives
    /// out what they take.
    pub fn gain(self, seen: &Seen) -> f32 {
        let preset = &self.machine.preset;
        let (k, k_turn) = self.stiffness(seen);
        let late = (self.delay as f32 + 0.5) / self.rate_hz as f32;
        let turning = if preset.max_torque > 0.0 { k_turn * late / self.spin_damping() } else { 0.0 };
        (k * late / self.damping()).max(turning)
    }

    fn damping(self) -> f32 {
        self.hand.damping + self.machine.preset.damping
    }

    fn spin_damping(self) -> f32 {
        self.hand.spin_damping + self.machine.preset.spin_damping
    }

    /// What the hand wants: minimum-jerk ramps. It presses as deep as takes 0.6 of the device's force from the hand's and the coupling's springs on a rigid object.
    fn target(self, time: f32) -> Target {
        let give = if self.coupled { 1.0 / self.machine.closes.0 } else { 0.0 };
        let depth = (0.6 * self.machine.preset.max_force * (1.0 / self.hand.stiffness + give)).min(0.012);
        let travel = CLEARANCE + depth;
        let (down, down_rate) = ramp(time, 0.0, PRESSED);
        let (up, up_rate) = ramp(time, HELD, LIFTED);
        let (turn, turn_rate) = ramp(time, PRESSED, TWISTED);
        Target {
            position: Vec3::Z * (travel * (up - down)),
            rotation: Quat::from_rotation_z(TWIST * turn),
            velocity: Vec3::Z * (travel * (up_rate - down_rate)),
            spin: Vec3::Z * (TWIST * turn_rate),
        }
    }
}

/// Minimum-jerk ramp from 0 to 1 and its rate.
fn ramp(time: f32, from: f32, to: f32) -> (f32, f32) {
    let s = ((time - from) / (to - from)).clamp(0.0, 1.0);
    (s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s) / (to - from))
}

/// Sums of a run.
#[derive(Default)]
struct Tally {
    seen: Seen,
    /// Square speeds and steps of the two halves of the hold.
    halves: [(f64, u32); 2],
    tremble: [HighPass; 2],
    /// Place and angle of the tremble, and where they were.
    swing: (Vec3, Vec3),
    spans: [Span; 2],
    encoders: (f32, f32),
    force: f64,
    energy: f64,
    spent: f64,
}

/// The hold is judged after a third of it, when its beginning has died away; the rest is halved.
const SETTLED: f32 = TWISTED + (HELD - TWISTED) / 3.0;

impl Tally {
    fn tick(&mut self, held: &Wrench, next: &Wrench, report: &Report) {
        self.seen.force_step = self.seen.force_step.max((next.force - held.force).length());
        self.seen.peak = self.seen.peak.max(next.force.length());
        self.seen.damped += u32::from(report.flags.contains(Flags::PASSIVITY_DAMPED));
        self.seen.radius = self.seen.radius.max(report.radius);
    }

    fn step(&mut self, time: f32, before: &Plant, after: &Plant, target: &Target, force: Vec3, torque: Vec3) {
        let turn = (after.rotation * before.rotation.conjugate()).to_scaled_axis();
        self.energy += f64::from(force.dot(after.position - before.position) + torque.dot(turn));
        let (fast, spin) = (self.tremble[0].take(after.velocity), self.tremble[1].take(after.spin));
        if (SETTLED..HELD).contains(&time) {
            let square = f64::from(fast.length_squared() + LEVER * LEVER * spin.length_squared());
            let late = time > 0.5 * (SETTLED + HELD);
            let (sum, count) = &mut self.halves[usize::from(late)];
            (*sum, *count) = (*sum + square, *count + 1);
            self.force += f64::from(force.z);
            if late {
                let dt = 1.0 / STEPS_PER_SECOND as f32;
                self.swing = (self.swing.0 + fast * dt, self.swing.1 + spin * dt);
                self.spans[0].take(self.swing.0);
                self.spans[1].take(self.swing.1);
            }
        }
        if time > LIFTED {
            self.seen.kick = self.seen.kick.max((after.velocity - target.velocity).length());
        }
    }

    fn spend(&mut self, plant: &Plant, damping: f32, spin_damping: f32) {
        let power = damping * plant.velocity.length_squared() + spin_damping * plant.spin.length_squared();
        self.spent += f64::from(power) / f64::from(STEPS_PER_SECOND);
        self.seen.fastest = self.seen.fastest.max(plant.velocity.length());
    }

    fn done(self) -> Seen {
        let mean = |(sum, count): (f64, u32)| (sum / f64::from(count.max(1))).sqrt() as f32;
        let [first, second] = self.halves;
        let force = (self.force / f64::from(first.1 + second.1)) as f32;
        let steps = (self.spans[0].width() / self.encoders.0).max(self.spans[1].width() / self.encoders.1);
        Seen {
            speed: (mean(first), mean(second)),
            steps,
            force,
            energy: self.energy as f32,
            spent: self.spent as f32,
            ..self.seen
        }
    }
}

//! One scene that is stepped under watch: what must hold in any tick of any scene is checked here, and the worst is kept.

use std::sync::Arc;

use glam::{Quat, Vec3};
use haptor_contact::profile::Profile;
use haptor_contact::{
    CouplingSpec, Flags, Green, Input, Invalid, MAX_DISTANCE, MAX_SPEED, MAX_TICK, Material, Model, ModelSpec, ObjectShape,
    Output, Params, ParamsSpec, Patch, Pose, ProbePart, Scratch, State, Tier, Wrench, step,
};

use super::bodies::OwnGreen;

/// Room for every part and the finest samples.
pub type Room = State<16, 256, 256>;

/// Place of a tier in [`Tier::ALL`], the order of every table.
pub fn index(tier: Tier) -> usize {
    Tier::ALL.iter().position(|&other| other == tier).unwrap_or(0)
}

/// Flags that say a figure is not to be relied on.
pub const WARNED: [Flags; 4] = [Flags::LARGE_STRAIN, Flags::POSE_COARSE, Flags::LENGTH_FLOORED, Flags::REGION_REFUSED];

/// True when the tick said of itself that its figures are not to be relied on.
pub fn is_warned(flags: Flags) -> bool {
    WARNED.iter().any(|&flag| flags.contains(flag))
}

/// Everything a model and its parameters are made from, owned.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The object.
    pub object: ObjectShape<'static>,
    /// Its material.
    pub material: Material,
    /// The probe.
    pub parts: Vec<ProbePart<'static>>,
    /// The body's own table, where the scene has one.
    pub green: Option<Arc<OwnGreen>>,
    /// Mass of the probe \[kg\].
    pub mass: f32,
    /// l of a half space in tier `paper` \[m\].
    pub paper_length: f32,
    /// Compliances in place of the computed ones.
    pub compliance: Option<haptor_contact::Compliance>,
    /// Parameters.
    pub params: ParamsSpec,
}

impl Scene {
    /// A scene with one part, the defaults of a scene file and the guard open.
    pub fn new(object: ObjectShape<'static>, material: Material, part: ProbePart<'static>, params: ParamsSpec) -> Self {
        Self { object, material, parts: vec![part], green: None, mass: 1.0, paper_length: 0.1, compliance: None, params }
    }

    /// The scene at rest, or what construction refuses.
    ///
    /// # Errors
    /// As the core's own construction.
    pub fn rig(&self) -> Result<Rig<'_>, Invalid> {
        let green: Option<Green<'_>> = self.green.as_deref().map(OwnGreen::borrowed).transpose()?;
        let spec = ModelSpec {
            green,
            mass: self.mass,
            paper_length: self.paper_length,
            compliance: self.compliance,
            ..ModelSpec::new(self.object, self.material, &self.parts)
        };
        Ok(Rig {
            model: Model::new(&spec)?,
            params: Params::new(&self.params)?,
            spec: self.params,
            state: Box::new(Room::new()),
            scratch: Scratch::new(),
            since: 0.0,
            seen: Seen::default(),
        })
    }
}

/// What was seen of a scene.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Ticks.
    pub steps: u64,
    /// Ticks with contact.
    pub touching: u64,
    /// Ticks that warned of themselves.
    pub warned: u64,
    /// Poses refused.
    pub refused: u64,
    /// Largest share of a friction budget used, less 1.
    pub excess: f64,
    /// First thing that must never be.
    pub fault: Option<String>,
    /// Hash of the bits of every output.
    pub digest: Digest,
}

/// Fowler, Noll and Vo's hash over words of 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    /// Takes a word.
    pub fn take(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3);
    }

    fn take_wrench(&mut self, wrench: &Wrench) {
        let numbers = wrench.force.to_array().into_iter().chain(wrench.torque.to_array());
        numbers.for_each(|number| self.take(number.to_bits()));
    }
}

/// A scene under watch.
#[derive(Debug)]
pub struct Rig<'a> {
    /// The model.
    pub model: Model<'a>,
    params: Params,
    spec: ParamsSpec,
    state: Box<Room>,
    scratch: Scratch<16>,
    /// Time since the last pose that was taken \[s\].
    since: f32,
    /// What was seen.
    pub seen: Seen,
}

impl Rig<'_> {
    /// One tick, and what must hold after any tick.
    pub fn tick(&mut self, position: Vec3, rotation: Quat, dt: f32) -> Output {
        let input = Input { pose: Pose::new(position, rotation), dt };
        let may_lose = self.may_lose(dt);
        let output = step(&self.model, &self.params, &mut self.state, &mut self.scratch, input);
        self.seen.steps += 1;
        self.seen.touching += u64::from(output.report.regions > 0);
        self.seen.warned += u64::from(is_warned(output.report.flags));
        let refused = output.report.flags.contains(Flags::POSE_REFUSED);
        self.seen.refused += u64::from(refused);
        self.since = if refused { self.since } else { 0.0 };
        self.seen.digest.take_wrench(&output.contact);
        self.seen.digest.take_wrench(&output.wrench);
        self.seen.digest.take(output.report.flags.0);
        if self.seen.fault.is_none() {
            self.seen.fault = self.fault_of(&output, may_lose).map(|what| format!("{what} at {input:?}"));
        }
        output
    }

    /// Whether a coupling may lose its probe in this tick: a stiff contact throws it off at the largest speed, and beyond the largest distance it is caught and said to be not finite.
    fn may_lose(&mut self, dt: f32) -> bool {
        self.since = (self.since + if dt > 0.0 { dt.min(MAX_TICK) } else { 0.0 }).min(MAX_TICK);
        let away = self.state.probe_pose().map_or(0.0, |pose| pose.position.length());
        self.spec.coupling != CouplingSpec::Direct && away + MAX_SPEED * self.since >= MAX_DISTANCE
    }

    /// Patches in contact.
    pub fn patches(&self) -> &[Patch] {
        self.state.patches()
    }

    /// Normal load of all patches \[N\].
    pub fn load(&self) -> f64 {
        self.patches().iter().map(|patch| f64::from(patch.footprint.load)).sum()
    }

    /// Keeps the first fault.
    pub fn fail(&mut self, what: impl FnOnce() -> String) {
        if self.seen.fault.is_none() {
            self.seen.fault = Some(what());
        }
    }

    fn fault_of(&mut self, output: &Output, may_lose: bool) -> Option<String> {
        let (report, guard) = (output.report, self.spec.guard);
        let (force, torque) = (length(output.wrench.force), length(output.wrench.torque));
        let most = |limit: f32| f64::from(limit) * (1.0 + GUARD_ROUNDING);
        if !(output.contact.is_finite() && output.wrench.is_finite()) {
            return Some("a wrench is not finite".to_owned());
        }
        if force > most(guard.max_force) || torque > most(guard.max_torque) {
            return Some(format!("the guard let {force} N, {torque} N m through"));
        }
        if report.flags.contains(Flags::NON_FINITE) && !may_lose {
            return Some("a result inside was not finite".to_owned());
        }
        if usize::from(report.regions) > self.spec.max_regions || report.regions > report.high_water {
            return Some(format!("{} regions of {}", report.regions, self.spec.max_regions));
        }
        if !(report.depth >= 0.0 && report.radius >= 0.0 && (0.0..=1.0).contains(&report.stick)) {
            return Some(format!("depth {}, radius {}, stick {}", report.depth, report.radius, report.stick));
        }
        self.check_budgets()
    }

    /// Every patch keeps its friction budget: sliding within mu P, spinning within the torque of full slip.
    fn check_budgets(&mut self) -> Option<String> {
        let mu = f64::from(self.spec.friction_static.unwrap_or(self.spec.friction_dynamic));
        let mut most = 0.0_f64;
        for patch in self.state.patches() {
            let (load, a) = (f64::from(patch.footprint.load), f64::from(patch.footprint.radius));
            if !(load >= 0.0 && a >= 0.0 && load.is_finite() && a.is_finite()) {
                return Some(format!("load {load} N on a radius of {a} m"));
            }
            let (drag, torque) =
                (f64::from(patch.grip.force.x).hypot(f64::from(patch.grip.force.y)), f64::from(patch.grip.torque.abs()));
            let full = f64::from(Profile::new(patch.footprint.fullness).full_slip_torque());
            // in tier paper the axis may pass through the rim: arms up to 2 a
            let paper = length(patch.paper.torque);
            let used = |held: f64, cap: f64| if held > LEAST_TOLD { held / cap } else { 0.0 };
            most = most
                .max(used(drag, mu * load))
                .max(used(torque, mu * load * f64::from(patch.footprint.arm()) * full))
                .max(used(paper, 2.0 * mu * load * a));
        }
        self.seen.excess = self.seen.excess.max(most - 1.0);
        (most > 1.0 + BUDGET_ROUNDING).then(|| format!("{most} of the friction budget"))
    }
}

/// Rounding of a limited vector's length.
const GUARD_ROUNDING: f64 = 1.0e-5;

/// Rounding of sums over a patch, relative to its friction budget.
pub const BUDGET_ROUNDING: f64 = 1.0e-3;

/// Below this a force is denormal or the sum of such: it has no digits to keep a budget with \[N, N m\].
const LEAST_TOLD: f64 = 1.0e-36;

/// Length in f64: the square of an f32 may leave its range.
pub fn length(v: Vec3) -> f64 {
    v.as_dvec3().length()
}

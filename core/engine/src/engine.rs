//! The running core: fitted to a device, stepped once a tick.

use haptor_contact as contact;
use haptor_contact::{
    GuardSpec, Input, Invalid, Model, Params, ParamsSpec, Pose, ProbeFrame, Scratch, State, World, Wrench, step,
};
use haptor_wire as wire;
use haptor_wire::units::{un_to_newtons, unm_to_newton_metres};
use haptor_wire::{DeviceHello, Tuning};

use crate::bodies::Bodies;
use crate::error::SceneError;
use crate::frames::{DeviceBase, Handle};
use crate::settings::{coupling_spec, guard_spec, lower_limits, tier_to_wire};
use crate::setup::Setup;
use crate::tuned::{Placed, Tuned};
use crate::work::Limit;

/// Patches that the core keeps in memory: as many as a probe may have parts.
const PATCHES: usize = contact::MAX_PARTS;

/// Samples per region for which there is memory. Four times the default; beyond, a step takes longer than a tick may.
pub const SAMPLES: usize = 256;

/// Time in which the guard lets the wrench go from zero to the device's limit \[s\]: fast for a hand, slow for a motor.
const FULL_SCALE_S: f32 = 0.02;

/// What survives a tick of an engine.
type Memory = State<PATCHES, SAMPLES, SAMPLES>;

/// Without history. A constant in memory: made on the stack it would need its size there once more.
static AT_REST: Memory = State::new();

/// The contact core with its four kinds of data, and the device's place.
#[derive(Debug)]
pub struct Engine<'a> {
    pub(crate) model: Model<'a>,
    /// Coupling that the scene asks for.
    coupling: wire::Coupling,
    /// The body's own table is there.
    table: bool,
    /// What the device renders; before it has said so, the core's own limits.
    device: GuardSpec,
    /// What holds, as it was asked for.
    tuning: Tuning,
    place: wire::Place,
    /// Where the scene has the device stand.
    start: wire::Place,
    pub(crate) spec: ParamsSpec,
    pub(crate) params: Params,
    pub(crate) state: Memory,
    scratch: Scratch<PATCHES>,
    pub(crate) x_wd: Pose<World, DeviceBase>,
}

/// An engine's memory at a moment: 200 kB. Another engine of the same scene goes on from it and gets the same bits.
#[derive(Clone, Debug)]
pub struct Kept {
    device: GuardSpec,
    tuning: Tuning,
    place: wire::Place,
    spec: ParamsSpec,
    params: Params,
    state: Memory,
    x_wd: Pose<World, DeviceBase>,
}

/// What a tick of the core felt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Wrench on the handle about its origin, after the guard: the contact's, with a virtual coupling the spring's and damper's.
    pub wrench: Wrench<DeviceBase>,
    /// Contact force on the probe, before the guard, in world \[N\].
    pub contact_force: [f32; 3],
    /// Contact torque on the probe about its mass centre, before the guard, in world \[N m\].
    pub contact_torque: [f32; 3],
    /// Regions in contact.
    pub regions: u8,
    /// Largest depth \[m\].
    pub depth: f32,
    /// Contact radius of the deepest region \[m\].
    pub radius: f32,
    /// Stuck share of the deepest region's area, 0 to 1.
    pub stick: f32,
    /// Tier used.
    pub tier: wire::Tier,
    /// Estimated work of the tick \[instructions\]; 0 where no budget is set.
    pub work: u32,
    /// The core's flags of this tick.
    pub flags: u32,
    /// A result was not finite; the wrench is zero.
    pub non_finite: bool,
    /// The core refused the pose: out of the world, or a jump no hand makes.
    pub refused: bool,
}

impl<'a> Engine<'a> {
    /// The core at rest, with all its memory.
    ///
    /// # Errors
    /// [`Invalid`] names the first value that the core refuses.
    pub fn new(setup: &Setup, bodies: &'a Bodies<'a>) -> Result<Self, Invalid> {
        let (model, params) = setup.core(bodies)?;
        let baked = setup.baked();
        Ok(Self {
            model,
            coupling: baked.coupling,
            table: bodies.green.is_some(),
            device: GuardSpec::default(),
            tuning: Tuning::of(baked),
            place: baked.place,
            start: baked.place,
            spec: setup.params,
            params,
            state: State::new(),
            scratch: Scratch::new(),
            x_wd: setup.x_wd,
        })
    }

    /// Sets the guard to what the device renders and the scene allows, the lower limit of each two, and fits what a scene with a virtual coupling
    /// leaves open. A device without torque gets the guard's own limit: it says itself, in its reports, that it does not render what
    /// it is asked for.
    ///
    /// # Errors
    /// [`Invalid`] when the device claims to render no force, or less than a coupling can be fitted to; guard and coupling then stay as they were.
    pub fn fit(&mut self, device: &DeviceHello) -> Result<(), Invalid> {
        self.fit_limits(device.max_force_un, device.max_torque_unm)
    }

    /// As [`Self::fit`], of all that a device says of itself by what counts: its largest force \[uN\] and torque \[uN m\], 0 = none.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub fn fit_limits(&mut self, max_force_un: u32, max_torque_unm: u32) -> Result<(), Invalid> {
        let limit = |micro: u32| un_to_newtons(i32::try_from(micro).unwrap_or(i32::MAX));
        let mut own = GuardSpec { max_force: limit(max_force_un), ..GuardSpec::default() };
        own.max_force_rate = own.max_force / FULL_SCALE_S;
        if max_torque_unm > 0 {
            own.max_torque = unm_to_newton_metres(i32::try_from(max_torque_unm).unwrap_or(i32::MAX));
            own.max_torque_rate = own.max_torque / FULL_SCALE_S;
        }
        let guard = lower_limits(&guard_spec(&self.tuning.guard), &own);
        let spec = ParamsSpec { guard, coupling: coupling_spec(&self.coupling, &own), ..self.spec };
        self.params = Params::new(&spec)?;
        (self.spec, self.device) = (spec, own);
        Ok(())
    }

    /// Checks a tuning for this engine.
    ///
    /// # Errors
    /// [`SceneError`] names the first value that does not pass.
    pub fn tuned(&self, tuning: &Tuning) -> Result<Tuned, SceneError> {
        Tuned::check(&self.coupling, self.table, tuning)
    }

    /// Takes over a tuning from the next tick on; what the contact remembers stays. The device's limits hold beside its own, and the coupling stays
    /// fitted to the device.
    pub fn tune(&mut self, tuned: &Tuned) {
        let guard = lower_limits(&guard_spec(&tuned.tuning.guard), &self.device);
        let spec = ParamsSpec { guard, coupling: self.spec.coupling, ..tuned.spec };
        // both limits of each two have been checked, and so has the coupling
        if let Ok(params) = Params::new(&spec) {
            (self.params, self.spec, self.tuning) = (params, spec, tuned.tuning);
        }
    }

    /// Takes over a work budget from the next tick on; everything else stays as it was tuned.
    pub fn limit(&mut self, limit: Limit) {
        let spec = ParamsSpec { work: limit.0, ..self.spec };
        // what is there has been checked, and so has the budget
        if let Ok(params) = Params::new(&spec) {
            (self.params, self.spec, self.tuning.work) = (params, spec, limit.0);
        }
    }

    /// What holds, as it was asked for.
    #[must_use]
    pub const fn tuning(&self) -> &Tuning {
        &self.tuning
    }

    /// Whether a virtual coupling ties the probe to the handle.
    #[must_use]
    pub const fn is_coupled(&self) -> bool {
        matches!(self.coupling, wire::Coupling::Virtual(_))
    }

    /// Has the device stand elsewhere from the next tick on. The core takes the handle for one that moved: put it at [rest](Self::rest) too.
    pub const fn place(&mut self, placed: &Placed) {
        (self.place, self.x_wd) = (placed.place, placed.x_wd);
    }

    /// Where the device stands.
    #[must_use]
    pub const fn placed(&self) -> &wire::Place {
        &self.place
    }

    /// Where the scene has the device stand, whatever was placed since.
    #[must_use]
    pub const fn start(&self) -> &wire::Place {
        &self.start
    }

    /// Puts the core at rest: the next tick is as the first of a new engine with the same device, tuning and place. A contact that the next pose is in begins anew, let
    /// in slowly.
    pub fn rest(&mut self) {
        self.state.clone_from(&AT_REST);
    }

    /// Everything that the next tick depends on, but for the scene.
    #[must_use]
    pub fn keep(&self) -> Kept {
        let Self { device, tuning, place, spec, params, state, x_wd, .. } = self;
        Kept { device: *device, tuning: *tuning, place: *place, spec: *spec, params: *params, state: state.clone(), x_wd: *x_wd }
    }

    /// Goes on as the engine of the same scene that `kept` is of.
    pub fn go_on_from(&mut self, kept: &Kept) {
        (self.device, self.tuning, self.place) = (kept.device, kept.tuning, kept.place);
        (self.spec, self.params, self.x_wd) = (kept.spec, kept.params, kept.x_wd);
        self.state.clone_from(&kept.state);
    }

    /// One tick of the core; `dt` since the previous one \[s\].
    pub fn step(&mut self, x_dh: &Pose<DeviceBase, Handle>, dt: f32) -> Felt {
        let x_hp = Pose::<Handle, ProbeFrame>::IDENTITY;
        let x_wp = self.x_wd.then(x_dh).then(&x_hp);
        let output = step(&self.model, &self.params, &mut self.state, &mut self.scratch, Input { pose: x_wp, dt });
        let report = &output.report;
        Felt {
            wrench: self.in_device(&output.wrench),
            contact_force: output.contact.force.to_array(),
            contact_torque: output.contact.torque.to_array(),
            regions: report.regions,
            depth: report.depth,
            radius: report.radius,
            stick: report.stick,
            tier: tier_to_wire(report.tier),
            work: report.work,
            flags: report.flags.0,
            non_finite: report.flags.contains(contact::Flags::NON_FINITE),
            refused: report.flags.contains(contact::Flags::POSE_REFUSED),
        }
    }

    fn in_device(&self, wrench: &Wrench<World>) -> Wrench<DeviceBase> {
        let q_dw = self.x_wd.rotation.conjugate();
        Wrench::new(q_dw * wrench.force, q_dw * wrench.torque)
    }
}

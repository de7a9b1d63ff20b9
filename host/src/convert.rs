//! Between the wire and the core: the only file that names types of both.
//!
//! ```text
//! BakedScene ──► Scene ──► Core { Model, Params, State, Scratch }          once, may fail with the parameter's name
//! sections   ──► Table, Grids ───┘
//! PoseReport ──► x_dh ──► x_wp = x_wd * x_dh ──► step ──► wrench in w ──► wrench in d ──► WrenchCommand      every tick
//! ```
//! Wire types may hold anything; what goes into the core has been checked here. A pose that is not finite, or whose quaternion is
//! off unit length by more than [`QUATERNION_TOLERANCE`], is refused and the loop goes on as if none had come.

use haptor_contact as contact;
use haptor_contact::{
    GuardSpec, Input, Invalid, Model, ModelSpec, Params, ParamsSpec, Pose, ProbeFrame, QUATERNION_TOLERANCE, Quat, Vec3, World,
    Wrench,
};
use haptor_wire as wire;
use haptor_wire::units::{
    NOT_A_NUMBER, newton_metres_to_unm, newtons_to_un, nm_to_metres, q30_to_unit, un_to_newtons, unm_to_newton_metres,
};
use haptor_wire::{BakedScene, DeviceHello, PoseReport, WrenchCommand};

use crate::frames::{DeviceBase, Handle};

mod data;
mod grid;
mod table;

use data::Data;
use grid::MAX_GRIDS;

/// Patches that the core keeps in memory: as many as a probe may have parts.
const PATCHES: usize = contact::MAX_PARTS;

/// Samples per region for which there is memory. Four times the default; beyond, a step takes longer than a tick may.
pub const SAMPLES: usize = 256;

/// Time in which the guard lets the wrench go from zero to the device's limit \[s\]: fast for a hand, slow for a motor.
const FULL_SCALE_S: f32 = 0.02;

/// Why a baked scene cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// The bytes are not a baked scene of this version.
    #[error(transparent)]
    File(#[from] wire::scene_file::SceneFileError),
    /// A value is out of its range.
    #[error(transparent)]
    Value(#[from] Invalid),
    /// A section's contents are not what its kind says.
    #[error("section {kind} of the baked scene: {what}; bake the scene anew")]
    Section {
        /// The section's kind.
        kind: u32,
        /// What is wrong.
        what: &'static str,
    },
    /// A shape names a mesh that the file does not carry.
    #[error("{key}: the file carries {found} meshes, none of number {number}; bake the scene anew")]
    NoMesh {
        /// Whose shape.
        key: &'static str,
        /// What it names, from 0.
        number: u8,
        /// Meshes there are.
        found: usize,
    },
    /// More meshes than bodies.
    #[error("the file carries more than {MAX_GRIDS} meshes; bake the scene anew")]
    TooManyMeshes,
    /// The scene wants the body's table, and there is none.
    #[error("model.tier = \"green\": the file carries no table of the body's own Green's function; bake the scene anew")]
    NoTable,
    /// More samples than there is memory for.
    #[error("model.samples is {0}, the host has memory for 16 to {SAMPLES} a region")]
    Samples(u16),
}

/// A checked scene: what the core is made from, and where the device stands.
#[derive(Clone, Debug)]
pub struct Scene {
    baked: BakedScene,
    params: ParamsSpec,
    x_wd: Pose<World, DeviceBase>,
    data: Data,
}

impl Scene {
    /// Reads and checks the file of a baked scene, with what it carries behind the scene.
    ///
    /// # Errors
    /// [`SceneError`] names the first thing that does not pass.
    pub fn read(file: &[u8]) -> Result<Self, SceneError> {
        let baked = wire::scene_file::decode_file(file)?;
        Self::with_data(&baked, Data::read(file)?)
    }

    /// Checks a baked scene that carries no data by making the core's model and parameters from it.
    ///
    /// # Errors
    /// [`SceneError`] names the first key or value that does not pass.
    pub fn new(baked: &BakedScene) -> Result<Self, SceneError> {
        Self::with_data(baked, Data::default())
    }

    fn with_data(baked: &BakedScene, data: Data) -> Result<Self, SceneError> {
        let x_wd = Pose::new(Vec3::from_array(baked.place.p_wd), quaternion(baked.place.q_wd).ok_or_else(place_rotation)?);
        if baked.tier == wire::Tier::Green && data.table.is_none() {
            return Err(SceneError::NoTable);
        }
        let scene = Self { baked: *baked, params: params_spec(baked)?, x_wd, data };
        Model::new(&scene.model_spec(&scene.parts()?)?)?;
        Ok(scene)
    }

    /// The probe's parts, borrowing the meshes.
    fn parts(&self) -> Result<Vec<contact::ProbePart<'_>>, SceneError> {
        self.baked.probe.as_slice().iter().map(|part| probe_part(part, &self.data)).collect()
    }

    /// The core at rest, with all its memory.
    ///
    /// # Errors
    /// [`SceneError::Value`], which [`Self::new`] has ruled out.
    pub fn core(&self) -> Result<Core<'_>, SceneError> {
        // two kilobytes that the core borrows beside what the scene holds: a program makes one core
        let parts = Box::leak(self.parts()?.into_boxed_slice());
        Ok(Core {
            model: Model::new(&self.model_spec(parts)?)?,
            asked: (self.baked.guard, self.baked.coupling),
            spec: self.params,
            params: Params::new(&self.params)?,
            state: Box::new(contact::State::new()),
            scratch: Box::new(contact::Scratch::new()),
            x_wd: self.x_wd,
        })
    }

    fn model_spec<'a>(&'a self, parts: &'a [contact::ProbePart<'a>]) -> Result<ModelSpec<'a>, SceneError> {
        let baked = &self.baked;
        let material =
            contact::Material { young_modulus: baked.young_modulus, poisson_ratio: baked.poisson_ratio, density: baked.density };
        let compliance = baked.compliance.map(|c| contact::Compliance { normal: c.normal, drag: c.drag, twist: c.twist });
        Ok(ModelSpec {
            fixed_below: Some(baked.fixed_below),
            compliance,
            green: self.data.table.as_ref().map(table::Table::green).transpose()?,
            mass: baked.mass,
            inertia: baked
                .inertia
                .map(|i| contact::Inertia { moments: Vec3::from_array(i.moments), products: Vec3::from_array(i.products) }),
            paper_length: baked.paper_length,
            ..ModelSpec::new(object_shape(&baked.object, &self.data)?, material, parts)
        })
    }
}

fn place_rotation() -> Invalid {
    Invalid { name: "place.q_wd (length)", value: f32::NAN, allowed: "a unit quaternion, within 1e-3" }
}

fn object_shape<'a>(shape: &wire::ObjectShape, data: &'a Data) -> Result<contact::ObjectShape<'a>, SceneError> {
    use wire::ObjectShape as From;
    Ok(match *shape {
        From::HalfSpace => contact::ObjectShape::HalfSpace,
        From::Box { size } => contact::ObjectShape::Box { size: Vec3::from_array(size) },
        From::Sphere { radius } => contact::ObjectShape::Sphere { radius },
        From::Ellipsoid { semi_axes } => contact::ObjectShape::Ellipsoid { semi_axes: Vec3::from_array(semi_axes) },
        From::Cylinder { radius, height } => contact::ObjectShape::Cylinder { radius, height },
        From::Mesh { grid } => contact::ObjectShape::Mesh(data.mesh("object", grid)?),
    })
}

/// As it is written; whether its rotation is one, the core's constructor checks.
fn probe_part<'a>(part: &wire::ProbePart, data: &'a Data) -> Result<contact::ProbePart<'a>, SceneError> {
    let [w, x, y, z] = part.rotation;
    Ok(contact::ProbePart {
        shape: probe_shape(&part.shape, data)?,
        position: Vec3::from_array(part.position),
        rotation: Quat::from_xyzw(x, y, z, w),
    })
}

fn probe_shape<'a>(shape: &wire::ProbeShape, data: &'a Data) -> Result<contact::ProbeShape<'a>, SceneError> {
    use wire::ProbeShape as From;
    Ok(match *shape {
        From::Sphere { radius } => contact::ProbeShape::Sphere { radius },
        From::Box { size } => contact::ProbeShape::Box { size: Vec3::from_array(size) },
        From::Cylinder { radius, height } => contact::ProbeShape::Cylinder { radius, height },
        From::Cone { radius, height } => contact::ProbeShape::Cone { radius, height },
        From::Capsule { radius, height } => contact::ProbeShape::Capsule { radius, height },
        From::Ellipsoid { semi_axes } => contact::ProbeShape::Ellipsoid { semi_axes: Vec3::from_array(semi_axes) },
        From::Mesh { grid } => contact::ProbeShape::Mesh(data.mesh("probe", grid)?),
    })
}

fn params_spec(baked: &BakedScene) -> Result<ParamsSpec, SceneError> {
    if usize::from(baked.samples) > SAMPLES {
        return Err(SceneError::Samples(baked.samples));
    }
    let spec = ParamsSpec {
        friction_static: Some(baked.friction_static),
        friction_dynamic: baked.friction_dynamic,
        region_distance: baked.region_distance,
        max_regions: usize::from(baked.max_regions),
        tier: tier_to_core(baked.tier),
        samples: usize::from(baked.samples),
        sweeps: usize::from(baked.sweeps),
        breakaway: match baked.breakaway {
            wire::Breakaway::Smooth => contact::Breakaway::Smooth,
            wire::Breakaway::Sharp => contact::Breakaway::Sharp,
        },
        force_law: force_law(&baked.force_law),
        gravity: baked.gravity,
        coupling: contact::CouplingSpec::Direct,
        guard: guard_spec(&baked.guard),
    };
    // the scene's own numbers are checked before the device's, or the core's until a device has said its own, are laid over them
    let core = GuardSpec::default();
    let asked = coupling_spec(&baked.coupling, &GuardSpec { max_force: f32::INFINITY, max_torque: f32::INFINITY, ..core });
    Params::new(&ParamsSpec { coupling: asked, ..spec })?;
    let (guard, coupling) = (lower_limits(&spec.guard, &core), coupling_spec(&baked.coupling, &core));
    Ok(ParamsSpec { guard, coupling, ..spec })
}

fn force_law(law: &wire::ForceLaw) -> contact::ForceLaw {
    match *law {
        wire::ForceLaw::Hertz => contact::ForceLaw::Hertz,
        wire::ForceLaw::Cubic { k1, k3 } => contact::ForceLaw::Cubic { k1, k3 },
        wire::ForceLaw::Table { step, force } => contact::ForceLaw::Table { step, force },
    }
}

fn guard_spec(limits: &wire::GuardLimits) -> GuardSpec {
    let wire::GuardLimits { max_force, max_torque, max_force_rate, max_torque_rate, ramp_in, passivity } = *limits;
    let passivity = passivity.map(|p| contact::Passivity {
        max_damping: p.max_damping,
        max_spin_damping: p.max_spin_damping,
        allowance: p.allowance,
        reserve: p.reserve,
        delay_ticks: p.delay_ticks.into(),
    });
    GuardSpec { max_force, max_torque, max_force_rate, max_torque_rate, ramp_in, passivity }
}

/// The coupling of a scene on a device with these limits.
///
/// What the scene leaves out comes from the device's full force and torque, which is all that a device says of its strength. Its stiffness is then such that full
/// force comes at the stretch at which it does on the device of the core's defaults (a Premium: 8.5 N on 800 N/m, 10.6 mm; 0.188 N m on 0.3 N m/rad, 36 degrees),
/// which is at or below what the makers of stronger devices say that theirs close; and the spring pulls no harder than the device can show.
fn coupling_spec(asked: &wire::Coupling, device: &GuardSpec) -> contact::CouplingSpec {
    let wire::Coupling::Virtual(asked) = asked else { return contact::CouplingSpec::Direct };
    let (premium, full) = (contact::VirtualCoupling::default(), GuardSpec::default());
    // a device without a limit has none to scale by
    let share = |own: f32, full: f32| if own.is_finite() { own / full } else { 1.0 };
    let scaled = contact::VirtualCoupling::closable(
        premium.translational_stiffness * share(device.max_force, full.max_force),
        premium.rotational_stiffness * share(device.max_torque, full.max_torque),
    );
    contact::CouplingSpec::Virtual(contact::VirtualCoupling {
        translational_stiffness: asked.translational_stiffness.unwrap_or(scaled.translational_stiffness),
        rotational_stiffness: asked.rotational_stiffness.unwrap_or(scaled.rotational_stiffness),
        translational_damping: asked.translational_damping,
        rotational_damping: asked.rotational_damping,
        max_force: lower(asked.max_force, device.max_force),
        max_torque: lower(asked.max_torque, device.max_torque),
    })
}

/// The lower of a scene's limit and the device's; one that is not a number stays, so that it is refused by its name.
fn lower(scene: f32, device: f32) -> f32 {
    if scene.is_nan() { scene } else { scene.min(device) }
}

/// The lower of each two limits; how long the ramp is, the scene says.
const fn lower_limits(scene: &GuardSpec, other: &GuardSpec) -> GuardSpec {
    GuardSpec {
        max_force: scene.max_force.min(other.max_force),
        max_torque: scene.max_torque.min(other.max_torque),
        max_force_rate: scene.max_force_rate.min(other.max_force_rate),
        max_torque_rate: scene.max_torque_rate.min(other.max_torque_rate),
        ramp_in: scene.ramp_in,
        passivity: scene.passivity,
    }
}

const fn tier_to_core(tier: wire::Tier) -> contact::Tier {
    match tier {
        wire::Tier::Point => contact::Tier::Point,
        wire::Tier::Paper => contact::Tier::Paper,
        wire::Tier::Bristle => contact::Tier::Bristle,
        wire::Tier::Influence => contact::Tier::Influence,
        wire::Tier::Green => contact::Tier::Green,
    }
}

const fn tier_to_wire(tier: contact::Tier) -> wire::Tier {
    match tier {
        contact::Tier::Point => wire::Tier::Point,
        contact::Tier::Paper => wire::Tier::Paper,
        contact::Tier::Bristle => wire::Tier::Bristle,
        contact::Tier::Influence => wire::Tier::Influence,
        contact::Tier::Green => wire::Tier::Green,
    }
}

/// The contact core with its four kinds of data, and the device's place.
#[derive(Debug)]
pub struct Core<'a> {
    model: Model<'a>,
    /// Limits and coupling that the scene asks for.
    asked: (wire::GuardLimits, wire::Coupling),
    spec: ParamsSpec,
    params: Params,
    state: Box<contact::State<PATCHES, SAMPLES, SAMPLES>>,
    scratch: Box<contact::Scratch<PATCHES>>,
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
    /// The core's flags of this tick.
    pub flags: u32,
    /// A result was not finite; the wrench is zero.
    pub non_finite: bool,
    /// The core refused the pose: out of the world, or a jump no hand makes.
    pub refused: bool,
}

impl Core<'_> {
    /// Sets the guard to what the device renders and the scene allows, the lower limit of each two, and fits what a scene with a virtual coupling
    /// leaves open. A device without torque gets the guard's own limit: it says itself, in its reports, that it does not render what
    /// it is asked for.
    ///
    /// # Errors
    /// [`Invalid`] when the device claims to render no force, or less than a coupling can be fitted to; guard and coupling then stay as they were.
    pub fn fit(&mut self, device: &DeviceHello) -> Result<(), Invalid> {
        let limit = |micro: u32| un_to_newtons(i32::try_from(micro).unwrap_or(i32::MAX));
        let mut own = GuardSpec { max_force: limit(device.max_force_un), ..GuardSpec::default() };
        own.max_force_rate = own.max_force / FULL_SCALE_S;
        if device.max_torque_unm > 0 {
            own.max_torque = unm_to_newton_metres(i32::try_from(device.max_torque_unm).unwrap_or(i32::MAX));
            own.max_torque_rate = own.max_torque / FULL_SCALE_S;
        }
        let (guard, coupling) = &self.asked;
        let guard = lower_limits(&guard_spec(guard), &own);
        let spec = ParamsSpec { guard, coupling: coupling_spec(coupling, &own), ..self.spec };
        self.params = Params::new(&spec)?;
        self.spec = spec;
        Ok(())
    }

    /// One tick of the core; `dt` since the previous one \[s\].
    pub fn step(&mut self, x_dh: &Pose<DeviceBase, Handle>, dt: f32) -> Felt {
        let x_hp = Pose::<Handle, ProbeFrame>::IDENTITY;
        let x_wp = self.x_wd.then(x_dh).then(&x_hp);
        let output = contact::step(&self.model, &self.params, &mut self.state, &mut self.scratch, Input { pose: x_wp, dt });
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

/// The handle's pose `x_dh` of a report, renormalised; `None` when it is not a pose.
#[must_use]
pub fn handle_pose(report: &PoseReport) -> Option<Pose<DeviceBase, Handle>> {
    if report.position_nm.contains(&NOT_A_NUMBER) {
        return None;
    }
    let position = report.position_nm.map(nm_to_metres);
    Some(Pose::new(Vec3::from_array(position), quaternion(report.rotation_q30.map(q30_to_unit))?))
}

/// Unit quaternion of (w, x, y, z); `None` when it is not finite or too far from unit length.
fn quaternion([w, x, y, z]: [f32; 4]) -> Option<Quat> {
    let q = Quat::from_xyzw(x, y, z, w);
    // a NaN compares false
    ((q.length() - 1.0).abs() <= QUATERNION_TOLERANCE).then(|| q.normalize())
}

/// The command that answers report `echo` with `wrench`, to be rendered for `hold_us` \[us\] at most.
#[must_use]
pub fn command(seq: u32, echo: u32, wrench: &Wrench<DeviceBase>, hold_us: u32) -> WrenchCommand {
    let force_un = wrench.force.to_array().map(newtons_to_un);
    let torque_unm = wrench.torque.to_array().map(newton_metres_to_unm);
    WrenchCommand { seq, echo, force_un, torque_unm, hold_us }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_1_SQRT_2;
    use wire::sections;
    use wire::units::{metres_to_nm, unit_to_q30};
    use wire::{Mode, ProbePart, ProbeParts};

    fn baked() -> BakedScene {
        let ball = ProbePart { shape: wire::ProbeShape::Sphere { radius: 0.02 }, ..ProbePart::UNUSED };
        BakedScene {
            object: wire::ObjectShape::HalfSpace,
            fixed_below: 0.0,
            young_modulus: 3.0e6,
            poisson_ratio: 0.5,
            density: 1100.0,
            compliance: None,
            probe: ProbeParts::from_slice(&[ball]).unwrap(),
            mass: 1.0,
            inertia: None,
            friction_static: 0.75,
            friction_dynamic: 0.75,
            region_distance: 0.004,
            max_regions: 10,
            tier: wire::Tier::Bristle,
            samples: 64,
            sweeps: 4,
            deformation: wire::Deformation::Full,
            coupling: wire::Coupling::Direct,
            breakaway: wire::Breakaway::Smooth,
            gravity: false,
            force_law: wire::ForceLaw::Hertz,
            guard: wire::GuardLimits::DEVICE_S_OWN,
            paper_length: 0.1,
            place: wire::Place { p_wd: [0.0; 3], q_wd: [1.0, 0.0, 0.0, 0.0] },
        }
    }

    const PASSIVITY: wire::Passivity =
        wire::Passivity { max_damping: 5.0, max_spin_damping: 0.004, allowance: 1.0e-6, reserve: 0.1, delay_ticks: 0 };

    fn with(change: fn(&mut wire::VirtualCoupling)) -> wire::Coupling {
        let mut coupling = wire::VirtualCoupling::DEVICE_S_OWN;
        change(&mut coupling);
        wire::Coupling::Virtual(coupling)
    }

    fn report(position: [f32; 3], rotation: [f32; 4]) -> PoseReport {
        PoseReport {
            seq: 1,
            t_us: 0,
            position_nm: position.map(metres_to_nm),
            rotation_q30: rotation.map(unit_to_q30),
            buttons: 0,
            mode: Mode::Force,
            flags: 0,
            echo: 0,
        }
    }

    #[test]
    fn what_this_build_cannot_do_is_named() {
        type Spoil = fn(&mut BakedScene);
        let table: [(Spoil, &str); 13] = [
            (|s| s.tier = wire::Tier::Influence, "52 or 112 for tiers influence and green"),
            (|s| s.tier = wire::Tier::Green, "carries no table"),
            (|s| s.coupling = with(|c| c.translational_stiffness = Some(0.0)), "coupling.translational_stiffness"),
            (|s| s.coupling = with(|c| c.rotational_damping = Some(f32::NAN)), "coupling.rotational_damping"),
            (|s| s.coupling = with(|c| c.max_force = f32::NAN), "coupling.max_force"),
            (|s| s.coupling = with(|c| c.max_torque = -1.0), "coupling.max_torque"),
            (|s| s.guard.passivity = Some(wire::Passivity { delay_ticks: 9, ..PASSIVITY }), "guard.passivity.delay_ticks"),
            (|s| s.samples = 300, "16 to 256"),
            (|s| s.young_modulus = -1.0, "object.young_modulus"),
            (|s| s.place.q_wd = [0.0; 4], "place.q_wd"),
            (|s| s.guard.max_force = f32::NAN, "guard.max_force"),
            (|s| s.guard.max_torque_rate = 0.0, "guard.max_torque_rate"),
            (|s| s.force_law = wire::ForceLaw::Cubic { k1: -1.0, k3: 0.0 }, "model.force_law.k1"),
        ];
        for (spoil, named) in table {
            let mut scene = baked();
            spoil(&mut scene);
            let text = Scene::new(&scene).unwrap_err().to_string();
            assert!(text.contains(named), "{text} lacks {named}");
        }
        Scene::new(&baked()).unwrap();
    }

    /// A file of the ball on a cube in tier `green`, with a section of these numbers.
    fn file(numbers: &[f32]) -> Vec<u8> {
        let mut scene = baked();
        scene.object = wire::ObjectShape::Box { size: [0.1; 3] };
        (scene.tier, scene.samples) = (wire::Tier::Green, 52);
        let mut file = vec![0; wire::scene_file::FILE_MAX];
        let length = wire::scene_file::encode_file(&scene, &mut file).unwrap();
        file.truncate(length);
        let contents: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let mut section = vec![0; contents.len() + sections::SECTION_OVERHEAD];
        sections::encode_section(sections::GREEN, &contents, &mut section).unwrap();
        [file, section].concat()
    }

    /// A table of 26 places whose loads move nothing but themselves, by `own` along x.
    fn table(own: f32) -> Vec<f32> {
        let mut numbers = vec![0.0, 0.0, 0.05, 0.05, 0.05, 0.05, 0.005, 3.0];
        for _ in 0..26 {
            numbers.extend([own].into_iter().chain([0.0; 15]));
        }
        numbers.extend(vec![0.0; (4 * 26) * (4 * 26)]);
        numbers
    }

    #[test]
    fn a_table_behind_the_scene_reaches_the_core() {
        let dragged = |own: f32| {
            let scene = Scene::read(&file(&table(own))).unwrap();
            let mut core = scene.core().unwrap();
            let mut felt = None;
            for x in [0.0, 0.0, 1.0e-4] {
                felt = Some(core.step(&handle_pose(&report([x, 0.0, 0.119], [1.0, 0.0, 0.0, 0.0])).unwrap(), 1.0e-3));
            }
            let felt = felt.unwrap();
            assert_eq!(felt.tier, wire::Tier::Green);
            felt.contact_force[0].abs()
        };
        // 1e-4 m/N beside about 4e-5 m/N of the contact itself
        assert!(dragged(1.0e-4) < 0.6 * dragged(0.0), "{} {}", dragged(1.0e-4), dragged(0.0));
    }

    #[test]
    fn a_table_that_does_not_fit_is_named() {
        let good = table(0.0);
        let mut odd = good.clone();
        odd[7] = 4.0;
        let mut endless = good.clone();
        endless[100] = f32::NAN;
        let cases: [(&[f32], &str); 5] = [
            (&good[..7], "within its head"),
            (&good[..100], "within the own moves"),
            (&good[..good.len() - 1], "green.table (length)"),
            (&odd, "nodes an edge"),
            (&endless, "green.table"),
        ];
        for (numbers, named) in cases {
            let text = Scene::read(&file(numbers)).unwrap_err().to_string();
            assert!(text.contains(named), "{text} lacks {named}");
        }
        Scene::read(&file(&good)).unwrap();
    }

    fn hello(max_force_un: u32, max_torque_unm: u32) -> DeviceHello {
        let (name, serial) = ([0; 12], [0; 12]);
        DeviceHello { version: 1, schema: 0, name, serial, max_force_un, max_torque_unm, watchdog_ticks: 160 }
    }

    #[test]
    fn the_lower_of_the_scene_s_and_the_device_s_limit_holds() {
        let own = wire::GuardLimits::DEVICE_S_OWN;
        let premium = hello(8_500_000, 188_000);
        let table = [
            // scene, device, force, torque, their rates
            (own, premium, [8.5, 0.188, 425.0, 9.4]),
            (wire::GuardLimits { max_force: 3.0, max_torque_rate: 1.0, ..own }, premium, [3.0, 0.188, 425.0, 1.0]),
            (wire::GuardLimits { max_force: 30.0, max_torque: 2.0, ..own }, premium, [8.5, 0.188, 425.0, 9.4]),
            // no torque: the guard's own limit; no force: refused, the limits stay as they were
            (own, hello(12_000_000, 0), [12.0, 0.188, 600.0, 9.4]),
            (wire::GuardLimits { max_force: 3.0, ..own }, hello(0, 0), [3.0, 0.188, 425.0, 9.4]),
        ];
        for (guard, device, expected) in table {
            let scene = Scene::new(&BakedScene { guard, ..baked() }).unwrap();
            let mut core = scene.core().unwrap();
            assert_eq!(core.fit(&device).is_err(), device.max_force_un == 0);
            let held = core.spec.guard;
            let found = [held.max_force, held.max_torque, held.max_force_rate, held.max_torque_rate];
            assert!(found.iter().zip(expected).all(|(f, e): (&f32, f32)| (f / e - 1.0).abs() < 1.0e-5), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn what_a_scene_leaves_out_of_its_coupling_is_fitted_to_the_device() {
        let table = [
            // coupling, device, stiffnesses, largest force and torque
            (with(|_| ()), hello(8_500_000, 188_000), [800.0, 0.3, 8.5, 0.188]),
            (with(|_| ()), hello(12_000_000, 200_000), [1129.4, 0.319, 12.0, 0.2]),
            (with(|_| ()), hello(3_300_000, 0), [310.6, 0.3, 3.3, 0.188]),
            (
                with(|c| (c.translational_stiffness, c.max_torque) = (Some(50.0), 0.1)),
                hello(12_000_000, 200_000),
                [50.0, 0.319, 12.0, 0.1],
            ),
            (with(|c| c.max_force = 30.0), hello(0, 0), [800.0, 0.3, 8.5, 0.188]),
        ];
        for (coupling, device, expected) in table {
            let scene = Scene::new(&BakedScene { coupling, ..baked() }).unwrap();
            let mut core = scene.core().unwrap();
            assert_eq!(core.fit(&device).is_err(), device.max_force_un == 0);
            let contact::CouplingSpec::Virtual(held) = core.spec.coupling else { panic!("virtual") };
            let found = [held.translational_stiffness, held.rotational_stiffness, held.max_force, held.max_torque];
            assert!(found.iter().zip(expected).all(|(f, e): (&f32, f32)| (f / e - 1.0).abs() < 2.0e-3), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn a_virtual_coupling_gives_the_hand_its_spring_and_the_probe_the_contact() {
        let scene = Scene::new(&BakedScene { coupling: with(|_| ()), ..baked() }).unwrap();
        let mut core = scene.core().unwrap();
        let at = |z: f32| handle_pose(&report([0.0, 0.0, z], [1.0, 0.0, 0.0, 0.0])).unwrap();
        core.step(&at(0.021), 1.0e-3);
        let felt = (0..2000).map(|_| core.step(&at(0.015), 1.0e-3)).last().unwrap();
        // 5 mm into rubber of 25 kN/m with a spring of 800 N/m: nearly all of it is the spring's
        assert!((3.5..4.0).contains(&felt.wrench.force.z), "{felt:?}");
        assert!((felt.wrench.force.z / felt.contact_force[2] - 1.0).abs() < 1.0e-3, "at rest both are one: {felt:?}");
        assert!(felt.depth < 5.0e-4, "{felt:?}");
    }

    #[test]
    fn a_measured_force_law_is_what_is_felt() {
        let mut force = [0.0; 16];
        force.iter_mut().enumerate().for_each(|(i, f)| *f = i as f32);
        let laws = [
            (wire::ForceLaw::Cubic { k1: 2000.0, k3: 4.0e9 }, 2000.0 * 5.0e-4 + 4.0e9 * 5.0e-4_f32.powi(3)),
            (wire::ForceLaw::Table { step: 1.0e-4, force }, 5.0),
        ];
        let press = handle_pose(&report([0.0, 0.0, 0.0195], [1.0, 0.0, 0.0, 0.0])).unwrap();
        for (force_law, expected) in laws {
            let scene = Scene::new(&BakedScene { force_law, ..baked() }).unwrap();
            let felt = scene.core().unwrap().step(&press, 1.0e-3).contact_force[2];
            assert!((felt / expected - 1.0).abs() < 1.0e-3, "{force_law:?}: {felt} N, expected {expected} N");
        }
    }

    #[test]
    fn poses_are_renormalised_or_refused() {
        let pose = handle_pose(&report([0.01, -0.02, 0.03], [FRAC_1_SQRT_2 * 1.0005, 0.0, FRAC_1_SQRT_2, 0.0])).unwrap();
        assert!((pose.rotation.length() - 1.0).abs() < 1.0e-6);
        assert!((pose.position - Vec3::new(0.01, -0.02, 0.03)).length() < 1.0e-8);
        for bad in [
            report([f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]),
            report([0.0; 3], [f32::NAN, 0.0, 0.0, 0.0]),
            report([0.0; 3], [1.002, 0.0, 0.0, 0.0]),
            report([0.0; 3], [0.0; 4]),
        ] {
            assert!(handle_pose(&bad).is_none(), "{bad:?}");
        }
    }

    #[test]
    fn a_press_is_felt_in_the_device_frame_wherever_the_device_stands() {
        let upright = Scene::new(&baked()).unwrap();
        let press = handle_pose(&report([0.0, 0.0, 0.0195], [1.0, 0.0, 0.0, 0.0])).unwrap();
        let straight = upright.core().unwrap().step(&press, 1.0e-3);
        assert!(straight.contact_force[2] > 1.0 && straight.regions == 1);

        // the device lies on its side: its x axis is the world's z
        let mut lying = baked();
        lying.place = wire::Place { p_wd: [0.0, 0.0, 0.1], q_wd: [FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2, 0.0] };
        let scene = Scene::new(&lying).unwrap();
        let press = handle_pose(&report([0.0195 - 0.1, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])).unwrap();
        let felt = scene.core().unwrap().step(&press, 1.0e-3);
        assert!((felt.contact_force[2] / straight.contact_force[2] - 1.0).abs() < 1.0e-3);
        assert!((felt.wrench.force.x - straight.wrench.force.z).abs() <= 1.0e-3 * straight.wrench.force.z);
        assert!(felt.wrench.force.y.abs() + felt.wrench.force.z.abs() < 1.0e-3);
    }

    #[test]
    fn commands_carry_micronewtons_and_a_nan_stays_one() {
        let wrench = Wrench::new(Vec3::new(1.5, 0.0, -2.0), Vec3::new(0.0, f32::NAN, 0.1));
        let c = command(3, 9, &wrench, 4000);
        assert_eq!((c.seq, c.echo, c.hold_us), (3, 9, 4000));
        assert_eq!(c.force_un, [1_500_000, 0, -2_000_000]);
        assert_eq!(c.torque_unm, [0, NOT_A_NUMBER, 100_000]);
    }
}

//! No input breaks a tick: the whole box of stated inputs, its edges and corners, and what lies outside it.
//!
//! Random cases come from a fixed seed, so that every run is the same. What must hold in every tick is in [`Watch::tick`].

use std::f64::consts::PI;

use glam::{Quat, Vec3};
use haptor_contact::geometry::gap::deepest_meaningful;
use haptor_contact::profile::Profile;
use haptor_contact::{
    Breakaway, Flags, GuardSpec, Input, Material, Model, ModelSpec, ObjectShape, Output, Params, ParamsSpec, Pose, ProbePart,
    ProbeShape, Scratch, State, Tier, step,
};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

const TIERS: [Tier; 3] = [Tier::Point, Tier::Paper, Tier::Bristle];

/// Rounding of sums over a patch, relative to its friction budget.
const SLACK: f32 = 1.0e-3;

/// A scene under watch.
struct Watch {
    model: Model<'static>,
    params: Params,
    spec: ParamsSpec,
    state: Box<State<16, 64>>,
    scratch: Scratch<16>,
}

impl Watch {
    fn new(object: ObjectShape<'static>, material: Material, probe: &[ProbePart<'static>], spec: ParamsSpec) -> Self {
        let parts: &'static [ProbePart<'static>] = Box::leak(probe.to_vec().into_boxed_slice());
        Self {
            model: Model::new(&ModelSpec::new(object, material, parts)).expect("valid model"),
            params: Params::new(&spec).expect("valid parameters"),
            spec,
            state: Box::new(State::new()),
            scratch: Scratch::new(),
        }
    }

    /// One tick, and everything that must hold after any tick.
    fn tick(&mut self, position: Vec3, rotation: Quat, dt: f32) -> Output {
        let input = Input { pose: Pose::new(position, rotation), dt };
        let output = step(&self.model, &self.params, &mut self.state, &mut self.scratch, input);
        let told = || format!("{:?} {:?} {:?} {input:?} {output:?}", self.model, self.params.tier(), self.state.patches());
        assert!(output.contact.is_finite() && output.wrench.is_finite(), "not finite: {}", told());
        let GuardSpec { max_force, max_torque, .. } = self.spec.guard;
        let (force, torque) = (output.wrench.force.length(), output.wrench.torque.length());
        assert!(force <= max_force * (1.0 + 1e-5) && torque <= max_torque * (1.0 + 1e-5), "guard: {}", told());
        let report = output.report;
        assert!(
            usize::from(report.regions) <= self.spec.max_regions && report.regions <= report.high_water,
            "regions: {}",
            told()
        );
        assert!(report.depth >= 0.0 && report.radius >= 0.0 && (0.0..=1.0).contains(&report.stick), "report: {}", told());
        assert!(!report.flags.contains(Flags::NON_FINITE), "not finite inside: {}", told());
        self.check_budgets(&told);
        output
    }

    /// Every patch keeps its friction budget.
    fn check_budgets(&self, told: &dyn Fn() -> String) {
        let mu = self.spec.friction_static.unwrap_or(self.spec.friction_dynamic);
        for patch in self.state.patches() {
            let (load, a) = (patch.footprint.load, patch.footprint.radius);
            assert!(load >= 0.0 && a >= 0.0 && load.is_finite() && a.is_finite(), "footprint: {}", told());
            let drag = patch.grip.force.length() / (mu * load).max(f32::MIN_POSITIVE);
            let most = mu * load * patch.footprint.arm() * Profile::new(patch.footprint.fullness).full_slip_torque();
            let torque = patch.grip.torque.abs() / most;
            let held = patch.grip.force.length() > 0.0 || patch.grip.torque != 0.0;
            assert!(!held || drag <= 1.0 + SLACK, "drag {drag} of mu P: {}", told());
            assert!(patch.grip.torque == 0.0 || torque <= 1.0 + SLACK, "torque {torque} of T_max: {}", told());
            // in tier paper the axis may pass through the rim: arms up to 2 a
            let paper = patch.paper.torque.length();
            assert!(paper <= 2.0 * mu * load * a * (1.0 + SLACK) + f32::MIN_POSITIVE, "paper: {}", told());
        }
    }
}

/// Log-uniform between powers of ten.
fn decades(low: f32, high: f32) -> impl Strategy<Value = f32> {
    (low..=high).prop_map(|power| 10.0_f32.powf(power))
}

fn any_rotation() -> impl Strategy<Value = Quat> {
    let level =
        prop::sample::select(vec![Quat::IDENTITY, Quat::from_rotation_x(0.5 * PI as f32), Quat::from_rotation_y(PI as f32)]);
    let tilted = (-1.0_f32..1.0, -1.0_f32..1.0, -1.0_f32..1.0, -1.0_f32..1.0).prop_map(|(x, y, z, w)| {
        if x * x + y * y + z * z + w * w > 1e-3 { Quat::from_xyzw(x, y, z, w).normalize() } else { Quat::IDENTITY }
    });
    let nearly = (-1.0e-4_f32..1.0e-4, -1.0e-4_f32..1.0e-4).prop_map(|(x, y)| Quat::from_xyzw(x, y, 0.0, 1.0).normalize());
    prop_oneof![level, tilted, nearly]
}

/// A shape of about `size`.
fn any_shape(size: f32) -> impl Strategy<Value = ProbeShape<'static>> {
    (0..6, 0.2_f32..1.0, 0.2_f32..1.0, 0.2_f32..1.0).prop_map(move |(kind, x, y, z)| {
        let (x, y, z) = (x * size, y * size, z * size);
        match kind {
            0 => ProbeShape::Sphere { radius: x },
            1 => ProbeShape::Box { size: Vec3::new(x, y, z) },
            2 => ProbeShape::Cylinder { radius: x, height: y },
            3 => ProbeShape::Cone { radius: x, height: y },
            4 => ProbeShape::Capsule { radius: x, height: y },
            _ => ProbeShape::Ellipsoid { semi_axes: Vec3::new(x, y, z) },
        }
    })
}

fn any_object(size: f32) -> impl Strategy<Value = ObjectShape<'static>> {
    (0..5, 0.2_f32..1.0, 0.2_f32..1.0, 0.2_f32..1.0).prop_map(move |(kind, x, y, z)| {
        let (x, y, z) = (x * size, y * size, z * size);
        match kind {
            0 => ObjectShape::HalfSpace,
            1 => ObjectShape::Box { size: Vec3::new(x, y, z) },
            2 => ObjectShape::Sphere { radius: x },
            3 => ObjectShape::Ellipsoid { semi_axes: Vec3::new(x, y, z) },
            _ => ObjectShape::Cylinder { radius: x, height: y },
        }
    })
}

#[derive(Clone, Debug)]
struct Scene {
    object: ObjectShape<'static>,
    material: Material,
    shape: ProbeShape<'static>,
    rotation: Quat,
    /// Side from which the object is touched: towards its centre.
    side: Vec3,
    /// Depth over the probe's size, log-uniform.
    depth: f32,
    mu: (f32, f32),
    tier: Tier,
    breakaway: Breakaway,
    size: f32,
}

/// Directions: random, faces, edges and corners.
fn any_side() -> impl Strategy<Value = Vec3> {
    let sharp = (-1_i8..=1, -1_i8..=1, 0_i8..=1).prop_map(|(x, y, z)| Vec3::new(x.into(), y.into(), z.into()));
    let random = (-1.0_f32..1.0, -1.0_f32..1.0, -0.5_f32..1.0).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    prop_oneof![sharp, random].prop_map(|v| if v.length() > 1e-3 { v.normalize() } else { Vec3::Z })
}

fn any_scene() -> impl Strategy<Value = Scene> {
    (decades(-5.9, 1.9), decades(-1.0, 1.0)).prop_flat_map(|(size, ratio)| {
        let object_size = (size * ratio).clamp(5.1e-6, 90.0);
        let probe_size = size.clamp(5.1e-6, 90.0);
        let look = (any_object(object_size), any_shape(probe_size), any_rotation(), any_side(), decades(-9.0, 0.0));
        let stuff = (decades(2.0, 12.0), 0.0_f32..=0.5, 0.0_f32..=10.0, 0.0_f32..=1.0, 0..3_usize, any::<bool>());
        (look, stuff).prop_map(move |((object, shape, rotation, side, depth), (e, nu, mu, mu_share, tier, sharp))| Scene {
            object,
            material: Material { young_modulus: e.clamp(1.0e2, 1.0e12), poisson_ratio: nu, density: 1.0e3 },
            shape,
            rotation,
            side,
            depth,
            mu: (mu, mu * mu_share),
            tier: TIERS[tier],
            breakaway: if sharp { Breakaway::Sharp } else { Breakaway::Smooth },
            size: probe_size,
        })
    })
}

fn params(scene: &Scene) -> ParamsSpec {
    ParamsSpec {
        friction_static: Some(scene.mu.0),
        friction_dynamic: scene.mu.1,
        tier: scene.tier,
        breakaway: scene.breakaway,
        samples: 64,
        ..ParamsSpec::default()
    }
}

fn watch(scene: &Scene) -> Watch {
    Watch::new(scene.object, scene.material, &[ProbePart::at_origin(scene.shape)], params(scene))
}

/// Height of the middle of the object [m].
fn middle(object: &ObjectShape<'_>) -> Vec3 {
    Vec3::Z * (0.5 * object.height())
}

/// Distance from the object's middle along `side` at which the probe begins to touch, by halving.
fn touch(scene: &Scene) -> f32 {
    let depth_at = |distance: f32| {
        let mut fresh = Watch::new(scene.object, scene.material, &[ProbePart::at_origin(scene.shape)], ParamsSpec::default());
        fresh.tick(middle(&scene.object) + scene.side * distance, scene.rotation, 1.0e-3).report.depth
    };
    let (mut inside, mut outside) = (0.0, 4.0 * (scene.size + 10.0 * scene.size));
    for _ in 0..24 {
        let between = 0.5 * (inside + outside);
        if depth_at(between) > 0.0 { inside = between } else { outside = between }
    }
    inside
}

/// Steps in units of the probe's size and of radians, each with its dt \[s\].
type Motion = Vec<([f32; 3], [f32; 3], f32)>;

/// A motion of 24 steps.
fn any_motion() -> impl Strategy<Value = Motion> {
    let part = || prop::array::uniform3(-1.0_f32..1.0);
    prop::collection::vec((part(), part(), decades(-6.0, 0.0)), 24)
}

/// All of `most` in release; a third of them, the same ones, in debug, which is fifteen times slower.
fn cases(most: u32) -> u32 {
    if cfg!(debug_assertions) { most / 3 } else { most }
}

fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, max_shrink_iters: 200, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]))
}

/// Any probe on any object, at any tilt and depth, moved about by steps from a millionth of its size to the whole of it.
#[test]
fn anything_goes() {
    let case = (any_scene(), any_motion(), decades(-6.0, 0.0));
    let run = |(scene, motion, size): (Scene, Motion, f32)| {
        let mut watch = watch(&scene);
        let start = middle(&scene.object) + scene.side * (touch(&scene) - scene.depth * scene.size);
        let (mut at, mut turn) = (start, scene.rotation);
        watch.tick(at, turn, 1.0e-3);
        for (shift, spin, dt) in motion {
            at += Vec3::from(shift) * (scene.size * size);
            turn = (Quat::from_scaled_axis(Vec3::from(spin) * size) * turn).normalize();
            watch.tick(at, turn, dt);
        }
        Ok(())
    };
    runner(cases(300)).run(&case, run).unwrap();
}

/// The corners of the stated box, all of them: modulus, Poisson's ratio, friction, size, depth, tick.
#[test]
fn corners_of_the_box() {
    for corner in 0..1_u32 << 6 {
        let pick = |bit: u32, low: f32, high: f32| if corner & (1 << bit) == 0 { low } else { high };
        let (e, nu, mu) = (pick(0, 1.0e2, 1.0e12), pick(1, 0.0, 0.5), pick(2, 0.0, 10.0));
        let (radius, dt) = (pick(3, 1.0e-6, 1.0e2), pick(5, 1.0e-6, 1.0));
        let depth = pick(4, 1.0e-12, radius);
        let material = Material { young_modulus: e, poisson_ratio: nu, density: 1.0e3 };
        for tier in TIERS {
            for mu_d in [mu, 0.0] {
                let spec = ParamsSpec { tier, friction_static: Some(mu), friction_dynamic: mu_d, ..ParamsSpec::default() };
                let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius })];
                let mut watch = Watch::new(ObjectShape::HalfSpace, material, &ball, spec);
                for tick in 0..12 {
                    let (way, spin) = (1.0e-7 * radius * tick as f32, 1.0e-7 * tick as f32);
                    watch.tick(Vec3::new(way, 0.0, radius - depth), Quat::from_rotation_z(spin), dt);
                }
                for tick in 0..12 {
                    let (way, spin) = (0.3 * radius * tick as f32, 1.3 * tick as f32);
                    watch.tick(Vec3::new(way, 0.0, radius - depth), Quat::from_rotation_z(spin), 1.0);
                }
            }
        }
    }
}

/// A thousand turns one way: friction stays full, and the first turn back takes it the other way.
#[test]
fn a_thousand_turns() {
    for tier in TIERS {
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1.1e3 };
        let mut watch = Watch::new(ObjectShape::HalfSpace, rubber, &ball, ParamsSpec { tier, ..ParamsSpec::default() });
        let at = Vec3::Z * 0.019;
        let turn = |tick: i32| Quat::from_rotation_z((f64::from(tick) * 1.0 % (2.0 * PI)) as f32);
        let mut torque = 0.0;
        for tick in 0..6284 {
            torque = watch.tick(at, turn(tick), 1.0e-3).contact.torque.z;
        }
        assert!(torque < -0.04, "{tier:?}: {torque} N m");
        if tier != Tier::Paper {
            torque = watch.tick(at, turn(6282), 1.0e-3).contact.torque.z;
            assert!(torque > 0.04, "{tier:?}: {torque} N m on the way back");
        }
    }
}

/// Poses that are no poses: refused by name, nothing of the contact is lost, and the next good pose goes on from there.
#[test]
fn poses_that_are_no_poses() {
    let good = (Vec3::Z * 0.019, Quat::IDENTITY);
    let nan = f32::NAN;
    let bad = [
        // too fast; refused time counts, so that these come first
        (good.0, Quat::from_rotation_x(3.1), 1.0e-3),
        (Vec3::new(0.5, 0.0, 0.019), good.1, 1.0e-3),
        (Vec3::new(nan, 0.0, 0.0), good.1, 1.0e-3),
        (Vec3::new(0.0, f32::INFINITY, 0.0), good.1, 1.0e-3),
        (Vec3::new(0.0, 0.0, f32::NEG_INFINITY), good.1, 1.0e-3),
        (Vec3::splat(f32::MAX), good.1, 1.0e-3),
        (Vec3::X * 2.0e3, good.1, 1.0e-3),
        (good.0, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), 1.0e-3),
        (good.0, Quat::from_xyzw(nan, 0.0, 0.0, 1.0), 1.0e-3),
        (good.0, Quat::from_xyzw(f32::INFINITY, 0.0, 0.0, 1.0), 1.0e-3),
        (good.0, Quat::from_xyzw(0.0, 0.0, 0.0, 1.01), 1.0e-3),
        (good.0, Quat::from_xyzw(f32::MAX, f32::MAX, f32::MAX, f32::MAX), 1.0e-3),
        (good.0, good.1, nan),
        (good.0, good.1, 0.0),
        (good.0, good.1, -1.0),
        (good.0, good.1, f32::INFINITY),
    ];
    for tier in TIERS {
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1.1e3 };
        let mut watch = Watch::new(ObjectShape::HalfSpace, rubber, &ball, ParamsSpec { tier, ..ParamsSpec::default() });
        watch.tick(good.0, good.1, 1.0e-3);
        let held = watch.tick(good.0, Quat::from_rotation_z(0.05), 1.0e-3).contact;
        for (count, (position, rotation, dt)) in bad.into_iter().enumerate() {
            let output = watch.tick(position, rotation, dt);
            assert!(output.report.flags.contains(Flags::POSE_REFUSED), "{tier:?} {position} {rotation} {dt}");
            assert_eq!(output.report.poses_refused as usize, count + 1);
            assert_eq!(output.contact, held, "{tier:?}: the contact is kept");
        }
        let again = watch.tick(good.0, Quat::from_rotation_z(0.05), 1.0e-3);
        assert_eq!((again.contact, again.report.flags.contains(Flags::POSE_REFUSED)), (held, false), "{tier:?}");
    }
}

/// Numbers below the normal range, in every place of a pose.
#[test]
fn denormals() {
    let tiny = [1.0e-40_f32, -1.0e-40, f32::from_bits(1), f32::MIN_POSITIVE];
    for tier in TIERS {
        for x in tiny {
            let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 1.0e-6 })];
            let soft = Material { young_modulus: 1.0e2, poisson_ratio: 0.5, density: 1.1e3 };
            let mut watch = Watch::new(ObjectShape::HalfSpace, soft, &ball, ParamsSpec { tier, ..ParamsSpec::default() });
            for tick in 0..40 {
                let sign = if tick % 2 == 0 { 1.0 } else { -1.0 };
                let at = Vec3::new(sign * x, x, 1.0e-6 - 1.0e-9 * tick as f32);
                watch.tick(at, Quat::from_xyzw(x, -x, sign * x, 1.0), 1.0e-3);
            }
            watch.tick(Vec3::Z * 9.0e-7, Quat::IDENTITY, x.abs());
        }
    }
}

/// A kilometre from the origin an f32 knows a place to 0.06 mm: coarse, but finite and within every budget.
#[test]
fn a_kilometre_away() {
    for tier in TIERS {
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1.1e3 };
        let mut watch = Watch::new(ObjectShape::HalfSpace, rubber, &ball, ParamsSpec { tier, ..ParamsSpec::default() });
        for tick in 0..400 {
            let t = 0.05 * tick as f32;
            let at = Vec3::new(700.0 + 1.0e-3 * t.sin(), -700.0 + 1.0e-3 * t.cos(), 0.019 + 5.0e-4 * t.sin());
            let output = watch.tick(at, Quat::from_rotation_z(0.3 * t.sin()), 1.0e-3);
            assert!(output.contact.force.z > 0.0);
        }
    }
}

/// Coincident surfaces: a box resting on a box of the same face, a punch as wide as the cylinder under it, a ball inside a ball.
#[test]
fn coincident_surfaces() {
    let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.3, density: 1.1e3 };
    let pairs = [
        (ObjectShape::Box { size: Vec3::splat(0.1) }, ProbeShape::Box { size: Vec3::splat(0.1) }, 0.15),
        (ObjectShape::Cylinder { radius: 0.05, height: 0.1 }, ProbeShape::Cylinder { radius: 0.05, height: 0.1 }, 0.15),
        (ObjectShape::Sphere { radius: 0.05 }, ProbeShape::Sphere { radius: 0.05 }, 0.05),
        (ObjectShape::Ellipsoid { semi_axes: Vec3::splat(0.05) }, ProbeShape::Ellipsoid { semi_axes: Vec3::splat(0.05) }, 0.05),
        (ObjectShape::Box { size: Vec3::splat(0.1) }, ProbeShape::Box { size: Vec3::splat(0.1) }, 0.05),
    ];
    for tier in TIERS {
        for (object, shape, height) in pairs {
            let mut watch =
                Watch::new(object, rubber, &[ProbePart::at_origin(shape)], ParamsSpec { tier, ..ParamsSpec::default() });
            for tick in -20..=20 {
                let at = Vec3::new(0.0, 0.0, height + 1.0e-9 * tick as f32 * tick as f32 * tick as f32);
                watch.tick(at, Quat::from_rotation_z(1.0e-3 * tick as f32), 1.0e-3);
            }
        }
    }
}

/// Smallest extent of the shape from its surface inwards \[m\].
fn thickness(shape: &ProbeShape<'_>) -> f32 {
    match *shape {
        ProbeShape::Sphere { radius } => radius,
        ProbeShape::Box { size } => 0.5 * size.min_element(),
        ProbeShape::Cylinder { radius, height } => radius.min(0.5 * height),
        ProbeShape::Cone { radius, height } => 0.3 * radius.min(height),
        ProbeShape::Capsule { radius, .. } => radius,
        ProbeShape::Ellipsoid { semi_axes } => semi_axes.min_element(),
        ProbeShape::Mesh(mesh) => mesh.grid().inmost(),
    }
}

/// A millionth of a change in the pose changes the force by little: no ripple, no step, on any pair of shapes. The depth stays well
/// below the thickness of both bodies, where the nearest face of an object is no question.
#[test]
fn force_is_continuous_in_the_pose() {
    /// Share of the force that a millionth of the thickness may change, at depths from a hundredth of it. The steepest power law and a turn
    /// of bodies ten times as wide as thick make 1 %; slivers that a box's edge or a cone's rim cuts from a strongly curved object make 6 %.
    const MOST: f32 = 0.08;
    let unit = || prop::array::uniform3(-1.0_f32..1.0);
    let case = (any_scene(), unit(), unit(), decades(-2.0, -0.9));
    let run = |(mut scene, shift, spin, depth): (Scene, [f32; 3], [f32; 3], f32)| {
        let thin = thickness(&scene.shape).min(deepest_meaningful(&scene.object));
        (scene.mu, scene.tier) = ((0.0, 0.0), Tier::Point);
        let at = middle(&scene.object) + scene.side * (touch(&scene) - depth * thin);
        let next = at + Vec3::from(shift) * (1.0e-6 * thin);
        let turned = (Quat::from_scaled_axis(Vec3::from(spin) * (1.0e-6 * thin / scene.size)) * scene.rotation).normalize();
        let here = watch(&scene).tick(at, scene.rotation, 1.0e-3);
        let there = watch(&scene).tick(next, turned, 1.0e-3);
        let change = (there.contact.force - here.contact.force).length();
        let force = here.contact.force.length().max(there.contact.force.length());
        prop_assert!(here.report.depth > 0.3 * thin || change <= MOST * force, "{change} of {force} N: {here:?} {there:?}");
        Ok(())
    };
    runner(cases(1500)).run(&case, run).unwrap();
}

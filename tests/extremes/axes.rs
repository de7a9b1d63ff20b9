//! The axes of the box, each walked from end to end and beyond while the rest stays in the middle.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use haptor_contact::{
    Compliance, CouplingSpec, GuardSpec, Invalid, MAX_PARTS, Material, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Tier,
    VirtualCoupling,
};

use super::bodies::OwnGreen;
use super::rig::Scene;
use super::session::{Felt, Plan, Units, felt};

/// The middle of the box: a ball of 20 mm on rubber.
const STUFF: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.3, density: 1.1e3 };
const RADIUS: f64 = 0.02;
const SHARE: f64 = 0.05;
const MU: f64 = 0.75;

/// Error above which a value no longer holds: two per cent, what the tiers themselves are good for.
pub const HOLDS: f64 = 0.02;

/// What was found at a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// Construction or the tick refused it by name.
    Refused,
    /// The ticks warned of themselves; largest error.
    Warned(f64),
    /// Largest error.
    Held(f64),
    /// No contact at all: the digits of the pose do not tell the value, the core is given none.
    Untold,
    /// The axis has no meaning for the tier.
    Nothing,
}

/// A quantity.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The range that is asked for, ends included.
    pub asked: (f64, f64),
    /// What is walked through.
    pub values: &'static [f64],
    /// What the error is told against.
    pub against: &'static str,
    /// Says what a tier does at a value.
    run: fn(Tier, f64) -> Pair,
}

/// A session at a value, the one it is compared with, and whether the normal force alone is.
type Pair = Result<Option<(Felt, Felt, bool)>, Invalid>;

impl Axis {
    /// What `tier` does at a value, and the ticks that took.
    pub fn at(&self, tier: Tier, value: f64) -> (Found, u64) {
        match (self.run)(tier, value) {
            Err(_) => (Found::Refused, 0),
            Ok(None) => (Found::Nothing, 0),
            Ok(Some((here, base, normal))) => {
                let (off, steps) = (here.off(&base, normal), here.steps + base.steps);
                match (here.refused, here.warned) {
                    (true, _) => (Found::Refused, steps),
                    _ if !here.touched => (Found::Untold, steps),
                    (_, true) => (Found::Warned(off), steps),
                    _ => (Found::Held(off), steps),
                }
            }
        }
    }
}

/// Every axis of the box.
pub const AXES: [Axis; 14] = [
    Axis {
        name: "Young's modulus",
        unit: "Pa",
        asked: (1.0e2, 1.0e12),
        values: &[1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14],
        against: "3 MPa",
        run: young,
    },
    Axis {
        name: "Poisson's ratio",
        unit: "1",
        asked: (0.0, 0.5),
        values: &[-0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49, 0.4999, 0.5, 0.51],
        against: "0.3",
        run: poisson,
    },
    Axis {
        name: "friction",
        unit: "1",
        asked: (0.0, 10.0),
        values: &[0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0],
        against: "0.75",
        run: friction,
    },
    Axis {
        name: "probe radius",
        unit: "m",
        asked: (1.0e-6, 1.0e2),
        values: &[1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3],
        against: "20 mm",
        run: radius,
    },
    Axis {
        name: "contact radius (flat end)",
        unit: "m",
        asked: (1.0e-6, 1.0e2),
        values: &[1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3],
        against: "20 mm",
        run: flat_end,
    },
    Axis {
        name: "object size (cube)",
        unit: "m",
        // the ball on it is a sixth as large
        asked: (1.0e-5, 1.0e2),
        values: &[1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3],
        against: "125 mm",
        run: cube,
    },
    Axis {
        name: "object over probe",
        unit: "1",
        asked: (1.0, 1.0e8),
        values: &[1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8],
        against: "half space",
        run: ratio,
    },
    Axis {
        name: "depth (ball of 20 mm)",
        unit: "m",
        asked: (1.0e-12, 0.02),
        values: &[1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 3e-8, 1e-7, 3e-7, 1e-6, 1e-5, 1e-4, 1e-3, 5e-3, 0.02],
        against: "1 mm",
        run: depth,
    },
    Axis {
        name: "twist before",
        unit: "turns",
        asked: (0.0, 1.0e3),
        values: &[0.1, 0.5, 1.0, 10.0, 100.0, 1e3, 1e4],
        against: "2 turns",
        run: twist,
    },
    Axis {
        name: "tick",
        unit: "s",
        asked: (1.0e-6, 1.0),
        values: &[1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e3, 1e4, 1e9],
        against: "1 ms",
        run: tick,
    },
    Axis {
        name: "distance from the origin",
        unit: "m",
        asked: (0.0, 1.0e3),
        values: &[1e-3, 1e-2, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 990.0, 1e4],
        against: "0 m",
        run: distance,
    },
    Axis {
        name: "ticks of rest",
        unit: "1",
        asked: (1.0, 1.0e8),
        values: &[1.0, 1e2, 1e4, 1e6, 1e8],
        against: "none",
        run: rest,
    },
    Axis {
        name: "parts in contact",
        unit: "1",
        asked: (1.0, 10.0),
        values: &[1.0, 2.0, 4.0, 7.0, 9.0, 10.0, 11.0, 12.0, 16.0, 17.0],
        against: "as many alone",
        run: parts,
    },
    Axis {
        name: "probe mass, on a coupling",
        unit: "kg",
        asked: (0.0, 1.0e4),
        values: &[0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e2, 1e4, 1e5],
        against: "1 kg",
        run: mass,
    },
];

fn params(tier: Tier) -> ParamsSpec {
    let samples = if matches!(tier, Tier::Influence | Tier::Green) { 52 } else { 64 };
    ParamsSpec {
        tier,
        samples,
        friction_dynamic: MU as f32,
        guard: GuardSpec::OPEN,
        region_distance: 0.0,
        ..ParamsSpec::default()
    }
}

fn ball(r: f64) -> ProbePart<'static> {
    ProbePart::at_origin(ProbeShape::Sphere { radius: r as f32 })
}

/// A ball on a half space, and its session.
fn flat(tier: Tier, r: f64, depth: f64, stuff: Material, mu: f64) -> (Scene, Plan) {
    let spec = ParamsSpec { friction_dynamic: mu as f32, ..params(tier) };
    let mut scene = Scene::new(ObjectShape::HalfSpace, stuff, ball(r), spec);
    scene.paper_length = r.clamp(1.0e-6, 1.0e2) as f32;
    let units = Units::ball(r, depth, &stuff, mu);
    (scene, Plan { units, place: DVec3::Z * (r - depth), dt: pace(r), rest: 0, turns: 0.0 })
}

/// A tick that large probes are not too fast for \[s\].
fn pace(size: f64) -> f32 {
    (size / RADIUS).max(1.0) as f32 * 1.0e-3
}

fn middle(tier: Tier) -> (Scene, Plan) {
    flat(tier, RADIUS, SHARE * RADIUS, STUFF, MU)
}

/// Tier `green` needs a body: on the half space it is tier `influence`.
fn needs_body(tier: Tier) -> bool {
    tier == Tier::Green
}

/// A session against that of the middle.
fn against_middle(tier: Tier, (scene, plan): &(Scene, Plan), normal: bool) -> Pair {
    let (base, base_plan) = middle(tier);
    Ok(Some((felt(scene, plan)?, felt(&base, &base_plan)?, normal)))
}

fn young(tier: Tier, e: f64) -> Pair {
    if needs_body(tier) {
        return on_cube(0.125, e / STUFF_OF_CUBE);
    }
    let stuff = Material { young_modulus: e as f32, ..STUFF };
    against_middle(tier, &flat(tier, RADIUS, SHARE * RADIUS, stuff, MU), false)
}

fn poisson(tier: Tier, nu: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    let stuff = Material { poisson_ratio: nu as f32, ..STUFF };
    // cells know that a push along the surface widens it, and the paper's resistance is G over l
    let normal = matches!(tier, Tier::Paper | Tier::Influence);
    against_middle(tier, &flat(tier, RADIUS, SHARE * RADIUS, stuff, MU), normal)
}

fn friction(tier: Tier, mu: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    against_middle(tier, &flat(tier, RADIUS, SHARE * RADIUS, STUFF, mu), tier == Tier::Paper || mu == 0.0)
}

fn radius(tier: Tier, r: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    against_middle(tier, &flat(tier, r, SHARE * r, STUFF, MU), false)
}

fn flat_end(tier: Tier, a: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    let punch = |a: f64| {
        let part = ProbePart::at_origin(ProbeShape::Cylinder { radius: a as f32, height: a as f32 });
        let mut scene = Scene::new(ObjectShape::HalfSpace, STUFF, part, params(tier));
        scene.paper_length = a.clamp(1.0e-6, 1.0e2) as f32;
        let units = Units::punch(a, 0.01 * a, &STUFF, MU);
        (scene, Plan { units, place: DVec3::Z * (0.49 * a), dt: pace(a), rest: 0, turns: 0.0 })
    };
    let ((scene, plan), (base, base_plan)) = (punch(a), punch(RADIUS));
    Ok(Some((felt(&scene, &plan)?, felt(&base, &base_plan)?, false)))
}

/// The cube's table with lengths and moduli multiplied.
fn green_of(length: f32, modulus: f32) -> Arc<OwnGreen> {
    Arc::new(OwnGreen::scaled(length, modulus))
}

/// Young's modulus of the cube with a table \[Pa\].
const STUFF_OF_CUBE: f64 = super::bodies::STUFF.young_modulus as f64;

/// A ball on the cube with its own table, both in any size and of any modulus, against the table's own.
fn on_cube(b: f64, modulus: f64) -> Pair {
    let of = |b: f64, modulus: f64| {
        let stuff = Material { young_modulus: (STUFF_OF_CUBE * modulus) as f32, ..super::bodies::STUFF };
        let (scene, plan) = cube_scene(Tier::Green, b, stuff);
        let green = Some(green_of((b / f64::from(super::bodies::CUBE)) as f32, modulus as f32));
        (Scene { green, ..scene }, plan)
    };
    let ((scene, plan), (base, base_plan)) = (of(b, modulus), of(0.125, 1.0));
    Ok(Some((felt(&scene, &plan)?, felt(&base, &base_plan)?, false)))
}

fn cube_scene(tier: Tier, b: f64, stuff: Material) -> (Scene, Plan) {
    let r = 0.16 * b;
    let (scene, plan) = flat(tier, r, SHARE * r, stuff, MU);
    let object = ObjectShape::Box { size: Vec3::splat(b as f32) };
    (Scene { object, ..scene }, Plan { place: plan.place + DVec3::Z * b, ..plan })
}

fn cube(tier: Tier, b: f64) -> Pair {
    if needs_body(tier) {
        return on_cube(b, 1.0);
    }
    let ((scene, plan), (base, base_plan)) = (cube_scene(tier, b, STUFF), cube_scene(tier, 0.125, STUFF));
    Ok(Some((felt(&scene, &plan)?, felt(&base, &base_plan)?, false)))
}

/// A cube of 100 m under smaller and smaller balls. Its compliance is told to be none, so that it is a half space that stands elsewhere.
fn ratio(tier: Tier, ratio: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    let (b, r) = (100.0, 100.0 / ratio);
    let (scene, plan) = flat(tier, r, SHARE * r, STUFF, MU);
    let object = ObjectShape::Box { size: Vec3::splat(b as f32) };
    let scene = Scene { object, compliance: Some(Compliance::default()), ..scene };
    against_middle(tier, &(scene, Plan { place: plan.place + DVec3::Z * b, ..plan }), tier == Tier::Paper)
}

fn depth(tier: Tier, depth: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    against_middle(tier, &flat(tier, RADIUS, depth, STUFF, MU), tier == Tier::Paper)
}

/// The scene of the middle, or the cube for tier `green`, under another plan than usual.
fn planned(tier: Tier, change: impl Fn(&mut Plan), reference: impl Fn(&mut Plan), normal: bool) -> Pair {
    let (scene, plan) = if needs_body(tier) {
        let (scene, plan) = cube_scene(tier, 0.125, super::bodies::STUFF);
        (Scene { green: Some(green_of(1.0, 1.0)), ..scene }, plan)
    } else {
        middle(tier)
    };
    let (mut here, mut base) = (plan, plan);
    change(&mut here);
    reference(&mut base);
    Ok(Some((felt(&scene, &here)?, felt(&scene, &base)?, normal)))
}

fn twist(tier: Tier, turns: f64) -> Pair {
    // in tier `paper` what has slipped starts anew wherever it stops; below full slip the way back is another
    planned(tier, |plan| plan.turns = turns, |plan| plan.turns = 2.0, tier == Tier::Paper)
}

fn tick(tier: Tier, dt: f64) -> Pair {
    // half the way, so that a wrist does not turn too fast in a tick of a microsecond
    let half = |plan: &mut Plan| {
        (plan.units.shift, plan.units.angle) = (0.5 * plan.units.shift, 0.5 * plan.units.angle);
    };
    let change = |plan: &mut Plan| {
        half(plan);
        plan.dt = dt as f32;
    };
    planned(tier, change, half, false)
}

fn distance(tier: Tier, x: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    planned(tier, |plan| plan.place += DVec3::X * x, |_| (), false)
}

fn rest(tier: Tier, ticks: f64) -> Pair {
    planned(tier, |plan| plan.rest = ticks as u64, |_| (), false)
}

/// Balls far enough from each other that the dents do not matter.
fn parts(tier: Tier, count: f64) -> Pair {
    if needs_body(tier) {
        return Ok(None);
    }
    let (single, plan) = middle(tier);
    let mut scene = single.clone();
    scene.parts = (0..(count as usize).min(MAX_PARTS + 1))
        .map(|i| ProbePart { position: Vec3::new((i % 4) as f32 * 4.0, (i / 4) as f32 * 4.0, 0.0), ..ball(RADIUS) })
        .collect();
    let units = Units { load: plan.units.load * count, ..plan.units };
    Ok(Some((felt(&scene, &Plan { units, ..plan })?, felt(&single, &plan)?, true)))
}

/// Rest at the end of a coupling's swing: the mass must not show.
fn mass(tier: Tier, kg: f64) -> Pair {
    let coupling = CouplingSpec::Virtual(VirtualCoupling::default());
    let of = |kg: f64| -> Result<Felt, Invalid> {
        let (scene, plan) = middle(tier);
        let scene = Scene { mass: kg as f32, params: ParamsSpec { coupling, ..scene.params }, ..scene };
        // ten times the slowest swing of the heaviest probe
        let plan = Plan { units: Units { shift: 0.0, angle: 0.0, ..plan.units }, rest: 20_000, dt: 1.0e-2, ..plan };
        felt(&scene, &plan)
    };
    if needs_body(tier) {
        return Ok(None);
    }
    Ok(Some((of(kg)?, of(1.0)?, true)))
}

/// Found at every value of an axis, tier by tier, with the ticks that took.
pub fn walk(axis: &Axis) -> (Vec<[Found; 5]>, u64) {
    let mut steps = 0;
    let rows = axis.values.iter().map(|&value| {
        Tier::ALL.map(|tier| {
            let (found, more) = axis.at(tier, value);
            steps += more;
            found
        })
    });
    let rows: Vec<_> = rows.collect();
    (rows, steps)
}

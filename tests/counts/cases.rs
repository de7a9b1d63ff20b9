//! Which scenes are counted: one list. A feature of the core gets a row here, with it and without it.

#[path = "meshes.rs"]
mod meshes;

use haptor_contact::geometry::support::support;
use haptor_contact::{
    Breakaway, CouplingSpec, GuardSpec, MAX_WORK, Material, ObjectShape, ParamsSpec, Passivity, Pose, ProbeFrame, ProbePart,
    ProbeShape, Quat, Tier, Vec3, VirtualCoupling, World,
};

/// Ticks of a round of the motion: divided by every period below.
pub const ROUND: usize = 48;

/// The material of the paper's Table I.
pub const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };

/// How the probe moves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    /// Presses and slides, never turns.
    Slide,
    /// Presses, slides and turns.
    Twist,
    /// Holds still.
    Still,
    /// Moves above the object.
    Clear,
    /// Presses, tilts and walks from the middle of the object's top outward, so that faces, edges and corners meet.
    Tilt,
    /// Lifts off and comes back, so that every region of a compound is born anew, one a tick.
    Births,
}

/// A scene in motion.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name, unique.
    pub name: String,
    /// The elastic object.
    pub object: ObjectShape<'static>,
    /// The probe.
    pub probe: Vec<ProbePart<'static>>,
    /// Everything else.
    pub params: ParamsSpec,
    /// Mass of the probe \[kg\].
    pub mass: f32,
    motion: Motion,
    /// How much deeper the handle goes than 1 mm \[m\]: through a coupling, the probe does not follow.
    deeper: f32,
    /// Regions in contact at the end.
    pub regions: u8,
    /// The body has a table of its own.
    pub table: bool,
    /// Counts updates of the surface in place of ticks.
    pub surface: Option<Shown>,
}

/// A surface that somebody looks at.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// With the motion of the whole body.
    pub body: bool,
    /// Vertices of an update.
    pub vertices: usize,
}

/// Vertices of a whole surface: what the field loops are meant for.
const VERTICES: usize = 4096;

/// Vertices of a block so small that what comes before the vertices is most of it.
const BLOCK: usize = 64;

impl Case {
    /// Pose of a tick: depth 0.6 to 1.4 mm, shift and twist that stick and slip, by triangles of different period.
    pub fn pose(&self, tick: usize) -> Pose<World, ProbeFrame> {
        let wave = |period: usize| {
            let share = (tick % period) as f32 / period as f32;
            1.0 - 4.0 * (share - 0.5).abs()
        };
        let touch = self.object.height() + 0.02;
        if self.motion == Motion::Still {
            return Pose::new(Vec3::Z * (touch - 1.0e-3), Quat::IDENTITY);
        }
        if self.motion == Motion::Tilt {
            return self.tilted(wave(48), wave(24), wave(16));
        }
        let off = self.motion == Motion::Clear || self.motion == Motion::Births && tick % 24 < 8;
        let lift = if off { 0.01 } else { -1.0e-3 };
        let position = Vec3::new(1.0e-3 * wave(48), 7.0e-4 * wave(24), touch + lift - self.deeper + 4.0e-4 * wave(16));
        let angle = if self.motion == Motion::Slide { 0.0 } else { 0.1 * wave(48) };
        Pose::new(position, Quat::from_rotation_z(angle))
    }

    /// Tilted by the slow wave, turned by the middle one and pressed by the fast one: 0.6 to 1.4 mm of the lowest point are inside the object's highest plane.
    fn tilted(&self, slow: f32, middle: f32, fast: f32) -> Pose<World, ProbeFrame> {
        let turn = (Quat::from_rotation_x(0.8 * slow) * Quat::from_rotation_y(0.4 * middle)).normalize();
        let lowest = self.probe.first().map_or(Vec3::ZERO, |part| turn * support(&part.shape, turn.conjugate() * Vec3::NEG_Z));
        // flat tops are walked past their edges; round ones only as far as the press still meets them
        let flat = matches!(self.object, ObjectShape::Box { .. } | ObjectShape::Cylinder { .. }) && self.object.height() < WIDE.z;
        let walk = if flat { 0.04 } else { 0.003 };
        let place = Vec3::new(0.5 * walk * (1.0 + middle), 0.5 * walk * (1.0 + slow), self.object.height());
        Pose::new(place - lowest + Vec3::Z * (4.0e-4 * fast - 1.0e-3), turn)
    }

    /// Vertices of the undeformed surface around the contacts: a square of 0.1 m on the object's top.
    pub fn surface_at_rest(&self, count: usize) -> Vec<Vec3> {
        let side = count.isqrt();
        let at = |k: usize| 0.1 * ((k as f32 + 0.5) / side as f32 - 0.5);
        (0..side * side).map(|k| Vec3::new(at(k % side), at(k / side), self.object.height())).collect()
    }
}

/// A ball of 20 mm.
fn ball() -> Vec<ProbePart<'static>> {
    vec![ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })]
}

/// Ten balls of 10 mm in two rows, 30 mm apart.
fn ten() -> Vec<ProbePart<'static>> {
    let place = |i: usize| Vec3::new(0.03 * ((i % 5) as f32 - 2.0), 0.03 * ((i / 5) as f32 - 0.5), -0.01);
    let leg = |i| ProbePart { position: place(i), ..ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 }) };
    (0..10).map(leg).collect()
}

/// Names and settings of friction, from none up the tiers.
fn frictions() -> Vec<(&'static str, ParamsSpec)> {
    let plain = |tier, samples| ParamsSpec { tier, samples, ..ParamsSpec::default() };
    vec![
        ("no friction", ParamsSpec { friction_dynamic: 0.0, ..ParamsSpec::default() }),
        ("point", plain(Tier::Point, 64)),
        ("paper 64", plain(Tier::Paper, 64)),
        ("bristle 64", plain(Tier::Bristle, 64)),
        ("influence 52", plain(Tier::Influence, 52)),
    ]
}

/// Every scene.
pub fn all() -> Vec<Case> {
    let mut cases = Vec::new();
    for (friction, params) in frictions() {
        for (body, object) in [("half space", ObjectShape::HalfSpace), ("box", TABLE)] {
            for (count, probe, regions) in [("one region", ball(), 1), ("ten regions", ten(), 10)] {
                for (turn, motion) in [("slide", Motion::Slide), ("twist", Motion::Twist)] {
                    let name = format!("{friction}, {body}, {count}, {turn}");
                    cases.push(Case { name, object, probe: probe.clone(), params, motion, regions, ..base() });
                }
            }
        }
    }
    cases.extend(features());
    cases.extend(budgets());
    cases.extend(tables());
    cases.extend(surfaces());
    cases.extend(pairs());
    cases
}

/// Work budgets: one that never bites, and such that ten regions do not get what they ask for.
fn budgets() -> Vec<Case> {
    let with = |work: u32, params: ParamsSpec| ParamsSpec { work: Some(work), ..params };
    let influence = ParamsSpec { tier: Tier::Influence, samples: 52, ..ParamsSpec::default() };
    let many = Case { probe: ten(), regions: 10, object: TABLE, ..base() };
    let of = |name: &str, params, case: &Case| Case { name: name.to_owned(), params, ..case.clone() };
    let tipped = Case { probe: tips(), regions: 10, object: ObjectShape::Box { size: Vec3::splat(0.1) }, ..base() };
    let births = Case { motion: Motion::Births, ..many.clone() };
    vec![
        of("influence 52, cube, ten tips", influence, &tipped),
        of("influence 52, cube, ten tips, work 1000000", with(1_000_000, influence), &tipped),
        of("base, work to spare", with(MAX_WORK, ParamsSpec::default()), &base()),
        of("influence 52, box, ten regions, work 1000000", with(1_000_000, influence), &many),
        of("influence 52, box, ten regions, work 400000", with(400_000, influence), &many),
        of("influence 52, box, ten regions, work 200000", with(200_000, influence), &many),
        of("influence 52, box, ten regions, births, work 400000", with(400_000, influence), &births),
    ]
}

/// The box with a table of its own, as tier `green` has it; every tier reads it.
fn tables() -> Vec<Case> {
    let tabled = Case { object: TABLE, table: true, ..base() };
    let many = Case { probe: ten(), regions: 10, ..tabled.clone() };
    let none = ParamsSpec { friction_dynamic: 0.0, ..ParamsSpec::default() };
    let green = ParamsSpec { tier: Tier::Green, samples: 52, ..ParamsSpec::default() };
    let point = ParamsSpec { tier: Tier::Point, ..ParamsSpec::default() };
    let mut cases = Vec::new();
    for (friction, params) in [("no friction", none), ("point", point), ("green 52", green)] {
        cases.push(Case { name: format!("{friction}, box with a table, one region"), params, ..tabled.clone() });
        cases.push(Case { name: format!("{friction}, box with a table, ten regions"), params, ..many.clone() });
    }
    cases
}

/// Updates of a surface: one patch and ten, with the motion of the body and without, a whole one and a block.
fn surfaces() -> Vec<Case> {
    let one = base();
    let many = Case { probe: ten(), regions: 10, ..base() };
    let mut cases = Vec::new();
    for vertices in [VERTICES, BLOCK] {
        for (count, case) in [("one region", &one), ("ten regions", &many)] {
            let local = Shown { body: false, vertices };
            cases.push(Case { name: format!("surface of {vertices}, local, {count}"), surface: Some(local), ..case.clone() });
            let full = Some(Shown { body: true, vertices });
            let name = format!("surface of {vertices}, full, {count}, box");
            cases.push(Case { name, surface: full, object: TABLE, ..case.clone() });
        }
    }
    cases
}

/// Extents of an object so wide that its edges are out of reach \[m\].
const WIDE: Vec3 = Vec3::new(0.3, 0.3, 0.2);

/// Ten round tips under a plate, as `tests/scenes/ten-regions.toml` has them.
fn tips() -> Vec<ProbePart<'static>> {
    let tip = ProbeShape::Capsule { radius: 0.006, height: 0.02 };
    let place = |i: usize| Vec3::new(0.016 * ((i % 5) as f32 - 2.0), 0.032 * ((i / 5) as f32 - 0.5), -0.004);
    let mut parts = vec![ProbePart {
        position: Vec3::Z * 0.013,
        ..ProbePart::at_origin(ProbeShape::Box { size: Vec3::new(0.08, 0.048, 0.006) })
    }];
    parts.extend((0..10).map(|i| ProbePart { position: place(i), ..ProbePart::at_origin(tip) }));
    parts
}

/// Samples of a mesh: more than any search asks for.
const SAMPLES: usize = 512;

/// Every shape of a part on every shape of an object, without friction: what finding and pressing one contact costs.
fn pairs() -> Vec<Case> {
    let size = Vec3::splat(0.08);
    let objects = [
        ("half space", ObjectShape::HalfSpace),
        ("box", ObjectShape::Box { size }),
        ("sphere", ObjectShape::Sphere { radius: 0.05 }),
        ("ellipsoid", ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) }),
        ("cylinder", ObjectShape::Cylinder { radius: 0.04, height: 0.08 }),
        ("mesh", ObjectShape::Mesh(meshes::ball(0.05, 0.05, SAMPLES))),
        // no part comes near their edges
        ("wide box", ObjectShape::Box { size: WIDE }),
        ("wide cylinder", ObjectShape::Cylinder { radius: 0.5 * WIDE.x, height: WIDE.z }),
    ];
    let (radius, height) = (0.01, 0.03);
    let shapes = [
        ("sphere", ProbeShape::Sphere { radius: 0.02 }),
        ("box", ProbeShape::Box { size: Vec3::new(0.03, 0.02, 0.025) }),
        ("ellipsoid", ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.02, 0.03, 0.015) }),
        ("capsule", ProbeShape::Capsule { radius, height }),
        ("cylinder", ProbeShape::Cylinder { radius, height }),
        ("cone", ProbeShape::Cone { radius, height }),
        ("mesh", ProbeShape::Mesh(meshes::ball(0.02, 0.0, SAMPLES))),
        ("mesh of 32", ProbeShape::Mesh(meshes::ball(0.02, 0.0, 32))),
    ];
    let mut cases = Vec::new();
    for (on, object) in objects {
        let params = ParamsSpec { tier: Tier::Point, ..ParamsSpec::default() };
        cases.push(Case { name: format!("point, sphere on {on}"), object, params, motion: Motion::Tilt, ..base() });
        for (what, shape) in shapes {
            let params = ParamsSpec { friction_dynamic: 0.0, ..ParamsSpec::default() };
            let probe = vec![ProbePart::at_origin(shape)];
            cases.push(Case { name: format!("{what} on {on}"), object, probe, params, motion: Motion::Tilt, ..base() });
        }
    }
    cases
}

/// A box wide enough for the ten balls.
const TABLE: ObjectShape<'_> = ObjectShape::Box { size: Vec3::new(0.2, 0.2, 0.1) };

/// One ball on the half space, twisted, tier `bristle`.
fn base() -> Case {
    Case {
        name: String::new(),
        object: ObjectShape::HalfSpace,
        probe: ball(),
        params: ParamsSpec::default(),
        mass: 1.0,
        motion: Motion::Twist,
        deeper: 0.0,
        regions: 1,
        table: false,
        surface: None,
    }
}

/// That ball: with one feature more or less than the row of that name above.
fn features() -> Vec<Case> {
    let base = base();
    let case = |name: &str, change: &dyn Fn(&mut Case)| {
        let mut case = Case { name: name.to_owned(), ..base.clone() };
        change(&mut case);
        case
    };
    vec![
        case("base", &|_| ()),
        case("base, gravity", &|c| c.params.gravity = true),
        case("base, guard without limits", &|c| c.params.guard = GuardSpec::OPEN),
        case("base, guard with passivity", &|c| c.params.guard.passivity = Some(Passivity::default())),
        case("base, virtual coupling", &|c| couple(c)),
        case("no friction, virtual coupling", &|c| {
            couple(c);
            c.params.friction_dynamic = 0.0;
        }),
        case("base, static friction, smooth", &|c| c.params.friction_static = Some(0.9)),
        case("base, static friction, sharp", &|c| {
            (c.params.friction_static, c.params.breakaway) = (Some(0.9), Breakaway::Sharp);
        }),
        case("base, bristle 16", &|c| c.params.samples = 16),
        case("base, bristle 256", &|c| c.params.samples = 256),
        case("base, influence 52, one sweep", &|c| {
            (c.params.tier, c.params.samples, c.params.sweeps) = (Tier::Influence, 52, 1);
        }),
        case("base, influence 112", &|c| (c.params.tier, c.params.samples) = (Tier::Influence, 112)),
        case("base, held still", &|c| c.motion = Motion::Still),
        case("base, no friction, tier influence", &|c| {
            c.params = ParamsSpec { friction_dynamic: 0.0, tier: Tier::Influence, samples: 52, ..c.params };
        }),
        case("no friction, half space, ten regions, births", &|c| {
            (c.motion, c.probe, c.regions, c.params.friction_dynamic) = (Motion::Births, ten(), 10, 0.0);
        }),
        case("no friction, box, ten regions, births", &|c| {
            (c.motion, c.probe, c.regions, c.object, c.params.friction_dynamic) = (Motion::Births, ten(), 10, TABLE, 0.0);
        }),
        case("bristle 64, box, ten regions, births", &|c| {
            (c.motion, c.probe, c.regions, c.object) = (Motion::Births, ten(), 10, TABLE);
        }),
        case("no contact, one part", &|c| (c.motion, c.regions) = (Motion::Clear, 0)),
        case("no contact, ten parts, mesh", &|c| {
            (c.object, c.probe, c.motion, c.regions) =
                (ObjectShape::Mesh(meshes::ball(0.05, 0.05, SAMPLES)), ten(), Motion::Clear, 0);
        }),
        case("no contact, ten parts", &|c| (c.probe, c.motion, c.regions) = (ten(), Motion::Clear, 0)),
    ]
}

/// Ties the probe to the handle by spring and damper. 50 g settle within a round, and 4 mm of the spring press as hard as the rows without.
fn couple(case: &mut Case) {
    case.params.coupling = CouplingSpec::Virtual(VirtualCoupling::default());
    (case.mass, case.deeper) = (0.05, 0.004);
}

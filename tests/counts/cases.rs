//! Which scenes are counted: one list. A feature of the core gets a row here, with it and without it.

use haptor_contact::{
    Breakaway, CouplingSpec, GuardSpec, Material, ObjectShape, ParamsSpec, Passivity, Pose, ProbeFrame, ProbePart, ProbeShape,
    Quat, Tier, Vec3, VirtualCoupling, World,
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
    /// Counts updates of the surface in place of ticks; with the body's motion or without.
    pub surface: Option<bool>,
}

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
        let lift = if self.motion == Motion::Clear { 0.01 } else { -1.0e-3 };
        let position = Vec3::new(1.0e-3 * wave(48), 7.0e-4 * wave(24), touch + lift - self.deeper + 4.0e-4 * wave(16));
        let angle = if self.motion == Motion::Slide { 0.0 } else { 0.1 * wave(48) };
        Pose::new(position, Quat::from_rotation_z(angle))
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
        case("base, influence 112", &|c| (c.params.tier, c.params.samples) = (Tier::Influence, 112)),
        case("base, held still", &|c| c.motion = Motion::Still),
        case("base, no friction, tier influence", &|c| {
            c.params = ParamsSpec { friction_dynamic: 0.0, tier: Tier::Influence, samples: 52, ..c.params };
        }),
        case("no contact, one part", &|c| (c.motion, c.regions) = (Motion::Clear, 0)),
        case("no contact, ten parts", &|c| (c.probe, c.motion, c.regions) = (ten(), Motion::Clear, 0)),
        case("surface of 4096, local, one region", &|c| c.surface = Some(false)),
        case("surface of 4096, full, one region, box", &|c| (c.surface, c.object) = (Some(true), TABLE)),
        case("surface of 4096, local, ten regions", &|c| (c.surface, c.probe, c.regions) = (Some(false), ten(), 10)),
        case("surface of 4096, full, ten regions, box", &|c| {
            (c.surface, c.probe, c.regions, c.object) = (Some(true), ten(), 10, TABLE);
        }),
    ]
}

/// Ties the probe to the handle by spring and damper. 50 g settle within a round, and 4 mm of the spring press as hard as the rows without.
fn couple(case: &mut Case) {
    case.params.coupling = CouplingSpec::Virtual(VirtualCoupling::default());
    (case.mass, case.deeper) = (0.05, 0.004);
}

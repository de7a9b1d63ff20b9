//! Which scenes are counted: one list, on a PC and on a Cortex-M7. A feature of the core gets a row here, with it and without it.
//!
//! Needs nothing but the core, so that the image for the Cortex-M7 can include this file.

use core::fmt;

use haptor_contact::{
    Breakaway, CouplingSpec, GuardSpec, Material, ObjectShape, ParamsSpec, Passivity, Pose, ProbeFrame, ProbePart, ProbeShape,
    Quat, Tier, Vec3, VirtualCoupling, World,
};

/// Ticks of a round of the motion: divided by every period below.
pub const ROUND: usize = 48;

/// The material of the paper's Table I.
pub const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };

/// Vertices along a side of a whole surface, and of it all: what the field loops are meant for.
const SIDE: usize = 64;
pub const VERTICES: usize = SIDE * SIDE;

/// Updates of a surface that are counted: every one costs the same but for the branches of its closed forms.
pub const UPDATES: usize = 2;

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

/// Words that name a scene; the first is not empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Name([&'static str; 4]);

impl fmt::Display for Name {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, more @ ..] = self.0;
        out.write_str(first)?;
        more.iter().filter(|word| !word.is_empty()).try_for_each(|word| write!(out, ", {word}"))
    }
}

/// A scene in motion.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name, unique.
    pub name: Name,
    /// The elastic object.
    pub object: ObjectShape<'static>,
    /// The probe.
    pub probe: &'static [ProbePart<'static>],
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

    /// A vertex of the undeformed surface around the contacts: a square of 0.1 m on the object's top.
    pub fn vertex_at_rest(&self, k: usize) -> Vec3 {
        let at = |k: usize| 0.1 * ((k as f32 + 0.5) / SIDE as f32 - 0.5);
        Vec3::new(at(k % SIDE), at(k / SIDE), self.object.height())
    }
}

/// A ball of 20 mm.
const BALL: &[ProbePart<'static>] = &[ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];

/// Ten balls of 10 mm in two rows, 30 mm apart.
const TEN: &[ProbePart<'static>] = &ten();

const fn ten() -> [ProbePart<'static>; 10] {
    let mut legs = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 }); 10];
    let mut i = 0;
    while i < legs.len() {
        legs[i].position = Vec3::new(0.03 * ((i % 5) as f32 - 2.0), 0.03 * ((i / 5) as f32 - 0.5), -0.01);
        i += 1;
    }
    legs
}

/// Names and settings of friction, from none up the tiers.
fn frictions() -> [(&'static str, ParamsSpec); 5] {
    let plain = |tier, samples| ParamsSpec { tier, samples, ..ParamsSpec::default() };
    [
        ("no friction", ParamsSpec { friction_dynamic: 0.0, ..ParamsSpec::default() }),
        ("point", plain(Tier::Point, 64)),
        ("paper 64", plain(Tier::Paper, 64)),
        ("bristle 64", plain(Tier::Bristle, 64)),
        ("influence 52", plain(Tier::Influence, 52)),
    ]
}

/// A box wide enough for the ten balls.
const TABLE: ObjectShape<'_> = ObjectShape::Box { size: Vec3::new(0.2, 0.2, 0.1) };

/// What friction is combined with.
const BODIES: [(&str, ObjectShape<'_>); 2] = [("half space", ObjectShape::HalfSpace), ("box", TABLE)];
const PROBES: [(&str, &[ProbePart<'_>], u8); 2] = [("one region", BALL, 1), ("ten regions", TEN, 10)];
const TURNS: [(&str, Motion); 2] = [("slide", Motion::Slide), ("twist", Motion::Twist)];

/// Every scene.
pub fn all() -> impl Iterator<Item = Case> {
    frictions().into_iter().flat_map(combined).chain(FEATURES.iter().map(|(name, change)| {
        let mut case = Case { name: Name([name, "", "", ""]), ..base() };
        change(&mut case);
        case
    }))
}

/// A friction with every body, probe and turn.
fn combined((friction, params): (&'static str, ParamsSpec)) -> impl Iterator<Item = Case> {
    BODIES.into_iter().flat_map(move |(body, object)| {
        PROBES.into_iter().flat_map(move |(count, probe, regions)| {
            TURNS.into_iter().map(move |(turn, motion)| {
                let name = Name([friction, body, count, turn]);
                Case { name, object, probe, params, motion, regions, ..base() }
            })
        })
    })
}

/// One ball on the half space, twisted, tier `bristle`.
fn base() -> Case {
    Case {
        name: Name(["base", "", "", ""]),
        object: ObjectShape::HalfSpace,
        probe: BALL,
        params: ParamsSpec::default(),
        mass: 1.0,
        motion: Motion::Twist,
        deeper: 0.0,
        regions: 1,
        surface: None,
    }
}

/// A name, and what it changes.
type Feature = (&'static str, fn(&mut Case));

/// That ball: with one feature more or less than the row of that name above.
const FEATURES: [Feature; 20] = [
    ("base", |_| ()),
    ("base, gravity", |c| c.params.gravity = true),
    ("base, guard without limits", |c| c.params.guard = GuardSpec::OPEN),
    ("base, guard with passivity", |c| c.params.guard.passivity = Some(Passivity::default())),
    ("base, virtual coupling", couple),
    ("no friction, virtual coupling", |c| {
        couple(c);
        c.params.friction_dynamic = 0.0;
    }),
    ("base, static friction, smooth", |c| c.params.friction_static = Some(0.9)),
    ("base, static friction, sharp", |c| {
        (c.params.friction_static, c.params.breakaway) = (Some(0.9), Breakaway::Sharp);
    }),
    ("base, bristle 16", |c| c.params.samples = 16),
    ("base, bristle 256", |c| c.params.samples = 256),
    ("base, influence 112", |c| (c.params.tier, c.params.samples) = (Tier::Influence, 112)),
    ("base, held still", |c| c.motion = Motion::Still),
    ("base, no friction, tier influence", |c| {
        c.params = ParamsSpec { friction_dynamic: 0.0, tier: Tier::Influence, samples: 52, ..c.params };
    }),
    ("no contact, one part", |c| (c.motion, c.regions) = (Motion::Clear, 0)),
    ("no contact, ten parts", |c| (c.probe, c.motion, c.regions) = (TEN, Motion::Clear, 0)),
    ("bristle 32, box, ten regions, twist", |c| {
        (c.params.samples, c.probe, c.regions, c.object) = (32, TEN, 10, TABLE);
    }),
    ("surface of 4096, local, one region", |c| c.surface = Some(false)),
    ("surface of 4096, full, one region, box", |c| (c.surface, c.object) = (Some(true), TABLE)),
    ("surface of 4096, local, ten regions", |c| (c.surface, c.probe, c.regions) = (Some(false), TEN, 10)),
    ("surface of 4096, full, ten regions, box", |c| {
        (c.surface, c.probe, c.regions, c.object) = (Some(true), TEN, 10, TABLE);
    }),
];

/// Ties the probe to the handle by spring and damper. 50 g settle within a round, and 4 mm of the spring press as hard as the rows without.
fn couple(case: &mut Case) {
    case.params.coupling = CouplingSpec::Virtual(VirtualCoupling::default());
    (case.mass, case.deeper) = (0.05, 0.004);
}

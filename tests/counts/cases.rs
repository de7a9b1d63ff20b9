//! Which scenes are counted: one list, on a PC and on a Cortex-M7. A feature of the core gets a row here, with it and without it;
//! rows that only a PC counts are in `cases_pc.rs`.
//!
//! Needs nothing but the core, so that the image for the Cortex-M7 can include this file.

use core::fmt;
use core::num::NonZeroUsize;

use haptor_contact::geometry::support::support;
use haptor_contact::{
    Breakaway, CouplingSpec, Green, GuardSpec, Material, ObjectShape, ParamsSpec, Passivity, Pose, ProbeFrame, ProbePart,
    ProbeShape, Quat, Tier, Vec3, VirtualCoupling, World,
};

/// Ticks of a round of the motion: divided by every period below.
pub const ROUND: usize = 48;

/// The material of the paper's Table I.
pub const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };

/// A surface that somebody looks at.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// With the motion of the whole body.
    pub body: bool,
    /// Vertices along a side of an update, at most [`SIDE`].
    pub side: NonZeroUsize,
}

/// Vertices along a side of a whole surface: what the field loops are meant for.
pub const SIDE: NonZeroUsize = NonZeroUsize::new(64).unwrap();

/// How the probe moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Presses and slides, never turns.
    Slide,
    /// Presses, slides and turns.
    Twist,
    /// Moves above the object.
    Clear,
    /// Holds still.
    Still,
    /// Lifts off and comes back, so that every region of a compound is born anew, one a tick.
    Births,
    /// Presses, tilts and walks from the middle of the object's top outward, so that faces, edges and corners meet.
    Tilt,
}

/// Words that name a scene; the first is not empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Name(pub [&'static str; 4]);

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
    /// How the probe moves.
    pub motion: Motion,
    /// How much deeper the handle goes than 1 mm \[m\]: through a coupling, the probe does not follow.
    pub deeper: f32,
    /// Regions in contact at the end.
    pub regions: u8,
    /// The table that the body has of its own.
    pub green: Option<Green<'static>>,
    /// Counts updates of the surface in place of ticks.
    pub surface: Option<Shown>,
}

impl Case {
    /// Pose of a tick.
    pub fn pose(&self, tick: usize) -> Pose<World, ProbeFrame> {
        match self.motion {
            Motion::Slide => Pose::new(place(self, tick, PRESSED), Quat::IDENTITY),
            Motion::Twist => Pose::new(place(self, tick, PRESSED), turn(tick)),
            Motion::Clear => Pose::new(place(self, tick, CLEAR), turn(tick)),
            Motion::Still => Pose::new(Vec3::Z * (self.touch() + PRESSED), Quat::IDENTITY),
            Motion::Births => Pose::new(place(self, tick, if tick % 24 < 8 { CLEAR } else { PRESSED }), turn(tick)),
            Motion::Tilt => tilted(self, tick),
        }
    }

    /// Height of the probe's origin where a ball of 20 mm touches the object's top \[m\].
    fn touch(&self) -> f32 {
        self.object.height() + 0.02
    }
}

/// A triangle of this period, between -1 and 1.
fn wave(tick: usize, period: NonZeroUsize) -> f32 {
    let share = (tick % period) as f32 / period.get() as f32;
    1.0 - 4.0 * (share - 0.5).abs()
}

/// Periods of the triangles: shift, turn and tilt; shift across and turn about a second axis; press.
const SLOW: NonZeroUsize = NonZeroUsize::new(48).unwrap();
/// See [`SLOW`].
const MIDDLE: NonZeroUsize = NonZeroUsize::new(24).unwrap();
/// See [`SLOW`].
const FAST: NonZeroUsize = NonZeroUsize::new(16).unwrap();

/// How much higher than touching the presses are in the middle \[m\]: depth 0.6 to 1.4 mm.
const PRESSED: f32 = -1.0e-3;

/// The same where nothing is touched \[m\].
const CLEAR: f32 = 0.01;

/// A press around `lift` \[m\], and a shift that sticks and slips.
fn place(case: &Case, tick: usize, lift: f32) -> Vec3 {
    let height = case.touch() + lift - case.deeper + 4.0e-4 * wave(tick, FAST);
    Vec3::new(1.0e-3 * wave(tick, SLOW), 7.0e-4 * wave(tick, MIDDLE), height)
}

/// A twist that sticks and slips.
fn turn(tick: usize) -> Quat {
    Quat::from_rotation_z(0.1 * wave(tick, SLOW))
}

/// Extents of an object so wide that its edges are out of reach \[m\].
pub const WIDE: Vec3 = Vec3::new(0.3, 0.3, 0.2);

/// Tilted by the slow wave, turned by the middle one and pressed by the fast one: 0.6 to 1.4 mm of the lowest point are inside the object's highest plane.
fn tilted(case: &Case, tick: usize) -> Pose<World, ProbeFrame> {
    let [slow, middle, fast] = [SLOW, MIDDLE, FAST].map(|period| wave(tick, period));
    let turn = (Quat::from_rotation_x(0.8 * slow) * Quat::from_rotation_y(0.4 * middle)).normalize();
    let lowest = case.probe.first().map_or(Vec3::ZERO, |part| turn * support(&part.shape, turn.conjugate() * Vec3::NEG_Z));
    // flat tops are walked past their edges; round ones only as far as the press still meets them
    let flat = matches!(case.object, ObjectShape::Box { .. } | ObjectShape::Cylinder { .. }) && case.object.height() < WIDE.z;
    let walk = if flat { 0.04 } else { 0.003 };
    let place = Vec3::new(0.5 * walk * (1.0 + middle), 0.5 * walk * (1.0 + slow), case.object.height());
    Pose::new(place - lowest + Vec3::Z * (4.0e-4 * fast - 1.0e-3), turn)
}

/// A ball of 20 mm.
pub const BALL: &[ProbePart<'static>] = &[ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];

/// Ten balls of 10 mm in two rows, 30 mm apart.
pub const TEN: &[ProbePart<'static>] = &ten();

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
pub const TABLE: ObjectShape<'_> = ObjectShape::Box { size: Vec3::new(0.2, 0.2, 0.1) };

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
pub fn base() -> Case {
    Case {
        name: Name(["base", "", "", ""]),
        object: ObjectShape::HalfSpace,
        probe: BALL,
        params: ParamsSpec::default(),
        mass: 1.0,
        motion: Motion::Twist,
        deeper: 0.0,
        regions: 1,
        green: None,
        surface: None,
    }
}

/// A whole surface, with the motion of the body and without.
const FULL: Option<Shown> = Some(Shown { body: true, side: SIDE });
const LOCAL: Option<Shown> = Some(Shown { body: false, side: SIDE });

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
    ("surface of 4096, local, one region", |c| c.surface = LOCAL),
    ("surface of 4096, full, one region, box", |c| (c.surface, c.object) = (FULL, TABLE)),
    ("surface of 4096, local, ten regions", |c| (c.surface, c.probe, c.regions) = (LOCAL, TEN, 10)),
    ("surface of 4096, full, ten regions, box", |c| {
        (c.surface, c.probe, c.regions, c.object) = (FULL, TEN, 10, TABLE);
    }),
];

/// Ties the probe to the handle by spring and damper. 50 g settle within a round, and 4 mm of the spring press as hard as the rows without.
fn couple(case: &mut Case) {
    case.params.coupling = CouplingSpec::Virtual(VirtualCoupling::default());
    (case.mass, case.deeper) = (0.05, 0.004);
}

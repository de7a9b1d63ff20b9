//! `[friction]`, `[contact]`, `[model]`, `[guard]`: what may change without changing the bodies.

use haptor_contact::{Breakaway, ForceLaw, GuardSpec, MAX_WORK, MIN_WORK, ParamsSpec, Tier};
use haptor_wire::{Coupling, Deformation};

use super::coupling;
use super::document::{Key, SceneError, Section, key};

/// What `[model]` says beside the core's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extras {
    /// Gauss-Seidel sweeps of the tiers above `bristle`.
    pub sweeps: u8,
    /// How much of the surface is computed when someone looks.
    pub deformation: Deformation,
    /// Limits that `[guard]` gives, infinity where it gives none: beside a device only these hold.
    pub asked: GuardSpec,
    /// What ties the probe to the handle, as far as the scene says.
    pub coupling: Coupling,
    /// The paper's l on a half space \[m\]; `None` takes the core's default.
    pub paper_length: Option<f32>,
}

const STATIC: Key = key("static", "a number, friction.dynamic to 10", "0.75");
const DYNAMIC: Key = key("dynamic", "a number, 0 to 10", "0.75");
const REGION_DISTANCE: Key = key("region_distance", "a number, 0 to 1e2 m", "0.004");
const MAX_REGIONS: Key = key("max_regions", "a whole number, 1 to 10", "10");
const TIER: Key = key("tier", "point, paper, bristle, influence or green", "\"bristle\"");
const SAMPLES: Key = key(
    "samples",
    "a whole number, 16 to 256 for tier bristle, 16 to 1024 for tier paper, 52 or 112 for tiers influence and green",
    "64",
);
const SWEEPS: Key = key("sweeps", "a whole number, 1 to 32", "4");
const DEFORMATION: Key = key("deformation", "none, local or full", "\"full\"");
const COUPLING: Key = key("coupling", "direct or virtual", "\"direct\"");
const BREAKAWAY: Key = key("breakaway", "smooth or sharp", "\"smooth\"");
const GRAVITY: Key = key("gravity", "true or false", "false");
const WORK: Key = key("work", "a whole number of instructions, 1e4 to 1e9; leave it out for no limit", "300000");
const PAPER_LENGTH: Key = key("paper_length", "a number, 1e-6 to 1e2 m", "0.1");
const FORCE_LAW: Key = key("force_law", "a table with kind = hertz, cubic or table", "{ kind = \"hertz\" }");
const KIND: Key = key("kind", "hertz, cubic or table", "\"hertz\"");
const K1: Key = key("k1", "a number, 0 or more, N/m", "1.0e4");
const K3: Key = key("k3", "a number, 0 or more, N/m^3", "1.0e9");
const STEP: Key = key("step", "a number above 0, m", "1.0e-4");
const FORCE: Key = key("force", "16 numbers, the first 0, not falling, N", "[0.0, 0.1, ...]");
const MAX_FORCE: Key = key("max_force", "a number above 0, or inf for none, N", "8.5");
const MAX_TORQUE: Key = key("max_torque", "a number above 0, or inf for none, N m", "0.188");
const MAX_FORCE_RATE: Key = key("max_force_rate", "a number above 0, or inf for none, N/s", "425.0");
const MAX_TORQUE_RATE: Key = key("max_torque_rate", "a number above 0, or inf for none, N m/s", "9.4");
const RAMP_IN: Key = key("ramp_in", "a number, 0 to 60 s", "0.5");

/// Words of tiers.
const TIERS: [(&str, Tier); 5] = [
    ("point", Tier::Point),
    ("paper", Tier::Paper),
    ("bristle", Tier::Bristle),
    ("influence", Tier::Influence),
    ("green", Tier::Green),
];

/// Most sweeps: more than the tiers' tables were made with, and still bounded.
const MAX_SWEEPS: usize = 32;

/// Cells of a scene of tier `influence` or `green` that gives none.
const DEFAULT_CELLS: usize = 52;

/// Sweeps of a scene that gives none.
const DEFAULT_SWEEPS: u8 = 4;

/// Reads `[friction]`.
pub fn friction(section: &Section<'_, '_>, params: &mut ParamsSpec) -> Result<(), SceneError> {
    params.friction_dynamic = section.number(DYNAMIC)?;
    params.friction_static = section.optional_number(STATIC)?;
    section.finish("[friction]")
}

/// Reads `[contact]`.
pub fn contact(section: &Section<'_, '_>, params: &mut ParamsSpec) -> Result<(), SceneError> {
    set(&mut params.region_distance, section.optional_number(REGION_DISTANCE)?);
    set(&mut params.max_regions, section.optional_count(MAX_REGIONS)?);
    section.finish("[contact]")
}

/// What a scene without `[model]`, `[coupling]` and `[guard]` says.
pub const NOTHING_SAID: Extras = Extras {
    sweeps: DEFAULT_SWEEPS,
    deformation: Deformation::Full,
    asked: NO_LIMITS,
    coupling: Coupling::Direct,
    paper_length: None,
};

/// Reads `[model]`, and the `[coupling]` of `root` that goes with it.
pub fn model(root: &Section<'_, '_>, section: Option<&Section<'_, '_>>, params: &mut ParamsSpec) -> Result<Extras, SceneError> {
    let mut extras = NOTHING_SAID;
    let Some(section) = section else {
        extras.coupling = coupling::coupling(root, false)?;
        return Ok(extras);
    };
    set(&mut params.tier, section.optional_word(TIER, &TIERS)?);
    if matches!(params.tier, Tier::Influence | Tier::Green) {
        params.samples = DEFAULT_CELLS;
    }
    set(&mut params.samples, section.optional_count(SAMPLES)?);
    set(&mut extras.sweeps, sweeps(section)?);
    params.sweeps = usize::from(extras.sweeps);
    let amounts = [("none", Deformation::None), ("local", Deformation::Local), ("full", Deformation::Full)];
    set(&mut extras.deformation, section.optional_word(DEFORMATION, &amounts)?);
    let virtually = section.optional_word(COUPLING, &[("direct", false), ("virtual", true)])?.unwrap_or(false);
    extras.coupling = coupling::coupling(root, virtually)?;
    params.coupling = coupling::without_device(&extras.coupling);
    let manners = [("smooth", Breakaway::Smooth), ("sharp", Breakaway::Sharp)];
    set(&mut params.breakaway, section.optional_word(BREAKAWAY, &manners)?);
    set(&mut params.gravity, section.optional_flag(GRAVITY)?);
    set(&mut params.work, work(section)?.map(Some));
    extras.paper_length = section.optional_number(PAPER_LENGTH)?;
    let law = section.optional_section(FORCE_LAW)?;
    set(&mut params.force_law, law.map(|inner| force_law(&inner)).transpose()?);
    section.finish("[model]")?;
    Ok(extras)
}

/// No limit, and the core's ramp.
const NO_LIMITS: GuardSpec = GuardSpec { ramp_in: 0.5, ..GuardSpec::OPEN };

/// Reads `[guard]` over the core's own limits, and over none.
pub fn guard(section: &Section<'_, '_>, params: &mut ParamsSpec, extras: &mut Extras) -> Result<(), SceneError> {
    let limits = [MAX_FORCE, MAX_TORQUE, MAX_FORCE_RATE, MAX_TORQUE_RATE, RAMP_IN];
    let mut given = [None; 5];
    for (value, key) in given.iter_mut().zip(limits) {
        *value = section.optional_number(key)?;
    }
    let passivity = coupling::passivity(section)?;
    for guard in [&mut params.guard, &mut extras.asked] {
        guard.passivity = passivity;
        let [max_force, max_torque, max_force_rate, max_torque_rate, ramp_in] = given;
        set(&mut guard.max_force, max_force);
        set(&mut guard.max_torque, max_torque);
        set(&mut guard.max_force_rate, max_force_rate);
        set(&mut guard.max_torque_rate, max_torque_rate);
        set(&mut guard.ramp_in, ramp_in);
    }
    section.finish("[guard]")
}

fn sweeps(section: &Section<'_, '_>) -> Result<Option<u8>, SceneError> {
    let Some(count) = section.optional_count(SWEEPS)? else { return Ok(None) };
    match u8::try_from(count) {
        Ok(sweeps) if (1..=MAX_SWEEPS).contains(&count) => Ok(Some(sweeps)),
        _ => Err(section.error("sweeps", &format!("allowed is {}; correct the value", SWEEPS.allowed))),
    }
}

fn work(section: &Section<'_, '_>) -> Result<Option<u32>, SceneError> {
    let Some(count) = section.optional_count(WORK)? else { return Ok(None) };
    match u32::try_from(count) {
        Ok(work) if (MIN_WORK..=MAX_WORK).contains(&work) => Ok(Some(work)),
        _ => Err(section.error("work", &format!("allowed is {}; correct the value", WORK.allowed))),
    }
}

#[derive(Clone, Copy)]
enum LawKind {
    Hertz,
    Cubic,
    Table,
}

fn force_law(section: &Section<'_, '_>) -> Result<ForceLaw, SceneError> {
    let kinds = [("hertz", LawKind::Hertz), ("cubic", LawKind::Cubic), ("table", LawKind::Table)];
    let law = match section.word(KIND, &kinds)? {
        LawKind::Hertz => ForceLaw::Hertz,
        LawKind::Cubic => ForceLaw::Cubic { k1: section.number(K1)?, k3: section.number(K3)? },
        LawKind::Table => ForceLaw::Table { step: section.number(STEP)?, force: section.numbers(FORCE)? },
    };
    section.finish("a force law of this kind")?;
    Ok(law)
}

fn set<T>(place: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *place = value;
    }
}

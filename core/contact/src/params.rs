//! What may change between ticks: friction, tier, samples, limits. Validated once, then read-only.

use crate::budget::Rung;
use crate::coupling::CouplingSpec;
use crate::error::{Invalid, require};
use crate::guard::GuardSpec;
use crate::limits::{MAX_BRISTLES, MAX_REGIONS, MAX_SAMPLES, MAX_SWEEPS, MAX_WORK, MIN_SAMPLES, MIN_WORK};
use crate::tier::bristle::Layout;
use crate::tier::influence;

/// Fidelity of the tangential force and the torsion, from fast to accurate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tier {
    /// Closed-form curves, no samples.
    Point,
    /// The paper's equations, as printed where they can be; not predictive in torque.
    Paper,
    /// Calibrated bristles with Coulomb's cap at each sample.
    Bristle,
    /// Cells that move the whole elastic surface, with Coulomb's cap at each.
    Influence,
    /// As `influence`, on a body whose Green's function was computed by finite elements.
    Green,
}

impl Tier {
    /// Every level, from fast to accurate.
    pub const ALL: [Self; 5] = [Self::Point, Self::Paper, Self::Bristle, Self::Influence, Self::Green];

    /// The name used in files and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Paper => "paper",
            Self::Bristle => "bristle",
            Self::Influence => "influence",
            Self::Green => "green",
        }
    }
}

/// What happens when a sample leaves stick and static friction is above dynamic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Breakaway {
    /// The cap falls from static to dynamic over a slip length, so the torque has no step.
    #[default]
    Smooth,
    /// The cap falls at once (the paper): a click in the hand.
    Sharp,
}

/// Normal force over depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ForceLaw {
    /// From the footprint (Hertz and its relatives).
    #[default]
    Hertz,
    /// F = k1 d + k3 d^3, the nonlinear law of a point contact in the paper's reference \[1\].
    Cubic {
        /// Linear stiffness \[N/m\].
        k1: f32,
        /// Cubic stiffness \[N/m^3\].
        k3: f32,
    },
    /// Measured law: `force[i]` at depth `i * step`, linear between, held beyond the last.
    Table {
        /// Depth between entries \[m\].
        step: f32,
        /// Forces \[N\], from depth 0 on, not falling.
        force: [f32; FORCE_TABLE_LEN],
    },
}

/// Entries of a measured force law: a press of 15 steps is what a load cell curve is usually reduced to.
pub const FORCE_TABLE_LEN: usize = 16;

/// Everything [`Params`] is made from. `Default` is the scene file's default.
#[derive(Clone, Copy, Debug)]
pub struct ParamsSpec {
    /// Static coefficient of friction; `None` takes the dynamic one.
    pub friction_static: Option<f32>,
    /// Dynamic coefficient of friction, 0 to 10.
    pub friction_dynamic: f32,
    /// Patches closer than this belong to one region (the paper's r_th) \[m\].
    pub region_distance: f32,
    /// Regions at once, 1 to [`MAX_REGIONS`].
    pub max_regions: usize,
    /// Fidelity.
    pub tier: Tier,
    /// Samples per region for `paper` and `bristle`; cells of a fresh contact for `influence` and `green`, 52 or 112.
    pub samples: usize,
    /// Gauss-Seidel sweeps per tick of tiers `influence` and `green`, 1 to [`MAX_SWEEPS`].
    pub sweeps: usize,
    /// Stick to slip when static friction is above dynamic.
    pub breakaway: Breakaway,
    /// Normal force over depth.
    pub force_law: ForceLaw,
    /// Adds the probe's weight to the wrench.
    pub gravity: bool,
    /// What a tick may spend, in instructions of the x86-64 release build ([`budget`](crate::budget)), [`MIN_WORK`] to [`MAX_WORK`]; `None` is no limit.
    pub work: Option<u32>,
    /// What ties the probe to the handle.
    pub coupling: CouplingSpec,
    /// Limits of the last stage.
    pub guard: GuardSpec,
}

impl Default for ParamsSpec {
    fn default() -> Self {
        Self {
            friction_static: None,
            friction_dynamic: 0.75,
            region_distance: 0.004,
            max_regions: MAX_REGIONS,
            tier: Tier::Bristle,
            samples: 64,
            sweeps: 4,
            breakaway: Breakaway::Smooth,
            force_law: ForceLaw::Hertz,
            gravity: false,
            work: None,
            coupling: CouplingSpec::Direct,
            guard: GuardSpec::default(),
        }
    }
}

/// Validated parameters.
#[derive(Clone, Copy, Debug)]
pub struct Params {
    pub(crate) mu_s: f32,
    pub(crate) mu_d: f32,
    pub(crate) region_distance: f32,
    pub(crate) max_regions: usize,
    pub(crate) tier: Tier,
    pub(crate) samples: usize,
    /// Highest rung of the ladder.
    pub(crate) rung: Rung,
    pub(crate) breakaway: Breakaway,
    pub(crate) force_law: ForceLaw,
    pub(crate) gravity: bool,
    pub(crate) work: Option<u32>,
    pub(crate) coupling: CouplingSpec,
    pub(crate) guard: GuardSpec,
    pub(crate) layout: Layout,
    /// Tells one set of parameters from another, so that a change is noticed while the probe holds still.
    pub(crate) fingerprint: u32,
}

impl Params {
    /// Validates the spec.
    ///
    /// # Errors
    /// [`Invalid`] names the first value out of range.
    pub fn new(spec: &ParamsSpec) -> Result<Self, Invalid> {
        let mu_d = spec.friction_dynamic;
        let mu_s = spec.friction_static.unwrap_or(mu_d);
        require((0.0..=10.0).contains(&mu_d), "friction.dynamic", mu_d, "0 to 10")?;
        require(mu_s >= mu_d && mu_s <= 10.0, "friction.static", mu_s, "friction.dynamic to 10")?;
        require((0.0..=1.0e2).contains(&spec.region_distance), "contact.region_distance", spec.region_distance, "0 to 1e2 m")?;
        let count = spec.max_regions as f32;
        require((1..=MAX_REGIONS).contains(&spec.max_regions), "contact.max_regions", count, "1 to 10")?;
        let samples = spec.samples as f32;
        require((MIN_SAMPLES..=MAX_SAMPLES).contains(&spec.samples), "model.samples", samples, "16 to 1024")?;
        let most = if spec.tier == Tier::Bristle { MAX_BRISTLES } else { MAX_SAMPLES };
        require(spec.samples <= most, "model.samples", samples, "16 to 256 for tier bristle, 16 to 1024 for tier paper")?;
        let cells = [influence::Layout::COARSE.cells, influence::Layout::FINE.cells];
        let known = !matches!(spec.tier, Tier::Influence | Tier::Green) || cells.contains(&spec.samples);
        require(known, "model.samples", samples, "52 or 112 for tiers influence and green")?;
        check_work(spec.work)?;
        require((1..=MAX_SWEEPS).contains(&spec.sweeps), "model.sweeps", spec.sweeps as f32, "1 to 32")?;
        check_law(&spec.force_law)?;
        spec.coupling.check()?;
        spec.guard.check()?;
        Ok(Self {
            mu_s,
            mu_d,
            region_distance: spec.region_distance,
            max_regions: spec.max_regions,
            tier: spec.tier,
            samples: spec.samples,
            // both have been held to their limits, which are far below
            rung: Rung { tier: spec.tier, samples: spec.samples as u16, sweeps: spec.sweeps as u8 },
            breakaway: spec.breakaway,
            force_law: spec.force_law,
            gravity: spec.gravity,
            work: spec.work,
            coupling: spec.coupling,
            guard: spec.guard,
            layout: Layout::new(spec.samples),
            fingerprint: fingerprint(spec, mu_s),
        })
    }

    /// The tier ticks run at.
    pub fn tier(&self) -> Tier {
        self.tier
    }
}

/// FNV-1a over everything that changes a contact wrench.
fn fingerprint(spec: &ParamsSpec, mu_s: f32) -> u32 {
    let numbers = [mu_s, spec.friction_dynamic, spec.region_distance];
    let counts = [spec.samples, spec.sweeps, spec.max_regions].map(|count| count as u32);
    let choices =
        [spec.tier as u32, spec.breakaway as u32, u32::from(spec.gravity), spec.work.unwrap_or(0)].into_iter().chain(counts);
    let law: [f32; FORCE_TABLE_LEN + 2] = core::array::from_fn(|i| match (spec.force_law, i) {
        (ForceLaw::Hertz, _) => 0.0,
        (ForceLaw::Cubic { k1, .. }, 0) => k1,
        (ForceLaw::Cubic { k3, .. }, 1) => k3,
        (ForceLaw::Cubic { .. }, _) => -1.0,
        (ForceLaw::Table { step, .. }, 0) => step,
        (ForceLaw::Table { force, .. }, i) => force[(i - 1).min(FORCE_TABLE_LEN - 1)],
    });
    let words = numbers.into_iter().chain(law).map(f32::to_bits).chain(choices).chain(spec.coupling.words());
    words.flat_map(u32::to_le_bytes).fold(0x811c_9dc5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// Checks a work budget \[instructions\]; `None` is no limit.
///
/// # Errors
/// [`Invalid`] when it is not within [`MIN_WORK`] and [`MAX_WORK`].
pub fn check_work(work: Option<u32>) -> Result<(), Invalid> {
    let asked = work.unwrap_or(MIN_WORK);
    let allowed = "1e4 to 1e9 instructions, or absent for no limit";
    require((MIN_WORK..=MAX_WORK).contains(&asked), "model.work", asked as f32, allowed)
}

fn check_law(law: &ForceLaw) -> Result<(), Invalid> {
    match *law {
        ForceLaw::Hertz => Ok(()),
        ForceLaw::Cubic { k1, k3 } => {
            require(k1 >= 0.0, "model.force_law.k1", k1, "0 or more, N/m")?;
            require(k3 >= 0.0, "model.force_law.k3", k3, "0 or more, N/m^3")
        }
        ForceLaw::Table { step, force } => {
            require(step > 0.0, "model.force_law.step", step, "above 0, m")?;
            require(force[0] == 0.0, "model.force_law.force[0]", force[0], "0 N at depth 0")?;
            force.windows(2).try_for_each(|pair| require(pair[1] >= pair[0], "model.force_law.force", pair[1], "not falling, N"))
        }
    }
}

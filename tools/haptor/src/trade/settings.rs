//! The settings that a trade tries.

use haptor_contact::{ParamsSpec, Tier};

use super::stage::Stage;

/// Tier, samples (or cells), sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Fidelity.
    pub tier: Tier,
    /// Samples of a region, or cells of a fresh contact; nothing to tiers without.
    pub samples: usize,
    /// Sweeps of tiers `influence` and `green`.
    pub sweeps: usize,
}

impl Setting {
    const fn new(tier: Tier, samples: usize, sweeps: usize) -> Self {
        Self { tier, samples, sweeps }
    }

    /// The parameters on a stage.
    pub fn params(&self, stage: &Stage<'_>) -> ParamsSpec {
        stage.params(self.tier, self.samples, self.sweeps)
    }

    /// From `tier samples sweeps`.
    pub fn read(text: &str) -> Option<Self> {
        let [tier, samples, sweeps] = text.split(' ').collect::<Vec<_>>().try_into().ok()?;
        let tier = Tier::ALL.into_iter().find(|known| known.name() == tier)?;
        Some(Self { tier, samples: samples.parse().ok()?, sweeps: sweeps.parse().ok()? })
    }

    /// Whether the tier has cells that are swept.
    pub fn sweeps_cells(&self) -> bool {
        matches!(self.tier, Tier::Influence | Tier::Green)
    }

    /// The keys of `[model]` that say it in a scene file.
    pub fn keys(&self) -> String {
        let mut keys = format!("tier = {:?}", self.tier.name());
        if self.tier != Tier::Point {
            keys += &format!(", samples = {}", self.samples);
        }
        if self.sweeps_cells() {
            keys += &format!(", sweeps = {}", self.sweeps);
        }
        keys
    }

    /// Name in tables, pictures and sentences: `bristle 64`, `influence 52 x 4`.
    pub fn name(&self) -> String {
        let tier = self.tier.name();
        match self.tier {
            Tier::Point => tier.to_owned(),
            Tier::Paper | Tier::Bristle => format!("{tier} {}", self.samples),
            Tier::Influence | Tier::Green => format!("{tier} {} x {}", self.samples, self.sweeps),
        }
    }
}

/// Sweeps of a setting that has none to make: any number will do.
const IDLE: usize = 1;

/// Every setting of the whole sweep.
pub const ALL: [Setting; 20] = [
    Setting::new(Tier::Point, 64, IDLE),
    Setting::new(Tier::Paper, 16, IDLE),
    Setting::new(Tier::Paper, 64, IDLE),
    Setting::new(Tier::Paper, 256, IDLE),
    Setting::new(Tier::Bristle, 16, IDLE),
    Setting::new(Tier::Bristle, 32, IDLE),
    Setting::new(Tier::Bristle, 64, IDLE),
    Setting::new(Tier::Bristle, 128, IDLE),
    Setting::new(Tier::Bristle, 256, IDLE),
    Setting::new(Tier::Influence, 52, 1),
    Setting::new(Tier::Influence, 52, 2),
    Setting::new(Tier::Influence, 52, 4),
    Setting::new(Tier::Influence, 52, 8),
    Setting::new(Tier::Influence, 112, 1),
    Setting::new(Tier::Influence, 112, 2),
    Setting::new(Tier::Influence, 112, 4),
    Setting::new(Tier::Influence, 112, 8),
    Setting::new(Tier::Green, 52, 2),
    Setting::new(Tier::Green, 52, 4),
    Setting::new(Tier::Green, 112, 4),
];

/// Those of a first look.
pub const QUICK: [Setting; 6] = [ALL[0], ALL[2], ALL[4], ALL[6], ALL[11], ALL[15]];

/// Rates of the whole sweep, beside the one that is asked for \[Hz\].
pub const RATES: [f64; 4] = [500.0, 1000.0, 2000.0, 4000.0];

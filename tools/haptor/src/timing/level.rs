//! Levels: the tiers with their samples that a scene can be run at.

use haptor_wire::{BakedScene, Tier, Tuning};

/// Samples of a region where the scene says nothing: bristles, and the paper's.
const SAMPLES: u16 = 64;

/// Cells of a fresh contact where the scene says nothing.
const CELLS: u16 = 52;

/// A tier and its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Fidelity.
    pub tier: Tier,
    /// Samples of a region, or cells.
    pub samples: u16,
    /// Work budget of a tick in place of the scene's \[instructions\].
    pub work: Option<u32>,
}

impl Level {
    /// Every level of a scene: each tier with its default, and the scene's own where that is another. Tier `green` only where the scene has its table.
    pub fn of(scene: &BakedScene) -> Vec<Self> {
        let tiers = [Tier::Point, Tier::Paper, Tier::Bristle, Tier::Influence, Tier::Green];
        let own = Self { tier: scene.tier, samples: scene.samples, work: None };
        let mut levels = Vec::new();
        for tier in tiers.into_iter().filter(|&tier| tier != Tier::Green || scene.tier == Tier::Green) {
            let default = Self { tier, samples: if has_cells(tier) { CELLS } else { SAMPLES }, work: None };
            levels.push(default);
            if tier == own.tier && own != default && tier != Tier::Point {
                levels.push(own);
            }
        }
        levels
    }

    /// Its name: the tier, the samples where it has any, and the budget where it is not the scene's.
    pub fn name(self) -> String {
        let tier = match self.tier {
            Tier::Point => self.tier.name().to_owned(),
            _ => format!("{} {}", self.tier.name(), self.samples),
        };
        self.work.map_or(tier.clone(), |work| format!("{tier} within {work}"))
    }

    /// Its name in a file's.
    pub fn slug(self) -> String {
        self.name().replace(' ', "-")
    }

    /// A tuning at this level.
    pub fn tuning(self, base: &Tuning) -> Tuning {
        Tuning { tier: self.tier, samples: self.samples, work: self.work.or(base.work), ..*base }
    }
}

/// Whether a tier's samples are cells.
pub const fn has_cells(tier: Tier) -> bool {
    matches!(tier, Tier::Influence | Tier::Green)
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_wire::ObjectShape;

    #[test]
    fn the_scenes_own_level_is_among_them() {
        let ball = BakedScene { tier: Tier::Bristle, samples: 128, ..BakedScene::ball_on(ObjectShape::HalfSpace) };
        let names: Vec<_> = Level::of(&ball).into_iter().map(Level::name).collect();
        assert_eq!(names, ["point", "paper 64", "bristle 64", "bristle 128", "influence 52"]);
        let green = BakedScene { tier: Tier::Green, samples: 52, ..ball };
        assert_eq!(Level::of(&green).last().map(|level| level.slug()), Some("green-52".to_owned()));
    }
}

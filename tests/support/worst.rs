//! The dearest inputs of the ready scenes, and the table of what they cost.
//!
//! An input is a trajectory file, `tests/bench/worst/SCENE-LEVEL.csv`; its row in `tests/bench/WORST.md` has the instructions of its dearest tick, and those
//! of the dearest tick of the fixed motions. Needs nothing but the standard library: the test and the developer command that writes the table both include this file.

use std::path::{Path, PathBuf};

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Name of the scene.
    pub scene: String,
    /// Tier, samples where it has any, and a work budget where it has one: "bristle 64 within 300000".
    pub level: String,
    /// Instructions of the dearest tick.
    pub worst: u64,
    /// Instructions of the dearest tick of the fixed motions.
    pub motions: u64,
}

/// Where the inputs lie, from the repository's root.
pub const FOLDER: &str = "tests/bench/worst";

/// Where the table lies; `root` is the repository's.
pub fn table_file(root: &Path) -> PathBuf {
    root.join("tests/bench/WORST.md")
}

impl Kept {
    /// Scene and level.
    pub fn name(&self) -> String {
        format!("{}, {}", self.scene, self.level)
    }

    /// The scene's file, from the repository's root.
    pub fn scene_file(&self) -> String {
        format!("tests/scenes/{}.toml", self.scene)
    }

    /// The input, from the repository's root.
    pub fn input(&self) -> String {
        format!("{FOLDER}/{}-{}.csv", self.scene, self.level.replace(' ', "-"))
    }

    /// The tier's name.
    pub fn tier(&self) -> &str {
        self.level.split(' ').next().unwrap_or_default()
    }

    /// Samples; for a tier without, a number that it takes.
    pub fn samples(&self) -> u16 {
        self.level.split(' ').nth(1).and_then(|samples| samples.parse().ok()).unwrap_or(64)
    }

    /// The work budget, in words as it is in the level.
    pub fn work(&self) -> Option<&str> {
        self.level.split_once(" within ").map(|(_, work)| work)
    }

    /// How programs are told the level.
    pub fn args(&self) -> Vec<String> {
        let level = [("--tier", self.tier().to_owned()), ("--samples", self.samples().to_string())];
        let level = level.into_iter().chain(self.work().map(|work| ("--work", work.to_owned())));
        level.flat_map(|(name, value)| [name.to_owned(), value]).collect()
    }
}

/// Rows `| scene, level | worst | motions |` of a table.
pub fn rows(table: &str) -> Vec<Kept> {
    let row = |line: &str| {
        let fields: Vec<_> = line.strip_prefix('|')?.strip_suffix('|')?.split('|').map(str::trim).collect();
        let [name, worst, motions] = fields[..] else { return None };
        let (scene, level) = name.split_once(", ")?;
        Some(Kept { scene: scene.into(), level: level.into(), worst: worst.parse().ok()?, motions: motions.parse().ok()? })
    };
    table.lines().filter_map(row).collect()
}

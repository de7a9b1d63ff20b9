//! The expected curves of the ready scenes: which there are, how they are thinned, and how a difference is told.
//!
//! The core gives the same bits on every build, so a curve is compared byte by byte. Needs nothing but the standard library: the
//! test and the developer command that accepts new curves both include this file.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Scenes of `tests/scenes`, each with its trajectory: the paper's figures 5, 6, 7, and as many regions as it allows.
pub const SCENES: [&str; 4] = ["cube-twist", "mallet", "compass", "ten-regions"];

/// A tier and the samples it is run with; none: the scene's own.
#[derive(Clone, Copy, Debug)]
pub struct Tier {
    /// Name on the command line.
    pub name: &'static str,
    /// Samples or cells where the scene's 64 are none of its own.
    pub samples: Option<&'static str>,
}

/// Every tier whose curves are kept.
pub const TIERS: [Tier; 4] = [
    Tier { name: "point", samples: None },
    Tier { name: "paper", samples: None },
    Tier { name: "bristle", samples: None },
    Tier { name: "influence", samples: Some("52") },
];

/// Rows of the result per row of the curve: 50 points a second draw the curve, and every tick before a row is in it.
pub const EVERY: usize = 20;

/// Command that makes the present curves the expected ones.
pub const ACCEPT: &str = "cargo xtask golden --accept";

/// Scenes and tiers, each with each.
pub fn all() -> impl Iterator<Item = (&'static str, Tier)> {
    SCENES.into_iter().flat_map(|scene| TIERS.into_iter().map(move |tier| (scene, tier)))
}

/// Where the expected curve lies; `root` is the repository's.
pub fn file(root: &Path, scene: &str, tier: Tier) -> PathBuf {
    root.join("tests/golden/curves").join(format!("{scene}-{}.csv", tier.name))
}

/// The command whose output is the whole result.
pub fn eval(haptor: &Path, root: &Path, scene: &str, tier: Tier) -> Command {
    let mut command = Command::new(haptor);
    command.current_dir(root).arg("eval");
    command.args(["toml", "csv"].map(|kind| format!("tests/scenes/{scene}.{kind}")));
    command.args(["--tier", tier.name]);
    command.args(tier.samples.iter().flat_map(|samples| ["--samples", samples]));
    command
}

/// The header and every [`EVERY`]th row.
pub fn thinned(table: &str) -> String {
    let (header, rows) = table.split_once('\n').unwrap_or((table, ""));
    rows.lines().step_by(EVERY).fold(format!("{header}\n"), |text, row| text + row + "\n")
}

/// What differs between two curves, in words; `None` when they are the same bytes.
pub fn difference(scene: &str, tier: Tier, expected: &str, found: &str) -> Option<String> {
    if expected == found {
        return None;
    }
    let mut text = format!("{scene}, tier {}: ", tier.name);
    let (old, new) = (cells(expected), cells(found));
    if old.first() != new.first() || old.len() != new.len() {
        let counts = (old.len().saturating_sub(1), new.len().saturating_sub(1));
        let _ = write!(text, "{} rows of {:?}, expected {} of {:?}", counts.1, new.first(), counts.0, old.first());
    } else {
        tell(&mut text, &old, &new);
    }
    let _ = write!(text, "; if the physics was meant to change: {ACCEPT}");
    Some(text)
}

/// Rows and their fields, the header first.
fn cells(table: &str) -> Vec<Vec<&str>> {
    table.lines().map(|line| line.split(',').collect()).collect()
}

/// One field that is not what it was.
struct Change<'a> {
    column: &'a str,
    time: &'a str,
    expected: &'a str,
    found: &'a str,
    /// Difference in per cent of the largest magnitude the column is expected to have; `None` for words.
    per_cent: Option<f64>,
}

fn tell(text: &mut String, old: &[Vec<&str>], new: &[Vec<&str>]) {
    let changes = changes(old, new);
    let (Some(first), count) = (changes.first(), changes.len()) else { return };
    let share = |change: &Change<'_>| change.per_cent.map_or(String::new(), |p| format!(" ({p:.3} % of the column's peak)"));
    let Change { column, time, expected, found, .. } = first;
    let _ = write!(text, "first at t = {time}: {column} is {found}, expected {expected}{}", share(first));
    let size = |change: &Change<'_>| change.per_cent.unwrap_or(0.0);
    if let Some(worst) = changes.iter().filter(|c| c.per_cent.is_some()).max_by(|a, b| size(a).total_cmp(&size(b))) {
        let _ = write!(text, "; largest at t = {}: {}{}", worst.time, worst.column, share(worst));
    }
    let _ = write!(text, "; {count} fields differ");
}

/// Every field that changed, row by row; both tables have one header and as many rows.
fn changes<'a>(old: &[Vec<&'a str>], new: &[Vec<&'a str>]) -> Vec<Change<'a>> {
    let Some((header, rows)) = old.split_first() else { return Vec::new() };
    let number = |row: &[&str], column: usize| row.get(column).and_then(|field| field.parse::<f64>().ok());
    let peak = |column| rows.iter().filter_map(|row| number(row, column)).fold(0.0_f64, |peak, value| peak.max(value.abs()));
    let mut changes = Vec::new();
    for (was, is) in rows.iter().zip(&new[1..]) {
        for (column, name) in header.iter().enumerate() {
            let (Some(&expected), Some(&found)) = (was.get(column), is.get(column)) else { continue };
            if expected == found {
                continue;
            }
            let both = number(was, column).zip(number(is, column));
            let per_cent = both.map(|(a, b)| 100.0 * (b - a).abs() / peak(column).max(f64::MIN_POSITIVE));
            changes.push(Change { column: name, time: was[0], expected, found, per_cent });
        }
    }
    changes
}

//! Runs paths through the patch and writes what came out, as JSON that does not depend on date or machine.

use super::led::{Answer, Led, Pose};
use super::paths::Path;
use super::profile::Profile;
use serde::Serialize;

/// Digits kept in tables, so that the last bits of a platform's arithmetic do not show.
const DECIMALS: f64 = 1e5;

/// Steps solved per row written: the direction of slip turns within a row, and four steps bring what that costs
/// from 4 % of mu P (one step, tightest circle) to below 1 %.
pub const SUBSTEPS: usize = 4;

/// One path with its answers, one row per `SUBSTEPS` steps.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Path name.
    pub name: &'static str,
    /// `straight` or `turning`.
    pub kind: &'static str,
    /// Shift along x and y in s0, angle in phi0.
    pub pose: Vec<Pose>,
    /// Force on the patch in mu P (x, y), torque in T_max.
    pub answer: Vec<Answer>,
}

/// Everything one run writes.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    /// What the numbers mean.
    pub note: &'static str,
    /// Pressure profile: `hertz`, `cone` or `punch`.
    pub profile: &'static str,
    /// Number of square cells on the patch.
    pub cells: usize,
    /// Rows per path.
    pub rows: usize,
    /// Steps solved per row; each was iterated to convergence.
    pub substeps: usize,
    /// Steps that did not converge; zero in a good table.
    pub unconverged: usize,
    /// The paths.
    pub paths: Vec<Row>,
}

/// What a table's numbers mean, written into it.
const NOTE: &str = "Half-space boundary elements, nu 0.5, Coulomb friction iterated at each step. \
pose: shift x, y in s0 = 3 mu P (2-nu)/(16 a G), angle in phi0 = 9 pi mu P/(256 G a^2). answer: Q_x, Q_y in mu P, \
T in the profile's T_max, that the object feels (the probe feels the opposite). Written by the binary `reference`.";

/// Runs `paths` on a patch of `across` cells over the diameter, pressed by `profile`, and keeps `rows` rows of each.
#[must_use]
pub fn run(paths: &[Path], profile: Profile, across: usize, rows: usize, progress: &mut dyn FnMut(&str)) -> Table {
    let fresh = Led::new(across, profile);
    let mut table = Table {
        note: NOTE,
        profile: profile.name(),
        cells: fresh.cells(),
        rows,
        substeps: SUBSTEPS,
        unconverged: 0,
        paths: Vec::new(),
    };
    for path in paths {
        let mut patch = fresh.clone();
        table.paths.push(follow(path, &mut patch, rows));
        table.unconverged += patch.unconverged();
        progress(&format!("{} {} sweeps", path.name, patch.sweeps()));
    }
    table
}

/// Leads `patch` along `path` and keeps every `SUBSTEPS`th pose and answer.
fn follow(path: &Path, patch: &mut Led, rows: usize) -> Row {
    let mut row =
        Row { name: path.name, kind: if path.turning { "turning" } else { "straight" }, pose: Vec::new(), answer: Vec::new() };
    for steps in path.poses(rows * SUBSTEPS).chunks(SUBSTEPS) {
        let answers: Vec<Answer> = steps.iter().map(|p| patch.step(*p)).collect();
        row.pose.extend(steps.last().map(|p| p.map(rounded)));
        row.answer.extend(answers.last().map(|a| a.map(rounded)));
    }
    row
}

pub(super) fn rounded(x: f64) -> f64 {
    let kept = (x * DECIMALS).round() / DECIMALS;
    // minus zero prints differently from zero
    if kept == 0.0 { 0.0 } else { kept }
}

#[cfg(test)]
mod tests {
    use super::super::paths::named;
    use super::*;

    /// Combined shift and twist, solved elsewhere with 1528 cells in 24 steps: path, step, Q over mu P, T over T_max.
    const KNOWN: &[(&str, usize, f64, f64)] = &[
        ("mix_q1f1", 6, 0.8045, 0.3382),
        ("mix_q1f1", 12, 0.9608, 0.2139),
        ("mix_q1f1", 24, 0.9713, 0.1830),
        ("mix_q2f1", 6, 0.8583, 0.1685),
        ("mix_q2f1", 12, 0.9908, 0.1032),
        ("mix_q2f1", 24, 0.9930, 0.0899),
        ("mix_q1f2", 6, 0.4279, 0.5636),
        ("mix_q1f2", 12, 0.6464, 0.6315),
        ("mix_q1f2", 24, 0.7926, 0.5116),
        ("mix_q1f4", 6, 0.2162, 0.6308),
        ("mix_q1f4", 12, 0.3345, 0.8251),
        ("mix_q1f4", 24, 0.4344, 0.8568),
    ];

    #[test]
    fn combined_paths_meet_an_independent_solution() {
        // 112 cells stay within 1 %
        let mut worst: f64 = 0.0;
        for chunk in KNOWN.chunk_by(|a, b| a.0 == b.0) {
            let path = *named(chunk[0].0).expect("a path of this name exists");
            let table = run(&[path], Profile::Hertz, 12, 24, &mut |_| ());
            assert_eq!(table.unconverged, 0);
            for (_, step, force, torque) in chunk {
                let got = table.paths[0].answer[step - 1];
                worst = worst.max((got[0] - force).abs()).max((got[2] - torque).abs());
            }
        }
        assert!(worst < 0.01, "{worst}");
    }
}

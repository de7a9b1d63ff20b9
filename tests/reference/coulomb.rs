//! Coulomb friction on the patch, step by step, each step iterated until it holds.
//!
//! At the end of a step every cell obeys: traction within its limit; if it is below the limit the cell did not slip
//! during the step; if it slipped, it slipped along its traction. Slip = rigid displacement - elastic displacement. This is a
//! convex problem with one answer; projected Gauss-Seidel with over-relaxation finds it cell by cell, because a square cell's own influence
//! is the same in every direction.

use super::half_space::{Grid, Matrix};
use super::profile::{ANGLE_UNIT, Profile, SHIFT_UNIT};

/// Over-relaxation of the sweeps; 1 would be plain Gauss-Seidel, 2 the limit of convergence.
const RELAXATION: f64 = 1.35;
/// A step is done when a sweep moves less force than this, in mu P, summed over the cells.
const TOLERANCE: f64 = 1e-6;
/// More sweeps than any path here needs (about 100); reaching it is counted, never silent.
const SWEEPS_MAX: usize = 4000;

/// Where the probe is: shift in s0, angle in phi0.
pub type Pose = [f64; 3];

/// What the patch answers, as force in mu P and torque in T_max of the profile: (Q_x, Q_y, T).
pub type Answer = [f64; 3];

/// A patch with its stick state.
#[derive(Debug, Clone)]
pub struct Patch {
    grid: Grid,
    matrix: Matrix,
    caps: Vec<f64>,
    torque_limit: f64,
    pose: Pose,
    qx: Vec<f64>,
    qy: Vec<f64>,
    /// Tractions at the end of the step before, whose change is the next step's first guess.
    before: (Vec<f64>, Vec<f64>),
    /// Steps that ended on `SWEEPS_MAX`; zero in every committed table.
    pub unconverged: usize,
    /// Sweeps spent so far.
    pub sweeps: usize,
}

impl Patch {
    /// A patch of `across` cells over its diameter, free of traction, at the origin.
    #[must_use]
    pub fn new(across: usize, profile: Profile) -> Self {
        let grid = Grid::new(across);
        let matrix = Matrix::new(&grid);
        let caps = profile.caps(&grid);
        let zero = vec![0.0; grid.centres.len()];
        Self {
            caps,
            matrix,
            torque_limit: profile.torque_limit(),
            pose: [0.0; 3],
            qx: zero.clone(),
            qy: zero.clone(),
            before: (zero.clone(), zero),
            grid,
            unconverged: 0,
            sweeps: 0,
        }
    }

    /// Presses a sphere's contact to `radius` <= 1 of the full one; its load goes as the cube. The next step is solved under it. Cells that
    /// leave the contact lose their traction, cells that enter do so free of traction, where they are.
    pub fn press(&mut self, radius: f64) {
        self.caps = Profile::Hertz.caps_of(&self.grid, radius, radius.powi(3));
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.caps.len()
    }

    /// Moves the probe to `pose` in one step and returns the answer there.
    pub fn step(&mut self, pose: Pose) -> Answer {
        let target = self.targets(pose);
        self.guess();
        let mut done = false;
        for _ in 0..SWEEPS_MAX {
            self.sweeps += 1;
            if self.sweep(&target) < TOLERANCE {
                done = true;
                break;
            }
        }
        self.unconverged += usize::from(!done);
        self.pose = pose;
        self.answer()
    }

    /// Displacement each cell would need in order not to slip in this step: its present one plus the rigid motion.
    fn targets(&self, pose: Pose) -> Vec<[f64; 2]> {
        let shift = [0, 1].map(|k| (pose[k] - self.pose[k]) * SHIFT_UNIT);
        let turn = (pose[2] - self.pose[2]) * ANGLE_UNIT;
        let rows = self.grid.centres.iter().enumerate();
        rows.map(|(i, [x, y])| {
            let now = self.matrix.displacement(i, &self.qx, &self.qy);
            [now[0] + shift[0] - turn * y, now[1] + shift[1] + turn * x]
        })
        .collect()
    }

    /// Starts the step from the previous step's change, kept within the limits.
    fn guess(&mut self) {
        for i in 0..self.cells() {
            let old = [self.qx[i], self.qy[i]];
            let next = [2.0 * old[0] - self.before.0[i], 2.0 * old[1] - self.before.1[i]];
            let [x, y] = within(next, self.caps[i]);
            (self.before.0[i], self.before.1[i]) = (old[0], old[1]);
            (self.qx[i], self.qy[i]) = (x, y);
        }
    }

    /// One pass over the cells; returns the force it moved.
    fn sweep(&mut self, target: &[[f64; 2]]) -> f64 {
        let mut moved = 0.0;
        for (i, want) in target.iter().enumerate() {
            let now = self.matrix.displacement(i, &self.qx, &self.qy);
            let gain = RELAXATION / self.matrix.xx[i * self.matrix.cells + i];
            let trial = [self.qx[i] + gain * (want[0] - now[0]), self.qy[i] + gain * (want[1] - now[1])];
            let [x, y] = within(trial, self.caps[i]);
            moved += (x - self.qx[i]).hypot(y - self.qy[i]);
            (self.qx[i], self.qy[i]) = (x, y);
        }
        moved * self.grid.edge * self.grid.edge
    }

    /// Sums the tractions.
    #[must_use]
    pub fn answer(&self) -> Answer {
        let area = self.grid.edge * self.grid.edge;
        let mut sum = [0.0; 3];
        for (i, [x, y]) in self.grid.centres.iter().enumerate() {
            sum[0] += area * self.qx[i];
            sum[1] += area * self.qy[i];
            sum[2] += area * (x * self.qy[i] - y * self.qx[i]) / self.torque_limit;
        }
        sum
    }
}

/// The vector shortened to `cap` where it is longer.
fn within(v: [f64; 2], cap: f64) -> [f64; 2] {
    let length = v[0].hypot(v[1]);
    if length <= cap { v } else { v.map(|c| c * cap / length) }
}

#[cfg(test)]
mod tests {
    use super::super::profile::{cattaneo, lubkin};
    use super::*;

    /// Cells over the diameter in these tests: 112 cells.
    const ACROSS: usize = 12;

    #[test]
    fn small_motions_meet_mindlin_and_reissner_sagoci() {
        // K_t = 8 G a/(2 - nu): one s0 of stuck shift would give 1.5 mu P. A coarse grid resolves the punch's steep rim to 3 %.
        let pulled = Patch::new(ACROSS, Profile::Punch).step([0.01, 0.0, 0.0])[0];
        assert!((pulled / 0.015 - 1.0).abs() < 0.03, "{pulled}");
        // K_theta = 16/3 G a^3: one phi0 of stuck twist would give the Hertz T_max
        let twisted = Patch::new(ACROSS, Profile::Punch).step([0.0, 0.0, 0.01])[2];
        let want = 0.01 * Profile::Hertz.torque_limit() / Profile::Punch.torque_limit();
        assert!((twisted / want - 1.0).abs() < 0.05, "{twisted} {want}");
    }

    #[test]
    fn drag_meets_cattaneo_and_twist_meets_lubkin() {
        let mut drag = Patch::new(ACROSS, Profile::Hertz);
        let mut twist = Patch::new(ACROSS, Profile::Hertz);
        for i in 1..=12 {
            let s = 0.1 * f64::from(i);
            assert!((drag.step([s, 0.0, 0.0])[0] - cattaneo(s)).abs() < 0.01, "s {s}");
            let x = 0.3 * f64::from(i);
            assert!((twist.step([0.0, 0.0, x])[2] - lubkin(x)).abs() < 0.01, "x {x}");
        }
        assert_eq!(drag.unconverged + twist.unconverged, 0);
    }

    #[test]
    fn standing_still_changes_nothing() {
        let mut patch = Patch::new(ACROSS, Profile::Hertz);
        let loaded = patch.step([0.4, 0.2, 0.5]);
        for _ in 0..5 {
            let held = patch.step([0.4, 0.2, 0.5]);
            assert!((0..3).all(|k| (held[k] - loaded[k]).abs() < 1e-4));
        }
    }
}

//! A probe on an elastic half space, patch by patch, led step by step: pressure, stick, slip and spin with memory.
//!
//! At the end of a step every cell of a patch obeys: pressure where bodies touch, a gap where they do not; traction within mu times the pressure;
//! below that limit the cell did not slip during the step; if it slipped, it slipped along its traction. Slip = rigid motion - elastic
//! displacement. Projected Gauss-Seidel with over-relaxation finds this state cell by cell, because a square cell's own
//! influence is the same in every direction. For nu = 0.5 pressure and friction do not disturb each other; below, both are solved in turn until
//! neither changes, and the displacement that a growing pressure causes along the surface counts as motion.
//!
//! Several patches feel each other and the body they sit on through [`Ground`], a compliance between their resultants.

use crate::kernel::{Kernels, Solid, influence};
use crate::lattice::Lattice;

/// Over-relaxation of the sweeps; 1 would be plain Gauss-Seidel, 2 the limit of convergence.
const RELAXATION: f64 = 1.35;
/// A step is done when a sweep moves less force than this, in mu P (tractions) or P (pressure), summed over the cells.
pub const TOLERANCE: f64 = 1e-6;
/// More sweeps than any history needs (about 100); reaching it is counted, never silent.
const SWEEPS_MAX: usize = 4000;
/// Turns of pressure and friction about each other; each takes a factor of ten or more off the rest.
const TURNS_MAX: usize = 40;
/// Cells of less than this of the mean pressure's share count as apart.
const TOUCHING: f64 = 1e-12;

/// Rigid motion of the probe over a patch: along x, along y, turn about the normal.
pub type Motion = [f64; 3];

/// What a patch's friction holds: force along x and y, torque about the normal through the patch's middle.
pub type Grip = [f64; 3];

/// How resultants of all patches move the ground under each, beyond the half space under the patch itself.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Of `3 K x 3 K`, row by row: motion (x, y, turn) of patch i by grip (x, y, torque) of patch j. Symmetric, not negative.
    pub level: Vec<f64>,
    /// Of `K x K`: sinking of patch i by the load of patch j.
    pub normal: Vec<f64>,
}

impl Ground {
    /// Firm ground under `patches` patches that do not feel each other.
    #[must_use]
    pub fn firm(patches: usize) -> Self {
        Self { level: vec![0.0; 9 * patches * patches], normal: vec![0.0; patches * patches] }
    }
}

/// One patch: cells, and what each of them carries.
#[derive(Clone, Debug)]
pub struct Patch {
    lattice: Lattice,
    kernels: Kernels,
    /// Distance of the undeformed bodies at each cell when the probe just touches; empty when the pressure is given.
    separation: Vec<f64>,
    pressure: Vec<f64>,
    traction: [Vec<f64>; 2],
    /// Tractions at the end of the step before, whose change is the next step's first guess.
    before: [Vec<f64>; 2],
    /// Level displacement of every cell when friction was last solved.
    held: Vec<[f64; 2]>,
    /// Level displacement at which a cell would not have slipped in the present step.
    wanted: Vec<[f64; 2]>,
    /// The part of the level displacement that pressure makes.
    pressed: Vec<[f64; 2]>,
}

impl Patch {
    /// A patch whose pressure will be given.
    #[must_use]
    pub fn new(solid: Solid, lattice: Lattice) -> Self {
        let blank = vec![0.0; lattice.len()];
        Self {
            lattice,
            kernels: Kernels::new(solid, lattice),
            separation: Vec::new(),
            pressure: blank.clone(),
            traction: [blank.clone(), blank.clone()],
            before: [blank.clone(), blank],
            held: vec![[0.0; 2]; lattice.len()],
            wanted: vec![[0.0; 2]; lattice.len()],
            pressed: vec![[0.0; 2]; lattice.len()],
        }
    }

    /// A patch whose pressure comes from the gap: `separation(x, y)` is the distance of the undeformed bodies over (x, y) when they just touch.
    #[must_use]
    pub fn of_gap(solid: Solid, lattice: Lattice, separation: impl Fn(f64, f64) -> f64) -> Self {
        let mut patch = Self::new(solid, lattice);
        patch.separation = vec![f64::INFINITY; lattice.len()];
        lattice.cells().for_each(|(index, [x, y])| patch.separation[index] = separation(x, y));
        patch
    }

    /// Its cells.
    #[must_use]
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Mean pressure of every cell.
    #[must_use]
    pub fn pressure(&self) -> &[f64] {
        &self.pressure
    }

    /// Normal load.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.pressure.iter().sum::<f64>() * self.lattice.area()
    }

    /// Cells that touch.
    #[must_use]
    pub fn touching(&self) -> usize {
        let least = TOUCHING * self.pressure.iter().fold(0.0_f64, |most, p| most.max(*p));
        self.pressure.iter().filter(|p| **p > least).count()
    }

    /// Radius of the disc that has the second moment of the load, were its pressure Hertz's: <r^2> = 2/5 a^2. It converges faster than the
    /// number of cells that touch, which changes by whole cells.
    #[must_use]
    pub fn radius(&self) -> f64 {
        let moment: f64 = self.lattice.cells().map(|(index, [x, y])| self.pressure[index] * (x * x + y * y)).sum();
        (2.5 * moment * self.lattice.area() / self.load()).sqrt()
    }

    /// Torque of friction when every cell slips about the patch's middle, per mu.
    #[must_use]
    pub fn full_slip_torque(&self) -> f64 {
        self.lattice.cells().map(|(index, [x, y])| self.pressure[index] * x.hypot(y)).sum::<f64>() * self.lattice.area()
    }

    /// Resultant of the tractions.
    #[must_use]
    pub fn grip(&self) -> Grip {
        let area = self.lattice.area();
        let [qx, qy] = &self.traction;
        self.lattice.cells().fold([0.0; 3], |[x, y, turn], (index, [cx, cy])| {
            [x + area * qx[index], y + area * qy[index], turn + area * (cx * qy[index] - cy * qx[index])]
        })
    }

    /// Displacement (x, y, into the body) of the half space at (x, y) of this patch, anywhere on the surface, under its pressure and tractions.
    #[must_use]
    pub fn displacement(&self, solid: Solid, [x, y]: [f64; 2]) -> [f64; 3] {
        let ([qx, qy], p) = (&self.traction, &self.pressure);
        let mut sum = [0.0; 3];
        for (index, [cx, cy]) in
            self.lattice.cells().filter(|&(index, _)| p[index] != 0.0 || qx[index] != 0.0 || qy[index] != 0.0)
        {
            let k = influence(solid, [x - cx, y - cy], self.lattice.edge);
            sum[0] += k.xx * qx[index] + k.xy * qy[index] + k.xz * p[index];
            sum[1] += k.xy * qx[index] + k.yy * qy[index] + k.yz * p[index];
            sum[2] += k.zz * p[index] - k.xz * qx[index] - k.yz * qy[index];
        }
        sum
    }

    fn slices(&self) -> [&[f64]; 2] {
        [&self.traction[0], &self.traction[1]]
    }
}

/// Patches under one probe, with their stick state.
#[derive(Clone, Debug)]
pub struct Contact {
    solid: Solid,
    friction: f64,
    patches: Vec<Patch>,
    ground: Ground,
    /// Whether pressure and friction disturb each other.
    coupled: bool,
    /// Steps that ended on a limit of sweeps; zero in every committed table.
    pub unconverged: usize,
    /// Sweeps of friction spent so far.
    pub sweeps: usize,
}

impl Contact {
    /// Patches at rest and free of traction; Coulomb friction `friction`.
    ///
    /// # Panics
    /// If the ground is of another number of patches.
    #[must_use]
    pub fn new(solid: Solid, friction: f64, patches: Vec<Patch>, ground: Ground) -> Self {
        let count = patches.len();
        let fits = ground.level.len() == 9 * count * count && ground.normal.len() == count * count;
        assert!(fits, "ground of {} and {} numbers for {count} patches", ground.level.len(), ground.normal.len());
        Self { solid, friction, patches, ground, coupled: solid.poisson_ratio < 0.5, unconverged: 0, sweeps: 0 }
    }

    /// The same with the mutual disturbance of pressure and friction left out, as most theories do.
    #[must_use]
    pub fn uncoupled(mut self) -> Self {
        self.coupled = false;
        self
    }

    /// The patches.
    #[must_use]
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// Gives patch `index` its pressure, over its lattice. Cells that lose it lose their traction with the next step; new ones enter free of
    /// traction where they are.
    ///
    /// # Panics
    /// If there is no such patch or the field is not of its lattice.
    pub fn set_pressure(&mut self, index: usize, pressure: Vec<f64>) {
        assert_eq!(pressure.len(), self.patches[index].pressure.len(), "a field over another lattice");
        self.patches[index].pressure = pressure;
    }

    /// Presses every patch to its depth, then moves the probe by `motions` since the last step, and solves for where that ends.
    pub fn advance(&mut self, depths: &[f64], motions: &[Motion]) {
        self.aim(motions);
        self.press(depths);
        self.guess();
        self.slide();
        if self.coupled {
            let mut turns = 0;
            while self.press(depths) + self.slide() > 2 {
                turns += 1;
                if turns == TURNS_MAX {
                    self.unconverged += 1;
                    break;
                }
            }
        }
        self.hold();
    }

    /// Moves the probe by `motions` since the last step, under the pressure as it is.
    pub fn drag(&mut self, motions: &[Motion]) {
        self.aim(motions);
        self.guess();
        self.slide();
        self.hold();
    }

    /// Solves the gaps for depths without moving the probe along the surface; returns the sweeps it took.
    pub fn press(&mut self, depths: &[f64]) -> usize {
        assert_eq!(depths.len(), self.patches.len(), "a depth per patch");
        let sunk: Vec<Vec<f64>> = self.patches.iter().map(|patch| self.sunk_by_friction(patch)).collect();
        for sweep in 1..=SWEEPS_MAX {
            let moved = self.sweep_pressure(depths, &sunk);
            if moved <= TOLERANCE * self.load() {
                return sweep;
            }
        }
        self.unconverged += 1;
        SWEEPS_MAX
    }

    /// Normal load of all patches.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.patches.iter().map(Patch::load).sum()
    }

    /// The law's rest after a step: force that one plain pass over the cells would still move, in mu P.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.clone().sweep_friction(1.0) / (self.friction * self.load())
    }

    fn sunk_by_friction(&self, patch: &Patch) -> Vec<f64> {
        let mut sunk = vec![0.0; patch.lattice.len()];
        if self.coupled {
            patch.lattice.cells().for_each(|(index, _)| sunk[index] = patch.kernels.sunk_by_tractions(index, patch.slices()));
        }
        sunk
    }

    /// One pass of the gaps; returns the force it moved.
    fn sweep_pressure(&mut self, depths: &[f64], sunk: &[Vec<f64>]) -> f64 {
        let count = self.patches.len();
        let mut loads: Vec<f64> = self.patches.iter().map(Patch::load).collect();
        let mut moved = 0.0;
        for at in 0..count {
            let row = &self.ground.normal[at * count..(at + 1) * count];
            let patch = &mut self.patches[at];
            let (area, lattice) = (patch.lattice.area(), patch.lattice);
            let own = patch.kernels.own().zz + row[at] * area;
            for (index, _) in lattice.cells() {
                if patch.separation[index] > depths[at] && patch.pressure[index] == 0.0 {
                    continue;
                }
                let ground: f64 = row.iter().zip(&loads).map(|(c, load)| c * load).sum();
                let now = patch.kernels.sunk(index, &patch.pressure) + sunk[at][index] + ground;
                let wanted = depths[at] - patch.separation[index];
                let next = (patch.pressure[index] + RELAXATION * (wanted - now) / own).max(0.0);
                let change = area * (next - patch.pressure[index]);
                patch.pressure[index] = next;
                loads[at] += change;
                moved += change.abs();
            }
        }
        moved
    }

    /// Notes the displacement each cell would need in order not to slip in this step: that of the last step plus the rigid motion.
    fn aim(&mut self, motions: &[Motion]) {
        assert_eq!(motions.len(), self.patches.len(), "a motion per patch");
        for (patch, [x, y, turn]) in self.patches.iter_mut().zip(motions) {
            for (index, [cx, cy]) in patch.lattice.cells() {
                let [held_x, held_y] = patch.held[index];
                patch.wanted[index] = [held_x + x - turn * cy, held_y + y + turn * cx];
            }
        }
    }

    /// Starts a step from the previous step's change, kept within the limits.
    fn guess(&mut self) {
        for patch in &mut self.patches {
            for (index, _) in patch.lattice.cells() {
                let old = [patch.traction[0][index], patch.traction[1][index]];
                let next = [0, 1].map(|k| 2.0 * old[k] - patch.before[k][index]);
                let kept = within(next, self.friction * patch.pressure[index]);
                for k in 0..2 {
                    patch.before[k][index] = old[k];
                    patch.traction[k][index] = kept[k];
                }
            }
        }
    }

    /// Sweeps until the law holds; returns the sweeps it took.
    fn slide(&mut self) -> usize {
        if self.coupled {
            for patch in &mut self.patches {
                let lattice = patch.lattice;
                lattice.cells().for_each(|(at, _)| patch.pressed[at] = patch.kernels.level_of_pressure(at, &patch.pressure));
            }
        }
        let enough = TOLERANCE * self.friction * self.load();
        for sweep in 1..=SWEEPS_MAX {
            self.sweeps += 1;
            if self.sweep_friction(RELAXATION) <= enough {
                return sweep;
            }
        }
        self.unconverged += 1;
        SWEEPS_MAX
    }

    /// One pass of friction over the cells; returns the force it moved.
    fn sweep_friction(&mut self, relaxation: f64) -> f64 {
        let mut ground = self.ground_motion();
        let width = ground.len();
        let mut moved = 0.0;
        for (at, patch) in self.patches.iter_mut().enumerate() {
            let (area, lattice) = (patch.lattice.area(), patch.lattice);
            let own = |k: usize| self.ground.level[(3 * at + k) * width + 3 * at + k];
            let (own_shift, own_turn) = (own(0).max(own(1)), own(2));
            for (index, [cx, cy]) in lattice.cells() {
                let cap = self.friction * patch.pressure[index];
                let old = [patch.traction[0][index], patch.traction[1][index]];
                if cap == 0.0 && old == [0.0; 2] {
                    continue;
                }
                let [ux, uy] = patch.kernels.level(index, patch.slices());
                let [gx, gy, turn] = [0, 1, 2].map(|k| ground[3 * at + k]);
                let [tx, ty] = [0, 1].map(|k| patch.wanted[index][k] - patch.pressed[index][k]);
                let rest = [tx - ux - gx + turn * cy, ty - uy - gy - turn * cx];
                let gain = relaxation / (patch.kernels.own().xx + area * (own_shift + own_turn * (cx * cx + cy * cy)));
                let next = within([0, 1].map(|k| old[k] + gain * rest[k]), cap);
                let [dx, dy] = [0, 1].map(|k| area * (next[k] - old[k]));
                (patch.traction[0][index], patch.traction[1][index]) = (next[0], next[1]);
                let change = [dx, dy, cx * dy - cy * dx];
                for (motion, row) in ground.iter_mut().zip(self.ground.level.chunks_exact(width)) {
                    *motion += (0..3).map(|k| row[3 * at + k] * change[k]).sum::<f64>();
                }
                moved += dx.hypot(dy);
            }
        }
        moved
    }

    /// Motion of the ground under every patch by all grips.
    #[must_use]
    pub fn ground_motion(&self) -> Vec<f64> {
        let grips: Vec<f64> = self.patches.iter().flat_map(Patch::grip).collect();
        self.ground.level.chunks_exact(grips.len()).map(|row| row.iter().zip(&grips).map(|(c, r)| c * r).sum()).collect()
    }

    /// Remembers where every cell is now.
    fn hold(&mut self) {
        let ground = self.ground_motion();
        for (patch, motion) in self.patches.iter_mut().zip(ground.chunks_exact(3)) {
            for (index, [cx, cy]) in patch.lattice.cells() {
                let ([x, y], [px, py]) = (patch.kernels.level(index, patch.slices()), patch.pressed[index]);
                patch.held[index] = [x + px + motion[0] - motion[2] * cy, y + py + motion[1] + motion[2] * cx];
            }
        }
    }

    /// Elastic constants.
    #[must_use]
    pub fn solid(&self) -> Solid {
        self.solid
    }
}

/// The vector shortened to `cap` where it is longer.
fn within(v: [f64; 2], cap: f64) -> [f64; 2] {
    let length = v[0].hypot(v[1]);
    if length <= cap { v } else { v.map(|c| c * cap / length) }
}

//! The sweeps: block Gauss-Seidel over the cells with Coulomb's cap, spreading every change to all cells at once.
//!
//! Each cell lacks a displacement: the shift of this tick less what the changes of all tractions have moved the surface there. Visiting
//! a cell, its traction changes so that the lack vanishes, but not beyond the cap; the change then moves every other cell. A cell's own
//! influence is the same in every direction, so that the cut to the cap is the exact answer of the cell's own friction problem.

use glam::Vec2;

use crate::math::{PI, clamp, max, min, root};
use crate::patch::{Grip, Shift};
use crate::tier::Hold;
use crate::tier::bristle::Bristle;
use crate::tier::influence::cells::Cells;
use crate::tier::influence::grid::{Grid, Layout};
use crate::tier::influence::kernel::Kernel;
use crate::tier::influence::{Elastic, Stored, Trace};

/// Part of the way to a cell's own answer that a visit goes. The whole way is too far: the cells not yet visited will take over most of the
/// shift, and what the cap cut off meanwhile turns sliding cells too much. Fitted on straight and turning paths.
const RELAXATION: f32 = 0.4;

/// Most times the last tick's changes are repeated: beyond it a hand's next step has little to do with its last.
const MOST_LIKE: f32 = 2.0;

/// Components of a vector per cell, apart so that rows are read and written in one go.
type Plane<const W: usize> = [[f32; W]; W];

/// A patch being solved.
#[derive(Debug)]
struct Work<'a, const W: usize> {
    hold: &'a Hold,
    elastic: &'a Elastic,
    kernel: Kernel<W>,
    cells: Cells<W>,
    /// Width of a cell \[m\].
    width: f32,
    /// Displacement per force of the kernel's unit \[m/N\].
    scale: f32,
    /// Stiffness by which a slip is told from what the cap cut off \[N/m\].
    slope: f32,
    /// Forces \[N\] and lacks \[m\].
    force: (Plane<W>, Plane<W>),
    lack: (Plane<W>, Plane<W>),
    slipped: Plane<W>,
    /// What body and correction have yielded since the tick began.
    yielded: Shift,
}

/// Shifts the patch by `wanted` and returns its new grip; `W` cells square about the centre is what is looked at of the grid.
pub fn shift<const W: usize>(
    hold: &Hold,
    elastic: &Elastic,
    layout: &Layout,
    grid: &Grid,
    sweeps: usize,
    wanted: Shift,
    stored: &mut Stored<'_>,
) -> Grip {
    let mut work = Work::<W>::new(hold, elastic, grid);
    work.load(layout, wanted, stored);
    work.guess(layout, likeness(&grid.wanted, &wanted, hold.radius), stored);
    for sweep in 0..sweeps {
        for k in 0..W * W {
            // to and fro, so that no side of the patch is always first
            let k = if sweep % 2 == 0 { k } else { W * W - 1 - k };
            work.visit(k / W, k % W);
        }
    }
    work.store(layout, stored)
}

/// How many times the last shift this one is, as far as it goes the same way; displacements are compared at the rim of radius `a`.
fn likeness(last: &Shift, now: &Shift, a: f32) -> f32 {
    let size = last.drag.length_squared() + last.twist * last.twist * a * a;
    let same = now.drag.dot(last.drag) + now.twist * last.twist * a * a;
    if size > 0.0 { clamp(same / size, -MOST_LIKE, MOST_LIKE) } else { 0.0 }
}

impl<'a, const W: usize> Work<'a, W> {
    fn new(hold: &'a Hold, elastic: &'a Elastic, grid: &Grid) -> Self {
        let cells = Cells::<W>::new(hold, grid.width);
        let share = grid.width * grid.width / (PI * hold.radius * hold.radius);
        Self {
            hold,
            elastic,
            kernel: Kernel::new(elastic.poisson_ratio),
            cells,
            width: grid.width,
            scale: 1.0 / (2.0 * PI * elastic.shear_modulus * grid.width),
            slope: hold.drag_stiffness * share,
            force: ([[0.0; W]; W], [[0.0; W]; W]),
            lack: ([[0.0; W]; W], [[0.0; W]; W]),
            slipped: [[0.0; W]; W],
            yielded: Shift::default(),
        }
    }

    /// Takes the cells from the state and adds this tick's shift to what they lack.
    fn load(&mut self, layout: &Layout, wanted: Shift, stored: &Stored<'_>) {
        for row in 0..W {
            for column in 0..W {
                let Some((cell, trace)) = kept::<W>(layout, stored, row, column) else { continue };
                let lack = trace.lack + wanted.drag + self.arm(row, column).perp() * wanted.twist;
                (self.force.0[row][column], self.force.1[row][column]) = (cell.force.x, cell.force.y);
                (self.lack.0[row][column], self.lack.1[row][column]) = (lack.x, lack.y);
                self.slipped[row][column] = cell.slipped;
            }
        }
    }

    /// Repeats the changes of the last tick `times`: most motions go on as they went.
    fn guess(&mut self, layout: &Layout, times: f32, stored: &Stored<'_>) {
        if times == 0.0 {
            return;
        }
        for row in 0..W {
            for column in 0..W {
                if let Some((_, trace)) = kept::<W>(layout, stored, row, column) {
                    self.change(row, column, trace.change * times);
                }
            }
        }
    }

    /// Arm of a cell's force about the centre \[m\].
    fn arm(&self, row: usize, column: usize) -> Vec2 {
        let at = |k: usize| (k as f32 + 0.5 - 0.5 * W as f32) * self.width * self.cells.arm;
        Vec2::new(at(column), at(row))
    }

    /// What a cell lacks after all have yielded together.
    fn lack_at(&self, row: usize, column: usize) -> Vec2 {
        let local = Vec2::new(self.lack.0[row][column], self.lack.1[row][column]);
        local - self.yielded.drag - self.arm(row, column).perp() * self.yielded.twist
    }

    /// Takes the cell part of the way to where it lacks nothing.
    fn visit(&mut self, row: usize, column: usize) {
        let idle = self.cells.load[row][column] <= 0.0 && self.force.0[row][column] == 0.0 && self.force.1[row][column] == 0.0;
        if idle {
            return;
        }
        let common = self.elastic.common.drag + self.elastic.common.twist * self.arm(row, column).length_squared();
        let stiffness = 1.0 / (self.kernel.own() * self.scale + common);
        self.change(row, column, self.lack_at(row, column) * (RELAXATION * stiffness));
    }

    /// Changes the cell's force by `wanted` as far as friction allows, and moves the surface by it.
    fn change(&mut self, row: usize, column: usize, wanted: Vec2) {
        let load = self.cells.load[row][column];
        let old = Vec2::new(self.force.0[row][column], self.force.1[row][column]);
        let trial = old + wanted;
        let cap = self.friction(row, column) * load;
        let size2 = trial.length_squared();
        let new = if size2 <= cap * cap { trial } else { trial * (self.cut(row, column, cap) / root(size2)) };
        let change = new - old;
        if change == Vec2::ZERO {
            return;
        }
        (self.force.0[row][column], self.force.1[row][column]) = (new.x, new.y);
        self.yielded.drag += change * self.elastic.common.drag;
        self.yielded.twist += self.arm(row, column).perp_dot(change) * self.elastic.common.twist;
        self.spread(row, column, change * self.scale);
    }

    /// What a cell holds that has come to its cap: it has left stick, and meets the dynamic cap at once where breakaway is sharp.
    fn cut(&mut self, row: usize, column: usize, cap: f32) -> f32 {
        let slipped = &mut self.slipped[row][column];
        *slipped = max(*slipped, LEAST_SLIP);
        if self.hold.sharp { self.hold.mu_d * self.cells.load[row][column] } else { cap }
    }

    /// Takes what `change` of the cell moves every cell from what they lack.
    fn spread(&mut self, row: usize, column: usize, change: Vec2) {
        for (j, (x, y)) in self.lack.0.iter_mut().zip(&mut self.lack.1).enumerate() {
            let kernel = self.kernel.rows(j.abs_diff(row), column);
            let mixed = if j < row { -change } else { change };
            for i in 0..W {
                x[i] -= kernel.xx[i] * change.x + kernel.xy[i] * mixed.y;
                y[i] -= kernel.xy[i] * mixed.x + kernel.yy[i] * change.y;
            }
        }
    }

    /// Friction of a cell that slipped: dynamic at once when sharp, else falling over a length on which the cell would shed
    /// twice the difference, so that nothing snaps.
    fn friction(&self, row: usize, column: usize) -> f32 {
        let excess = self.hold.mu_s - self.hold.mu_d;
        let slipped = self.slipped[row][column];
        if excess <= 0.0 || slipped <= 0.0 {
            return self.hold.mu_s;
        }
        if self.hold.sharp {
            return self.hold.mu_d;
        }
        let fall = 2.0 * excess * self.cells.load[row][column] / self.slope;
        self.hold.mu_s - excess * min(slipped / fall, 1.0)
    }

    /// Gives the cells back to the state and sums them.
    fn store(&self, layout: &Layout, stored: &mut Stored<'_>) -> Grip {
        let mut grip = Grip::default();
        let (mut stuck, mut touching) = (0.0, 0.0);
        for row in 0..W {
            for column in 0..W {
                let Some(slot) = slot::<W>(layout, row, column) else { continue };
                let (Some(cell), Some(trace)) = (stored.force.get_mut(slot), stored.trace.get_mut(slot)) else { continue };
                if self.cells.load[row][column] <= 0.0 {
                    (*cell, *trace) = (Bristle::default(), Trace::default());
                    continue;
                }
                let force = Vec2::new(self.force.0[row][column], self.force.1[row][column]);
                let slides = self.slides(row, column, force);
                let lack = self.lack_at(row, column);
                *trace = Trace { lack: if slides { Vec2::ZERO } else { lack }, change: force - cell.force };
                *cell = Bristle { force, slipped: self.slip(row, column, slides, lack, force) };
                grip.force += force;
                grip.torque += self.arm(row, column).perp_dot(force);
                touching += 1.0;
                stuck += if slides { 0.0 } else { 1.0 };
            }
        }
        grip.stick = if touching > 0.0 { stuck / touching } else { 0.0 };
        grip
    }

    fn slides(&self, row: usize, column: usize, force: Vec2) -> bool {
        let cap = self.friction(row, column) * self.cells.load[row][column];
        force.length_squared() >= cap * cap * ON_CAP
    }

    /// Distance slipped since stick was left; back to 0 when the cell sticks below the dynamic cap.
    fn slip(&self, row: usize, column: usize, slides: bool, lack: Vec2, force: Vec2) -> f32 {
        let before = self.slipped[row][column];
        if slides {
            let slipped = before + root(lack.length_squared());
            return if slipped > LEAST_SLIP { slipped } else { LEAST_SLIP };
        }
        let dynamic = self.hold.mu_d * self.cells.load[row][column];
        if before > 0.0 && force.length_squared() < dynamic * dynamic { 0.0 } else { before }
    }
}

/// Square of the share of the cap above which a cell counts as sliding: rounding of the cut.
const ON_CAP: f32 = 0.999_99;

/// A cell that has left stick is marked by a slip above zero, however small the step was \[m\].
const LEAST_SLIP: f32 = 1.0e-12;

/// What the state keeps of a place of the window.
fn kept<const W: usize>(layout: &Layout, stored: &Stored<'_>, row: usize, column: usize) -> Option<(Bristle, Trace)> {
    let slot = slot::<W>(layout, row, column)?;
    Some((*stored.force.get(slot)?, *stored.trace.get(slot)?))
}

/// Slot of the state for a place of the window, if it is kept.
fn slot<const W: usize>(layout: &Layout, row: usize, column: usize) -> Option<usize> {
    let at = |k: usize| (k + layout.side / 2).checked_sub(W / 2).filter(|&k| k < layout.side);
    Some(at(row)? * layout.side + at(column)?)
}

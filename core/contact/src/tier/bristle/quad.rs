//! Four bristles at a time: two rings of two. What their forces come to is summed quad by quad, then over the four.

use crate::lanes::{LANES, Lanes};
use crate::limits::MAX_BRISTLES;
use crate::patch::Shift;
use crate::tier::Hold;
use crate::tier::bristle::ring::{Four, Rings};
use crate::tier::bristle::slip::friction;
use crate::tier::bristle::{AROUND, Bristle, Layout};

/// Bristles of a quad.
pub const BRISTLES: usize = 2 * AROUND;

/// Figures of four bristles. Where there is only one ring left, those of the second hold nothing.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    /// What they hold before the shift \[N\].
    force: (Lanes, Lanes),
    /// Unit vectors to them.
    pub radial: (Lanes, Lanes),
    /// Force per drag \[N/m\].
    pub drag: Lanes,
    /// Hoop force per twist \[N/rad\].
    pub twist: Lanes,
    /// Arms of their forces \[m\].
    pub arm: Lanes,
    /// What they can hold while they stick, and once they have left stick \[N\].
    cap: Lanes,
    cut: Lanes,
    /// The dynamic cap: one that sticks below it forgets that it slipped \[N\].
    pub dynamic: Lanes,
    /// Area that counts as stuck with each in pure drag and in pure twist, shares of the contact area.
    pub stuck: (Lanes, Lanes),
}

/// The quads of a patch, innermost first.
pub type Quads = heapless::Vec<Quad, { MAX_BRISTLES / BRISTLES }>;

/// Bristles after a shift.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// What they hold \[N\].
    pub force: (Lanes, Lanes),
    /// Torque of it about the centre \[N m\].
    pub torque: Lanes,
    /// Some of them slide.
    pub slides: bool,
    /// Size of the elastic trial of a bristle that slides \[N\], 0 of one that sticks.
    pub trial: Lanes,
    /// What it holds over that size; 1 while it sticks.
    pub scale: Lanes,
    /// Unit vector along the trial of a bristle that slides, 0 of one that sticks.
    pub along: (Lanes, Lanes),
}

/// What four bristles take from the stiffness of a patch, each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lost {
    /// Force over drag, x over x, x over y and y over y \[N/m\].
    pub drag: [Lanes; 3],
    /// Force over twist \[N/rad\].
    pub force_twist: (Lanes, Lanes),
    /// Torque over drag \[N m/m\].
    pub torque_drag: (Lanes, Lanes),
    /// Torque over twist \[N m/rad\].
    pub twist: Lanes,
}

impl core::ops::AddAssign for Lost {
    fn add_assign(&mut self, other: Self) {
        for (sum, more) in self.drag.iter_mut().zip(other.drag) {
            *sum += more;
        }
        self.force_twist.0 += other.force_twist.0;
        self.force_twist.1 += other.force_twist.1;
        self.torque_drag.0 += other.torque_drag.0;
        self.torque_drag.1 += other.torque_drag.1;
        self.twist += other.twist;
    }
}

/// Lays out the bristles of `rings`, of which the last may stand alone.
pub fn lay_out(hold: &Hold, layout: &Layout, rings: &Rings, bristles: &[Bristle], quads: &mut Quads) {
    for (k, (four, cells)) in rings.fours().iter().zip(bristles.chunks(2 * BRISTLES)).enumerate() {
        let (inner, outer) = cells.split_at_checked(BRISTLES).unwrap_or((cells, &[]));
        let _ = quads.push(Quad::new(hold, layout, LANES * k, &four.inner(), inner));
        if LANES * k + 2 < rings.len() {
            let _ = quads.push(Quad::new(hold, layout, LANES * k + 2, &four.outer(), outer));
        }
    }
}

/// The bristles of a ring that stands alone, and two that hold nothing.
#[cold]
fn padded(cells: &[Bristle]) -> [Bristle; BRISTLES] {
    let mut four = [Bristle::default(); BRISTLES];
    if let ([a, b, ..], [c, d]) = (&mut four, cells) {
        (*a, *b) = (*c, *d);
    }
    four
}

impl Quad {
    /// Bristles of the ring `k` and of the next.
    #[inline(always)]
    fn new(hold: &Hold, layout: &Layout, k: usize, figures: &Four, cells: &[Bristle]) -> Self {
        let alone;
        let cells = match cells.first_chunk() {
            Some(cells) => cells,
            None => {
                alone = padded(cells);
                &alone
            }
        };
        let [a, b] = [layout.direction(k, 0), layout.direction(k + 1, 0)];
        let Four { load, drag, twist, arm, stuck } = *figures;
        let falls = hold.mu_s > hold.mu_d;
        let cap = if falls {
            let mu = |i: usize| friction(hold, load.0[i], drag.0[i], cells[i].slipped);
            load * Lanes([mu(0), mu(1), mu(2), mu(3)])
        } else {
            load * hold.mu_s
        };
        let dynamic = load * hold.mu_d;
        Self {
            force: (Lanes(cells.map(|cell| cell.force.x)), Lanes(cells.map(|cell| cell.force.y))),
            radial: (Lanes([a.x, -a.x, b.x, -b.x]), Lanes([a.y, -a.y, b.y, -b.y])),
            drag,
            twist,
            arm,
            cap,
            // what has just left stick meets the dynamic cap already in this tick where breakaway is sharp
            cut: if hold.sharp { dynamic } else { cap },
            dynamic,
            stuck,
        }
    }

    /// What the bristles hold if the patch shifts by `felt`.
    #[inline(always)]
    pub fn moved(&self, felt: Shift) -> Moved {
        let hoop = self.twist * felt.twist;
        let x = self.force.0 + self.drag * felt.drag.x - self.radial.1 * hoop;
        let y = self.force.1 + self.drag * felt.drag.y + self.radial.0 * hoop;
        let (size2, cap2) = (x * x + y * y, self.cap * self.cap);
        let (none, one) = (Lanes::default(), Lanes::splat(1.0));
        if (size2 - cap2).larger(none) == none {
            return Moved {
                force: (x, y),
                torque: self.torque(x, y),
                slides: false,
                trial: none,
                scale: one,
                along: (none, none),
            };
        }
        // 1 of one that slides, 0 of one that sticks, whose size is not needed, but must be no zero to divide by
        let slides = Lanes(core::array::from_fn(|i| if size2.0[i] > cap2.0[i] { 1.0 } else { 0.0 }));
        let sticks = one - slides;
        let size = (size2 * slides + sticks).roots_in_line();
        let over = slides / size;
        let (trial, scale, along) = (size * slides, self.cut * over + sticks, (x * over, y * over));
        let force = (x * sticks + along.0 * self.cut, y * sticks + along.1 * self.cut);
        Moved { force, torque: self.torque(force.0, force.1), slides: true, trial, scale, along }
    }

    /// Torque of forces about the centre \[N m\].
    fn torque(&self, x: Lanes, y: Lanes) -> Lanes {
        self.arm * (self.radial.0 * y - self.radial.1 * x)
    }

    /// What the bristles lose by sliding along the unit vectors n: k (1 - Pi) with Pi = scale (1 - n n^T), scale = cap/|trial|; nothing of those
    /// that stick, with n = 0 and scale 1.
    pub fn lost(&self, moved: &Moved) -> Lost {
        let Moved { scale, along: (x, y), .. } = *moved;
        let cut = Lanes::splat(1.0) - scale;
        // the hoop direction is the radial one a quarter turn on
        let (hoop_x, hoop_y) = (self.radial.1 * Lanes::splat(-1.0), self.radial.0);
        let across = scale * (x * hoop_x + y * hoop_y);
        let (lost_x, lost_y) = (hoop_x * cut + x * across, hoop_y * cut + y * across);
        let arm_drag = self.arm * self.drag;
        Lost {
            drag: [self.drag * (cut + scale * x * x), self.drag * scale * x * y, self.drag * (cut + scale * y * y)],
            force_twist: (lost_x * self.twist, lost_y * self.twist),
            torque_drag: (lost_x * arm_drag, lost_y * arm_drag),
            twist: self.arm * self.twist * (hoop_x * lost_x + hoop_y * lost_y),
        }
    }
}

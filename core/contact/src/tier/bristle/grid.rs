//! The polar grid of a patch, and how tractions move to a new one.
//!
//! Rings have equal width h and keep it while the contact radius a stays within a range of h, so that a growing contact enters
//! new, free rings and a shrinking one leaves rings behind. When a leaves the range the grid is laid anew and the forces are
//! shared out by overlap, so that force and torque of what the new grid holds are kept.

use glam::Vec2;

use crate::math::{clamp, max, min};
use crate::patch::Grip;
use crate::tier::Hold;
use crate::tier::bristle::ring::Rings;
use crate::tier::bristle::{AROUND, Bristle, Layout, MAX_RINGS};

/// The grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grid {
    /// Width of a ring \[m\]; 0 before the first load.
    pub width: f32,
    /// Contact radius the bristles were last fitted to \[m\].
    pub radius: f32,
    /// Rings the grid was laid with.
    pub rings: usize,
}

/// Rings in contact on a fresh grid, as a share of the layout's rings: room to grow by a quarter.
const FRESH: f32 = 0.8;

/// Fewest rings in contact, as a share of the layout's rings, before the grid is laid anew.
const FEWEST: f32 = 0.6;

impl Grid {
    /// Lays the grid anew when `radius` has left its range or the number of rings has changed; a new grid takes up what is `held`.
    pub fn fit(&mut self, layout: &Layout, hold: &Hold, held: &Grip, bristles: &mut [Bristle]) {
        let radius = hold.radius;
        let fresh = fresh(layout.rings, radius);
        if self.width <= 0.0 {
            bristles.fill(Bristle::default());
            self.width = fresh;
            seed(layout, fresh, hold, held, bristles);
        } else if self.is_outgrown(layout.rings, radius) {
            share_out(layout, self, fresh, bristles);
            self.width = fresh;
        }
        (self.radius, self.rings) = (radius, layout.rings);
    }

    /// True where `radius` has left the range of the grid or the number of rings is another.
    pub fn is_outgrown(&self, rings: usize, radius: f32) -> bool {
        let all = rings as f32;
        self.rings != rings || radius > self.width * all || radius < self.width * FEWEST * all
    }

    /// Rings that a contact of this radius reaches once the grid fits it.
    pub fn reached(&self, rings: usize, radius: f32) -> usize {
        let width = if self.is_outgrown(rings, radius) { fresh(rings, radius) } else { self.width };
        // one more where the last is reached in full
        rings.min((radius / width) as usize + 1)
    }
}

/// Width of a ring of a fresh grid \[m\].
fn fresh(rings: usize, radius: f32) -> f32 {
    radius / (FRESH * rings as f32)
}

/// Spreads a grip that another tier held by the load, force and hoop force alike: as a contact in full slip holds it, so that no cap cuts what was held.
fn seed(layout: &Layout, width: f32, hold: &Hold, held: &Grip, bristles: &mut [Bristle]) {
    if held.force == Vec2::ZERO && held.torque == 0.0 {
        return;
    }
    let inside = |k: usize| hold.profile.inside(min(width * k as f32 / hold.radius, 1.0)).load;
    let share = |k: usize| (inside(k + 1) - inside(k)) / AROUND as f32;
    let arms: f32 = (0..layout.rings).map(|k| share(k) * middle(width, k as f32)).sum::<f32>() * AROUND as f32;
    for (k, cells) in bristles.chunks_exact_mut(AROUND).take(layout.rings).enumerate() {
        for (j, cell) in cells.iter_mut().enumerate() {
            let hoop = layout.direction(k, j).perp() * (held.torque / arms);
            cell.force = (held.force + hoop) * share(k);
        }
    }
}

/// Moves every cell's force to the cells of the new grid that overlap it. The part beyond the last new ring is lost: it lies outside
/// the contact, where the cap is zero.
fn share_out(layout: &Layout, grid: &Grid, new_width: f32, bristles: &mut [Bristle]) {
    let mut shared = Shared { ratio: new_width / grid.width, pairs: heapless::Vec::new(), missing: 0.0 };
    let mut next = Pair::default();
    let reach = max(grid.radius / grid.width, 0.0);
    for (k, cells) in pairs(bristles).enumerate().take(grid.rings) {
        if k as f32 >= reach {
            break;
        }
        let pair = Pair::of(cells, layout.direction(k, 0));
        next = shared.hand_over(layout.rings, (k as f32, min(k as f32 + 1.0, reach)), &pair, next);
    }
    shared.push(layout.rings, next);
    shared.store(layout, grid.rings, bristles);
}

/// Two opposite bristles: what they have in common is a drag and keeps its direction; what they have opposite is a twist and turns with them.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    /// Mean force \[N\].
    common: Vec2,
    /// Half the difference, along the radius and along the hoop \[N\].
    opposite: Vec2,
    slipped: [f32; AROUND],
}

impl Pair {
    /// The bristles of a ring whose first one lies in the direction `out`.
    fn of([one, two]: &[Bristle; AROUND], out: Vec2) -> Self {
        let opposite = (one.force - two.force) * 0.5;
        Self {
            common: (one.force + two.force) * 0.5,
            opposite: Vec2::new(out.dot(opposite), out.perp_dot(opposite)),
            slipped: [one.slipped, two.slipped],
        }
    }

    fn take(&mut self, other: &Self, share: f32) {
        self.common += other.common * share;
        self.opposite += other.opposite * share;
        self.slipped = [max(self.slipped[0], other.slipped[0]), max(self.slipped[1], other.slipped[1])];
    }

    /// The bristles, with this much more along the hoop \[N\].
    fn bristles(&self, out: Vec2, hoop: f32) -> [Bristle; AROUND] {
        let opposite = out.rotate(self.opposite + Vec2::new(0.0, hoop));
        let [one, two] = self.slipped;
        [Bristle { force: self.common + opposite, slipped: one }, Bristle { force: self.common - opposite, slipped: two }]
    }
}

/// What the new rings have got by now, innermost first. Radii are in widths of the old rings.
struct Shared {
    /// Width of a new ring.
    ratio: f32,
    pairs: heapless::Vec<Pair, MAX_RINGS>,
    /// Torque that moving to the middle of another ring lost, over that of a hoop force of 1 N on a pair one old width out \[N\].
    missing: f32,
}

impl Shared {
    /// Hands a pair, spread between two radii, to the rings that overlap it; `next` is the first of these, and the last is given back, which may get more.
    fn hand_over(&mut self, rings: usize, (inner, outer): (f32, f32), pair: &Pair, mut next: Pair) -> Pair {
        let (per_area, arm) = (1.0 / (outer * outer - inner * inner), middle(1.0, inner));
        let mut low = inner;
        for to in self.pairs.len()..rings {
            let end = self.ratio * (to + 1) as f32;
            let high = min(outer, end);
            let share = (high * high - low * low) * per_area;
            next.take(pair, share);
            self.missing += share * pair.opposite.y * (arm - middle(self.ratio, to as f32));
            if end > outer {
                break;
            }
            self.push(rings, next);
            (next, low) = (Pair::default(), high);
        }
        next
    }

    fn push(&mut self, rings: usize, pair: Pair) {
        if self.pairs.len() < rings {
            let _ = self.pairs.push(pair);
        }
    }

    /// Gives the rings their bristles, with a hoop force that grows with the radius for the torque that is missing, and clears the others.
    fn store(&self, layout: &Layout, old_rings: usize, bristles: &mut [Bristle]) {
        // the sum of the squares of 1/2, 3/2, ...
        let count = self.pairs.len() as f32;
        let rise = self.missing * 12.0 / (self.ratio * count * (4.0 * count * count - 1.0));
        let mut cells = pairs(bristles).enumerate().take(layout.rings.max(old_rings));
        for (pair, (k, cells)) in self.pairs.iter().zip(cells.by_ref()) {
            *cells = pair.bristles(layout.direction(k, 0), rise * middle(1.0, k as f32));
        }
        cells.for_each(|(_, cells)| *cells = Default::default());
    }
}

/// The bristles, ring by ring.
fn pairs(bristles: &mut [Bristle]) -> core::slice::IterMut<'_, [Bristle; AROUND]> {
    bristles.as_chunks_mut::<AROUND>().0.iter_mut()
}

/// Middle of ring `k`.
fn middle(width: f32, k: f32) -> f32 {
    width * (k + 0.5)
}

/// Takes away the traction that rolled out of the contact, and what lies outside it.
pub fn thin(layout: &Layout, rings: &Rings, bristles: &mut [Bristle], kept: f32) {
    let kept = clamp(kept, 0.0, 1.0);
    let inside = rings.len() * AROUND;
    if kept < 1.0 {
        bristles.iter_mut().take(inside).for_each(|bristle| bristle.force *= kept);
    }
    bristles.iter_mut().take(layout.rings * AROUND).skip(inside).for_each(|bristle| *bristle = Bristle::default());
}

//! The sweeps: block Gauss-Seidel over the places with Coulomb's cap at each cell, on the changes of this tick.
//!
//! Each cell lacks a displacement: the shift of this tick less what the changes of all tractions have moved the surface there. Visiting
//! a place, the tractions of its four cells change so that the lack vanishes, but not beyond their caps. A cell's own influence is the same
//! in every direction, so that the cut to the cap is the exact answer of the cell's own friction problem.

use glam::Vec2;

use crate::lanes::Lanes;
use crate::math::{PI, clamp, min, root};
use crate::patch::{Grip, Shift};
use crate::tier::Hold;
use crate::tier::bristle::Bristle;
use crate::tier::bristle::slip::LEAST_SLIP;
use crate::tier::influence::cells::{Cells, reached};
use crate::tier::influence::grid::{Grid, Layout};
use crate::tier::influence::mirror::{CENTRES, IMAGES, PAIRS, PLACES, Pair, SIGN_X, SIGN_Y};
use crate::tier::influence::table::ALONG;
use crate::tier::influence::{Elastic, Stored, Trace};

/// Part of the way to a cell's own answer that a visit goes. The whole way is too far: the cells not yet visited will take over most of the
/// shift, and what the cap cut off meanwhile turns sliding cells too much. Fitted on straight and turning paths.
const RELAXATION: f32 = 0.4;

/// Most times the last tick's changes are repeated: beyond it a hand's next step has little to do with its last.
const MOST_LIKE: f32 = 2.0;

/// A vector per image, or per class: its x and its y.
type Vectors = (Lanes, Lanes);

/// A place being solved.
#[derive(Clone, Copy, Debug)]
struct Site {
    /// Centre as the arm of a twist \[m\].
    arm: Vec2,
    /// Force per lack that a visit applies \[N/m\].
    step: f32,
    /// Normal load of a cell \[N\].
    load: f32,
    /// What the cells hold, and held before \[N\].
    force: Vectors,
    before: Vectors,
    /// Most that they can hold \[N\].
    cap: Lanes,
    /// Distances slipped \[m\].
    slipped: Lanes,
    /// What they lacked before this tick's shift \[m\].
    lack: Vectors,
}

/// What a place's change of force moves others by, by class: times the kernel's parts. \[m\]
#[derive(Clone, Copy, Debug, Default)]
struct Pull {
    round: Vectors,
    long: Vectors,
    /// `long` in the opposite order of classes.
    cross: Vectors,
}

/// A patch being solved.
#[derive(Debug)]
struct Work<'a> {
    hold: &'a Hold,
    elastic: &'a Elastic,
    /// Width of a cell \[m\].
    width: f32,
    /// Displacement per force of the round and the long part, over the images \[m/N\].
    scale: (f32, f32),
    /// Stiffness by which a slip is told from what the cap cut off \[N/m\].
    slope: f32,
    /// The shift, less what body and correction have yielded since the tick began.
    common: Shift,
}

/// The places that hold or held a force: the first ones of the order.
type Sites = heapless::Vec<Site, PLACES>;
type Pulls = heapless::Vec<Pull, PLACES>;

/// Shifts the patch by `wanted` and returns its new grip.
pub fn shift(
    hold: &Hold,
    elastic: &Elastic,
    layout: &Layout,
    grid: &Grid,
    sweeps: usize,
    wanted: Shift,
    stored: &mut Stored<'_>,
) -> Grip {
    let cells = Cells::new(hold, grid.width, layout.places());
    let left = reached(grid.radius / grid.width, layout.places());
    let held = if left > cells.count { left } else { cells.count };
    let mut work = Work::new(hold, elastic, grid.width, wanted);
    let (mut sites, mut pulls) = (Sites::new(), Pulls::new());
    work.load(&cells, held, stored, &mut sites);
    work.guess(likeness(&grid.wanted, &wanted, hold.radius), stored, &mut sites, &mut pulls);
    work.leave(cells.count, &mut sites, &mut pulls);
    for _ in 0..sweeps {
        // from the middle to the rim, so that no side is first
        for k in 0..cells.count {
            work.visit(k, &mut sites, &mut pulls);
        }
    }
    work.store(cells.count, &sites, &pulls, stored)
}

/// How many times the last shift this one is, as far as it goes the same way; displacements are compared at the rim of radius `a`.
fn likeness(last: &Shift, now: &Shift, a: f32) -> f32 {
    let size = last.drag.length_squared() + last.twist * last.twist * a * a;
    let same = now.drag.dot(last.drag) + now.twist * last.twist * a * a;
    if size > 0.0 { clamp(same / size, -MOST_LIKE, MOST_LIKE) } else { 0.0 }
}

impl<'a> Work<'a> {
    fn new(hold: &'a Hold, elastic: &'a Elastic, width: f32, wanted: Shift) -> Self {
        let unit = 1.0 / (2.0 * PI * elastic.shear_modulus * width);
        let long = 0.5 * elastic.poisson_ratio;
        let scale = ((1.0 - long) * unit / IMAGES as f32, long * unit / IMAGES as f32);
        let slope = hold.drag_stiffness * width * width / (PI * hold.radius * hold.radius);
        Self { hold, elastic, width, scale, slope, common: wanted }
    }

    /// Takes the first `held` places from the state.
    fn load(&self, cells: &Cells, held: usize, stored: &Stored<'_>, sites: &mut Sites) {
        // influence of a cell on itself
        let own = ALONG[0][0] * 2.0 * IMAGES as f32 * self.scale.0;
        let kept = stored.force.as_chunks::<IMAGES>().0.iter().zip(stored.trace.as_chunks::<IMAGES>().0);
        for (((bristles, traces), &(x, y)), &load) in kept.zip(&CENTRES).zip(&cells.load).take(held) {
            let arm = Vec2::new(x, y) * (self.width * cells.arm);
            let common = self.elastic.common.drag + self.elastic.common.twist * arm.length_squared();
            let force = lanes(bristles.map(|cell| cell.force));
            let slipped = Lanes(bristles.map(|cell| cell.slipped));
            let site = Site {
                arm,
                step: RELAXATION / (own + common),
                load,
                force,
                before: force,
                cap: Lanes(slipped.0.map(|slipped| friction(self.hold, self.slope, load, slipped) * load)),
                slipped,
                lack: lanes(traces.map(|trace| trace.lack)),
            };
            let _ = sites.push(site);
        }
    }

    /// Repeats the changes of the last tick `times`: most motions go on as they went.
    fn guess(&mut self, times: f32, stored: &Stored<'_>, sites: &mut Sites, pulls: &mut Pulls) {
        for (site, traces) in sites.iter_mut().zip(stored.trace.as_chunks::<IMAGES>().0) {
            let change = lanes(traces.map(|trace| trace.change));
            let mut pull = Pull::default();
            self.take(site, &mut pull, (site.force.0 + change.0 * times, site.force.1 + change.1 * times));
            let _ = pulls.push(pull);
        }
    }

    /// Counts once and for all what the places beyond the first `count` move by letting go: they lie outside the contact and change no more.
    fn leave(&self, count: usize, sites: &mut Sites, pulls: &mut Pulls) {
        let Some(left) = pulls.get(count..).filter(|left| !left.is_empty()) else { return };
        for (site, row) in sites.iter_mut().zip(&PAIRS).take(count) {
            let moved = moved(row.get(count..).unwrap_or_default(), left);
            site.lack = (site.lack.0 - moved.0.crossed(), site.lack.1 - moved.1.crossed());
        }
        pulls.truncate(count);
    }

    /// Takes the cells of place `k` part of the way to where they lack nothing.
    fn visit(&mut self, k: usize, sites: &mut Sites, pulls: &mut Pulls) {
        let (Some(site), Some(row)) = (sites.get_mut(k), PAIRS.get(k)) else { return };
        let lack = self.lack(site, row, pulls);
        let trial = (site.force.0 + lack.0 * site.step, site.force.1 + lack.1 * site.step);
        if let Some(pull) = pulls.get_mut(k) {
            self.take(site, pull, trial);
        }
    }

    /// What the cells of a place lack by now.
    fn lack(&self, site: &Site, row: &[Pair; PLACES], pulls: &[Pull]) -> Vectors {
        let moved = moved(row, pulls);
        let turned = site.arm * self.common.twist;
        let x = site.lack.0 + Lanes::splat(self.common.drag.x) - SIGN_Y * turned.y;
        let y = site.lack.1 + Lanes::splat(self.common.drag.y) + SIGN_X * turned.x;
        (x - moved.0.crossed(), y - moved.1.crossed())
    }

    /// Sets the forces of a place to `trial` as far as friction allows, and counts what that changes.
    fn take(&mut self, site: &mut Site, pull: &mut Pull, trial: Vectors) {
        let new = cut(self.hold, site, trial);
        let (x, y) = ((new.0 - site.force.0).crossed(), (new.1 - site.force.1).crossed());
        site.force = new;
        pull.round = (pull.round.0 + x * self.scale.0, pull.round.1 + y * self.scale.0);
        pull.long = (pull.long.0 + x * self.scale.1, pull.long.1 + y * self.scale.1);
        pull.cross = (pull.long.0.opposite(), pull.long.1.opposite());
        // sums over the images, of which the first class is that of the forces, and the odd ones those of the arms
        let torque = site.arm.x * y.0[1] - site.arm.y * x.0[2];
        self.common.drag -= Vec2::new(x.0[0], y.0[0]) * self.elastic.common.drag;
        self.common.twist -= torque * self.elastic.common.twist;
    }

    /// Gives the places back to the state, the first `count` of them in contact, and sums these.
    fn store(&self, count: usize, sites: &Sites, pulls: &Pulls, stored: &mut Stored<'_>) -> Grip {
        let mut grip = Grip::default();
        let mut stuck = 0.0;
        let kept = stored.force.as_chunks_mut::<IMAGES>().0.iter_mut().zip(stored.trace.as_chunks_mut::<IMAGES>().0);
        for (k, ((cells, traces), (site, row))) in kept.zip(sites.iter().zip(&PAIRS)).enumerate() {
            if k >= count {
                cells.fill(Bristle::default());
                traces.fill(Trace::default());
                continue;
            }
            let lacks = self.lack(site, row, pulls);
            for (image, (cell, trace)) in cells.iter_mut().zip(traces).enumerate() {
                let [force, before, lack] = [site.force, site.before, lacks].map(|of| Vec2::new(of.0.0[image], of.1.0[image]));
                let slides = slides(site, image, force);
                *trace = Trace { lack: if slides { Vec2::ZERO } else { lack }, change: force - before };
                *cell = Bristle { force, slipped: slip(self.hold, site, image, slides, lack, force) };
                grip.force += force;
                grip.torque += Vec2::new(site.arm.x * SIGN_X.0[image], site.arm.y * SIGN_Y.0[image]).perp_dot(force);
                stuck += if slides { 0.0 } else { 1.0 };
            }
        }
        grip.stick = if count > 0 { stuck / (IMAGES * count) as f32 } else { 0.0 };
        grip
    }
}

/// Vectors of the images as lanes.
fn lanes(vectors: [Vec2; IMAGES]) -> Vectors {
    (Lanes(vectors.map(|v| v.x)), Lanes(vectors.map(|v| v.y)))
}

/// How the changes of all places move one, by class. A function of its own: inlined, the compiler turns the lanes about in every round. Four places a round, one after the
/// other: counting rounds took a fifth of the instructions.
#[inline(never)]
fn moved(row: &[Pair], pulls: &[Pull]) -> Vectors {
    let (mut x, mut y) = (Lanes::default(), Lanes::default());
    let mut pulled = |pair: &Pair, pull: &Pull| {
        x = x + pair.round * pull.round.0 + pair.long * pull.long.0 + pair.cross * pull.cross.1;
        y = y + pair.round * pull.round.1 - pair.long * pull.long.1 + pair.cross * pull.cross.0;
    };
    // as many pulls as pairs at most
    let ((rounds, rest), (fours, last)) = (row.get(..pulls.len()).unwrap_or(row).as_chunks(), pulls.as_chunks());
    for ([a, b, c, d], [e, f, g, h]) in rounds.iter().zip(fours) {
        pulled(a, e);
        pulled(b, f);
        pulled(c, g);
        pulled(d, h);
    }
    for (pair, pull) in rest.iter().zip(last) {
        pulled(pair, pull);
    }
    (x, y)
}

/// The forces that friction leaves of `trial`. What has come to its cap has left stick, and meets the dynamic cap at once where breakaway is sharp.
fn cut(hold: &Hold, site: &mut Site, trial: Vectors) -> Vectors {
    let size2 = trial.0 * trial.0 + trial.1 * trial.1;
    let cap2 = site.cap * site.cap;
    let slides: [bool; IMAGES] = core::array::from_fn(|image| size2.0[image] > cap2.0[image]);
    if slides == [false; IMAGES] {
        return trial;
    }
    let one_of = |slides: [bool; IMAGES], slid: Lanes, stuck: Lanes| {
        Lanes(core::array::from_fn(|image| if slides[image] { slid.0[image] } else { stuck.0[image] }))
    };
    let cap = if hold.sharp { Lanes::splat(hold.mu_d * site.load) } else { site.cap };
    let left = one_of(slides, cap / size2.roots(), Lanes::splat(1.0));
    site.slipped = one_of(slides, site.slipped.larger(Lanes::splat(LEAST_SLIP)), site.slipped);
    site.cap = one_of(slides, cap, site.cap);
    (trial.0 * left, trial.1 * left)
}

/// Friction of a cell that slipped: dynamic at once when sharp, else falling over a length on which the cell would shed twice the difference,
/// so that nothing snaps.
fn friction(hold: &Hold, slope: f32, load: f32, slipped: f32) -> f32 {
    let excess = hold.mu_s - hold.mu_d;
    if excess <= 0.0 || slipped <= 0.0 {
        return hold.mu_s;
    }
    if hold.sharp {
        return hold.mu_d;
    }
    let fall = 2.0 * excess * load / slope;
    hold.mu_s - excess * min(slipped / fall, 1.0)
}

fn slides(site: &Site, image: usize, force: Vec2) -> bool {
    let cap = site.cap.0[image];
    force.length_squared() >= cap * cap * ON_CAP
}

/// Distance slipped since stick was left; back to 0 when the cell sticks below the dynamic cap.
fn slip(hold: &Hold, site: &Site, image: usize, slides: bool, lack: Vec2, force: Vec2) -> f32 {
    let before = site.slipped.0[image];
    if slides {
        let slipped = before + root(lack.length_squared());
        return if slipped > LEAST_SLIP { slipped } else { LEAST_SLIP };
    }
    let dynamic = hold.mu_d * site.load;
    if before > 0.0 && force.length_squared() < dynamic * dynamic { 0.0 } else { before }
}

/// Square of the share of the cap above which a cell counts as sliding: rounding of the cut.
const ON_CAP: f32 = 0.999_99;

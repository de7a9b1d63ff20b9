//! What a tick is going to cost, from counts that are known before it is computed.

use super::costs::{self, object_row, shape_column};
use super::rung::Rung;
use super::turns::Turns;
use crate::coupling::CouplingSpec;
use crate::geometry::support::ASKED_SAMPLES;
use crate::lanes::LANES;
use crate::model::{Model, ObjectShape, ProbePart, ProbeShape};
use crate::params::{Params, Tier};
use crate::patch::Patch;
use crate::stage::detect::{Look, Parts};
use crate::stage::force::{Pressed, SERIES_STEPS};
use crate::tier::bristle;
use crate::tier::influence::Layout;

/// What every tick of a scene has to do: the list of calls, bounding balls, coupling, guard.
pub fn of_any_tick(model: &Model<'_>, params: &Params) -> u32 {
    let part = if matches!(model.object, ObjectShape::Mesh(_)) { costs::PART_ON_MESH } else { costs::PART };
    let balls = count(model.probe.len());
    let coupling = if params.coupling == CouplingSpec::Direct { 0 } else { costs::COUPLING };
    let passivity = if params.guard.passivity.is_some() { costs::PASSIVITY } else { 0 };
    costs::TICK.saturating_add(part.saturating_mul(balls)).saturating_add(coupling + passivity)
}

/// A tick that is not computed, beside so many patches.
pub fn of_still(patches: usize) -> u32 {
    costs::STILL.saturating_add(costs::STILL_PATCH.saturating_mul(count(patches)))
}

/// Looking for the first time at a part that has come near, whose mesh, if it is one, is asked for so many samples.
pub fn of_first_look(object: &ObjectShape<'_>, part: &ProbePart<'_>, asked: usize) -> u32 {
    of_row(object_row(object, true), part, asked)
}

/// Looking at one part, by what the look met: near edges of a box what is searched and cut is counted, under the rim of a cylinder it is taken at its dearest.
pub fn of_look(object: &ObjectShape<'_>, part: &ProbePart<'_>, asked: usize, look: &Look) -> u32 {
    let cuts = look.contact.map_or(0, |contact| contact.seat.cuts());
    let (searched, in_box) = (costs::ASKED.saturating_mul(look.asked), matches!(object, ObjectShape::Box { .. }));
    if look.asked <= costs::ASKED_AT_LEAST && cuts == 0 {
        let apart = in_box && look.contact.is_none() && !is_mesh(part);
        let found = of_row(object_row(object, false), part, asked);
        return if apart { found.min(costs::LOOK_APART) } else { found }.saturating_add(searched);
    }
    if !in_box {
        return of_first_look(object, part, asked);
    }
    let cut = of_shape(&costs::CUT, part).saturating_mul(u32::from(cuts));
    let samples = of_samples(object_row(object, true), part, asked);
    of_shape(&costs::LOOK_BY_EDGES, part).saturating_add(samples).saturating_add(searched).saturating_add(cut)
}

fn of_row(row: usize, part: &ProbePart<'_>, asked: usize) -> u32 {
    let found = costs::LOOK.get(row).and_then(|row| row.get(shape_column(&part.shape))).copied().unwrap_or(u32::MAX);
    found.saturating_add(of_samples(row, part, asked))
}

fn of_samples(row: usize, part: &ProbePart<'_>, asked: usize) -> u32 {
    let ProbeShape::Mesh(mesh) = part.shape else { return 0 };
    let asked = mesh.samples().len().min(ASKED_SAMPLES).min(asked);
    costs::SAMPLE.get(row).copied().unwrap_or(u32::MAX).saturating_mul(count(asked))
}

/// Looking at the meshes among these parts, each asked for so many samples.
pub fn of_search(model: &Model<'_>, near: Parts, asked: usize) -> u32 {
    let meshes = near.of(model.probe).filter(|(_, part)| is_mesh(part));
    meshes.fold(0, |sum: u32, (_, part)| sum.saturating_add(of_first_look(&model.object, part, asked)))
}

/// True for a part whose search asks samples.
pub fn is_mesh(part: &ProbePart<'_>) -> bool {
    matches!(part.shape, ProbeShape::Mesh(_))
}

/// What stages 1 and 2 have found, and how it is pressed.
#[derive(Clone, Copy, Debug)]
pub struct Counts<'a> {
    /// What the looks took.
    pub spent: u32,
    /// Parts near the object.
    pub near: usize,
    /// Those of them that were not looked at.
    pub waiting: Parts,
    /// Patches that are followed.
    pub patches: &'a [Patch],
    /// What pressing them takes.
    pub pressed: Pressed,
}

impl<'a> Counts<'a> {
    /// After stages 1 and 2.
    pub fn new(turns: &Turns, patches: &'a [Patch], pressed: Pressed) -> Self {
        Self { spent: turns.spent(), near: turns.near().count(), waiting: turns.waiting(), patches, pressed }
    }
}

/// What the budget costs itself beside so many near parts.
fn of_budget(near: usize) -> u32 {
    if near > 0 { costs::BUDGET.saturating_add(costs::BUDGET_PART.saturating_mul(count(near))) } else { 0 }
}

/// Everything of a tick but what friction holds.
pub fn of_contacts(model: &Model<'_>, params: &Params, counts: &Counts<'_>) -> u32 {
    let patches = counts.patches.len();
    let excess = count(patches.saturating_sub(params.max_regions));
    let joined = costs::EXCESS.saturating_mul(neighbours(patches) * excess);
    [
        of_budget(counts.near),
        of_carrying(model, counts.waiting),
        of_following(patches),
        joined,
        of_pressing(model, counts.patches, counts.pressed),
    ]
    .into_iter()
    .fold(of_any_tick(model, params).saturating_add(counts.spent), u32::saturating_add)
}

/// The same before anything is looked at, without the looks: as if every near part were a patch and one of them newborn, pressed as rarely as may be.
pub fn beside_looks(model: &Model<'_>, params: &Params, near: Parts) -> u32 {
    let parts = near.count();
    let press = |part: &ProbePart<'_>| {
        of_press(model, part, parts).saturating_add(of_shape(&costs::TRIAL, part).saturating_mul(count(SERIES_STEPS)))
    };
    let each = near.of(model.probe).fold(0, |sum: u32, (_, part)| sum.saturating_add(press(part)));
    let newborn = near.of(model.probe).map(|(_, part)| press(part)).fold(0, u32::max);
    let carried = of_carrying(model, near);
    // at most as many regions too many as there are parts
    let joined = costs::EXCESS.saturating_mul(neighbours(parts) * count(parts.saturating_sub(params.max_regions)));
    [of_budget(parts), each, newborn, carried, joined, of_following(parts)]
        .into_iter()
        .fold(of_any_tick(model, params), u32::saturating_add)
}

/// Carrying the contacts of these parts.
fn of_carrying(model: &Model<'_>, waiting: Parts) -> u32 {
    waiting.of(model.probe).fold(0, |sum: u32, (_, part)| sum.saturating_add(of_shape(&costs::CARRIED, part)))
}

/// Following so many patches, and grouping them.
fn of_following(patches: usize) -> u32 {
    costs::NEIGHBOUR.saturating_mul(neighbours(patches))
}

/// Pressing the patches, and once more the newborn where one is pressed apart; every trial as if it were at the dearest.
fn of_pressing(model: &Model<'_>, patches: &[Patch], Pressed { passes, trials }: Pressed) -> u32 {
    let part = |patch: &Patch| model.probe.get(usize::from(patch.part));
    let press = |patch: &Patch| part(patch).map_or(0, |part| of_press(model, part, patches.len()));
    let whole = patches.iter().fold(0, |sum: u32, patch| sum.saturating_add(press(patch)));
    let newborn = patches.last().filter(|_| passes.newborn).map_or(0, press);
    let trial = patches.iter().filter_map(part).map(|part| of_shape(&costs::TRIAL, part)).fold(0, u32::max);
    whole.saturating_mul(count(passes.whole)).saturating_add(newborn).saturating_add(trial.saturating_mul(count(trials)))
}

/// Pressing one part beside so many patches once, the trials apart.
fn of_press(model: &Model<'_>, part: &ProbePart<'_>, patches: usize) -> u32 {
    let others = count(patches.saturating_sub(1));
    let (table, of_others) = match model.table() {
        Some(_) => (costs::TABLE, costs::TABLE_NEIGHBOUR),
        None => (0, 0),
    };
    let shape = of_shape(&costs::PRESSED, part);
    shape.saturating_add(table).saturating_add(costs::DENT.saturating_add(of_others).saturating_mul(others))
}

/// What a part of this shape costs.
fn of_shape(costs: &[u32; costs::SHAPES], part: &ProbePart<'_>) -> u32 {
    costs.get(shape_column(&part.shape)).copied().unwrap_or(u32::MAX)
}

/// What friction holds in these patches on a rung; 0 where there is none.
pub fn of_grip(model: &Model<'_>, params: &Params, rung: Rung, patches: &[Patch]) -> u32 {
    let tier = patches.iter().fold(0, |sum: u32, patch| sum.saturating_add(of_patch(rung, patch)));
    if params.mu_s > 0.0 { tier.saturating_add(of_ground(model, rung, patches.len())) } else { 0 }
}

/// The same for so many patches, whatever they are.
pub fn of_dearest_grip(model: &Model<'_>, params: &Params, rung: Rung, patches: usize) -> u32 {
    let tier = of_tier(rung).saturating_mul(count(patches));
    if params.mu_s > 0.0 { tier.saturating_add(of_ground(model, rung, patches)) } else { 0 }
}

/// How the ground under so many patches moves.
fn of_ground(model: &Model<'_>, rung: Rung, patches: usize) -> u32 {
    if rung.tier == Tier::Paper {
        return 0;
    }
    let grounded = model.object != ObjectShape::HalfSpace;
    let ground = if grounded { costs::GROUND.saturating_mul(count(patches)) } else { 0 };
    let moved = match model.table() {
        Some(_) => costs::GROUND_TABLE_NEIGHBOUR.saturating_mul(neighbours(patches)),
        None if patches > 1 => costs::GROUND_FOUR.saturating_mul(count(patches * patches.div_ceil(LANES))),
        None => 0,
    };
    ground.saturating_add(moved)
}

/// One patch on a rung, its ground apart: of bristles those that the contact reaches, and all that are laid where it has outgrown its grid.
fn of_patch(rung: Rung, patch: &Patch) -> u32 {
    if rung.tier != Tier::Bristle {
        return of_tier(rung);
    }
    let (rings, radius) = (bristle::Layout::rings_of(usize::from(rung.samples)), patch.footprint.radius);
    let laid = if patch.grid.is_outgrown(rings, radius) { bristle::MAX_RINGS.min(patch.grid.rings.max(rings)) } else { 0 };
    let samples = |rings: usize| count(bristle::AROUND * rings);
    let held = costs::BRISTLE_SAMPLE.saturating_mul(samples(patch.grid.reached(rings, radius)));
    costs::BRISTLE.saturating_add(held).saturating_add(costs::BRISTLE_LAID.saturating_mul(samples(laid)))
}

/// One patch on a rung, its ground apart, whatever it is.
fn of_tier(rung: Rung) -> u32 {
    match rung.tier {
        Tier::Point => costs::POINT,
        Tier::Paper => costs::PAPER.saturating_add(costs::PAPER_SAMPLE.saturating_mul(u32::from(rung.samples))),
        Tier::Bristle => {
            let sample = costs::BRISTLE_SAMPLE.saturating_add(costs::BRISTLE_LAID);
            costs::BRISTLE.saturating_add(sample.saturating_mul(u32::from(rung.samples)))
        }
        Tier::Influence | Tier::Green => of_cells(rung),
    }
}

/// Places of the two layouts.
const COARSE_PLACES: u32 = Layout::COARSE.places() as u32;
const FINE_PLACES: u32 = Layout::FINE.places() as u32;

/// The last tick's changes are repeated and every sweep visits each place that a contact can reach; all others pull at it.
fn of_cells(rung: Rung) -> u32 {
    let fine = usize::from(rung.samples) > Layout::COARSE.cells;
    let (places, visits) = (if fine { FINE_PLACES } else { COARSE_PLACES }, u32::from(rung.sweeps) + 1);
    let visit = costs::VISIT.saturating_add(costs::PULL.saturating_mul(places));
    places.saturating_mul(costs::PLACE.saturating_add(visits.saturating_mul(visit)))
}

/// An update of so many vertices of the surface under so many patches, with the motion of the whole body or without.
///
/// What a tick leaves of its budget is what a surface may take: see [`crate::deform`].
#[must_use]
pub fn of_surface(vertices: usize, patches: usize, body: bool) -> u32 {
    if vertices == 0 {
        return 0;
    }
    of_call(patches, body).saturating_add(of_vertex(patches, body).saturating_mul(count(vertices)))
}

/// The most vertices whose update fits into `room`.
pub fn vertices_for(room: u32, patches: usize, body: bool) -> usize {
    (room.saturating_sub(of_call(patches, body)) / of_vertex(patches, body)) as usize
}

fn of_call(patches: usize, body: bool) -> u32 {
    costs::SHOWN.saturating_add(costs::SHOWN_PATCH.saturating_mul(count(patches))).saturating_add(if body {
        costs::SHOWN_BODY
    } else {
        0
    })
}

/// One more vertex of an update, under so many patches, with the motion of the whole body or without.
#[must_use]
pub fn of_vertex(patches: usize, body: bool) -> u32 {
    costs::VERTEX.saturating_add(costs::VERTEX_PATCH.saturating_mul(count(patches))).saturating_add(if body {
        costs::VERTEX_BODY
    } else {
        0
    })
}

/// How often a patch meets another.
fn neighbours(patches: usize) -> u32 {
    count(patches * patches.saturating_sub(1))
}

/// Counts here are far below 2^32: parts, samples, vertices of a surface in memory.
fn count(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

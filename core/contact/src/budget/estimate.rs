//! What a tick is going to cost, from counts that are known before it is computed.

use super::costs::{self, object_row, shape_column};
use super::rung::Rung;
use crate::coupling::CouplingSpec;
use crate::frames::{Pose, ProbeFrame, World};
use crate::geometry::deepest::{is_clear, part_pose};
use crate::geometry::support::ASKED_SAMPLES;
use crate::lanes::LANES;
use crate::model::{Model, ObjectShape, ProbePart, ProbeShape};
use crate::params::{Params, Tier};
use crate::patch::Patch;
use crate::scratch::Contact;
use crate::stage::detect::Near;
use crate::stage::force::passes;
use crate::tier::influence::Layout;

/// What every tick of a scene has to do: the list of calls, bounding balls, coupling, guard.
pub fn of_any_tick(model: &Model<'_>, params: &Params) -> u32 {
    let part = if matches!(model.object, ObjectShape::Mesh(_)) { costs::PART_ON_MESH } else { costs::PART };
    // a mesh's ball is looked at before its samples are chosen, and once more by stage 1
    let balls = count(model.probe.len() + model.probe.iter().filter(|part| is_mesh(part)).count());
    let coupling = if params.coupling == CouplingSpec::Direct { 0 } else { costs::COUPLING };
    let passivity = if params.guard.passivity.is_some() { costs::PASSIVITY } else { 0 };
    costs::TICK.saturating_add(part.saturating_mul(balls)).saturating_add(coupling + passivity)
}

/// Finding and pressing the contact of one part whose mesh, if it is one, is asked for so many samples, by an edge of the object or away from it.
fn of_pair(object: &ObjectShape<'_>, part: &ProbePart<'_>, edge: bool, asked: usize) -> u32 {
    let row = object_row(object, edge);
    let found = costs::PAIR.get(row).and_then(|row| row.get(shape_column(&part.shape))).copied().unwrap_or(u32::MAX);
    found.saturating_add(of_samples(row, part, asked))
}

fn of_samples(row: usize, part: &ProbePart<'_>, asked: usize) -> u32 {
    let ProbeShape::Mesh(mesh) = part.shape else { return 0 };
    let asked = mesh.samples().len().min(ASKED_SAMPLES).min(asked);
    costs::SAMPLE.get(row).copied().unwrap_or(u32::MAX).saturating_mul(count(asked))
}

/// Meshes of the probe that are near the object at `x_wp`, each asked for so many samples, and nothing else.
pub fn of_search(model: &Model<'_>, x_wp: &Pose<World, ProbeFrame>, asked: usize) -> u32 {
    let meshes = model.probe.iter().filter(|part| is_mesh(part));
    let near = meshes.filter(|part| !is_clear(&model.object, part, &part_pose(part, x_wp)));
    near.fold(0, |sum: u32, part| sum.saturating_add(of_pair(&model.object, part, true, asked)))
}

/// True for a part whose search asks samples.
pub fn is_mesh(part: &ProbePart<'_>) -> bool {
    matches!(part.shape, ProbeShape::Mesh(_))
}

/// What stages 1 and 2 have found.
#[derive(Clone, Copy, Debug)]
pub struct Counts<'a> {
    /// Parts whose bounding ball meets the object.
    pub near: Near,
    /// Those that overlap it.
    pub contacts: &'a [Contact],
    /// Patches that are followed.
    pub patches: &'a [Patch],
    /// Samples that a mesh is asked for.
    pub asked: usize,
}

impl Counts<'_> {
    /// What every near part costs, and what a ball does where there is one.
    fn pairs(&self, model: &Model<'_>, ball: Option<u32>) -> u32 {
        let parts = self.near.parts(model.probe);
        parts.fold(0, |sum: u32, (index, part)| {
            let cost = match ball.filter(|_| matches!(part.shape, ProbeShape::Sphere { .. })) {
                Some(ball) => ball,
                None => of_pair(&model.object, part, self.is_at_edge(index), self.asked),
            };
            sum.saturating_add(cost)
        })
    }

    fn is_at_edge(&self, part: usize) -> bool {
        self.contacts.iter().any(|contact| usize::from(contact.part) == part && contact.seat.is_at_edge())
    }
}

/// Everything of a tick but what friction holds.
pub fn of_contacts(model: &Model<'_>, params: &Params, counts: &Counts<'_>) -> u32 {
    let patches = counts.patches.len();
    let neighbours = neighbours(patches);
    let (whole, again) = (passes(counts.patches) - 1, of_pressing_again(model, counts));
    // the newborn is pressed once more, alone
    let newborn = if whole > 0 { again.checked_div(count(patches)).unwrap_or(0) } else { 0 };
    let again = count(whole).saturating_mul(again).saturating_add(newborn);
    let excess = count(patches.saturating_sub(params.max_regions));
    let pairs = counts.pairs(model, None).saturating_add(costs::NEIGHBOUR.saturating_mul(neighbours));
    [pairs, of_table(model, patches), again, costs::EXCESS.saturating_mul(neighbours * excess)]
        .into_iter()
        .fold(of_any_tick(model, params), u32::saturating_add)
}

/// One more pass over the patches: what a pair of shapes costs holds what its pressing does.
fn of_pressing_again(model: &Model<'_>, counts: &Counts<'_>) -> u32 {
    let patches = counts.patches.len();
    let dents = costs::DENT_AGAIN.saturating_mul(neighbours(patches));
    counts.pairs(model, Some(costs::BALL_AGAIN)).saturating_add(dents).saturating_add(of_table(model, patches))
}

/// What the body's table adds to pressing so many patches.
fn of_table(model: &Model<'_>, patches: usize) -> u32 {
    match model.table() {
        Some(_) => {
            costs::TABLE.saturating_mul(count(patches)).saturating_add(costs::TABLE_NEIGHBOUR.saturating_mul(neighbours(patches)))
        }
        None => 0,
    }
}

/// What friction holds, on a rung, in so many patches; 0 where there is none.
pub fn of_grip(model: &Model<'_>, params: &Params, rung: Rung, patches: usize) -> u32 {
    if params.mu_s <= 0.0 {
        return 0;
    }
    let (tier, neighbours) = (of_tier(rung).saturating_mul(count(patches)), neighbours(patches));
    if rung.tier == Tier::Paper {
        return tier;
    }
    let grounded = model.object != ObjectShape::HalfSpace;
    let ground = if grounded { costs::GROUND.saturating_mul(count(patches)) } else { 0 };
    let moved = match model.table() {
        Some(_) => costs::GROUND_TABLE_NEIGHBOUR.saturating_mul(neighbours),
        None if patches > 1 => costs::GROUND_FOUR.saturating_mul(count(patches * patches.div_ceil(LANES))),
        None => 0,
    };
    tier.saturating_add(ground).saturating_add(moved)
}

/// One patch on a rung, its ground apart.
fn of_tier(rung: Rung) -> u32 {
    match rung.tier {
        Tier::Point => costs::POINT,
        Tier::Paper => costs::PAPER.saturating_add(costs::PAPER_SAMPLE.saturating_mul(u32::from(rung.samples))),
        Tier::Bristle => costs::BRISTLE.saturating_add(costs::BRISTLE_SAMPLE.saturating_mul(u32::from(rung.samples))),
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

//! Stage 3: normal force, contact radius and pressure profile of every patch.
//!
//! A patch feels the surface as the other patches displace it (equation 4.1 of theory.md). Patches are taken in birth order, each with
//! the latest loads of the others, starting from those of the previous tick; the paper's one-way order is the first pass of a newborn.

use crate::body;
use crate::footprint::{Footprint, law_load};
use crate::math::{clamp, max, min, root};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;
use crate::report::Flags;
use crate::scratch::Contact;
use crate::stage::deform::dent;
use crate::stage::ground;

/// Passes over the patches in a tick with a birth, after the paper's one-way order for the newborn alone: it feels its neighbours, and then they feel it. Each pass
/// shrinks the coupling's error by the share a neighbour's dent has of the depth, at most a third for separate patches. Otherwise one pass follows on
/// from the last tick.
const PASSES_AT_BIRTH: usize = 2;

/// Sets footprint and body compliance of every patch.
pub fn press(model: &Model<'_>, params: &Params, contacts: &[Contact], patches: &mut [Patch]) -> Flags {
    let passes = passes(patches);
    if passes > 1 {
        press_one(model, params, contacts, patches, patches.len() - 1);
    }
    for _ in 0..passes {
        for i in 0..patches.len() {
            press_one(model, params, contacts, patches, i);
        }
    }
    let mut flags = Flags::CLEAN;
    for patch in patches.iter_mut() {
        patch.body = body::compliance(model, patch.at_rest(), patch.normal, patch.footprint.radius, 1.0 / patch.object_radius);
        if patch.footprint.large_strain {
            flags |= Flags::LARGE_STRAIN;
        }
    }
    flags
}

fn press_one(model: &Model<'_>, params: &Params, contacts: &[Contact], patches: &mut [Patch], i: usize) {
    let displaced = displaced_by_others(model, patches, i);
    if let Some(patch) = patches.get_mut(i) {
        let pressed = footprint(model, params, contacts, patch, displaced);
        patch.footprint = Footprint { load: pressed.load * patch.share, ..pressed };
    }
}

/// Passes over all patches in this tick.
pub fn passes(patches: &[Patch]) -> usize {
    let newborn = patches.last().is_some_and(|patch| patch.footprint == Footprint::NONE);
    if newborn && patches.len() > 1 { PASSES_AT_BIRTH } else { 1 }
}

fn displaced_by_others(model: &Model<'_>, patches: &[Patch], i: usize) -> f32 {
    let Some(here) = patches.get(i) else { return 0.0 };
    let others = patches.iter().enumerate().filter(|(j, other)| *j != i && other.footprint.load > 0.0);
    let near = others.fold(0.0, |sum, (_, other)| {
        sum + dent(model, other, here.centre) * clip(other.normal.dot(here.normal)) * yielding(here, other)
    });
    near + ground::lowered(model, patches, i)
}

/// Relative difference of depth over which the ownership of a shared area passes from one patch to the other.
const OWNERSHIP: f32 = 0.4;

/// How much of the other's dent a patch feels: all of it while the two are apart. Where they overlap they share one area, which the deeper
/// owns, so that a pair on one spot carries the load once, without memory and without a second solution (theory.md, section 4).
fn yielding(here: &Patch, other: &Patch) -> f32 {
    let b = other.footprint.radius;
    // a newborn has no radius yet: it will be about as wide
    let a = if here.footprint.radius > 0.0 { here.footprint.radius } else { b };
    let distance2 = (here.centre - other.centre).length_squared();
    if distance2 >= (a + b) * (a + b) {
        return 1.0;
    }
    let distance = root(distance2);
    let overlap = min((a + b - distance) / (2.0 * min(a, b)), 1.0);
    let lead = (other.depth - here.depth) / (OWNERSHIP * max(other.depth, here.depth));
    let owned = clamp(0.5 + lead, 0.0, 1.0);
    let owned = owned * owned * (3.0 - 2.0 * owned);
    1.0 - overlap * (1.0 - owned - EVEN * owned * (1.0 - owned))
}

/// At equal depth on one spot each feels w of the other's dent with 2 / (1 + w)^(3/2) = 1, so w = 2^(2/3) - 1 = 1/2 + EVEN / 4.
const EVEN: f32 = 0.349_6;

fn clip(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

fn footprint(model: &Model<'_>, params: &Params, contacts: &[Contact], patch: &Patch, displaced: f32) -> Footprint {
    let Some(contact) = contacts.iter().find(|contact| contact.part == patch.part) else { return Footprint::NONE };
    let free = patch.depth - displaced;
    if free <= 0.0 {
        return Footprint::NONE;
    }
    let modulus = model.material.contact_modulus();
    let at_depth = |depth: f32| {
        let mut footprint = contact.seat.footprint(modulus, depth);
        if let Some(load) = law_load(&params.force_law, depth) {
            footprint.load = load;
        }
        footprint
    };
    in_series(at_depth, free, body::normal(model, patch.at_rest(), patch.normal))
}

/// Steps that share the depth between contact and body: false position on a residual that is convex in the depth settles to 1e-5 in five.
const SERIES_STEPS: usize = 5;

/// Solves local + C_n P(local) = depth; P grows with depth, so the local depth is bracketed (Illinois).
fn in_series(at_depth: impl Fn(f32) -> Footprint, depth: f32, compliance: f32) -> Footprint {
    let full = at_depth(depth);
    if compliance <= 0.0 {
        return full;
    }
    let (mut low, mut high) = ((0.0, -depth), (depth, compliance * full.load));
    let mut local = full;
    for _ in 0..SERIES_STEPS {
        let span = high.1 - low.1;
        if span <= 0.0 || high.1 <= 0.0 {
            break;
        }
        let middle = low.0 - low.1 * (high.0 - low.0) / span;
        local = at_depth(middle);
        let residual = middle + compliance * local.load - depth;
        if residual < 0.0 {
            (low, high.1) = ((middle, residual), 0.5 * high.1);
        } else {
            (high, low.1) = ((middle, residual), 0.5 * low.1);
        }
    }
    local
}

//! Stage 4: tangential force and torsion of every patch, by the tier.

use heapless::VecView;

use crate::budget::Rung;
use crate::frames::{Pose, ProbeFrame, World};
use crate::green::drawn::Discs;
use crate::limits::MIN_SAMPLES;
use crate::model::Model;
use crate::params::{Params, Tier};
use crate::patch::Patch;
use crate::report::Flags;
use crate::stage::ground::{self, Ground};
use crate::tier::bristle::{self, AROUND, Layout};
use crate::tier::influence::{self, Stored};
use crate::tier::{Hold, paper, point};

/// Memory that the tangential stage works in, beside the patches.
#[derive(Debug)]
pub struct Workspace<'a> {
    /// Samples of all slots.
    pub stored: Stored<'a>,
    /// Samples of a slot; those of a patch are its slot's.
    pub per_slot: usize,
    /// There is a trace for every sample.
    pub traced: bool,
    /// Grounds of the patches.
    pub grounds: &'a mut VecView<Ground>,
    /// Discs of the patches.
    pub discs: &'a mut Discs,
}

/// Sets the grip of every patch, as finely as the rung says. `changed` says that the parameters or the rung are not those of the last tick.
pub fn hold(
    model: &Model<'_>,
    params: &Params,
    rung: Rung,
    patches: &mut [Patch],
    mut work: Workspace<'_>,
    x_wp: &Pose<World, ProbeFrame>,
    changed: bool,
) -> Flags {
    if params.mu_s <= 0.0 {
        patches.iter_mut().for_each(Patch::forget_friction);
        return Flags::CLEAN;
    }
    match rung.tier {
        Tier::Paper => paper::hold(model, params, usize::from(rung.samples), patches, x_wp),
        Tier::Point => {
            each(model, params, patches, (work.grounds, work.discs), changed, point::advance);
            Flags::CLEAN
        }
        Tier::Bristle => hold_bristles(model, params, rung, patches, &mut work, changed),
        Tier::Influence | Tier::Green => {
            // without a table the body of tier `green` is the closed forms', as in tier `influence`
            let lowered = rung.tier == Tier::Green && model.green.is_none();
            let flags = if lowered { Flags::TIER_LOWERED } else { Flags::CLEAN };
            let room = if work.traced { work.per_slot } else { 0 };
            flags
                | match influence::Layout::fitting(usize::from(rung.samples), room) {
                    Some(layout) => hold_cells(model, params, (rung, &layout), patches, &mut work, changed),
                    // beside it and not below it: the stack holds one of the two
                    None => hold_bristles(model, params, rung, patches, &mut work, changed) | Flags::TIER_LOWERED,
                }
        }
    }
}

/// Tier `bristle`, with fewer rings where the state has no room for all, and in closed form where it has room for none. Not inlined: a tick that holds no
/// bristles needs no stack for them.
#[inline(never)]
fn hold_bristles(
    model: &Model<'_>,
    params: &Params,
    rung: Rung,
    patches: &mut [Patch],
    work: &mut Workspace<'_>,
    changed: bool,
) -> Flags {
    let Workspace { stored, per_slot, grounds, discs, .. } = work;
    if *per_slot < MIN_SAMPLES {
        each(model, params, patches, (grounds, discs), changed, point::advance);
        return Flags::TIER_LOWERED;
    }
    let (rings, flags) = fitting(params, rung, *per_slot);
    let fewer;
    let layout = if rings == params.layout.rings {
        &params.layout
    } else {
        fewer = params.layout.with(rings);
        &fewer
    };
    each(model, params, patches, (grounds, discs), changed, |hold, patch| {
        let start = usize::from(patch.slot) * *per_slot;
        if let Some(cells) = stored.force.get_mut(start..start + *per_slot) {
            bristle::advance(hold, layout, patch, cells);
        }
    });
    flags
}

/// Tier `influence`, with fewer cells where the state has no room for all. Not inlined, as [`hold_bristles`].
#[inline(never)]
fn hold_cells(
    model: &Model<'_>,
    params: &Params,
    (rung, layout): (Rung, &influence::Layout),
    patches: &mut [Patch],
    work: &mut Workspace<'_>,
    changed: bool,
) -> Flags {
    let Workspace { stored: Stored { force, trace }, per_slot, grounds, discs, .. } = work;
    each(model, params, patches, (grounds, discs), changed, |hold, patch| {
        let start = usize::from(patch.slot) * *per_slot;
        let (forces, traces) = (force.get_mut(start..start + *per_slot), trace.get_mut(start..start + *per_slot));
        if let (Some(force), Some(trace)) = (forces, traces) {
            influence::advance(hold, &model.material, layout, usize::from(rung.sweeps), patch, &mut Stored { force, trace });
        }
    });
    if layout.cells < usize::from(rung.samples) { Flags::TIER_LOWERED } else { Flags::CLEAN }
}

/// Advances every patch that moved, was pressed, or has new parameters, oldest first, each on the ground as the latest grips have moved it.
fn each(
    model: &Model<'_>,
    params: &Params,
    patches: &mut [Patch],
    (grounds, discs): (&mut VecView<Ground>, &mut Discs),
    changed: bool,
    mut advance: impl FnMut(&Hold, &mut Patch),
) {
    ground::prepare(model, patches, grounds, discs);
    for i in 0..patches.len() {
        let ground = ground::moved(model, grounds, discs, patches, i);
        let lever = grounds.get(i).map_or(0.0, |ground| ground.lever);
        if let Some(patch) = patches.get_mut(i).filter(|patch| changed || !is_at_rest(patch)) {
            let hold = Hold::new(model, params, patch, ground, lever);
            patch.ground = ground;
            advance(&hold, patch);
            ground::take_up(grounds, discs, i, patch);
        }
    }
}

/// Rings of a rung's bristles, as far as the state has room for them.
fn fitting(params: &Params, rung: Rung, per_slot: usize) -> (usize, Flags) {
    let samples = usize::from(rung.samples);
    // the highest rung's are known
    let rings = if samples == params.samples { params.layout.rings } else { Layout::rings_of(samples) };
    let room = per_slot / AROUND;
    if rings <= room { (rings, Flags::CLEAN) } else { (room, Flags::TIER_LOWERED) }
}

/// Nothing moved and nothing was pressed: a quasi-static contact stays as it is, to the bit.
fn is_at_rest(patch: &Patch) -> bool {
    patch.motion.step.is_zero() && patch.motion.rolled == 0.0 && patch.footprint == patch.previous
}

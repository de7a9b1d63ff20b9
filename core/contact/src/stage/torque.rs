//! Stage 4: tangential force and torsion of every patch, by the tier.

use glam::Vec3;

use crate::frames::{Pose, ProbeFrame, World};
use crate::model::Model;
use crate::params::{Params, Tier};
use crate::patch::Patch;
use crate::report::Flags;
use crate::tier::bristle::{self, AROUND, Bristle, Layout};
use crate::tier::influence::{self, Stored};
use crate::tier::{Hold, paper, point};

/// Sets the grip of every patch. The samples of a patch are the `per_slot` ones of its slot; `changed` says that the parameters are not those
/// of the last tick.
pub fn hold(
    model: &Model<'_>,
    params: &Params,
    patches: &mut [Patch],
    stored: Stored<'_>,
    per_slot: usize,
    x_wp: &Pose<World, ProbeFrame>,
    changed: bool,
) -> Flags {
    if params.mu_s <= 0.0 {
        patches.iter_mut().for_each(Patch::forget_friction);
        return Flags::CLEAN;
    }
    match params.tier {
        Tier::Paper => paper::hold(model, params, patches, x_wp),
        Tier::Point => {
            each(model, params, patches, changed, point::advance);
            Flags::CLEAN
        }
        Tier::Bristle => hold_bristles(model, params, patches, stored.force, per_slot, changed),
        Tier::Influence | Tier::Green => hold_cells(model, params, patches, stored, per_slot, changed),
    }
}

/// Tier `bristle`, with fewer rings where the state has no room for all.
fn hold_bristles(
    model: &Model<'_>,
    params: &Params,
    patches: &mut [Patch],
    bristles: &mut [Bristle],
    per_slot: usize,
    changed: bool,
) -> Flags {
    let (layout, flags) = fitting(&params.layout, per_slot);
    each(model, params, patches, changed, |hold, patch| {
        let start = usize::from(patch.slot) * per_slot;
        if let Some(cells) = bristles.get_mut(start..start + per_slot) {
            bristle::advance(hold, &layout, patch, cells);
        }
    });
    flags
}

/// Tier `influence`, with fewer cells where the state has no room for all, and with bristles where it has room for none.
fn hold_cells(
    model: &Model<'_>,
    params: &Params,
    patches: &mut [Patch],
    stored: Stored<'_>,
    per_slot: usize,
    changed: bool,
) -> Flags {
    let Stored { force, trace } = stored;
    let Some(layout) = influence::Layout::fitting(params.samples, per_slot) else {
        return hold_bristles(model, params, patches, force, per_slot, changed) | Flags::TIER_LOWERED;
    };
    each(model, params, patches, changed, |hold, patch| {
        let start = usize::from(patch.slot) * per_slot;
        let (forces, traces) = (force.get_mut(start..start + per_slot), trace.get_mut(start..start + per_slot));
        if let (Some(force), Some(trace)) = (forces, traces) {
            influence::advance(hold, &model.material, &layout, params.sweeps, patch, &mut Stored { force, trace });
        }
    });
    if layout.cells < params.samples { Flags::TIER_LOWERED } else { Flags::CLEAN }
}

/// Advances every patch that moved, was pressed, or has new parameters.
fn each(model: &Model<'_>, params: &Params, patches: &mut [Patch], changed: bool, mut advance: impl FnMut(&Hold, &mut Patch)) {
    // what all patches drag along; each rides on the share of the others (shear and bending of the body are common to all)
    let mut dragged = patches.iter().fold(Vec3::ZERO, |sum, patch| sum + patch.to_world(patch.grip.force));
    for patch in patches.iter_mut().filter(|patch| changed || !is_at_rest(patch)) {
        dragged -= patch.to_world(patch.grip.force);
        let ridden = patch.to_patch(dragged) * patch.body.drag;
        let hold = Hold::new(model, params, patch, ridden);
        patch.ridden = ridden;
        advance(&hold, patch);
        dragged += patch.to_world(patch.grip.force);
    }
}

/// The layout as far as the state has room for it.
fn fitting(layout: &Layout, per_slot: usize) -> (Layout, Flags) {
    let room = per_slot / AROUND;
    if layout.rings <= room {
        return (*layout, Flags::CLEAN);
    }
    (layout.at_most(room), Flags::TIER_LOWERED)
}

/// Nothing moved and nothing was pressed: a quasi-static contact stays as it is, to the bit.
fn is_at_rest(patch: &Patch) -> bool {
    patch.motion.step.is_zero() && patch.motion.rolled == 0.0 && patch.footprint == patch.previous
}

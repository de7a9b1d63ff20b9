//! Stage 4: tangential force and torsion of every patch, by the tier.

use crate::frames::{Pose, ProbeFrame, World};
use crate::model::Model;
use crate::params::{Params, Tier};
use crate::patch::{Grip, Patch};
use crate::report::Flags;
use crate::stage::deform::body_drag;
use crate::tier::bristle::{self, Bristle};
use crate::tier::{Hold, paper, point};

/// Sets the grip of every patch. The bristles of a patch are the `per_slot` ones of its slot.
pub fn hold(
    model: &Model<'_>,
    params: &Params,
    patches: &mut [Patch],
    bristles: &mut [Bristle],
    per_slot: usize,
    x_wp: &Pose<World, ProbeFrame>,
) -> Flags {
    if params.mu_s <= 0.0 {
        patches.iter_mut().for_each(release);
        return Flags::CLEAN;
    }
    if params.tier == Tier::Paper {
        return paper::hold(model, params, patches, x_wp);
    }
    for i in 0..patches.len() {
        if is_at_rest(&patches[i]) {
            continue;
        }
        let ridden = patches[i].to_patch(body_drag(patches, i));
        let hold = Hold::new(model, params, &patches[i], ridden);
        let patch = &mut patches[i];
        if params.tier == Tier::Point {
            point::advance(&hold, patch);
        } else {
            let start = usize::from(patch.slot) * per_slot;
            bristle::advance(&hold, params, patch, &mut bristles[start..start + per_slot]);
        }
    }
    Flags::CLEAN
}

/// Without friction there is no stick state.
fn release(patch: &mut Patch) {
    patch.grip = Grip::default();
}

/// Nothing moved and nothing was pressed: a quasi-static contact stays as it is, to the bit.
fn is_at_rest(patch: &Patch) -> bool {
    patch.motion.step.is_zero() && patch.motion.rolled == 0.0 && patch.footprint == patch.previous
}

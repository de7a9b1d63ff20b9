//! Stage 6: one wrench on the probe. The only place where moment arms are taken.

use glam::Vec3;

use crate::frames::{Pose, ProbeFrame, World};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;
use crate::wrench::Wrench;

/// Standard gravity \[m/s^2\].
const GRAVITY: f32 = 9.806_65;

/// Force of one patch on the probe \[N\], world: the normal load, less what friction holds.
pub fn patch_force(patch: &Patch) -> Vec3 {
    patch.normal * patch.footprint.load - patch.to_world(patch.grip.force)
}

/// Torque of one patch on the probe about the patch's own centre \[N m\], world: torsion, and what the paper's tier turns off the normal.
pub fn patch_torque(patch: &Patch) -> Vec3 {
    patch.normal * -patch.grip.torque + patch.paper.torque
}

/// Sums the patches about the probe's mass centre (paper, equation 1, plus torsion), and its weight where the scene has gravity.
pub fn total(model: &Model<'_>, params: &Params, patches: &[Patch], x_wp: &Pose<World, ProbeFrame>) -> Wrench<World> {
    let weight = if params.gravity { Vec3::Z * (-model.mass * GRAVITY) } else { Vec3::ZERO };
    patches.iter().fold(Wrench::new(weight, Vec3::ZERO), |sum, patch| {
        let force = patch_force(patch);
        let arm = patch.centre - x_wp.position;
        Wrench::new(sum.force + force, sum.torque + arm.cross(force) + patch_torque(patch))
    })
}

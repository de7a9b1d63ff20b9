//! What may change between two ticks of a session: everything about the contact that is not a body, a material or the coupling.

use serde::{Deserialize, Serialize};

use crate::device::{ENUM, F32, U16, U32};
use crate::scene::{BakedScene, Breakaway, Deformation, ForceLaw, GuardLimits, Tier};

/// All parameters that may change between ticks, in one piece: it holds for every tick after it. What a value may be, the core's constructor
/// checks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// Fidelity.
    pub tier: Tier,
    /// Samples per region.
    pub samples: u16,
    /// Gauss-Seidel sweeps of the `influence` and `green` tiers.
    pub sweeps: u8,
    /// Static friction coefficient.
    pub friction_static: f32,
    /// Dynamic friction coefficient, at most the static one.
    pub friction_dynamic: f32,
    /// Contacts closer than this are one region \[m\].
    pub region_distance: f32,
    /// Regions at most.
    pub max_regions: u8,
    /// How stick gives way to slip.
    pub breakaway: Breakaway,
    /// How much of the surface's deformation is shown.
    pub deformation: Deformation,
    /// Whether the probe's weight is felt.
    pub gravity: bool,
    /// What a tick may spend \[instructions of the core's x86-64 release build\]; `None` is no limit.
    pub work: Option<u32>,
    /// Normal force over depth.
    pub force_law: ForceLaw,
    /// Limits on the wrench; the device's hold beside them.
    pub guard: GuardLimits,
}

impl Tuning {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize =
        ENUM + U16 + 1 + 3 * F32 + 1 + 2 * ENUM + 1 + (1 + U32) + ForceLaw::MAX_ENCODED + GuardLimits::MAX_ENCODED;

    /// What a scene begins with.
    #[must_use]
    pub const fn of(scene: &BakedScene) -> Self {
        Self {
            tier: scene.tier,
            samples: scene.samples,
            sweeps: scene.sweeps,
            friction_static: scene.friction_static,
            friction_dynamic: scene.friction_dynamic,
            region_distance: scene.region_distance,
            max_regions: scene.max_regions,
            breakaway: scene.breakaway,
            deformation: scene.deformation,
            gravity: scene.gravity,
            work: scene.work,
            force_law: scene.force_law,
            guard: scene.guard,
        }
    }
}

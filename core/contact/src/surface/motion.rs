//! Motion of the whole body under all patches together: prepared once per update, then asked for at every point.
//!
//! A source of it is a variant of [`BodyMotion`]; what uses it knows nothing but displacements.

use glam::Vec3;

use crate::model::Model;
use crate::patch::Patch;

use super::block::Block;
use super::skeleton::Skeleton;

/// How the body as a whole moves.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "one value per update, on the stack: there is no heap to put it on")]
pub enum BodyMotion {
    /// Not at all: a half space, or only the surroundings of the contacts are asked for.
    None,
    /// As the beam skeleton carries the patches' loads to the base.
    Skeleton(Skeleton),
}

impl BodyMotion {
    /// The motion under `patches`, from the beam skeleton.
    pub fn new(model: &Model<'_>, patches: &[Patch]) -> Self {
        Skeleton::new(model, patches).map_or(Self::None, Self::Skeleton)
    }

    /// Displacement \[m\] of the rest point `p_w`.
    pub fn at(&self, p_w: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Skeleton(skeleton) => skeleton.at(p_w),
        }
    }

    /// Adds the displacements of a block of points.
    pub(super) fn add(&self, block: &mut Block) {
        match self {
            Self::None => {}
            Self::Skeleton(skeleton) => skeleton.add(block),
        }
    }
}

//! Motion of the whole body under all patches together: prepared once per update, then asked for at every point.
//!
//! A source of it is a variant of [`BodyMotion`]; what uses it knows nothing but displacements.

use glam::Vec3;

use crate::model::Model;
use crate::patch::Patch;

use super::block::Block;
use super::field::Field;
use super::skeleton::Skeleton;
use super::table::TableMotion;

/// How the body as a whole moves.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "one value per update, on the stack: there is no heap to put it on")]
pub enum BodyMotion {
    /// Not at all: a half space, or only the surroundings of the contacts are asked for.
    None,
    /// As the beam skeleton carries the patches' loads to the base.
    Skeleton(Skeleton),
    /// As the body's own Green's function has it.
    Table(TableMotion),
}

impl BodyMotion {
    /// The motion under `patches`, from the body's table where it has one, else from the beam skeleton.
    pub fn new(model: &Model<'_>, patches: &[Patch]) -> Self {
        if let Some(motion) = TableMotion::new(model, patches) {
            return Self::Table(motion);
        }
        Skeleton::new(model, patches).map_or(Self::None, Self::Skeleton)
    }

    /// Displacement \[m\] of the rest point `p_w`.
    pub fn at(&self, p_w: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Skeleton(skeleton) => skeleton.at(p_w),
            Self::Table(table) => table.at(p_w),
        }
    }

    /// Adds the displacements of a block of points.
    pub(super) fn add(&self, block: &mut Block) {
        match self {
            Self::None => {}
            Self::Skeleton(skeleton) => skeleton.add(block),
            Self::Table(table) => table.add(block),
        }
    }

    /// Adds the field of patch `k`, as far as it goes with this motion.
    pub(super) fn add_field(&self, k: usize, field: &Field, block: &mut Block) {
        match self {
            Self::Table(table) => table.add_field(k, field, block),
            Self::None | Self::Skeleton(_) => field.add(block),
        }
    }
}

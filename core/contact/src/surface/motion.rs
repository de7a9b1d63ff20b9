//! Motion of the whole body under all patches together: prepared once per update, then asked for at every point.
//!
//! Each source of it has its place in [`BodyMotion`], is filled where it lies, and what uses it knows nothing but displacements.

use glam::Vec3;

use crate::model::Model;
use crate::patch::Patch;

use super::block::Block;
use super::field::Field;
use super::skeleton::Skeleton;
use super::table::TableMotion;

/// How the body as a whole moves. 27 kB: prepared where it lies, it is never copied.
#[derive(Clone, Debug)]
pub struct BodyMotion {
    source: Source,
    skeleton: Skeleton,
    table: TableMotion,
}

/// Where a motion comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// There is none: a half space, or only the surroundings of the contacts are asked for.
    None,
    /// The beam skeleton carries the patches' loads to the base.
    Skeleton,
    /// The body's own Green's function.
    Table,
}

impl BodyMotion {
    /// None.
    pub const REST: Self = Self { source: Source::None, skeleton: Skeleton::REST, table: TableMotion::REST };

    /// Becomes the motion under `patches`, from the body's table where it has one, else from the beam skeleton.
    pub fn prepare(&mut self, model: &Model<'_>, patches: &[Patch]) {
        self.source = if self.table.prepare(model, patches) {
            Source::Table
        } else if self.skeleton.prepare(model, patches) {
            Source::Skeleton
        } else {
            Source::None
        };
    }

    /// Becomes none.
    pub const fn stop(&mut self) {
        self.source = Source::None;
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.source == Source::None
    }

    /// Displacement \[m\] of the rest point `p_w`.
    pub fn at(&self, p_w: Vec3) -> Vec3 {
        match self.source {
            Source::None => Vec3::ZERO,
            Source::Skeleton => self.skeleton.at(p_w),
            Source::Table => self.table.at(p_w),
        }
    }

    /// Adds the displacements of a block of points.
    pub(super) fn add(&self, block: &mut Block) {
        match self.source {
            Source::None => {}
            Source::Skeleton => self.skeleton.add(block),
            Source::Table => self.table.add(block),
        }
    }

    /// Adds the field of patch `k`, as far as it goes with this motion.
    pub(super) fn add_field(&self, k: usize, field: &Field, block: &mut Block) {
        match self.source {
            Source::Table => self.table.add_field(k, field, block),
            Source::None | Source::Skeleton => field.add(block),
        }
    }
}

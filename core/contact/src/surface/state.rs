//! The displacements of an object's vertices as they survive a tick, updated whole or in blocks.

use glam::Vec3;

use super::{Prepared, Surface};

/// Displacements of up to `VERTICES` vertices, and how far round the surface the updates are.
///
/// A surface that is updated in blocks shows each vertex as of the tick that last reached it.
#[derive(Clone, Debug)]
pub struct SurfaceState<const VERTICES: usize> {
    moved: [Vec3; VERTICES],
    /// Memory that an update works in.
    prepared: Prepared,
    /// Vertex at which the next update starts.
    cursor: usize,
}

/// What one update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Updated {
    /// First vertex.
    pub first: usize,
    /// Vertices from there on.
    pub count: usize,
    /// The last vertex was reached: the next update starts at the first.
    pub round: bool,
    /// Vertices for which the state has no room. They are not shown as moved.
    pub left_out: usize,
}

impl<const VERTICES: usize> SurfaceState<VERTICES> {
    /// A surface at rest.
    pub const fn new() -> Self {
        Self { moved: [Vec3::ZERO; VERTICES], prepared: Prepared::new(), cursor: 0 }
    }

    /// Displacements \[m\] of the vertices.
    pub fn moved(&self) -> &[Vec3] {
        &self.moved
    }

    /// Updates the next `most` vertices of `rest`, the object's vertices at rest. `most` of their number or more updates all.
    pub fn update(&mut self, surface: &Surface<'_>, rest: &[Vec3], most: usize) -> Updated {
        let Self { moved, prepared, cursor } = self;
        advance((surface, prepared), rest, moved, cursor, most)
    }
}

impl<const VERTICES: usize> Default for SurfaceState<VERTICES> {
    fn default() -> Self {
        Self::new()
    }
}

fn advance(
    (surface, prepared): (&Surface<'_>, &mut Prepared),
    rest: &[Vec3],
    moved: &mut [Vec3],
    cursor: &mut usize,
    most: usize,
) -> Updated {
    let fits = rest.len().min(moved.len());
    let first = if *cursor < fits && most < fits { *cursor } else { 0 };
    let count = most.min(fits - first);
    let block = first..first + count;
    if let (Some(rest), Some(moved), true) = (rest.get(block.clone()), moved.get_mut(block), count > 0) {
        prepared.prepare(surface);
        prepared.update(rest, moved);
    }
    let round = first + count == fits;
    *cursor = if round { 0 } else { first + count };
    Updated { first, count, round, left_out: rest.len() - fits }
}

//! The displacements of an object's vertices as they survive a tick, updated whole or in blocks.

use glam::Vec3;

use super::Surface;

/// Displacements of up to `VERTICES` vertices, and how far round the surface the updates are.
///
/// A surface that is updated in blocks shows each vertex as of the tick that last reached it.
#[derive(Clone, Debug)]
pub struct SurfaceState<const VERTICES: usize> {
    moved: [Vec3; VERTICES],
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
        Self { moved: [Vec3::ZERO; VERTICES], cursor: 0 }
    }

    /// Displacements \[m\] of the vertices.
    pub fn moved(&self) -> &[Vec3] {
        &self.moved
    }

    /// Updates the next `most` vertices of `rest`, the object's vertices at rest. `most` of their number or more updates all.
    pub fn update(&mut self, surface: &Surface<'_>, rest: &[Vec3], most: usize) -> Updated {
        advance(surface, rest, &mut self.moved, &mut self.cursor, most)
    }
}

impl<const VERTICES: usize> Default for SurfaceState<VERTICES> {
    fn default() -> Self {
        Self::new()
    }
}

fn advance(surface: &Surface<'_>, rest: &[Vec3], moved: &mut [Vec3], cursor: &mut usize, most: usize) -> Updated {
    let fits = rest.len().min(moved.len());
    let first = if *cursor < fits && most < fits { *cursor } else { 0 };
    let count = most.min(fits - first);
    if count > 0 {
        surface.update_block(rest, moved, first..first + count);
    }
    let round = first + count == fits;
    *cursor = if round { 0 } else { first + count };
    Updated { first, count, round, left_out: rest.len() - fits }
}

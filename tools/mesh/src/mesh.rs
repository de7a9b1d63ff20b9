//! The mesh itself: vertices and triangles, nothing derived.

use glam::DVec3;

/// A triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions \[m\].
    pub vertices: Vec<DVec3>,
    /// Corners of each triangle as indices of `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Corners of a triangle \[m\].
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|index| self.vertices[index as usize])
    }

    /// Smallest and largest coordinates \[m\]; `None` for a mesh without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.vertices.first()?;
        Some(self.vertices.iter().fold((first, first), |(low, high), &v| (low.min(v), high.max(v))))
    }

    /// The same mesh, each vertex taken through `map`; a map that mirrors turns the triangles inside out.
    #[must_use]
    pub fn mapped(&self, map: impl Fn(DVec3) -> DVec3) -> Self {
        Self { vertices: self.vertices.iter().map(|&v| map(v)).collect(), triangles: self.triangles.clone() }
    }

    /// Sum of the triangles' areas \[m^2\].
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|&triangle| twice_area(self.corners(triangle)).length() / 2.0).sum()
    }
}

/// Normal of a triangle, twice as long as its area \[m^2\].
pub(crate) fn twice_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

//! Sections of the object normal to z, as a beam sees them. A shape enters here by its outline at a height; a body that is known by its
//! extents only is taken as the box of equal extents.

use glam::{Vec2, Vec3};

use crate::math::{PI, max, min, root};
use crate::model::ObjectShape;

/// Section of the body normal to z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Distance of the rim from the axis along x and y \[m\].
    pub half: Vec2,
    /// Area \[m^2\].
    pub area: f32,
    /// Second moments of area against bending along x and along y \[m^4\].
    pub bending: Vec2,
    /// Torsion constant \[m^4\].
    pub torsion: f32,
    /// Where the rim is on the diagonals, per half width: 1 for a rectangle, sqrt(1/2) for an ellipse.
    pub diagonal: f32,
}

impl Section {
    /// Rectangle of half edges `half`.
    pub fn rectangle(half: Vec2) -> Self {
        let (x, y) = (2.0 * half.x, 2.0 * half.y);
        let (wide, thin) = (max(x, y), min(x, y));
        let slender = thin / wide;
        let slender4 = slender * slender * slender * slender;
        Self {
            half,
            area: x * y,
            bending: Vec2::new(y * x * x * x, x * y * y * y) / 12.0,
            // Roark: 0.1406 b^4 for the square
            torsion: wide * thin * thin * thin * (1.0 / 3.0 - 0.21 * slender * (1.0 - slender4 / 12.0)),
            diagonal: 1.0,
        }
    }

    /// Ellipse of semi-axes `half`.
    pub fn ellipse(half: Vec2) -> Self {
        let (a, b) = (half.x, half.y);
        Self {
            half,
            area: PI * a * b,
            bending: Vec2::new(a * a, b * b) * (0.25 * PI * a * b),
            torsion: PI * a * a * a * b * b * b / (a * a + b * b),
            diagonal: core::f32::consts::FRAC_1_SQRT_2,
        }
    }

    /// The widest section of a shape; `None` for a half space.
    pub fn of(object: &ObjectShape<'_>) -> Option<Self> {
        match *object {
            ObjectShape::HalfSpace => None,
            ObjectShape::Mesh(mesh) => Self::of(&mesh.stand_in()),
            ObjectShape::Box { size: Vec3 { x, y, .. } } => Some(Self::rectangle(0.5 * Vec2::new(x, y))),
            ObjectShape::Cylinder { radius, .. } | ObjectShape::Sphere { radius } => Some(Self::ellipse(Vec2::splat(radius))),
            ObjectShape::Ellipsoid { semi_axes } => Some(Self::ellipse(Vec2::new(semi_axes.x, semi_axes.y))),
        }
    }

    /// Width of the section at the height `z` over that of the widest one: 1 for columns, less towards the ends of round bodies.
    pub fn width_at(object: &ObjectShape<'_>, z: f32) -> f32 {
        if !is_round(object) {
            return 1.0;
        }
        let from_middle = 2.0 * z / object.height() - 1.0;
        root(max(1.0 - from_middle * from_middle, 0.0))
    }

    /// The same section with all lengths times `width`.
    #[must_use]
    pub fn scaled(&self, width: f32) -> Self {
        let (w2, w4) = (width * width, width * width * width * width);
        Self {
            half: self.half * width,
            area: self.area * w2,
            bending: self.bending * w4,
            torsion: self.torsion * w4,
            diagonal: self.diagonal,
        }
    }

    /// Polar second moment of area \[m^4\].
    pub fn polar(&self) -> f32 {
        self.bending.x + self.bending.y
    }
}

/// Whether the body narrows towards both ends.
pub fn is_round(object: &ObjectShape<'_>) -> bool {
    match object {
        ObjectShape::Sphere { .. } | ObjectShape::Ellipsoid { .. } => true,
        ObjectShape::Mesh(mesh) => is_round(&mesh.stand_in()),
        ObjectShape::HalfSpace | ObjectShape::Box { .. } | ObjectShape::Cylinder { .. } => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_sections() {
        let square = Section::rectangle(Vec2::splat(0.5));
        assert!((square.torsion - 0.1406).abs() < 4.0e-4 && (square.bending.x - 1.0 / 12.0).abs() < 1.0e-6);
        let circle = Section::ellipse(Vec2::splat(1.0));
        assert!((circle.torsion / circle.polar() - 1.0).abs() < 1.0e-6);
        let ball = ObjectShape::Sphere { radius: 0.05 };
        assert_eq!(Section::width_at(&ball, 0.05), 1.0);
        assert_eq!(Section::width_at(&ball, 0.1), 0.0);
    }
}

//! Triangles that are drawn together, and how.

use glam::Vec3;

use crate::feed::Pose;

/// A colour, sRGB, and how much of what lies behind it covers.
pub type Colour = [u8; 4];

/// Triangles of one look: what a graphics driver and the rasteriser both take.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    /// Vertices in the frame of `place` \[m\].
    pub positions: Vec<Vec3>,
    /// Unit normals, one for each vertex.
    pub normals: Vec<Vec3>,
    /// Colours in full light, one for each vertex.
    pub colours: Vec<Colour>,
    /// Corners as indices of the vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Where it stands in world.
    pub place: Pose,
    /// How it is drawn.
    pub paint: Paint,
    /// Grows whenever vertices change; a driver need not be told of others.
    pub vertices_version: u64,
    /// Grows whenever triangles change.
    pub triangles_version: u64,
}

/// How triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint {
    /// Share of what lies behind that is covered, 0 to 1; times that of the colours.
    pub opacity: f32,
    /// Lit by the lights; otherwise the colours as they are.
    pub lit: bool,
    /// Faces that look away are left out.
    pub one_sided: bool,
    /// What is behind it is hidden, also from what is drawn later.
    pub hides: bool,
    /// How much nearer to the eye it counts than it is, so that it lies upon what it touches \[m\].
    pub lift: f32,
    /// Opacity where something lies before it; 0 = hidden as usual.
    pub behind: f32,
    /// The line (unit vector) along which one may look at it end on, hiding all below: it then turns transparent. Zero = none.
    pub axis: Vec3,
}

impl Default for Paint {
    fn default() -> Self {
        Self { opacity: 1.0, lit: true, one_sided: false, hides: true, lift: 0.0, behind: 0.0, axis: Vec3::ZERO }
    }
}

/// Cosine to the axis from which on an arrow fades, and at which it is at its faintest.
const FADE: (f32, f32) = (0.90, 0.985);

/// Opacity of an arrow looked at end on.
const END_ON: f32 = 0.25;

impl Paint {
    /// The opacity for an eye in the direction `towards` (unit vector).
    pub fn opacity_from(&self, towards: Vec3) -> f32 {
        let share = ((self.axis.dot(towards).abs() - FADE.0) / (FADE.1 - FADE.0)).clamp(0.0, 1.0);
        self.opacity * (1.0 + share * (END_ON - 1.0))
    }
}

impl Batch {
    /// Nothing, to be drawn with `paint`.
    pub fn new(paint: Paint) -> Self {
        Self { paint, ..Self::default() }
    }

    /// Adds a vertex; its number.
    pub fn push(&mut self, position: Vec3, normal: Vec3, colour: Colour) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.colours.push(colour);
        self.positions.len() as u32 - 1
    }

    /// Removes all, to be filled anew.
    pub fn clear(&mut self) {
        self.positions.clear();
        self.normals.clear();
        self.colours.clear();
        self.triangles.clear();
        self.touch();
    }

    /// Everything counts as changed.
    pub fn touch(&mut self) {
        self.vertices_version += 1;
        self.triangles_version += 1;
    }

    /// Nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty() || self.paint.opacity <= 0.0
    }
}

//! Stations of the skeleton, and the **anchors** on the surface in which their cross beams end.
//!
//! ```text
//!   7---3---5       0 1  along x      4..7  along the diagonals
//!   |   |   |       2 3  along y
//!   1---+---0
//!   |   |   |
//!   6---2---4       seen from above; + is the body's axis
//! ```

use glam::{Vec2, Vec3};

use crate::math::max;
use crate::model::ObjectShape;
use crate::surface::section::Section;

/// Stations from the base to the top.
pub const STATIONS: usize = 13;

/// Anchors of a station.
pub const ANCHORS: usize = 8;

/// Directions of the anchors, in half widths; diagonals count as far as the section reaches.
const DIRECTIONS: [(f32, f32); ANCHORS] =
    [(1.0, 0.0), (-1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)];

/// Least width of a cross beam over the widest one: at a pole the section is a point, and the anchors stand this far beside it.
const LEAST_WIDTH: f32 = 0.05;

/// One station: a section of the body, and its cross beams' ends.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Height \[m\].
    pub z: f32,
    /// Half widths of the widest section \[m\], this station's width over them, and how far the diagonals reach.
    pub half: Vec2,
    /// Width of this section over the widest.
    pub width: f32,
    /// Reach of the diagonals in half widths.
    pub diagonal: f32,
    /// Motion of the section, summed over the patches.
    pub motion: Motion,
    /// Displacement of the axis \[m\], and its growth over a half width along x and y where the cross beams leave it.
    pub axis: Vec3,
    /// Growth over a half width along x, and along y \[m\].
    pub slopes: [Vec3; 2],
    /// Places of the anchors at rest \[m\], and their displacements \[m\].
    pub anchors: [(Vec3, Vec3); ANCHORS],
}

/// Motion of a section: shift, rotations and change of form.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Shift of the axis \[m\].
    pub shift: Vec3,
    /// Slope of the axis along x and y: the section tilts by it.
    pub slope: Vec2,
    /// Turn about the axis \[rad\].
    pub turn: f32,
    /// What the rim turns more, in the middle of the sides and in the corners \[rad\].
    pub rim_turn: [f32; 2],
    /// nu times the curvature of the axis along x and y \[1/m\].
    pub curved: Vec2,
    /// Growth of the section's lengths: minus nu times the strain along the axis.
    pub swell: f32,
    /// What free sides give way by \[m\].
    pub rim: Rim,
}

impl core::ops::AddAssign for Motion {
    fn add_assign(&mut self, other: Self) {
        self.shift += other.shift;
        self.slope += other.slope;
        self.turn += other.turn;
        self.rim_turn = [self.rim_turn[0] + other.rim_turn[0], self.rim_turn[1] + other.rim_turn[1]];
        self.curved += other.curved;
        self.swell += other.swell;
        self.rim += other.rim;
    }
}

/// How the free sides of a column give way to a level force, by the force's parts along x and y \[m\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Rim {
    /// Sides that look along the force go out by this, sides that look across follow it by that, corners by the third.
    pub ahead: Vec2,
    /// Of the sides that look across.
    pub aside: Vec2,
    /// Of the corners.
    pub corner: Vec2,
    /// Corners also spread at right angles to the force.
    pub spread: Vec2,
    /// Sides that look along the force go down, and corners by the other.
    pub down: Vec2,
    /// Of the corners.
    pub corner_down: Vec2,
}

impl Rim {
    const NONE: Self = Self {
        ahead: Vec2::ZERO,
        aside: Vec2::ZERO,
        corner: Vec2::ZERO,
        spread: Vec2::ZERO,
        down: Vec2::ZERO,
        corner_down: Vec2::ZERO,
    };

    /// Under a force of `force` = F/(G width) \[m\], at the share `t` of the way from one width below the patch up to it.
    ///
    /// Fitted to the drag of bonded discs on the cube, nu 0.3 and 0.5: in these units the four radii of 5 to 30 mm agree.
    pub fn under(force: Vec2, t: f32, nu: f32) -> Self {
        let s = (1.0 - 2.0 * nu) / 0.4;
        let t2 = t * t;
        let t8 = t2 * t2 * t2 * t2;
        Self {
            ahead: force * (0.09 + 0.10 * t * t2 + s * (0.19 * t - 0.06)),
            aside: force * (0.08 - 0.09 * t8 * t2 + s * 0.13 * t),
            corner: force * (0.06 - 0.06 * t8 + s * (0.14 * t - 0.01)),
            spread: force * (0.02 + 0.06 * t),
            down: force * (0.21 * t2 + s * 0.35 * t * (1.0 - t)),
            corner_down: force * (0.045 + s * 0.07),
        }
    }

    /// Displacement of anchor `i`.
    fn at(&self, i: usize) -> Vec3 {
        let (ex, ey) = DIRECTIONS.get(i).copied().unwrap_or_default();
        match i {
            0 | 1 => Vec3::new(self.ahead.x, self.aside.y, -ex * self.down.x),
            2 | 3 => Vec3::new(self.aside.x, self.ahead.y, -ey * self.down.y),
            _ => Vec3::new(
                self.corner.x + ex * ey * self.spread.y,
                self.corner.y + ex * ey * self.spread.x,
                -ex * self.corner_down.x - ey * self.corner_down.y,
            ),
        }
    }
}

impl core::ops::AddAssign for Rim {
    fn add_assign(&mut self, other: Self) {
        self.ahead += other.ahead;
        self.aside += other.aside;
        self.corner += other.corner;
        self.spread += other.spread;
        self.down += other.down;
        self.corner_down += other.corner_down;
    }
}

impl Station {
    /// A place without extent.
    pub(super) const REST: Self = Self {
        z: 0.0,
        half: Vec2::ONE,
        width: 1.0,
        diagonal: 1.0,
        motion: Motion {
            shift: Vec3::ZERO,
            slope: Vec2::ZERO,
            turn: 0.0,
            rim_turn: [0.0; 2],
            curved: Vec2::ZERO,
            swell: 0.0,
            rim: Rim::NONE,
        },
        axis: Vec3::ZERO,
        slopes: [Vec3::ZERO; 2],
        anchors: [(Vec3::ZERO, Vec3::ZERO); ANCHORS],
    };

    /// The station at the height `z`.
    pub(super) fn at_rest(object: &ObjectShape<'_>, section: &Section, z: f32) -> Self {
        let width = max(Section::width_at(object, z), LEAST_WIDTH);
        let mut station = Self { z, half: section.half, width, diagonal: section.diagonal, ..Self::REST };
        for ((place, _), (i, &(x, y))) in station.anchors.iter_mut().zip(DIRECTIONS.iter().enumerate()) {
            let reach = if i < 4 { width } else { width * section.diagonal };
            *place = Vec3::new(x * reach * section.half.x, y * reach * section.half.y, z);
        }
        station
    }

    /// Moves the anchors with the section.
    pub(super) fn carry_anchors(&mut self) {
        let Motion { shift, slope, turn, swell, .. } = self.motion;
        self.axis = shift;
        self.slopes = [Vec3::new(swell, turn, -slope.x) * self.half.x, Vec3::new(-turn, swell, -slope.y) * self.half.y];
        for (i, (place, moved)) in self.anchors.iter_mut().enumerate() {
            let [side, corner] = self.motion.rim_turn;
            *moved = self.motion.at(*place, if i < 4 { side } else { corner }) + self.motion.rim.at(i);
        }
    }
}

impl Motion {
    /// Displacement of the point `p` of the section's rim that turns by `rim_turn` more than the axis.
    fn at(&self, p: Vec3, rim_turn: f32) -> Vec3 {
        let (x, y) = (p.x, p.y);
        let turn = self.turn + rim_turn;
        let Vec2 { x: along_x, y: along_y } = self.curved;
        let square = 0.5 * (x * x - y * y);
        self.shift
            + Vec3::new(
                -turn * y + self.swell * x + along_x * square + along_y * x * y,
                turn * x + self.swell * y - along_y * square + along_x * x * y,
                -self.slope.x * x - self.slope.y * y,
            )
    }
}

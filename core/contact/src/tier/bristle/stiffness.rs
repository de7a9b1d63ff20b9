//! Tangent stiffness of a patch: how its grip (Qx, Qy, T) changes with a shift (x, y, phi) at a state of stick and slip.

use glam::{Mat3, Vec2, Vec3};

use crate::patch::Shift;
use crate::tier::bristle::ring::{Ring, Rings};
use crate::tier::bristle::slip::Common;
use crate::tier::bristle::{AROUND, Layout};

/// The matrix K; rows Qx, Qy, T; columns x, y, phi.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness(Mat3);

impl Default for Stiffness {
    fn default() -> Self {
        Self(Mat3::ZERO)
    }
}

impl Stiffness {
    /// Every bristle sticks: the pairs cancel every mixed term.
    pub fn all_stuck(layout: &Layout, rings: &Rings) -> Self {
        debug_assert!(rings.len() <= layout.rings);
        let (mut drag, mut twist) = (0.0, 0.0);
        for ring in rings.as_slice() {
            drag += ring.drag * AROUND as f32;
            twist += ring.twist * ring.arm * AROUND as f32;
        }
        Self(Mat3::from_diagonal(Vec3::new(drag, drag, twist)))
    }

    /// Adds one bristle: k Pi, with Pi = 1 while it sticks and (cap/|trial|)(1 - n n^T) while it slides along n.
    pub fn add(&mut self, ring: &Ring, radial: Vec2, slides: bool, scale: f32, force: Vec2) {
        let hoop = radial.perp();
        let pull = |v: Vec2| if slides { across(v, force) * scale } else { v };
        let (x, y, turn) = (pull(Vec2::X) * ring.drag, pull(Vec2::Y) * ring.drag, pull(hoop) * ring.twist);
        let row = |v: Vec2| Vec3::new(v.x, v.y, ring.arm * hoop.dot(v));
        self.0 += Mat3::from_cols(row(x), row(y), row(turn));
    }

    /// Solves (1 + C K) d = rest. Zero where the matrix has no inverse, which a finite K >= 0 and C >= 0 do not reach.
    pub fn solve(&self, common: &Common, rest: Shift) -> Shift {
        let scale = Mat3::from_diagonal(Vec3::new(common.drag, common.drag, common.twist));
        let matrix = Mat3::IDENTITY + scale * self.0;
        let determinant = matrix.determinant();
        if !determinant.is_finite() || determinant.abs() < f32::MIN_POSITIVE {
            return Shift::default();
        }
        let d = matrix.inverse() * rest.drag.extend(rest.twist);
        Shift { drag: d.truncate(), twist: d.z }
    }
}

/// Part of `v` at right angles to `along`.
fn across(v: Vec2, along: Vec2) -> Vec2 {
    let size2 = along.length_squared();
    if size2 > 0.0 { v - along * (v.dot(along) / size2) } else { v }
}

//! Tangent stiffness of a patch: how its grip (Qx, Qy, T) changes with a shift (x, y, phi) at a state of stick and slip.

use glam::{Mat3, Vec2, Vec3};

use crate::lanes::Lanes;
use crate::patch::Shift;
use crate::tier::bristle::AROUND;
use crate::tier::bristle::quad::Lost;
use crate::tier::bristle::ring::Rings;
use crate::tier::bristle::slip::Common;

/// The matrix K; rows Qx, Qy, T; columns x, y, phi. Drag against drag is symmetric, drag against twist is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    xx: f32,
    xy: f32,
    yy: f32,
    /// Force over twist \[N/rad\].
    force_twist: Vec2,
    /// Torque over drag \[N m/m\].
    torque_drag: Vec2,
    /// Torque over twist \[N m/rad\].
    twist: f32,
}

impl Stiffness {
    /// Every bristle sticks: the pairs cancel every mixed term.
    pub fn all_stuck(rings: &Rings) -> Self {
        let (mut drag, mut twist) = (0.0, 0.0);
        for four in rings.fours() {
            // ring after ring: those outside the contact add nothing
            let ([a, b, c, d], [e, f, g, h]) = ((four.drag * AROUND as f32).0, (four.twist * four.arm * AROUND as f32).0);
            (drag, twist) = (drag + a + b + c + d, twist + e + f + g + h);
        }
        Self { xx: drag, xy: 0.0, yy: drag, force_twist: Vec2::ZERO, torque_drag: Vec2::ZERO, twist }
    }

    /// Takes away what bristles lose by sliding, in all.
    pub fn soften(&mut self, lost: &Lost) {
        let [xx, xy, yy] = lost.drag.map(Lanes::total);
        (self.xx, self.xy, self.yy) = (self.xx - xx, self.xy - xy, self.yy - yy);
        self.force_twist -= Vec2::new(lost.force_twist.0.total(), lost.force_twist.1.total());
        self.torque_drag -= Vec2::new(lost.torque_drag.0.total(), lost.torque_drag.1.total());
        self.twist -= lost.twist.total();
    }

    fn matrix(&self) -> Mat3 {
        let (a, b) = (self.force_twist, self.torque_drag);
        Mat3::from_cols(Vec3::new(self.xx, self.xy, b.x), Vec3::new(self.xy, self.yy, b.y), Vec3::new(a.x, a.y, self.twist))
    }

    /// Solves (1 + C K) d = rest. Zero where the matrix has no inverse, which a finite K >= 0 and C >= 0 do not reach.
    pub fn solve(&self, common: &Common, rest: Shift) -> Shift {
        let scale = Mat3::from_diagonal(Vec3::new(common.drag, common.drag, common.twist));
        let matrix = Mat3::IDENTITY + scale * self.matrix();
        let determinant = matrix.determinant();
        if !determinant.is_finite() || determinant.abs() < f32::MIN_POSITIVE {
            return Shift::default();
        }
        let d = matrix.inverse() * rest.drag.extend(rest.twist);
        Shift { drag: d.truncate(), twist: d.z }
    }
}

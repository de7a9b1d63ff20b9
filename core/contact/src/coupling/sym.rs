//! Symmetric 3x3 matrices and the one 6x6 solve of the coupling, without an index and without a division by a small pivot.
//!
//! A stiffness is a sum of positive terms, so every pivot of its elimination is at least that of the known part (mass and coupling). f32 keeps the known part next to
//! a contact up to [`STIFFEST`] times as stiff; a stiffer one is taken as that stiff (theory.md, equation 10.9).

use core::ops::{Add, Mul};

use glam::{Quat, Vec3};

use crate::math::{max, min};

/// How many times stiffer than mass and coupling a contact may enter: f32 then keeps 6 % of the soft directions. 1e6 x 0.8 kN/m is steel under a
/// ball of a metre.
const STIFFEST: f32 = 1.0e6;

/// Symmetric matrix, six numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sym3 {
    /// xx, yy, zz.
    pub diagonal: Vec3,
    /// xy, xz, yz.
    pub off: Vec3,
}

impl Sym3 {
    /// All zero.
    pub const ZERO: Self = Self { diagonal: Vec3::ZERO, off: Vec3::ZERO };

    /// `x` times the identity.
    pub const fn splat(x: f32) -> Self {
        Self { diagonal: Vec3::splat(x), off: Vec3::ZERO }
    }

    /// The dyad u u^T.
    pub fn dyad(u: Vec3) -> Self {
        Self { diagonal: u * u, off: Vec3::new(u.x * u.y, u.x * u.z, u.y * u.z) }
    }

    /// Matrix times vector.
    pub fn times(&self, v: Vec3) -> Vec3 {
        let (d, o) = (self.diagonal, self.off);
        Vec3::new(d.x * v.x + o.x * v.y + o.y * v.z, o.x * v.x + d.y * v.y + o.z * v.z, o.y * v.x + o.z * v.y + d.z * v.z)
    }

    /// Sum of the diagonal.
    pub fn trace(&self) -> f32 {
        self.diagonal.x + self.diagonal.y + self.diagonal.z
    }

    /// R S R^T: the same tensor in a frame from which `rotation` leads to this one.
    pub fn rotated(&self, rotation: Quat) -> Self {
        let (x, y, z) = (rotation * Vec3::X, rotation * Vec3::Y, rotation * Vec3::Z);
        let pair = |a: Vec3, b: Vec3, k: f32| {
            let off = Vec3::new(a.x * b.y + b.x * a.y, a.x * b.z + b.x * a.z, a.y * b.z + b.y * a.z);
            Self { diagonal: a * b * (2.0 * k), off: off * k }
        };
        let (d, o) = (self.diagonal, self.off);
        Self::dyad(x) * d.x + Self::dyad(y) * d.y + Self::dyad(z) * d.z + pair(x, y, o.x) + pair(x, z, o.y) + pair(y, z, o.z)
    }
}

impl Add for Sym3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { diagonal: self.diagonal + other.diagonal, off: self.off + other.off }
    }
}

impl Mul<f32> for Sym3 {
    type Output = Self;
    fn mul(self, k: f32) -> Self {
        Self { diagonal: self.diagonal * k, off: self.off * k }
    }
}

/// Factors L D L^T of a symmetric positive matrix.
#[derive(Clone, Copy, Debug)]
struct Factored {
    /// Pivots.
    d: Vec3,
    /// l21, l31, l32.
    l: Vec3,
}

impl Factored {
    /// Factors `a`, whose pivots are known to be at least `floor` > 0.
    fn new(a: &Sym3, floor: f32) -> Self {
        let d1 = max(a.diagonal.x, floor);
        let (l21, l31) = (a.off.x / d1, a.off.y / d1);
        let d2 = max(a.diagonal.y - l21 * a.off.x, floor);
        let middle = a.off.z - l31 * a.off.x;
        let l32 = middle / d2;
        let d3 = max(a.diagonal.z - l31 * a.off.y - l32 * middle, floor);
        Self { d: Vec3::new(d1, d2, d3), l: Vec3::new(l21, l31, l32) }
    }

    fn solve(&self, b: Vec3) -> Vec3 {
        let y1 = b.x;
        let y2 = b.y - self.l.x * y1;
        let y3 = b.z - self.l.y * y1 - self.l.z * y2;
        let x3 = y3 / self.d.z;
        let x2 = y2 / self.d.y - self.l.z * x3;
        let x1 = y1 / self.d.x - self.l.x * x2 - self.l.y * x3;
        Vec3::new(x1, x2, x3)
    }
}

/// Symmetric positive 6x6 matrix of translation and rotation, about the probe's mass centre in world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sym6 {
    /// Force for a translation \[N/m\].
    pub linear: Sym3,
    /// Torque for a translation: its rows x, y, z \[N\].
    pub mixed: [Vec3; 3],
    /// Torque for a rotation \[N m/rad\].
    pub angular: Sym3,
}

impl Sym6 {
    /// `self` times at most `k`, so that no entry is above [`STIFFEST`] times the known stiffness of its block.
    pub fn scaled_within(&self, k: f32, known: (f32, f32)) -> Self {
        let share = |known: f32, trace: f32| if k * trace > STIFFEST * known { STIFFEST * known / trace } else { k };
        self.scaled(min(share(known.0, self.linear.trace()), share(known.1, self.angular.trace())))
    }

    /// `self` times `k`.
    pub fn scaled(&self, k: f32) -> Self {
        Self { linear: self.linear * k, mixed: self.mixed.map(|row| row * k), angular: self.angular * k }
    }

    /// The diagonal blocks of a free body.
    pub const fn blocks(linear: Sym3, angular: Sym3) -> Self {
        Self { linear, mixed: [Vec3::ZERO; 3], angular }
    }

    /// The sum of both.
    pub fn plus(&self, other: &Self) -> Self {
        let ([x, y, z], [ox, oy, oz]) = (self.mixed, other.mixed);
        Self { linear: self.linear + other.linear, mixed: [x + ox, y + oy, z + oz], angular: self.angular + other.angular }
    }

    /// Adds a spring of stiffness `k` against the motion `u` . translation + `w` . rotation.
    pub fn add_spring(&mut self, u: Vec3, w: Vec3, k: f32) {
        let [x, y, z] = self.mixed;
        self.linear = self.linear + Sym3::dyad(u) * k;
        self.mixed = [x + u * (w.x * k), y + u * (w.y * k), z + u * (w.z * k)];
        self.angular = self.angular + Sym3::dyad(w) * k;
    }

    /// Force and torque of a motion.
    pub fn times(&self, v: Vec3, w: Vec3) -> (Vec3, Vec3) {
        let [x, y, z] = self.mixed;
        let force = self.linear.times(v) + x * w.x + y * w.y + z * w.z;
        (force, Vec3::new(x.dot(v), y.dot(v), z.dot(v)) + self.angular.times(w))
    }

    /// Motion under a force and a torque; `floors` are the least pivots of the two diagonal blocks, above 0.
    pub fn solve(&self, force: Vec3, torque: Vec3, floors: (f32, f32)) -> (Vec3, Vec3) {
        let [x, y, z] = self.mixed;
        let linear = Factored::new(&self.linear, floors.0);
        // the rotation's matrix once the translation follows it
        let (px, py, pz) = (linear.solve(x), linear.solve(y), linear.solve(z));
        let lost = Sym3 { diagonal: Vec3::new(x.dot(px), y.dot(py), z.dot(pz)), off: Vec3::new(x.dot(py), x.dot(pz), y.dot(pz)) };
        let free = linear.solve(force);
        let rest = torque - Vec3::new(x.dot(free), y.dot(free), z.dot(free));
        let w = Factored::new(&(self.angular + lost * -1.0), floors.1).solve(rest);
        (linear.solve(force - x * w.x - y * w.y - z * w.z), w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring matrix of a few legs on a heavy start.
    fn matrix() -> Sym6 {
        let mut a = Sym6::blocks(Sym3::splat(2.0), Sym3::splat(0.3));
        a.add_spring(Vec3::Z, Vec3::new(0.1, -0.2, 0.0), 50.0);
        a.add_spring(Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.3, 0.1, -0.4), 20.0);
        a.add_spring(Vec3::ZERO, Vec3::new(0.0, 0.6, 0.8), 3.0);
        a
    }

    #[test]
    fn the_solution_solves() {
        let a = matrix();
        let (f, t) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(0.5, 0.1, -0.7));
        let (v, w) = a.solve(f, t, (2.0, 0.3));
        let (f_back, t_back) = a.times(v, w);
        assert!((f_back - f).length() < 1.0e-4 && (t_back - t).length() < 1.0e-4, "{f_back} {t_back}");
    }

    #[test]
    fn next_to_a_contact_however_stiff_the_soft_directions_stay() {
        let (u, arm) = (Vec3::new(0.48, 0.6, 0.64), Vec3::new(0.01, 0.02, -0.03));
        for k in [1.0e3, 1.0e6, 1.0e12, 1.0e20] {
            let mut contact = Sym6::default();
            contact.add_spring(u, arm.cross(u), k);
            let known = (1.0e-3, 1.0e-6);
            let a = contact.scaled_within(1.0, known).plus(&Sym6::blocks(Sym3::splat(known.0), Sym3::splat(known.1)));
            let (v, w) = a.solve(u, arm.cross(u), known);
            assert!(v.length() < 1.0e-1 / known.0 && w.length() < 1.0e-1 * arm.length() / known.1, "{k}: {v} {w}");
            let across = Vec3::new(0.8, 0.0, -0.6);
            let (v, _) = a.solve(across, Vec3::ZERO, known);
            assert!((v.dot(across) * known.0 - 1.0).abs() < 0.2, "{k}: {v}");
        }
    }

    #[test]
    fn a_tensor_turns_with_its_frame() {
        let tensor = Sym3 { diagonal: Vec3::new(1.0, 2.0, 4.0), off: Vec3::new(0.1, -0.2, 0.3) };
        let q = Quat::from_xyzw(0.1, -0.4, 0.2, 0.9).normalize();
        let v = Vec3::new(0.3, -1.0, 0.7);
        let expected = q * tensor.times(q.conjugate() * v);
        assert!((tensor.rotated(q).times(v) - expected).length() < 1.0e-5);
        assert!((tensor.rotated(q).trace() - tensor.trace()).abs() < 1.0e-5);
    }
}

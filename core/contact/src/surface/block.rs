//! Points in fixed blocks, coordinate by coordinate, so that a compiler turns the loops over a block into vector instructions.
//!
//! Every point of a block goes through the same operations in the same order, whatever its neighbours are: a point's displacement has the
//! same bits in every block, in every build and on every machine. Additions, products, quotients and selects only: no function of the
//! platform, no fused operations, no reductions of floats.

use glam::Vec3;

/// Points in a block: a dozen arrays of it stay in the first cache, and loops of this length are neither unrolled nor left scalar.
pub(super) const BLOCK: usize = 64;

/// One number for each point of a block.
pub(super) type Lane = [f32; BLOCK];

/// A block of surface points and what has been found of their displacements.
pub(super) struct Block {
    /// Rest points in world \[m\].
    pub x: Lane,
    pub y: Lane,
    pub z: Lane,
    /// Displacements \[m\].
    pub ux: Lane,
    pub uy: Lane,
    pub uz: Lane,
}

impl Block {
    /// Up to [`BLOCK`] points; places without a point hold the origin.
    pub fn load(rest: &[Vec3]) -> Self {
        let mut block =
            Self { x: [0.0; BLOCK], y: [0.0; BLOCK], z: [0.0; BLOCK], ux: [0.0; BLOCK], uy: [0.0; BLOCK], uz: [0.0; BLOCK] };
        let places = block.x.iter_mut().zip(&mut block.y).zip(&mut block.z);
        for (p, ((x, y), z)) in rest.iter().zip(places) {
            (*x, *y, *z) = (p.x, p.y, p.z);
        }
        block
    }

    /// Hands the displacements of the first `count` points over; what is at or below `base` does not move.
    pub fn store(&self, base: f32, count: usize, moved: &mut [Vec3]) {
        let found = self.ux.iter().zip(&self.uy).zip(&self.uz).zip(&self.z).take(count);
        for (u, (((&x, &y), &z), &height)) in moved.iter_mut().zip(found) {
            *u = if height - base > 0.0 { Vec3::new(x, y, z) } else { Vec3::ZERO };
        }
    }
}

/// 1/sqrt(x) for normal x > 0, to 3e-7: a first guess from the exponent, a step of Newton's and one of third order. Products and sums only, so
/// that it vectorises and has the same bits everywhere.
#[inline(always)]
pub(super) fn inverse_root(x: f32) -> f32 {
    let y = f32::from_bits(GUESS.wrapping_sub(x.to_bits() >> 1));
    let y = y * (1.5 - (0.5 * x * y) * y);
    let t = x * y * y;
    y * (1.875 - t * (1.25 - 0.375 * t))
}

/// Bits of the guess: halves and negates the exponent; within 3.5 % everywhere, 0.2 % after the first step.
const GUESS: u32 = 0x5f37_59df;

/// The smaller, by a select.
#[inline(always)]
pub(super) fn less(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger, by a select.
#[inline(always)]
pub(super) fn more(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_good_to_three_in_ten_million() {
        let mut x = 1.0e-30_f32;
        while x < 1.0e12 {
            let exact = 1.0 / libm::sqrt(f64::from(x));
            let found = f64::from(inverse_root(x));
            assert!((found / exact - 1.0).abs() < 3.0e-7, "{x}: {found} {exact}");
            x *= 1.013_7;
        }
    }
}

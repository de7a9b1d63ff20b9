//! Four numbers side by side, each through the same operations: what a processor with vectors does at once, one without does one by one, to the same bits.
//!
//! Written out, not as loops: a build that does not optimise takes these a hundred times slower through closures.

use core::ops::{Add, AddAssign, Div, Mul, Sub};

use crate::math::{max, min, sqrt};

/// Numbers side by side: what every x86-64 takes at once.
pub const LANES: usize = 4;

/// Four numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(16))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// All the same.
    pub const fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    /// Their sum. A function of its own: inlined, the compiler turns the lanes about in every round of the loop that led to it.
    #[inline(never)]
    pub fn total(self) -> f32 {
        let [a, b, c, d] = self.0;
        (a + b) + (c + d)
    }

    /// Their square roots, of what is not negative. A function of its own, as [`total`](Self::total).
    #[inline(never)]
    pub fn roots(self) -> Self {
        self.roots_in_line()
    }

    /// The same in line, for where many lanes are in use: around a call each goes to memory and back.
    #[inline(always)]
    pub fn roots_in_line(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([sqrt(a), sqrt(b), sqrt(c), sqrt(d)])
    }

    /// How many whole steps each holds, `most` at most, and what is left above them; of numbers from 0 to 2^22.
    #[inline(always)]
    pub fn steps<const MOST: usize>(self) -> ([usize; LANES], Self) {
        const { assert!((MOST + 1).is_power_of_two(), "the steps are cut out of the bits") }
        // from here on floats are a whole number apart, and their last bits count
        let whole = Self::splat(8_388_608.0);
        let near = self + whole - whole;
        let ([a, b, c, d], [e, f, g, h]) = (near.0, self.0);
        let above = |near: f32, x: f32| if near > x { 1.0 } else { 0.0 };
        let steps = (near - Self([above(a, e), above(b, f), above(c, g), above(d, h)])).smaller(Self::splat(MOST as f32));
        let [a, b, c, d] = (steps + whole).0;
        let index = |x: f32| x.to_bits() as usize & MOST;
        ([index(a), index(b), index(c), index(d)], self - steps)
    }

    /// The larger of each pair.
    pub fn larger(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([max(a, e), max(b, f), max(c, g), max(d, h)])
    }

    /// The smaller of each pair.
    pub fn smaller(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([min(a, e), min(b, f), min(c, g), min(d, h)])
    }
}

impl Add for Lanes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a + e, b + f, c + g, d + h])
    }
}

impl AddAssign for Lanes {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Lanes {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a - e, b - f, c - g, d - h])
    }
}

impl Mul for Lanes {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a * e, b * f, c * g, d * h])
    }
}

impl Div for Lanes {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a / e, b / f, c / g, d / h])
    }
}

impl Add<Lanes> for f32 {
    type Output = Lanes;

    fn add(self, lanes: Lanes) -> Lanes {
        Lanes::splat(self) + lanes
    }
}

impl Sub<Lanes> for f32 {
    type Output = Lanes;

    fn sub(self, lanes: Lanes) -> Lanes {
        Lanes::splat(self) - lanes
    }
}

impl Mul<f32> for Lanes {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        self * Self::splat(factor)
    }
}

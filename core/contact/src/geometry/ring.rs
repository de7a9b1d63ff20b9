//! A convex polygon of twelve corners about an inner point, and what a half plane leaves of it, without building what is left.
//!
//! Area and first moment of a polygon are sums over its sides of what each spans with the origin. With the origin on the line of the cut, the side that the cut
//! makes spans nothing, and of another side counts the share that is left: all sides at once, four side by side.

use glam::Vec2;

use crate::geometry::outline::RAYS;
use crate::lanes::{LANES, Lanes};
use crate::math::max;

/// Fours of corners.
pub const FOURS: usize = RAYS / LANES;

const ZERO: Lanes = Lanes::splat(0.0);

/// Least length of a side that is shared out: one on the line is left whole.
const LEAST: Lanes = Lanes::splat(f32::MIN_POSITIVE);

const _: () = assert!(FOURS == 3, "corners are told in three fours");

/// Places x and y of the corners, counter-clockwise \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring(pub [[Lanes; 2]; FOURS]);

/// Area and first moment about an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spanned {
    /// Area \[m^2\].
    pub area: f32,
    /// Centroid \[m\].
    pub centroid: Vec2,
}

impl Ring {
    /// Of these corners.
    pub const fn new(corners: [Vec2; RAYS]) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = corners;
        Self([four(a, b, c, d), four(e, f, g, h), four(i, j, k, l)])
    }

    /// Of at most as many corners: the last stands for those that are missing.
    pub fn of(corners: &[Vec2]) -> Self {
        let mut all = [corners.last().copied().unwrap_or_default(); RAYS];
        for (to, from) in all.iter_mut().zip(corners) {
            *to = *from;
        }
        Self::new(all)
    }

    /// The corners.
    pub fn corners(&self) -> [Vec2; RAYS] {
        let [
            [Lanes([a, b, c, d]), Lanes([m, n, o, p])],
            [Lanes([e, f, g, h]), Lanes([q, r, s, t])],
            [Lanes([i, j, k, l]), Lanes([u, v, w, x])],
        ] = self.0;
        [(a, m), (b, n), (c, o), (d, p), (e, q), (f, r), (g, s), (h, t), (i, u), (j, v), (k, w), (l, x)].map(Vec2::from)
    }

    /// Drawn in about the origin.
    pub fn scaled(&self, scale: f32) -> Self {
        Self(self.0.map(|[x, y]| [x * scale, y * scale]))
    }

    /// How far the corners reach along a vector, in lengths of it.
    pub fn reach(&self, along: Vec2) -> f32 {
        let [a, b, c] = self.0.map(|[x, y]| x * along.x + y * along.y);
        let Lanes([a, b, c, d]) = a.larger(b).larger(c);
        max(max(a, b), max(c, d))
    }

    /// Area and centroid of the whole, and of where normal . x <= limit; the centroid of nothing is the foot of the origin on the line.
    pub fn cut(&self, normal: Vec2, limit: f32) -> [Spanned; 2] {
        let foot = normal * (limit / max(normal.length_squared(), f32::MIN_POSITIVE));
        let here = self.0.map(|[x, y]| [x - Lanes::splat(foot.x), y - Lanes::splat(foot.y)]);
        let over = self.0.map(|[x, y]| x * normal.x + y * normal.y - Lanes::splat(limit));
        let ([xs, ys], next_over) = ([here.map(|[x, _]| x), here.map(|[_, y]| y)].map(following), following(over));
        let mut sums = [Lanes::default(); 6];
        let sides = here.into_iter().zip(xs).zip(ys).zip(over).zip(next_over);
        for (((([x, y], to_x), to_y), a), b) in sides {
            let (a_out, b_out) = (a.larger(ZERO), b.larger(ZERO));
            let (outside, inside) = (a_out + b_out, (a_out - a) + (b_out - b));
            let share = Lanes::splat(1.0) / (outside + inside).larger(LEAST);
            let (first, last) = (a_out * share, b_out * share);
            let spanned = x * to_y - y * to_x;
            let kept = spanned * (inside * share);
            let (middle_x, middle_y, shift) = (x + to_x, y + to_y, first - last);
            let [whole, whole_x, whole_y, left, left_x, left_y] = &mut sums;
            *whole += spanned;
            *whole_x += middle_x * spanned;
            *whole_y += middle_y * spanned;
            *left += kept;
            *left_x += (middle_x + (to_x - x) * shift) * kept;
            *left_y += (middle_y + (to_y - y) * shift) * kept;
        }
        let [whole, whole_x, whole_y, left, left_x, left_y] = sums.map(Lanes::sum);
        let spanned = |twice: f32, x: f32, y: f32| {
            let middle = if twice > 0.0 { Vec2::new(x, y) / (3.0 * twice) } else { Vec2::ZERO };
            Spanned { area: max(0.5 * twice, 0.0), centroid: foot + middle }
        };
        [spanned(whole, whole_x, whole_y), spanned(left, left_x, left_y)]
    }
}

/// Four corners side by side.
const fn four(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> [Lanes; 2] {
    [Lanes([a.x, b.x, c.x, d.x]), Lanes([a.y, b.y, c.y, d.y])]
}

/// What stands one place on, round.
fn following(fours: [Lanes; FOURS]) -> [Lanes; FOURS] {
    let [Lanes([a, b, c, d]), Lanes([e, f, g, h]), Lanes([i, j, k, l])] = fours;
    [Lanes([b, c, d, e]), Lanes([f, g, h, i]), Lanes([j, k, l, a])]
}

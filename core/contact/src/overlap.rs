//! How the overlap of a part that has flats, edges or tips grows with its depth: cut at a few depths when the contact is found, read from a polynomial
//! as often as the depth is asked for, because a body that gives way shares the depth in several trials.
//!
//! Terms: the **overlap** at a depth is where the undeformed bodies would meet when pressed in by it; its **radius** is that of the disc of equal area; it
//! is **pressed** as a disc of that radius times the factor of a long footprint would be (theory.md, equations 3.6 to 3.11). Lengths \[m\].

use glam::Vec3;

use crate::geometry::edges::{Edges, Left};
use crate::geometry::outline::Levels;
use crate::geometry::slice::{Slice, slice};
use crate::math::{FRAC_1_SQRT_2, GAUSS_4, PI, clamp, ln, max, min, pow, root};
use crate::model::ProbeShape;

/// Depths that are cut, as square roots of their share of the whole: [`PLACES`], and half the depth, which tells how the radius grows.
const CUTS: [f32; 6] = [GAUSS_4[0].0, GAUSS_4[1].0, GAUSS_4[2].0, FRAC_1_SQRT_2, GAUSS_4[3].0, 1.0];

/// The places at which the load is integrated over the whole depth, and the whole. The radius of a power profile is a polynomial of these roots.
const PLACES: [f32; 5] = [GAUSS_4[0].0, GAUSS_4[1].0, GAUSS_4[2].0, GAUSS_4[3].0, 1.0];

/// An overlap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlap {
    /// Radius of the disc of equal area \[m\].
    pub radius: f32,
    /// The radius times the factor of a long footprint \[m\].
    pub pressed: f32,
    /// How many times longer than wide it is.
    pub aspect: f32,
}

impl Overlap {
    fn new(area: f32, aspect: f32) -> Self {
        let radius = root(area / PI);
        Self { radius, pressed: radius * long_factor(aspect), aspect }
    }
}

/// The overlap from no depth to that of the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Depth of the contact \[m\].
    depth: f32,
    radius: Quartic,
    pressed: Quartic,
    /// Radius at half the depth over that of the polynomial.
    half: f32,
    /// Aspect at the depth of the contact.
    aspect: f32,
}

impl Growth {
    fn new(depth: f32, cuts: &[Overlap; CUTS.len()]) -> Self {
        let [a, b, c, half, d, e] = *cuts;
        let radius = Quartic::through([a, b, c, d, e].map(|cut| cut.radius));
        let pressed = Quartic::through([a, b, c, d, e].map(|cut| cut.pressed));
        let read = radius.at(FRAC_1_SQRT_2);
        Self { depth, radius, pressed, half: if read > 0.0 { half.radius / read } else { 1.0 }, aspect: max(e.aspect, 1.0) }
    }

    /// The overlap of a mesh up to `depth` \[m\], at most of the area `widest` \[m^2\].
    pub fn of_outlines(levels: &Levels, depth: f32, widest: f32) -> Self {
        let cut = |s: f32| {
            let (area, aspect) = levels.at(depth * s * s);
            Overlap::new(min(area, widest), aspect)
        };
        Self::new(depth, &CUTS.map(cut))
    }

    /// The same for a contact that has grown deeper since it was seen: to `depth` \[m\], by the power of the depth that it grew with there.
    pub fn stretched(&self, depth: f32) -> Self {
        if depth <= self.depth {
            return *self;
        }
        let growth = self.radius(1.0) / self.half(1.0);
        // also false for none
        let power = if growth > 1.0 { min(ln(growth) / ln(2.0), 1.0) } else { 0.0 };
        let factor = pow(depth / self.depth, power);
        Self { depth, radius: self.radius.times(factor), pressed: self.pressed.times(factor), ..*self }
    }

    /// Square root of the share of the contact's depth that `depth` \[m\] is; beyond it the overlap grows no more.
    pub fn share(&self, depth: f32) -> f32 {
        root(min(depth / self.depth, 1.0))
    }

    /// Radius at half the depth that a root of a share stands for \[m\].
    pub fn half(&self, s: f32) -> f32 {
        self.half * self.radius.at(s * FRAC_1_SQRT_2)
    }

    /// Radius at a square root of a share of the depth \[m\].
    pub fn radius(&self, s: f32) -> f32 {
        self.radius.at(s)
    }

    /// The same times the factor of a long footprint \[m\].
    pub fn pressed(&self, s: f32) -> f32 {
        self.pressed.at(s)
    }

    /// How many times longer than wide the overlap is at the depth of the contact, 1 where it is round.
    pub const fn aspect(&self) -> f32 {
        self.aspect
    }
}

/// Polynomial through the values at [`PLACES`], by divided differences, kept between 0 and the largest of them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Quartic {
    differences: [f32; PLACES.len()],
    largest: f32,
}

impl Quartic {
    fn through(values: [f32; PLACES.len()]) -> Self {
        let [a, b, c, d, e] = PLACES;
        let [va, vb, vc, vd, ve] = values;
        let (ab, bc, cd, de) = ((vb - va) / (b - a), (vc - vb) / (c - b), (vd - vc) / (d - c), (ve - vd) / (e - d));
        let (abc, bcd, cde) = ((bc - ab) / (c - a), (cd - bc) / (d - b), (de - cd) / (e - c));
        let (abcd, bcde) = ((bcd - abc) / (d - a), (cde - bcd) / (e - b));
        let differences = [va, ab, abc, abcd, (bcde - abcd) / (e - a)];
        Self { differences, largest: max(max(max(va, vb), max(vc, vd)), ve) }
    }

    fn times(&self, factor: f32) -> Self {
        Self { differences: self.differences.map(|value| value * factor), largest: self.largest * factor }
    }

    fn at(&self, s: f32) -> f32 {
        let [a, b, c, d, _] = PLACES.map(|place| s - place);
        let [first, second, third, fourth, fifth] = self.differences;
        clamp((((fifth * d + fourth) * c + third) * b + second) * a + first, 0.0, self.largest)
    }
}

/// A primitive that stands on an object.
#[derive(Clone, Copy, Debug)]
pub struct Standing<'a> {
    /// Its shape; no ball and no ellipsoid, which Hertz describes.
    pub shape: &'a ProbeShape<'static>,
    /// Direction into the object, in the part's frame.
    pub d: Vec3,
    /// How far the part reaches below its deepest point along `d` \[m\]: nothing but for the rounding of a normal, which tilts a wide flat by more than its depth, and where the deepest point was missed.
    pub below: f32,
    /// Edges of the object near it.
    pub edges: Option<&'a Edges>,
    /// Mean curvature of the object, none where it is flat or hollow \[1/m\].
    pub curvature: f32,
    /// Largest area the two can share \[m^2\].
    pub widest: f32,
}

impl Standing<'_> {
    /// How the overlap grows up to `used` \[m\], the part of the `depth` \[m\] that has a meaning, and the centre of the patch in the part's frame.
    pub fn growth(&self, depth: f32, used: f32) -> (Growth, Vec3) {
        let top = self.slice(depth);
        let fall = 0.5 * self.curvature / PI;
        let left = self.left(&top, if fall > 0.0 { min(depth / fall, top.area) } else { top.area }, depth);
        let middle = top.centroid + left.moved + self.d * depth;
        let (top, share) = if used < depth { (self.slice(used), None) } else { (top, Some(left.share)) };
        let cuts =
            if fall * top.area > FLAT_FALL * used { self.on_curved(used, fall, &top) } else { self.on_flat(used, &top, share) };
        (Growth::new(used, &cuts), middle)
    }

    /// The slice `z` \[m\] above the deepest point.
    fn slice(&self, z: f32) -> Slice {
        slice(self.shape, self.d, self.below + z)
    }

    /// What the object's edges leave of an overlap of this area in a slice.
    fn left(&self, slice: &Slice, area: f32, depth: f32) -> Left {
        self.edges.map_or(Left::ALL, |edges| edges.left(self.shape, slice, area, depth))
    }

    fn overlap(&self, area: f32, slice: &Slice, aspect: f32, depth: f32) -> Overlap {
        self.kept(area, aspect, self.left(slice, area, depth).share)
    }

    /// The overlap of this area and aspect, of which a share is left.
    fn kept(&self, area: f32, aspect: f32, share: f32) -> Overlap {
        // a strip that is cut is as much shorter
        Overlap::new(min(area * share, self.widest), 1.0 + (aspect - 1.0) * share)
    }

    /// On a flat face the overlap is the slice at the depth; of the `top` one the share may be known.
    fn on_flat(&self, depth: f32, top: &Slice, share: Option<f32>) -> [Overlap; CUTS.len()] {
        CUTS.map(|s| {
            let depth = depth * s * s;
            let slice = if s < 1.0 { self.slice(depth) } else { *top };
            let share = share.filter(|_| s == 1.0).unwrap_or_else(|| self.left(&slice, slice.area, depth).share);
            self.kept(slice.area, slice.aspect, share)
        })
    }

    /// On a curved object it is the slice whose height and the object's own fall, `fall` times the area, add up to the depth. With the height x^2 and the fall y^2, as
    /// shares of the whole depth, the place s lies where the curve y(x) meets the circle of radius s (equation 3.11): found by secants of the curve, of which
    /// each meets the circle in closed form. A flat end is a level line, a ball's cap one through the middle: both are found at once.
    fn on_curved(&self, depth: f32, fall: f32, top: &Slice) -> [Overlap; CUTS.len()] {
        let unit = root(fall / depth);
        let mut last = (1.0, unit * root(top.area));
        let mut line = Line::through((0.0, 0.0), last);
        let mut cuts = [Overlap::default(); CUTS.len()];
        let (mut slice, mut wider) = (*top, *top);
        for (cut, s) in cuts.iter_mut().rev().zip(CUTS.into_iter().rev()) {
            for _ in 0..SECANTS {
                let x = clamp(line.meets(s), LOWEST * s, s);
                let found = self.slice(depth * x * x);
                if found.area < slice.area {
                    wider = slice;
                }
                slice = found;
                let next = (x, unit * root(slice.area));
                let off = (next.1 - line.at(x)).abs();
                line = Line::through(last, next);
                last = next;
                if off <= MET * s {
                    break;
                }
            }
            let x = clamp(line.meets(s), 0.0, s);
            // where the slice widens fast the height is the surer figure, where the object is nearly flat the slice is
            let y = if 2.0 * x < s { root(s * s - x * x) } else { clamp(line.at(x), 0.0, s) };
            let area = depth * y * y / fall;
            // at a corner of the curve the last slice may be far too small; the one before it has the shape when it is drawn in
            let near = if slice.area < CORNERED * area && wider.area > slice.area { &wider } else { &slice };
            // the part of the depth that the object's own fall makes is round
            let aspect = 1.0 + (near.aspect - 1.0) * (x / s) * (x / s);
            *cut = self.overlap(area, near, aspect, depth * s * s);
        }
        cuts
    }
}

/// An object that falls off by less than this share of the depth under the whole slice is flat.
const FLAT_FALL: f32 = 1.0e-6;

/// Secants for each place, at most: the curve hardly bends, and each place starts from the line of the one before. Where a flat fills it has a corner.
const SECANTS: usize = 4;

/// Share of the overlap's area below which a slice is not its shape.
const CORNERED: f32 = 0.5;

/// A curve that is off its secant by less than this share of the root meets the next secant closer by a hundredth of it.
const MET: f32 = 3.0e-3;

/// Root of the least height that is cut, as a share of the depth's: a flat that rests on the object's own fall is cut at a 128th of the depth.
const LOWEST: f32 = 0.088;

/// A straight line y = rise + slope x.
#[derive(Clone, Copy)]
struct Line {
    rise: f32,
    slope: f32,
}

impl Line {
    /// Through two points, or through the second and the middle where they are one.
    fn through((x0, y0): (f32, f32), (x1, y1): (f32, f32)) -> Self {
        let slope = if (x1 - x0).abs() > SAME * x1 { (y1 - y0) / (x1 - x0) } else { y1 / x1 };
        Self { rise: y1 - slope * x1, slope }
    }

    fn at(self, x: f32) -> f32 {
        self.rise + self.slope * x
    }

    /// Where it leaves the circle of radius `s` about the middle to the right; its nearest point where it misses the circle.
    fn meets(self, s: f32) -> f32 {
        let steep = 1.0 + self.slope * self.slope;
        (root(s * s * steep - self.rise * self.rise) - self.rise * self.slope) / steep
    }
}

/// Share by which two places differ at least to tell a slope.
const SAME: f32 = 1.0e-3;

/// Steps of the arithmetic-geometric mean: quadratic, so that four settle an aspect of 1e4 to f32.
const MEAN_STEPS: usize = 4;

/// How much stiffer an ellipse of this aspect is than the disc of equal area (theory.md, equation 3.9).
fn long_factor(aspect: f32) -> f32 {
    if aspect <= 1.0 {
        return 1.0;
    }
    let (mut a, mut g) = (1.0, 1.0 / aspect);
    for _ in 0..MEAN_STEPS {
        (a, g) = (0.5 * (a + g), root(a * g));
    }
    root(aspect) * a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::deepest::Deepest;
    use crate::geometry::gap::Gap;
    use crate::geometry::support::support;
    use crate::math::{direction, perpendicular};
    use crate::model::ObjectShape;
    use glam::Quat;

    #[test]
    fn a_quartic_is_read_as_it_is() {
        let f = |s: f32| 0.01 * s * (1.0 + s * (2.0 - 0.5 * s * s));
        let quartic = Quartic::through(PLACES.map(f));
        for i in 0..=100 {
            let s = i as f32 * 0.01;
            assert!((quartic.at(s) - f(s)).abs() < 1.0e-8, "{s}: {} {}", quartic.at(s), f(s));
        }
    }

    /// What the secants find is the area at which height and fall add up, by halving.
    #[test]
    fn height_and_fall_add_up_to_the_depth() {
        let shapes = [
            ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) },
            ProbeShape::Cylinder { radius: 0.01, height: 0.04 },
            ProbeShape::Capsule { radius: 0.005, height: 0.03 },
            ProbeShape::Cone { radius: 0.02, height: 0.03 },
        ];
        let mut worst = 0.0;
        for (shape, tilt) in shapes.iter().flat_map(|shape| (0..157).map(move |i| (shape, i as f32 * 0.02))) {
            let d = Vec3::new(libm::sinf(tilt), 0.0, -libm::cosf(tilt));
            let standing = Standing { shape, d, below: 0.0, edges: None, curvature: 20.0, widest: f32::MAX };
            let depth = 1.0e-3;
            let (growth, _) = standing.growth(depth, depth);
            let fall = 10.0 / PI;
            for s in PLACES {
                let (mut low, mut high) = (0.0, depth * s * s);
                for _ in 0..24 {
                    let middle = 0.5 * (low + high);
                    if middle + fall * slice(shape, d, middle).area < depth * s * s { low = middle } else { high = middle }
                }
                let area = (depth * s * s - low) / fall;
                let found = growth.radius(s);
                let off = (found / root(area / PI) - 1.0).abs();
                worst = max(worst, off * s);
                assert!(off * s < 0.02, "{shape:?} tilt {tilt} place {s}: {found} {}", root(area / PI));
            }
        }
        assert!(worst > 0.0);
    }

    /// A normal that leans by rounding lifts one side of a wide flat by more than the depth: the flat still rests on the small face under its middle.
    #[test]
    fn a_flat_that_leans_by_rounding_rests_where_it_is_deepest() {
        let shape = ProbeShape::Box { size: Vec3::splat(0.012) };
        let object = ObjectShape::Box { size: Vec3::splat(1.0e-3) };
        let depth = 1.0e-6;
        for lean in [0.0, 1.0e-4, 3.0e-4, 1.0e-3] {
            let n = direction(Vec3::new(lean, 0.0, 1.0), Vec3::Z);
            let at = Deepest { point: Vec3::Z * (1.0e-3 - depth), gap: Gap { distance: -depth, normal: n } };
            let (lowest, frame) = (Vec3::Z * -0.006, [n, perpendicular(n), n.cross(perpendicular(n))]);
            let edges = Edges::about(&object, &at, frame, Quat::IDENTITY, lowest, 0.02).unwrap();
            let below = (support(&shape, -n) - lowest).dot(-n);
            let standing = Standing { shape: &shape, d: -n, below, edges: Some(&edges), curvature: 0.0, widest: f32::MAX };
            let radius = standing.growth(depth, depth).0.radius(1.0);
            assert!((PI * radius * radius * 1.0e6 - 1.0).abs() < 0.02, "{lean}: {radius}");
        }
    }
}

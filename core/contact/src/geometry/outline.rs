//! The overlap of a mesh part with the object at several depths: area, centroid and length over width, by rays.
//!
//! Terms: at **level** z the part is cut by a plane z above its deepest point, or on a curved object by the paraboloid of the object's
//! curvature moved in by z; the cut, seen along the normal, is the **outline**. In each of [`RAYS`] directions about a point inside, the
//! outline is met by Newton's method on the part's distance. Between two rays the outline is the parabola through both points with both
//! tangents, or, where it turns by more than an arc would, the corner (theory.md, section 3). Frame of the part, SI units.

use glam::{Vec2, Vec3};

use crate::geometry::curvature::Curvature;
use crate::geometry::distance_grid::DistanceGrid;
use crate::geometry::field::form;
use crate::math::{PI, clamp, max, min, root};

/// Rays about the centre. Twelve find the area of an ellipse of aspect 3 within 0.3 %.
pub const RAYS: usize = 12;

/// Levels that are cut, as square roots of their share of the depth: the slice radius of every power profile is a polynomial of these.
pub const LEVELS: [f32; 4] = [0.25, 0.5, 0.75, 1.0];

/// Newton steps of a ray of the first outline, which starts from a guess, and of the others, which start from their neighbour above.
const FIRST_STEPS: usize = 6;
const NEXT_STEPS: usize = 4;

/// A twelfth of a turn: half and half the root of three.
const HALF: f32 = 0.5;
const LONG: f32 = 0.866_025_4;

/// Unit vectors of the rays.
pub const DIRECTIONS: [Vec2; RAYS] = [
    Vec2::new(1.0, 0.0),
    Vec2::new(LONG, HALF),
    Vec2::new(HALF, LONG),
    Vec2::new(0.0, 1.0),
    Vec2::new(-HALF, LONG),
    Vec2::new(-LONG, HALF),
    Vec2::new(-1.0, 0.0),
    Vec2::new(-LONG, -HALF),
    Vec2::new(-HALF, -LONG),
    Vec2::new(0.0, -1.0),
    Vec2::new(HALF, -LONG),
    Vec2::new(LONG, -HALF),
];

/// One outline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outline {
    /// Area \[m^2\].
    pub area: f32,
    /// Centroid from the deepest point, in the tangent plane \[m\].
    pub centroid: Vec2,
    /// Second moments of the area about the centroid over the area: xx, xy, yy \[m^2\].
    spread: [f32; 3],
    /// Longer over shorter extent, 1 or more.
    pub aspect: f32,
    /// Points of the outline from the deepest point, in the tangent plane \[m\].
    pub corners: [Vec2; RAYS],
}

/// Where a part stands on the object.
#[derive(Clone, Copy, Debug)]
pub struct Stand<'a> {
    /// The part's distance.
    pub grid: &'a DistanceGrid<'a>,
    /// Its deepest point \[m\].
    pub lowest: Vec3,
    /// Unit normal out of the object and two tangents.
    pub frame: [Vec3; 3],
    /// The object's curvature in the tangents \[1/m\].
    pub object: Curvature,
    /// Radius of the ball that holds the part \[m\].
    pub reach: f32,
}

/// Where a ray meets the outline.
#[derive(Clone, Copy, Default)]
struct Hit {
    at: Vec2,
    /// Gradient of the part's distance along the cut.
    slope: Vec2,
}

impl Stand<'_> {
    /// Outlines at [`LEVELS`] of `depth` \[m\]: a first look from the deepest point, then from the middle, in the frame that makes it round.
    pub fn outlines(&self, depth: f32) -> [Outline; LEVELS.len()] {
        let first = self.outline(depth, &self.osculating(depth), &[1.0; RAYS], FIRST_STEPS);
        let mut view = View::of(&first.0, self.reach);
        let mut radii = [1.0; RAYS];
        let mut above = 1.0;
        let mut found = [Outline::default(); LEVELS.len()];
        for (outline, s) in found.iter_mut().rev().zip(LEVELS.into_iter().rev()) {
            // a convex part's cut holds the one above, shrunk towards the deepest point by the ratio of the levels
            let share = s / above;
            view.centre *= share * share;
            radii = radii.map(|radius| radius * share);
            (*outline, radii) = self.outline(depth * s * s, &view, &radii, NEXT_STEPS);
            above = s;
        }
        found
    }

    /// The ellipse in which the osculating paraboloid is cut, no longer than the part.
    fn osculating(&self, z: f32) -> View {
        let [_, e1, e2] = self.frame;
        let bent = form(&self.grid.field(self.lowest), e1, e2).plus(self.object);
        let (large, small) = bent.principal();
        let along = eigenvector(bent.k11, bent.k12, large);
        let extent = |k: f32| min(root(2.0 * z / max(k, 0.0)), self.reach);
        View { centre: Vec2::ZERO, axes: [along * extent(large), along.perp() * extent(small)] }
    }

    /// The outline at level `z` in a view, from a guess of the radii, and the radii.
    fn outline(&self, z: f32, view: &View, guess: &[f32; RAYS], steps: usize) -> (Outline, [f32; RAYS]) {
        let mut hits = [Hit::default(); RAYS];
        let mut radii = *guess;
        for ((hit, radius), ray) in hits.iter_mut().zip(&mut radii).zip(DIRECTIONS) {
            let ray = view.axes[0] * ray.x + view.axes[1] * ray.y;
            (*radius, hit.slope) = self.meet(z, view.centre, ray, *radius, steps);
            hit.at = ray * *radius;
        }
        let mut outline = enclosed(&hits);
        outline.centroid += view.centre;
        outline.corners = hits.map(|hit| hit.at + view.centre);
        (outline, radii)
    }

    /// Share of a ray at which it leaves the part, by Newton's method kept inside a bracket, and the slope of the distance last seen.
    fn meet(&self, z: f32, centre: Vec2, ray: Vec2, guess: f32, steps: usize) -> (f32, Vec2) {
        let (mut low, mut high) = (0.0, 2.0 * self.reach / root(ray.length_squared()));
        let mut share = clamp(guess, SHORTEST, high);
        let mut slope = Vec2::ZERO;
        for _ in 0..steps {
            let (value, gradient) = self.cut(z, centre + ray * share);
            slope = gradient;
            if value < 0.0 {
                low = share;
            } else {
                high = share;
            }
            let rise = gradient.dot(ray);
            let next = share - value / rise;
            let last = (next - share).abs() <= SETTLED * share;
            let farthest = min(high, WIDENING * share);
            share = if rise > 0.0 && next <= farthest {
                max(next, low)
            } else if value < 0.0 {
                farthest
            } else {
                0.5 * (low + high)
            };
            if last {
                break;
            }
        }
        (share, slope)
    }

    /// The part's distance and its gradient along the cut, at a place in the tangent plane.
    fn cut(&self, z: f32, at: Vec2) -> (f32, Vec2) {
        let [n, e1, e2] = self.frame;
        let fall = Vec2::new(self.object.k11 * at.x + self.object.k12 * at.y, self.object.k12 * at.x + self.object.k22 * at.y);
        let q = self.lowest + e1 * at.x + e2 * at.y + n * (z - 0.5 * fall.dot(at));
        let (value, gradient) = self.grid.slope(q);
        (value, Vec2::new(gradient.dot(e1), gradient.dot(e2)) - fall * gradient.dot(n))
    }
}

/// Shortest first guess of a ray, as a share of it.
const SHORTEST: f32 = 1.0e-3;

/// How far a ray that ends inside may be lengthened in a step: under a flat the distance says nothing of its rim.
const WIDENING: f32 = 4.0;

/// A ray that moved by less than this share of itself has settled: Newton's next step would be its square.
const SETTLED: f32 = 1.0e-3;

/// A centre and the two half axes that a circle of rays is stretched to \[m\].
struct View {
    centre: Vec2,
    axes: [Vec2; 2],
}

impl View {
    /// The view in which an outline is about a unit circle.
    fn of(outline: &Outline, reach: f32) -> Self {
        let [xx, xy, yy] = outline.spread;
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let apart = root(half * half + xy * xy);
        let along = eigenvector(xx, xy, mean + apart);
        // an ellipse's second moment is a quarter of its half axis squared
        let length = |moment: f32| clamp(2.0 * root(moment), SHORTEST * reach, reach);
        Self { centre: outline.centroid, axes: [along * length(mean + apart), along.perp() * length(mean - apart)] }
    }
}

/// Unit vector of the principal value `value` of the form (xx, xy; xy, yy).
pub fn eigenvector(xx: f32, xy: f32, value: f32) -> Vec2 {
    // of the two rows (xx - value, xy) and (xy, yy - value) at right angles to it, the first unless it vanishes
    let v = Vec2::new(xy, value - xx);
    let length = root(v.length_squared());
    if length > SMALLEST * value.abs() { v / length } else { Vec2::X }
}

/// Off-diagonal part below which a form counts as diagonal.
const SMALLEST: f32 = 1.0e-6;

/// Area, centroid and aspect of a closed convex curve given by points and normals about an inner point.
fn enclosed(hits: &[Hit; RAYS]) -> Outline {
    let (mut twice, mut moment) = (0.0, Vec2::ZERO);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    let mut last = hits.last().copied().unwrap_or_default();
    for &here in hits {
        let (u, v) = (last.at, here.at);
        let cross = u.perp_dot(v);
        twice += cross;
        moment += (u + v) * (cross / 3.0);
        xx += cross * (u.x * u.x + u.x * v.x + v.x * v.x);
        xy += cross * (u.x * u.y + 0.5 * (u.x * v.y + v.x * u.y) + v.x * v.y);
        yy += cross * (u.y * u.y + u.y * v.y + v.y * v.y);
        let (bulge, middle) = bulge(last, here);
        twice += bulge;
        moment += middle * bulge;
        (xx, xy, yy) = (
            xx + 6.0 * bulge * middle.x * middle.x,
            xy + 6.0 * bulge * middle.x * middle.y,
            yy + 6.0 * bulge * middle.y * middle.y,
        );
        last = here;
    }
    if twice <= 0.0 {
        return Outline { aspect: 1.0, ..Outline::default() };
    }
    let centroid = moment / twice;
    // second moments about the centroid, in the same twice-the-area measure
    let about = |m: f32, product: f32| m / 6.0 - twice * product;
    let (xx, xy, yy) =
        (about(xx, centroid.x * centroid.x), about(xy, centroid.x * centroid.y), about(yy, centroid.y * centroid.y));
    Outline {
        area: 0.5 * twice,
        centroid,
        spread: [xx / twice, xy / twice, yy / twice],
        aspect: aspect(xx, xy, yy),
        ..Outline::default()
    }
}

/// Ratio of the extents from second moments.
fn aspect(xx: f32, xy: f32, yy: f32) -> f32 {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let spread = root(half * half + xy * xy);
    let ratio = root((mean + spread) / (mean - spread));
    if ratio.is_finite() { clamp(ratio, 1.0, LONGEST) } else { 1.0 }
}

/// Longest outline told from a longer one by this many rays.
const LONGEST: f32 = 1.0e2;

/// Twice the area between the chord of two neighbouring hits and the outline, and its centroid.
///
/// The tangents meet in a point c; the parabola takes two thirds of the triangle, a corner all of it.
fn bulge(u: Hit, v: Hit) -> (f32, Vec2) {
    let chord = v.at - u.at;
    let length2 = chord.length_squared();
    let turn = u.slope.perp_dot(v.slope);
    let scale = root(u.slope.length_squared() * v.slope.length_squared());
    if turn <= STRAIGHT * scale || scale <= 0.0 {
        return (0.0, u.at);
    }
    // tangents are the slopes turned by a quarter; lengths along them to where they meet
    let (first, second) = (u.slope.dot(chord), v.slope.dot(chord));
    let triangle = -first * second / turn;
    if !(triangle > 0.0 && triangle <= 4.0 * length2) {
        return (0.0, u.at);
    }
    let apex = u.at + u.slope.perp() * (second / turn);
    let sharp = clamp((turn / scale - ARC_TURN) / (CORNER_TURN - ARC_TURN), 0.0, 1.0);
    let share = 2.0 / 3.0 + sharp * sharp * (3.0 - 2.0 * sharp) / 3.0;
    let middle = 0.5 * (u.at + v.at);
    (share * triangle, middle + (apex - middle) * (0.2 + 0.4 / 3.0 * (3.0 * share - 2.0)))
}

/// Sines of turn between two rays: below the first a straight side to f32, below the second an arc, above the third a corner.
const STRAIGHT: f32 = 1.0e-4;
const ARC_TURN: f32 = 0.7;
const CORNER_TURN: f32 = 0.98;

/// Radius and aspect between the levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Depth of the last level \[m\].
    depth: f32,
    /// Radii of the discs of equal area \[m\].
    radii: [f32; LEVELS.len()],
    aspects: [f32; LEVELS.len()],
}

impl Levels {
    /// Reads the outlines of `depth`.
    pub fn new(depth: f32, outlines: &[Outline; LEVELS.len()]) -> Self {
        let mut radii = outlines.map(|outline| root(outline.area / PI));
        // an overlap only grows with depth
        let mut least = 0.0;
        for radius in &mut radii {
            *radius = max(*radius, least);
            least = *radius;
        }
        Self { depth, radii, aspects: outlines.map(|outline| outline.aspect) }
    }

    /// Area \[m^2\] and aspect at `depth` \[m\]: Lagrange's cubic in the square root of the depth's share.
    pub fn at(&self, depth: f32) -> (f32, f32) {
        let s = root(min(depth / self.depth, 1.0));
        let [a, b, c, d] = LEVELS.map(|level| s - level);
        let weights = [-32.0 / 3.0 * b * c * d, 32.0 * a * c * d, -32.0 * a * b * d, 32.0 / 3.0 * a * b * c];
        let sum = |values: [f32; 4]| weights.iter().zip(values).map(|(w, v)| w * v).sum::<f32>();
        let radius = clamp(sum(self.radii), 0.0, self.radii[3]);
        (PI * radius * radius, max(sum(self.aspects), 1.0))
    }
}

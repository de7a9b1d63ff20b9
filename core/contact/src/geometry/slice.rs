//! Plane slices of convex parts that have flats, edges or tips: area and centroid at a height above the deepest point.
//!
//! The area fixes the footprint of such a part through the axisymmetric profile of equal slice area (theory.md, section 3).
//! Terms: `d` unit direction into the object in the part's frame, `z` height of the slice above the deepest point.

use glam::{Vec2, Vec3};

use crate::geometry::outline::eigenvector;
use crate::geometry::support::{reach, support};
use crate::lanes::Lanes;
use crate::math::{GAUSS_4, PI, direction, max, min, perpendicular, root};
use crate::model::ProbeShape;

/// Area and centroid of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Area \[m^2\].
    pub area: f32,
    /// Centroid in the part's frame \[m\].
    pub centroid: Vec3,
    /// Longer over shorter extent, 1 or more.
    pub aspect: f32,
    /// Unit vector along the longer extent in the part's frame, none where the slice is round.
    pub along: Vec3,
    /// Half sides of a rectangle about the centroid that holds the slice, along `along` and across, [`f32::MAX`] where none is known \[m\].
    pub within: [f32; 2],
}

impl Slice {
    /// From the extents along a unit vector and across it.
    fn new(area: f32, centroid: Vec3, (length, width): (f32, f32), [along, across]: [Vec3; 2]) -> Self {
        let (long, short, along) = if length >= width { (length, width, along) } else { (width, length, across) };
        let aspect = if short > 0.0 && long.is_finite() { min(long / short, LONGEST) } else { 1.0 };
        Self { area, centroid, aspect, along, within: [f32::MAX; 2] }
    }

    fn round(area: f32, centroid: Vec3) -> Self {
        Self { area, centroid, aspect: 1.0, along: Vec3::ZERO, within: [f32::MAX; 2] }
    }

    /// The same, known to keep within a rectangle of these half sides about its centroid \[m\].
    fn within(self, half: [f32; 2]) -> Self {
        Self { within: half, ..self }
    }
}

/// Longest footprint told from a longer one: the stiffness of a strip grows with the logarithm only.
const LONGEST: f32 = 1.0e4;

/// Corners of the slice of a box of half edges `half` through its point `centre` \[m\], from that point along the tangents `e1` and `e2`.
pub fn corners_of_box(half: Vec3, centre: Vec3, tangents: [Vec3; 2]) -> heapless::Vec<Vec2, MAX_CORNERS> {
    Polygon::in_box(half, centre, tangents).corners
}

/// Slice of `shape` at height `z` > 0 \[m\] above its deepest point along `d`.
pub fn slice(shape: &ProbeShape<'_>, d: Vec3, z: f32) -> Slice {
    match *shape {
        ProbeShape::Box { size } => of_box(0.5 * size, d, z),
        ProbeShape::Cylinder { radius, height } => of_cylinder(radius, height, d, z),
        ProbeShape::Capsule { radius, height } => of_capsule(radius, height, d, z),
        ProbeShape::Cone { radius, height } => of_cone(radius, height, d, z),
        ProbeShape::Sphere { .. } | ProbeShape::Ellipsoid { .. } | ProbeShape::Mesh(_) => of_smooth(shape, d, z),
    }
}

/// Paraboloid slice of a smooth part; smooth parts use Hertz and meshes their outlines instead, and come here only in tests of limits.
fn of_smooth(shape: &ProbeShape<'_>, d: Vec3, z: f32) -> Slice {
    let radius = reach(shape);
    let height = min(z, radius);
    Slice::round(PI * (2.0 * radius * height - height * height), support(shape, d) - d * z)
}

/// How a body of revolution stands: axis from its lower end upwards, and its tilt.
struct Tilt {
    /// Unit vector along the axis, from the lower end up (part frame).
    axis: Vec3,
    cos: f32,
    sin: f32,
}

impl Tilt {
    fn of(d: Vec3) -> Self {
        let axis = if d.z > 0.0 { -Vec3::Z } else { Vec3::Z };
        let cos = d.z.abs();
        let sin = root(1.0 - min(cos * cos, 1.0));
        Self { axis, cos, sin }
    }
}

/// Below this sine of tilt a flat end counts as level: 1e-6 rad lifts the edge of a metre-wide punch by 1 um.
const UPRIGHT_SINE: f32 = 1.0e-6;

/// A level end is a disc; all else by quadrature.
fn of_cylinder(radius: f32, height: f32, d: Vec3, z: f32) -> Slice {
    let trunk = Trunk { tip_radius: radius, growth: 0.0, height, start: Vec3::Z * (-0.5 * height) };
    if root(d.x * d.x + d.y * d.y) <= UPRIGHT_SINE {
        let end = Vec3::Z * if d.z > 0.0 { 0.5 * height } else { -0.5 * height };
        return Slice::round(PI * radius * radius, end - d * z);
    }
    trunk.cut(support(&ProbeShape::Cylinder { radius, height }, d), d, z)
}

/// A cone whose tip is lowest and whose slice stays inside it is cut in an ellipse; a level base in a disc; all else by quadrature.
fn of_cone(radius: f32, height: f32, d: Vec3, z: f32) -> Slice {
    let slant = root(radius * radius + height * height);
    let (sin_half, cos_half) = (radius / slant, height / slant);
    let (cos_tilt, sin_tilt) = (-d.z, root(d.x * d.x + d.y * d.y));
    if sin_tilt <= UPRIGHT_SINE && cos_tilt < 0.0 {
        let share = max(1.0 - z / height, 0.0);
        return Slice::round(PI * radius * radius * share * share, Vec3::Z * (0.25 * height - z));
    }
    // height of the lowest point of the base rim above the tip
    let rim = height * cos_tilt - radius * sin_tilt;
    if rim <= z || cos_tilt * cos_half <= sin_tilt * sin_half {
        let trunk = Trunk { tip_radius: 0.0, growth: radius / height, height, start: Vec3::Z * (-0.75 * height) };
        return trunk.cut(support(&ProbeShape::Cone { radius, height }, d), d, z);
    }
    // cos^2 tilt - sin^2 half, without its cancellation on flat cones
    let spread = (cos_tilt * cos_half - sin_tilt * sin_half) * (cos_tilt * cos_half + sin_tilt * sin_half);
    let area = PI * z * z * sin_half * sin_half * cos_half / (spread * root(spread));
    let horizontal = if sin_tilt > 0.0 { (Vec3::Z - d * d.z) / sin_tilt } else { Vec3::ZERO };
    let centre = z * sin_tilt * cos_tilt / spread;
    let middle = Vec3::Z * (-0.75 * height) - d * z + horizontal * centre;
    // semi-axes z sin(half) cos(half) / spread and z sin(half) / sqrt(spread)
    Slice::new(area, middle, (cos_half / spread, 1.0 / root(spread)), [horizontal, d.cross(horizontal)])
}

/// Six-point Gauss rule over the angle that takes up the square-root ends of a chord: place on -1..1 (sine of the angle) and weight (with the
/// cosine of the substitution) of a span of length 1.
const CHORDS: [(f32, f32); 6] = [
    (-0.994_379_16, 0.014_246_701),
    (-0.861_707_5, 0.143_768_98),
    (-0.366_107_02, 0.341_984_33),
    (0.366_107_02, 0.341_984_33),
    (0.861_707_5, 0.143_768_98),
    (0.994_379_16, 0.014_246_701),
];

/// A stack of circles along +z whose radius grows evenly: cylinder and cone.
struct Trunk {
    tip_radius: f32,
    /// Growth of the radius per length.
    growth: f32,
    height: f32,
    /// Centre of the first circle (part frame).
    start: Vec3,
}

impl Trunk {
    /// Slice at height `z` above the deepest point `lowest`: area = 1/sin(tilt) x integral over the axis of the chord of each circle.
    fn cut(&self, lowest: Vec3, d: Vec3, z: f32) -> Slice {
        let (rise, sine) = (-d.z, max(root(d.x * d.x + d.y * d.y), UPRIGHT_SINE));
        let across = (-d - Vec3::Z * rise) / sine;
        // height of the plane above the first circle's centre
        let level = z - (lowest - self.start).dot(d);
        let (low, high) = self.span(level, rise, sine);
        let (mut area, mut along, mut up, mut widest) = (0.0, 0.0, 0.0, 0.0);
        let (middle, length) = (0.5 * (low + high), high - low);
        for (place, weight) in CHORDS {
            let t = middle + 0.5 * length * place;
            let y = (level - t * rise) / sine;
            let radius = self.tip_radius + self.growth * t;
            let chord = 2.0 * root((radius - y) * (radius + y));
            let strip = chord * length * weight / sine;
            (area, along, up, widest) = (area + strip, along + strip * t, up + strip * y, max(widest, chord));
        }
        if area <= 0.0 {
            return Slice::round(0.0, lowest - d * z);
        }
        let centroid = self.start + Vec3::Z * (along / area) + across * (up / area);
        // the plane climbs along the axis; a chord lies level
        let chord = across.cross(Vec3::Z);
        Slice::new(area, centroid, ((high - low) / sine, widest), [chord.cross(d), chord])
    }

    /// Where on 0..=height the plane meets the circles: |level - rise t| <= sine (tip_radius + growth t).
    fn span(&self, level: f32, rise: f32, sine: f32) -> (f32, f32) {
        let (lean, reach) = (sine * self.growth, sine * self.tip_radius);
        let (mut low, mut high) = (0.0, self.height);
        for (slope, wanted) in [(rise + lean, level - reach), (lean - rise, -level - reach)] {
            // wanted <= slope t
            if slope > FLAT {
                low = max(low, wanted / slope);
            } else if slope < -FLAT {
                high = min(high, wanted / slope);
            } else if wanted > 0.0 {
                return (0.0, 0.0);
            }
        }
        (low, max(low, high))
    }
}

/// A slope below this reaches nothing within the largest part.
const FLAT: f32 = 1.0e-9;

/// The four-point rule side by side.
const PLACES: Lanes = Lanes([GAUSS_4[0].0, GAUSS_4[1].0, GAUSS_4[2].0, GAUSS_4[3].0]);
const WEIGHTS: Lanes = Lanes([GAUSS_4[0].1, GAUSS_4[1].1, GAUSS_4[2].1, GAUSS_4[3].1]);

fn of_capsule(radius: f32, height: f32, d: Vec3, z: f32) -> Slice {
    let tilt = Tilt::of(d);
    let end = -tilt.axis * (0.5 * height);
    let discs = |t: Lanes| {
        let depth = (Lanes::splat(z) - t * tilt.cos).larger(Lanes::splat(0.0)).smaller(Lanes::splat(radius));
        (depth * (2.0 * radius) - depth * depth).larger(Lanes::default()).roots()
    };
    let length = if tilt.cos * height > z { z / tilt.cos } else { height };
    let places = PLACES * length;
    let widths = discs(places) * WEIGHTS * (2.0 * tilt.sin * length);
    let (strip, moment) = (widths.total(), (widths * places).total());
    let Lanes([wide, far, ..]) = discs(Lanes([0.0, length, 0.0, length]));
    let cap = PI * wide * wide;
    let stadium = 0.5 * cap + strip + 0.5 * PI * far * far;
    if stadium <= cap {
        return Slice::round(cap, end + d * (radius - z)).within([wide + length * tilt.sin; 2]);
    }
    // the centroid leaves the end as the stadium outgrows the cap, without a step
    let lead = min((stadium - cap) / (0.5 * cap), 1.0);
    let along = lead * (moment + 0.5 * PI * far * far * length) / stadium;
    let centroid = end + tilt.axis * along + d * (along * tilt.cos + radius - z);
    let level = direction(tilt.axis - d * tilt.axis.dot(d), Vec3::X);
    let along = along * tilt.sin;
    let half = max(along, length * tilt.sin - along) + wide;
    let long = wide + length * tilt.sin + far;
    // a stadium shorter than wide is told the other way round
    let within = if long >= 2.0 * wide { [half, wide] } else { [wide, half] };
    Slice::new(stadium, centroid, (long, 2.0 * wide), [level, d.cross(level)]).within(within)
}

/// Corners a slice of a box may have while it is clipped: a square and one more for each of six cuts.
pub const MAX_CORNERS: usize = 10;

/// Area over squared extent below which a polygon is a sliver to f32.
const SLIVER: f32 = 1.0e-6;

/// Convex polygon in the slice plane.
struct Polygon {
    corners: heapless::Vec<Vec2, MAX_CORNERS>,
}

impl Polygon {
    fn square(half: f32) -> Self {
        let mut corners = heapless::Vec::new();
        for (x, y) in [(-half, -half), (half, -half), (half, half), (-half, half)] {
            let _ = corners.push(Vec2::new(x, y));
        }
        Self { corners }
    }

    /// What the plane of two unit tangents through `centre` leaves of a box.
    fn in_box(half: Vec3, centre: Vec3, [e1, e2]: [Vec3; 2]) -> Self {
        let mut polygon = Self::square(2.0 * root(half.length_squared()));
        for (axis, h) in [(Vec3::X, half.x), (Vec3::Y, half.y), (Vec3::Z, half.z)] {
            let n = Vec2::new(axis.dot(e1), axis.dot(e2));
            let offset = axis.dot(centre);
            polygon = polygon.clip(n, h - offset).clip(-n, h + offset);
        }
        polygon
    }

    /// Keeps the part where n . x <= limit (Sutherland and Hodgman).
    fn clip(&self, n: Vec2, limit: f32) -> Self {
        let mut corners = heapless::Vec::new();
        for (i, &here) in self.corners.iter().enumerate() {
            let next = self.corners[(i + 1) % self.corners.len()];
            let (a, b) = (n.dot(here) - limit, n.dot(next) - limit);
            if a <= 0.0 {
                let _ = corners.push(here);
            }
            if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                let _ = corners.push(here + (next - here) * (a / (a - b)));
            }
        }
        Self { corners }
    }

    fn area_and_centroid(&self) -> (f32, Vec2) {
        let Some(&origin) = self.corners.first() else { return (0.0, Vec2::ZERO) };
        let (mut twice, mut moment, mut reach2, mut mean) = (0.0, Vec2::ZERO, 0.0, Vec2::ZERO);
        for pair in self.corners.windows(2) {
            let (u, v) = (pair[0] - origin, pair[1] - origin);
            let cross = u.perp_dot(v);
            twice += cross;
            moment += (u + v) * cross;
            reach2 = max(reach2, v.length_squared());
            mean += v / self.corners.len() as f32;
        }
        // a sliver's area is rounding: its corners say better where it is
        if twice <= SLIVER * reach2 {
            (max(0.5 * twice, 0.0), origin + mean)
        } else {
            (0.5 * twice, origin + moment / (3.0 * twice))
        }
    }

    /// Square roots of the principal second moments about `centre`, whose ratio is that of the sides of a rectangle, and the unit vector of the larger. In multiples of
    /// `unit` \[m\], so that the moments' squares, eighth powers of a length, neither vanish nor overflow.
    fn extents(&self, centre: Vec2, unit: f32) -> ((f32, f32), Vec2) {
        let scale = 1.0 / unit;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (i, &here) in self.corners.iter().enumerate() {
            let (u, v) = ((here - centre) * scale, (self.corners[(i + 1) % self.corners.len()] - centre) * scale);
            let cross = u.perp_dot(v);
            xx += cross * (u.x * u.x + u.x * v.x + v.x * v.x);
            yy += cross * (u.y * u.y + u.y * v.y + v.y * v.y);
            xy += cross * (u.x * u.y + v.x * v.y + 0.5 * (u.x * v.y + u.y * v.x));
        }
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let spread = root(half * half + xy * xy);
        ((root(mean + spread), root(mean - spread)), eigenvector(xx, xy, mean + spread))
    }
}

fn of_box(half: Vec3, d: Vec3, z: f32) -> Slice {
    let lowest = half * Vec3::new(sign(d.x), sign(d.y), sign(d.z));
    let foot = lowest - d * z;
    let height = foot.dot(d);
    let e1 = perpendicular(d);
    let e2 = d.cross(e1);
    let centre = d * height;
    let polygon = Polygon::in_box(half, centre, [e1, e2]);
    let (area, at) = polygon.area_and_centroid();
    if area > 0.0 {
        let (extents, long) = polygon.extents(at, root(area));
        let along = e1 * long.x + e2 * long.y;
        Slice::new(area, centre + e1 * at.x + e2 * at.y, extents, [along, d.cross(along)])
    } else {
        Slice::round(area, foot)
    }
}

fn sign(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f32, b: f32, relative: f32) -> bool {
        (a - b).abs() <= relative * b.abs()
    }

    #[test]
    fn level_ends_and_tips() {
        let cases = [
            (ProbeShape::Cylinder { radius: 0.01, height: 0.04 }, -Vec3::Z, 1.0e-3, PI * 1.0e-4),
            (ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) }, -Vec3::Z, 1.0e-3, 6.0e-4),
            (ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) }, Vec3::X, 1.0e-3, 12.0e-4),
            (ProbeShape::Cone { radius: 0.01, height: 0.03 }, -Vec3::Z, 3.0e-3, PI * 1.0e-6),
            (ProbeShape::Capsule { radius: 0.01, height: 0.03 }, -Vec3::Z, 1.0e-3, PI * 1.9e-5),
            (ProbeShape::Cylinder { radius: 0.01, height: 0.04 }, Vec3::X, 1.0e-3, 0.04 * 2.0 * 4.358_899e-3),
        ];
        for (shape, d, z, area) in cases {
            let found = slice(&shape, d, z);
            assert!(near(found.area, area, 1.0e-4), "{shape:?} {d}: {found:?} expected {area}");
        }
    }

    #[test]
    fn a_box_of_a_micrometre_is_as_long_as_a_large_one() {
        let d = Vec3::new(0.0, libm::sinf(0.3), -libm::cosf(0.3));
        let aspect = |scale: f32| slice(&ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) * scale }, d, 1.0e-3 * scale).aspect;
        for scale in [1.0e-5, 1.0e-3, 1.0, 1.0e3, 1.0e5] {
            assert!(near(aspect(scale), aspect(1.0), 1.0e-4), "{scale}: {} {}", aspect(scale), aspect(1.0));
        }
    }

    #[test]
    fn a_tilted_cylinder_at_half_its_rim_height_shows_half_its_end() {
        let d = Vec3::new(libm::sinf(0.1), 0.0, -libm::cosf(0.1));
        let (radius, z) = (0.01, 0.01 * libm::sinf(0.1));
        let found = slice(&ProbeShape::Cylinder { radius, height: 0.04 }, d, z);
        let expected = crate::math::FRAC_PI_2 * radius * radius / libm::cosf(0.1);
        assert!(near(found.area, expected, 1.0e-3), "{found:?} {expected}");
    }

    #[test]
    fn areas_grow_with_height_and_change_little_with_tilt() {
        let shapes = [
            ProbeShape::Box { size: Vec3::new(0.02, 0.03, 0.04) },
            ProbeShape::Cylinder { radius: 0.01, height: 0.04 },
            ProbeShape::Capsule { radius: 0.005, height: 0.03 },
            ProbeShape::Cone { radius: 0.02, height: 0.03 },
        ];
        for shape in shapes {
            for i in 0..157 {
                let tilt = i as f32 * 0.02;
                let d = Vec3::new(libm::sinf(tilt), 0.0, -libm::cosf(tilt));
                let mut last = 0.0;
                for step in 1..20 {
                    let area = slice(&shape, d, step as f32 * 1.0e-4).area;
                    // a cone on its base narrows upwards
                    assert!(area.is_finite() && area >= last * 0.94, "{shape:?} tilt {tilt} step {step}: {area} < {last}");
                    last = area;
                }
            }
        }
    }
}

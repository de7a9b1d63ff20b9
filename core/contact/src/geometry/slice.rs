//! Plane slices of convex parts that have flats, edges or tips: area and centroid at a height above the deepest point.
//!
//! The area fixes the footprint of such a part through the axisymmetric profile of equal slice area (theory.md, section 3).
//! Terms: `d` unit direction into the object in the part's frame, `z` height of the slice above the deepest point.

use glam::{Vec2, Vec3};

use crate::geometry::support::{reach, support};
use crate::math::{GAUSS_4, PI, asin, clamp, cos, max, min, perpendicular, root, sin};
use crate::model::ProbeShape;

/// Area and centroid of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Area \[m^2\].
    pub area: f32,
    /// Centroid in the part's frame \[m\].
    pub centroid: Vec3,
}

/// Slice of `shape` at height `z` > 0 \[m\] above its deepest point along `d`.
pub fn slice(shape: &ProbeShape, d: Vec3, z: f32) -> Slice {
    match *shape {
        ProbeShape::Box { size } => of_box(0.5 * size, d, z),
        ProbeShape::Cylinder { radius, height } => of_cylinder(Vec3::ZERO, 0.5 * height, radius, d, z),
        ProbeShape::Capsule { radius, height } => of_capsule(radius, height, d, z),
        ProbeShape::Cone { radius, height } => of_cone(radius, height, d, z),
        ProbeShape::Sphere { .. } | ProbeShape::Ellipsoid { .. } => of_smooth(shape, d, z),
    }
}

/// Paraboloid slice of a smooth part; smooth parts use Hertz instead and come here only in tests of limits.
fn of_smooth(shape: &ProbeShape, d: Vec3, z: f32) -> Slice {
    let radius = reach(shape);
    let height = min(z, radius);
    Slice { area: PI * (2.0 * radius * height - height * height), centroid: support(shape, d) - d * z }
}

/// How a body of revolution stands: axis from its lower end upwards, and its tilt.
struct Tilt {
    /// Unit vector along the axis, from the lower end up (part frame).
    axis: Vec3,
    /// Unit vector across the axis, upwards, in the plane of tilt.
    across: Vec3,
    cos: f32,
    sin: f32,
}

impl Tilt {
    fn of(d: Vec3) -> Self {
        let axis = if d.z > 0.0 { -Vec3::Z } else { Vec3::Z };
        let cos = d.z.abs();
        let sin = root(1.0 - min(cos * cos, 1.0));
        let across = if sin > UPRIGHT_SINE { (-d - axis * cos) / sin } else { perpendicular(axis) };
        Self { axis, across, cos, sin }
    }
}

/// Below this sine of tilt a flat end counts as level: 1e-6 rad lifts the edge of a metre-wide punch by 1 um.
const UPRIGHT_SINE: f32 = 1.0e-6;

/// Below this cosine a cylinder counts as lying: the slice is the chord times the length.
const LYING_COSINE: f32 = 1.0e-4;

fn of_cylinder(centre: Vec3, half_height: f32, radius: f32, d: Vec3, z: f32) -> Slice {
    let tilt = Tilt::of(d);
    let end = centre - tilt.axis * half_height;
    if tilt.sin <= UPRIGHT_SINE {
        return Slice { area: PI * radius * radius, centroid: end + tilt.axis * z };
    }
    let height = z - radius * tilt.sin; // of the slice above the lower end's centre
    let lower = clamp((height - 2.0 * half_height * tilt.cos) / (tilt.sin * radius), -1.0, 1.0);
    let upper = clamp(height / (tilt.sin * radius), -1.0, 1.0);
    if tilt.cos < LYING_COSINE {
        let chord = 2.0 * radius * root(1.0 - upper * upper);
        let centroid = end + tilt.axis * half_height + tilt.across * (upper * radius);
        return Slice { area: chord * 2.0 * half_height, centroid };
    }
    let (low, high) = (asin(lower), asin(upper));
    let covered = (high + sin(high) * cos(high)) - (low + sin(low) * cos(low));
    let cubes = cos(low) * cos(low) * cos(low) - cos(high) * cos(high) * cos(high);
    let y = if covered > 1.0e-12 { radius * (2.0 / 3.0) * cubes / covered } else { upper * radius };
    let along = clamp((height - y * tilt.sin) / tilt.cos, 0.0, 2.0 * half_height);
    Slice { area: radius * radius * covered / tilt.cos, centroid: end + tilt.axis * along + tilt.across * y }
}

/// A cone whose tip is lowest and whose slice stays inside it is cut in an ellipse; a level base in a disc; all else by quadrature.
fn of_cone(radius: f32, height: f32, d: Vec3, z: f32) -> Slice {
    let slant = root(radius * radius + height * height);
    let (sin_half, cos_half) = (radius / slant, height / slant);
    let (cos_tilt, sin_tilt) = (-d.z, root(d.x * d.x + d.y * d.y));
    if sin_tilt <= UPRIGHT_SINE && cos_tilt < 0.0 {
        let share = max(1.0 - z / height, 0.0);
        return Slice { area: PI * radius * radius * share * share, centroid: Vec3::Z * (0.25 * height - z) };
    }
    // height of the lowest point of the base rim above the tip
    let rim = height * cos_tilt - radius * sin_tilt;
    if rim <= z || cos_tilt * cos_half <= sin_tilt * sin_half {
        return of_cone_cut(radius, height, d, z);
    }
    let spread = cos_tilt * cos_tilt - sin_half * sin_half;
    let area = PI * z * z * sin_half * sin_half * cos_half / (spread * root(spread));
    let horizontal = if sin_tilt > 0.0 { (Vec3::Z - d * d.z) / sin_tilt } else { Vec3::ZERO };
    let centre = z * sin_tilt * cos_tilt / spread;
    Slice { area, centroid: Vec3::Z * (-0.75 * height) - d * z + horizontal * centre }
}

/// Places of the quadrature along the axis; the chord's square-root ends are taken up by the sine.
const CONE_PLACES: usize = 8;

/// Area = 1/sin(tilt) x integral over the axis of the chord of each circle (theory.md, section 3).
fn of_cone_cut(radius: f32, height: f32, d: Vec3, z: f32) -> Slice {
    let (cos_tilt, sin_tilt) = (-d.z, max(root(d.x * d.x + d.y * d.y), UPRIGHT_SINE));
    let across = (-d - Vec3::Z * cos_tilt) / sin_tilt;
    let level = z - support(&ProbeShape::Cone { radius, height }, d).dot(d) + 0.75 * height * cos_tilt; // above the tip
    // circle at t above the tip has radius g t; the plane passes (level - t cos) / sin from its centre
    let g = radius / height;
    let (lean, rise) = (g * sin_tilt, cos_tilt);
    let first = clamp(crossing(level, rise + lean), 0.0, height);
    let last = if rise - lean > 0.0 {
        clamp(level / (rise - lean), 0.0, height)
    } else if level > 0.0 {
        height
    } else {
        clamp(crossing(level, rise - lean), 0.0, height)
    };
    let (low, high) = (min(first, last), if first < last { last } else { height });
    let (mut area, mut along, mut up) = (0.0, 0.0, 0.0);
    for i in 0..CONE_PLACES {
        let angle = PI * ((i as f32 + 0.5) / CONE_PLACES as f32 - 0.5);
        let t = 0.5 * (low + high) + 0.5 * (high - low) * sin(angle);
        let y = (level - t * rise) / sin_tilt;
        let strip = 2.0 * root(g * g * t * t - y * y) * 0.5 * (high - low) * cos(angle) * (PI / CONE_PLACES as f32) / sin_tilt;
        area += strip;
        along += strip * t;
        up += strip * y;
    }
    if area <= 0.0 {
        return Slice { area: 0.0, centroid: support(&ProbeShape::Cone { radius, height }, d) - d * z };
    }
    Slice { area, centroid: Vec3::Z * (along / area - 0.75 * height) + across * (up / area) }
}

/// Where a line of slope `slope` reaches `level`; far away where it is flat.
fn crossing(level: f32, slope: f32) -> f32 {
    if slope.abs() > 1.0e-9 { level / slope } else { f32::MAX }
}

fn of_capsule(radius: f32, height: f32, d: Vec3, z: f32) -> Slice {
    let tilt = Tilt::of(d);
    let end = -tilt.axis * (0.5 * height);
    let disc = |t: f32| {
        let depth = clamp(z - t * tilt.cos, 0.0, radius);
        root(2.0 * radius * depth - depth * depth)
    };
    let cap = PI * disc(0.0) * disc(0.0);
    let length = if tilt.cos * height > z { z / tilt.cos } else { height };
    let (mut strip, mut moment) = (0.0, 0.0);
    for (x, w) in GAUSS_4 {
        let t = x * length;
        let width = 2.0 * disc(t) * tilt.sin * w * length;
        strip += width;
        moment += width * t;
    }
    let far = disc(length);
    let stadium = 0.5 * cap + strip + 0.5 * PI * far * far;
    if stadium <= cap {
        return Slice { area: cap, centroid: end + d * (radius - z) };
    }
    let along = (moment + 0.5 * PI * far * far * length) / stadium;
    Slice { area: stadium, centroid: end + tilt.axis * along + d * (along * tilt.cos + radius - z) }
}

/// Corners a slice of a box may have while it is clipped: a square and one more for each of six cuts.
const MAX_CORNERS: usize = 10;

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
        let (mut twice, mut moment) = (0.0, Vec2::ZERO);
        for pair in self.corners.windows(2) {
            let (u, v) = (pair[0] - origin, pair[1] - origin);
            let cross = u.perp_dot(v);
            twice += cross;
            moment += (u + v) * cross;
        }
        if twice <= 0.0 { (0.0, origin) } else { (0.5 * twice, origin + moment / (3.0 * twice)) }
    }
}

fn of_box(half: Vec3, d: Vec3, z: f32) -> Slice {
    let lowest = half * Vec3::new(sign(d.x), sign(d.y), sign(d.z));
    let foot = lowest - d * z;
    let height = foot.dot(d);
    let e1 = perpendicular(d);
    let e2 = d.cross(e1);
    let centre = d * height;
    let mut polygon = Polygon::square(2.0 * root(half.length_squared()));
    for (axis, h) in [(Vec3::X, half.x), (Vec3::Y, half.y), (Vec3::Z, half.z)] {
        let n = Vec2::new(axis.dot(e1), axis.dot(e2));
        let offset = axis.dot(centre);
        polygon = polygon.clip(n, h - offset).clip(-n, h + offset);
    }
    let (area, at) = polygon.area_and_centroid();
    if area > 0.0 { Slice { area, centroid: centre + e1 * at.x + e2 * at.y } } else { Slice { area, centroid: foot } }
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

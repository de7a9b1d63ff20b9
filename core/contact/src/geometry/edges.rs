//! What an edge or a rim of the object leaves of a part's slice.
//!
//! The object's faces bound where a part can be carried: a flat that overhangs an edge rests on what lies on the face, and a flat that
//! meets an edge head on rests on a strip as wide as the edge is blunt at that depth. The rule (theory.md, equation 3.10): the object is cut by the
//! plane through the part's deepest point at right angles to the normal; the share of the part's slice that lies over this cut counts. Away
//! from edges the share is exactly 1. Frame of the part, SI units.

use core::cell::Cell;

use glam::{Quat, Vec2, Vec3};

use crate::geometry::deepest::Deepest;
use crate::geometry::gap;
use crate::geometry::outline::{DIRECTIONS, RAYS};
use crate::geometry::slice::{Slice, corners_of_box};
use crate::geometry::support::support;
use crate::math::{clamp, direction, max, min, root};
use crate::model::{ObjectShape, ProbeShape};

/// Corners of a slice while it is cut: one per ray, and one more for each face and each tangent of a rim.
const MAX_CORNERS: usize = RAYS + FACES + RAYS;

/// Flat faces an object may have.
const FACES: usize = 6;

/// A flat face of the object as seen from the deepest point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Face {
    /// Outward normal along the tangents.
    along: Vec2,
    /// Outward normal's share of the contact's normal.
    rise: f32,
    /// Distance from the deepest point to the face \[m\].
    slack: f32,
}

/// Slack of a face that no point of the part comes to, and of one that is not there.
const OUT_OF_REACH: f32 = f32::MAX;

impl Face {
    fn is_in_reach(&self) -> bool {
        self.slack < OUT_OF_REACH
    }

    /// Slack where the deepest point stands higher by `lift` \[m\].
    fn limit(&self, lift: f32) -> f32 {
        self.slack - self.rise * lift
    }

    /// Least slack at any depth up to `depth` \[m\].
    fn least(&self, depth: f32) -> f32 {
        self.slack - max(self.rise, 0.0) * depth
    }
}

/// The round side of a cylinder as seen from the deepest point.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    /// Deepest point from the axis, across it, in world \[m\].
    off: Vec3,
    /// The contact's normal and tangents across the axis, in world.
    across: [Vec3; 3],
    radius: f32,
}

/// The object's edges about a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Edges {
    faces: [Face; FACES],
    side: Option<Side>,
    /// The contact's normal and tangents in the part's frame.
    frame: [Vec3; 3],
    /// Deepest point in the part's frame \[m\].
    lowest: Vec3,
    /// Depth of that point \[m\].
    depth: f32,
    /// Slices cut by now.
    cuts: Cell<u8>,
}

/// What is left of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Share of the area.
    pub share: f32,
    /// How far the centroid moves \[m\].
    pub moved: Vec3,
}

impl Left {
    /// All of it.
    pub const ALL: Self = Self { share: 1.0, moved: Vec3::ZERO };
}

impl Edges {
    /// Edges of the object about the deepest point `lowest` of a part, all of which lies within `reach` \[m\] of it; `frame` holds normal and tangents in world.
    /// `None` where there is no edge within that.
    pub fn about(
        object: &ObjectShape<'_>,
        at: &Deepest,
        frame: [Vec3; 3],
        to_part: Quat,
        lowest: Vec3,
        reach: f32,
    ) -> Option<Self> {
        let p = at.point - gap::centre(object);
        let face = |outward: Vec3, half: f32| Face {
            along: Vec2::new(outward.dot(frame[1]), outward.dot(frame[2])),
            rise: outward.dot(frame[0]),
            slack: half - outward.dot(p),
        };
        let pair = |axis: Vec3, half: f32| [face(axis, half), face(-axis, half)];
        let (faces, side) = match *object {
            ObjectShape::Box { size } => {
                let half = 0.5 * size;
                let ([a, b], [c, d], [e, f]) = (pair(Vec3::X, half.x), pair(Vec3::Y, half.y), pair(Vec3::Z, half.z));
                ([a, b, c, d, e, f], None)
            }
            ObjectShape::Cylinder { radius, height } => {
                let [top, bottom] = pair(Vec3::Z, 0.5 * height);
                let across = |v: Vec3| Vec3::new(v.x, v.y, 0.0);
                let none = Face { slack: OUT_OF_REACH, ..Face::default() };
                ([top, bottom, none, none, none, none], Some(Side { off: across(p), across: frame.map(across), radius }))
            }
            _ => return None,
        };
        let depth = -at.gap.distance;
        let mut edges = Self { faces, side, frame: frame.map(|e| to_part * e), lowest, depth, cuts: Cell::new(0) };
        let mut near = edges.side.is_some_and(|side| side.radius - root(side.off.length_squared()) < reach);
        for face in &mut edges.faces {
            let far = reach * root(face.along.length_squared());
            near |= face.slack < far;
            if face.least(depth) >= far {
                face.slack = OUT_OF_REACH;
            }
        }
        near.then_some(edges)
    }

    /// False where no slice of `shape` reaches over an edge, at any depth up to the contact's.
    pub fn may_cut(&self, shape: &ProbeShape<'_>) -> bool {
        let [_, e1, e2] = self.frame;
        // how far the part reaches from its deepest point along a direction in the tangent plane
        let reach = |along: Vec2| {
            let e = e1 * along.x + e2 * along.y;
            (support(shape, e) - self.lowest).dot(e)
        };
        let over = |face: &Face| face.is_in_reach() && face.least(self.depth) < reach(face.along);
        self.faces.iter().any(over) || self.side.is_some_and(|side| side.is_crossed(self.depth, reach))
    }

    /// What is left of the overlap that has `area` \[m^2\] of a slice of `shape`, all of it on a flat object, at `depth` \[m\].
    pub fn left(&self, shape: &ProbeShape<'_>, slice: &Slice, area: f32, depth: f32) -> Left {
        if slice.area <= 0.0 {
            return Left::ALL;
        }
        let [_, e1, e2] = self.frame;
        let lift = self.lift(depth);
        let from_lowest = slice.centroid - self.lowest;
        let middle = Vec2::new(from_lowest.dot(e1), from_lowest.dot(e2));
        if self.is_clear(slice, middle, lift) {
            return Left::ALL;
        }
        let inner = self.inner(shape, slice.centroid, middle, lift);
        let (from, mut corners) = match (shape, self.side) {
            (ProbeShape::Box { size }, None) => {
                (middle, Polygon::of(&corners_of_box(0.5 * *size, slice.centroid, [e1, e2])).corners)
            }
            _ => (inner, Polygon::of(&self.rays(shape, slice, inner - middle)).corners),
        };
        // a curved object meets the middle of the slice only
        let scale = root(min(area / slice.area, 1.0));
        for corner in &mut corners {
            *corner = inner + (*corner + from - inner) * scale;
        }
        let cut = self.cut(&corners, inner, lift);
        // what rays miss of a slice counts where nothing is cut, and not where little is left
        let seen = min(cut.whole / (slice.area * scale * scale), 1.0);
        let share = cut.share * (seen + (1.0 - seen) * cut.share);
        let moved = cut.after - middle - (cut.before - middle) * cut.share;
        if share < 1.0 { Left { share, moved: e1 * moved.x + e2 * moved.y } } else { Left::ALL }
    }

    /// True where the rectangle about a slice, whose centroid is `middle` along the tangents, keeps within the object's cut.
    fn is_clear(&self, slice: &Slice, middle: Vec2, lift: f32) -> bool {
        let ([_, e1, e2], [long, wide]) = (self.frame, slice.within);
        let along = Vec2::new(slice.along.dot(e1), slice.along.dot(e2));
        let along = if slice.along == Vec3::ZERO { Vec2::X } else { along };
        let keeps = |face: &Face| {
            if !face.is_in_reach() {
                return true;
            }
            let reach = face.along.dot(along).abs() * long + face.along.perp_dot(along).abs() * wide;
            face.along.dot(middle) + reach <= face.limit(lift)
        };
        self.side.is_none() && self.faces.iter().all(keeps)
    }

    /// How far the deepest point stands higher at a smaller depth \[m\].
    fn lift(&self, depth: f32) -> f32 {
        self.depth - depth
    }

    /// A point of the slice with this `centroid`, `middle` along the tangents, that lies over the object's cut where any does: the deepest point, drawn into the slice where it
    /// is not, and from there towards the centroid, half the way out of the cut at most.
    fn inner(&self, shape: &ProbeShape<'_>, centroid: Vec3, middle: Vec2, lift: f32) -> Vec2 {
        let [_, e1, e2] = self.frame;
        let [exit, _] = exits(shape, centroid, -(e1 * middle.x + e2 * middle.y));
        let held = min(INSIDE * exit, 1.0);
        let (start, way) = (middle * (1.0 - held), middle * held);
        let out = |out: f32, face: &Face| {
            let (speed, room) = (face.along.dot(way), face.limit(lift) - face.along.dot(start));
            if speed > 0.0 { min(out, room / speed) } else { out }
        };
        let out = self.faces.iter().fold(2.0, out);
        let out = self.side.map_or(out, |side| min(out, side.leaves(start, way, lift)));
        start + way * clamp(0.5 * out, 0.0, 1.0)
    }

    /// Where rays from a point of the slice, `from` its centroid along the tangents, leave the part, from that point: spread as the slice is long.
    fn rays(&self, shape: &ProbeShape<'_>, slice: &Slice, from: Vec2) -> [Vec2; RAYS] {
        let [_, e1, e2] = self.frame;
        let long = Vec2::new(slice.along.dot(e1), slice.along.dot(e2));
        let (long, wide) = if slice.aspect > 1.0 { (long * slice.aspect, long.perp()) } else { (Vec2::X, Vec2::Y) };
        let start = slice.centroid + e1 * from.x + e2 * from.y;
        let ends = HALF_ROUND.map(|ray| {
            let ray = long * ray.x + wide * ray.y;
            let [ahead, behind] = exits(shape, start, e1 * ray.x + e2 * ray.y);
            [ray * ahead, ray * -behind]
        });
        let [[a, g], [b, h], [c, i], [d, j], [e, k], [f, l]] = ends;
        [a, b, c, d, e, f, g, h, i, j, k, l]
    }

    /// Share of a polygon about the deepest point that lies over the object's cut at `depth`, and how far its centroid moves.
    pub fn kept(&self, corners: &[Vec2], depth: f32) -> (f32, Vec2) {
        let cut = self.cut(corners, Vec2::ZERO, self.lift(depth));
        (cut.share, cut.after - cut.before)
    }

    /// How many slices were cut by now.
    pub fn cuts(&self) -> u8 {
        self.cuts.get()
    }

    /// Cuts a polygon by the object's faces and, seen from the point `inner`, by tangents of its round side.
    fn cut(&self, corners: &[Vec2], inner: Vec2, lift: f32) -> Cut {
        self.cuts.set(self.cuts.get().wrapping_add(1));
        let reach2 = corners.iter().fold(0.0, |reach2, corner| max(reach2, corner.length_squared()));
        let mut polygon = Polygon::of(corners);
        for face in self.faces.iter().filter(|face| face.is_in_reach()) {
            let limit = face.limit(lift);
            if limit <= 0.0 || limit * limit < face.along.length_squared() * reach2 {
                polygon.clip(face.along, limit);
            }
        }
        if let Some(side) = self.side.filter(|side| side.is_left_by(corners, lift)) {
            for &corner in corners {
                if let Some((normal, limit)) = side.tangent(inner, corner, lift) {
                    polygon.clip(normal, limit);
                }
            }
        }
        let (whole, before) = area_and_centroid(corners);
        if !polygon.is_cut {
            return Cut { whole, share: 1.0, before, after: before };
        }
        let (left, after) = area_and_centroid(&polygon.corners);
        if whole > 0.0 && left > 0.0 {
            Cut { whole, share: min(left / whole, 1.0), before, after }
        } else {
            Cut { whole, share: 0.0, before, after: before }
        }
    }
}

/// What is left of a polygon.
struct Cut {
    /// Area before \[m^2\].
    whole: f32,
    /// Share that is left.
    share: f32,
    /// Centroids before and after \[m\].
    before: Vec2,
    after: Vec2,
}

/// How near its outline a slice is entered, as a share of the way from its centroid.
const INSIDE: f32 = 0.999;

impl Side {
    /// A place along the tangents, across the axis.
    fn across(&self, at: Vec2, lift: f32) -> Vec3 {
        let [n, e1, e2] = self.across;
        self.off + n * lift + e1 * at.x + e2 * at.y
    }

    /// The share of the way `way` from `start` at which it leaves the round side.
    fn leaves(&self, start: Vec2, way: Vec2, lift: f32) -> f32 {
        let [_, e1, e2] = self.across;
        let [out, _] = of_ball(self.across(start, lift), e1 * way.x + e2 * way.y, self.radius);
        out
    }

    /// The tangent of the round side where the way from `inner` to a corner leaves it, as a half plane along the tangents; none for a corner inside.
    fn tangent(&self, inner: Vec2, corner: Vec2, lift: f32) -> Option<(Vec2, f32)> {
        let [_, e1, e2] = self.across;
        if self.across(corner, lift).length_squared() <= self.radius * self.radius {
            return None;
        }
        let share = self.leaves(inner, corner - inner, lift);
        let out = direction(self.across(inner + (corner - inner) * min(share, 1.0), lift), Vec3::X);
        Some((Vec2::new(out.dot(e1), out.dot(e2)), self.radius - out.dot(self.across(Vec2::ZERO, lift))))
    }

    /// True where a corner lies outside the round side.
    fn is_left_by(&self, corners: &[Vec2], lift: f32) -> bool {
        corners.iter().any(|&corner| self.across(corner, lift).length_squared() > self.radius * self.radius)
    }

    /// True where a part that reaches so far in the tangent plane may leave the round side at some depth up to `depth`: from a box about it.
    fn is_crossed(&self, depth: f32, reach: impl Fn(Vec2) -> f32) -> bool {
        let [n, e1, e2] = self.across;
        let out = direction(self.off, Vec3::X);
        let farthest = |u: Vec3| u.dot(self.off) + max(u.dot(n), 0.0) * depth + reach(Vec2::new(u.dot(e1), u.dot(e2)));
        let hoop = Vec3::Z.cross(out);
        let (far, wide) = (max(farthest(out), farthest(-out)), max(farthest(hoop), farthest(-hoop)));
        far * far + wide * wide > self.radius * self.radius
    }
}

/// A polygon while it is cut.
struct Polygon {
    corners: Corners,
    is_cut: bool,
}

type Corners = heapless::Vec<Vec2, MAX_CORNERS>;

impl Polygon {
    fn of(corners: &[Vec2]) -> Self {
        Self { corners: Corners::from_slice(corners).unwrap_or_default(), is_cut: false }
    }

    /// Keeps the part where normal . x <= limit.
    fn clip(&mut self, normal: Vec2, limit: f32) {
        if self.corners.iter().all(|corner| normal.dot(*corner) <= limit) {
            return;
        }
        let mut kept = Corners::new();
        let Some(mut last) = self.corners.last().copied() else { return };
        let mut a = normal.dot(last) - limit;
        for &here in &self.corners {
            let b = normal.dot(here) - limit;
            if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                let _ = kept.push(last + (here - last) * (a / (a - b)));
            }
            if b <= 0.0 {
                let _ = kept.push(here);
            }
            (last, a) = (here, b);
        }
        *self = Self { corners: kept, is_cut: true };
    }
}

fn area_and_centroid(corners: &[Vec2]) -> (f32, Vec2) {
    let Some(&origin) = corners.first() else { return (0.0, Vec2::ZERO) };
    let (mut twice, mut moment) = (0.0, Vec2::ZERO);
    for pair in corners.windows(2) {
        if let [u, v] = *pair {
            let (u, v) = (u - origin, v - origin);
            let cross = u.perp_dot(v);
            twice += cross;
            moment += (u + v) * cross;
        }
    }
    if twice > 0.0 { (0.5 * twice, origin + moment / (3.0 * twice)) } else { (0.0, origin) }
}

/// The rays of half a round: the others are their opposites.
const HALF_ROUND: [Vec2; RAYS / 2] = {
    let [a, b, c, d, e, f, ..] = DIRECTIONS;
    [a, b, c, d, e, f]
};

/// How far rays along `e` and against it run in the shape from the inner point `q`, in lengths of `e`.
fn exits(shape: &ProbeShape<'_>, q: Vec3, e: Vec3) -> [f32; 2] {
    match *shape {
        ProbeShape::Sphere { radius } => of_ball(q, e, radius),
        ProbeShape::Ellipsoid { semi_axes } => {
            let (q, e) = (q / semi_axes, e / semi_axes);
            first_roots(-e.length_squared(), -2.0 * e.dot(q), 1.0 - q.length_squared())
        }
        ProbeShape::Box { size } => {
            let half = 0.5 * size;
            nearer(slab(q.x, e.x, half.x), nearer(slab(q.y, e.y, half.y), slab(q.z, e.z, half.z)))
        }
        ProbeShape::Cylinder { radius, height } => nearer(of_tube(q, e, radius), slab(q.z, e.z, 0.5 * height)),
        ProbeShape::Capsule { radius, height } => {
            let end = Vec3::Z * (0.5 * height);
            let inside = q.z.abs() <= 0.5 * height;
            let straight = if inside { nearer(of_tube(q, e, radius), slab(q.z, e.z, 0.5 * height)) } else { [0.0; 2] };
            farther(straight, farther(of_ball(q - end, e, radius), of_ball(q + end, e, radius)))
        }
        ProbeShape::Cone { radius, height } => {
            let (slope, above) = (radius / height, q.z + 0.75 * height);
            let (er, qr) = (Vec2::new(e.x, e.y), Vec2::new(q.x, q.y));
            let (a, b) = (slope * slope * e.z * e.z - er.length_squared(), 2.0 * (slope * slope * above * e.z - qr.dot(er)));
            let side = first_roots(a, b, slope * slope * above * above - qr.length_squared());
            let base = max(0.25 * height - q.z, 0.0);
            nearer(side, [e.z, -e.z].map(|up| if up > 0.0 { base / up } else { f32::MAX }))
        }
        ProbeShape::Mesh(mesh) => [mesh.reach(); 2],
    }
}

fn nearer(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [min(a[0], b[0]), min(a[1], b[1])]
}

fn farther(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [max(a[0], b[0]), max(a[1], b[1])]
}

fn slab(q: f32, e: f32, half: f32) -> [f32; 2] {
    if e == 0.0 {
        return [f32::MAX; 2];
    }
    let (ahead, behind) = ((half - q) / e, (-half - q) / e);
    if e > 0.0 { [max(ahead, 0.0), max(-behind, 0.0)] } else { [max(behind, 0.0), max(-ahead, 0.0)] }
}

fn of_tube(q: Vec3, e: Vec3, radius: f32) -> [f32; 2] {
    let (q, e) = (Vec2::new(q.x, q.y), Vec2::new(e.x, e.y));
    first_roots(-e.length_squared(), -2.0 * q.dot(e), radius * radius - q.length_squared())
}

/// Where rays leave a ball for good, in lengths of `e`; 0 where they miss it.
fn of_ball(q: Vec3, e: Vec3, radius: f32) -> [f32; 2] {
    let (a, b, c) = (e.length_squared(), q.dot(e), q.length_squared() - radius * radius);
    let rest = b * b - a * c;
    if rest <= 0.0 {
        return [0.0; 2];
    }
    let far = root(rest);
    [max((far - b) / a, 0.0), max((far + b) / a, 0.0)]
}

/// First zeros at t >= 0 of a t^2 + b t + c and of a t^2 - b t + c, which are not negative at 0.
fn first_roots(a: f32, b: f32, c: f32) -> [f32; 2] {
    let c = max(c, 0.0);
    let rest = b * b - 4.0 * a * c;
    if rest <= 0.0 && a > 0.0 {
        return [f32::MAX; 2];
    }
    // 2 c/(root - b) and (-b - root)/(2 a) are the same zero; the first cancels where b > 0
    let sum = root(rest) + b.abs();
    let [falling, rising] = [2.0 * c / sum, -sum / (2.0 * a)].map(|t| if t >= 0.0 && t.is_finite() { t } else { f32::MAX });
    [if b <= 0.0 { falling } else { rising }, if b >= 0.0 { falling } else { rising }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::slice::slice;
    use crate::geometry::support::tests::SHAPES;
    use crate::geometry::support::{closest, reach};
    use crate::math::perpendicular;

    #[test]
    fn rays_end_on_the_surface() {
        for shape in SHAPES {
            for i in 0..200 {
                let f = i as f32;
                let q = Vec3::new(libm::sinf(f), libm::sinf(2.3 * f), libm::cosf(0.7 * f)) * 0.003;
                let e = direction(Vec3::new(libm::cosf(3.1 * f), libm::sinf(1.7 * f), libm::cosf(f)), Vec3::X);
                for (e, t) in [e, -e].into_iter().zip(exits(&shape, q, e)) {
                    let off = |t: f32| (closest(&shape, q + e * t) - (q + e * t)).length();
                    assert!(t < 2.0 * reach(&shape) && off(t) < 1.0e-6 && off(t + 1.0e-4) > 1.0e-7, "{shape:?} {q} {e}: {t}");
                }
            }
        }
    }

    /// The rectangle about a capsule's slice holds it: no ray from within leaves it.
    #[test]
    fn a_slice_keeps_within_its_rectangle() {
        for (i, (radius, height)) in (1..3000).zip([(0.006, 0.02), (0.006, 1.0e-4), (0.001, 0.03)].into_iter().cycle()) {
            let (f, shape) = (i as f32, ProbeShape::Capsule { radius, height });
            let tilt = [1.0, 1.0e-3, 0.05][i % 3] * libm::sinf(0.37 * f);
            let d = Vec3::new(libm::cosf(tilt), 0.0, -libm::sinf(tilt));
            let d = if i % 2 == 0 { d } else { Vec3::new(-d.z, 0.0, -d.x) };
            let cut = slice(&shape, d, radius * libm::fabsf(libm::sinf(1.9 * f)));
            let tangents = [perpendicular(d), d.cross(perpendicular(d))];
            for ray in DIRECTIONS {
                let ray = tangents[0] * ray.x + tangents[1] * ray.y;
                let at = ray * exits(&shape, cut.centroid, ray)[0];
                let [long, wide] = cut.within;
                let long = if cut.along == Vec3::ZERO { at.length() } else { at.dot(cut.along).abs() } - long;
                let wide = at.dot(cut.along.cross(d)).abs() - wide;
                assert!(long < 1.0e-4 * radius && wide < 1.0e-4 * radius, "{shape:?} {d} {cut:?}: {at} {long} {wide}");
            }
        }
    }
}

//! What an edge or a rim of the object leaves of a part's slice.
//!
//! The object's faces bound where a part can be carried: a flat that overhangs an edge rests on what lies on the face, and a flat that
//! meets an edge head on rests on a strip as wide as the edge is blunt at that depth. The rule (theory.md, equation 3.10): the object is cut by the
//! plane through the part's deepest point at right angles to the normal; the share of the part's slice that lies over this cut counts. Away
//! from edges the share is exactly 1. Frame of the part, SI units.

use glam::{Quat, Vec2, Vec3};

use crate::geometry::deepest::Deepest;
use crate::geometry::gap;
use crate::geometry::outline::RAYS;
use crate::geometry::rays::{Fan, exits, of_ball};
use crate::geometry::ring::{Ring, Spanned};
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edges {
    faces: [Face; FACES],
    side: Option<Side>,
    /// The contact's normal and tangents in the part's frame.
    frame: [Vec3; 3],
    /// Deepest point in the part's frame \[m\].
    lowest: Vec3,
    /// Depth of that point \[m\].
    depth: f32,
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
    /// Edges of the object about the deepest point `lowest` of a part; `frame` holds normal and tangents in world. `None` where there is no edge
    /// within `reach` \[m\] of it.
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
                let none = Face { slack: f32::MAX, ..Face::default() };
                ([top, bottom, none, none, none, none], Some(Side { off: across(p), across: frame.map(across), radius }))
            }
            _ => return None,
        };
        let edges = Self { faces, side, frame: frame.map(|e| to_part * e), lowest, depth: -at.gap.distance };
        let near = edges.faces.iter().any(|face| face.slack < reach * root(face.along.length_squared()));
        let near_side = edges.side.is_some_and(|side| side.radius - root(side.off.length_squared()) < reach);
        (near || near_side).then_some(edges)
    }

    /// False where no slice of `shape` reaches over an edge, at any depth up to the contact's.
    pub fn may_cut(&self, shape: &ProbeShape<'_>) -> bool {
        let [_, e1, e2] = self.frame;
        // how far the part reaches from its deepest point along a direction in the tangent plane
        let reach = |along: Vec2| {
            let e = e1 * along.x + e2 * along.y;
            (support(shape, e) - self.lowest).dot(e)
        };
        let over = |face: &Face| face.slack - max(face.rise, 0.0) * self.depth < reach(face.along);
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
        let ring = match (shape, self.side) {
            (ProbeShape::Box { size }, None) => {
                let mut corners = corners_of_box(0.5 * *size, slice.centroid, [e1, e2]);
                corners.iter_mut().for_each(|corner| *corner += middle - inner);
                Ring::of(&corners)
            }
            _ => self.rays(slice, inner - middle).ends(shape),
        };
        // a curved object meets the middle of the slice only
        let scale = root(min(area / slice.area, 1.0));
        let Some(cut) = self.cut(&ring.scaled(scale), inner, lift) else { return Left::ALL };
        // what rays miss of a slice counts where nothing is cut, and not where little is left
        let seen = min(cut.whole / (slice.area * scale * scale), 1.0);
        let share = cut.share * (seen + (1.0 - seen) * cut.share);
        let moved = cut.after + (inner - middle) - (cut.before + (inner - middle)) * cut.share;
        if share < 1.0 { Left { share, moved: e1 * moved.x + e2 * moved.y } } else { Left::ALL }
    }

    /// True where the rectangle about a slice, whose centroid is `middle` along the tangents, keeps within the object's cut.
    fn is_clear(&self, slice: &Slice, middle: Vec2, lift: f32) -> bool {
        let ([_, e1, e2], [long, wide]) = (self.frame, slice.within);
        let along = Vec2::new(slice.along.dot(e1), slice.along.dot(e2));
        let along = if slice.along == Vec3::ZERO { Vec2::X } else { along };
        let keeps = |face: &Face| {
            let reach = face.along.dot(along).abs() * long + face.along.perp_dot(along).abs() * wide;
            face.slack == f32::MAX || face.along.dot(middle) + reach <= face.slack - face.rise * lift
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
            let (speed, room) = (face.along.dot(way), face.slack - face.rise * lift - face.along.dot(start));
            if speed > 0.0 { min(out, room / speed) } else { out }
        };
        let out = self.faces.iter().fold(2.0, out);
        let out = self.side.map_or(out, |side| min(out, side.leaves(start, way, lift)));
        start + way * clamp(0.5 * out, 0.0, 1.0)
    }

    /// Rays from a point of the slice, `from` its centroid along the tangents: spread as the slice is long.
    fn rays(&self, slice: &Slice, from: Vec2) -> Fan {
        let [_, e1, e2] = self.frame;
        let long = Vec2::new(slice.along.dot(e1), slice.along.dot(e2));
        let axes = if slice.aspect > 1.0 { [long * slice.aspect, long.perp()] } else { [Vec2::X, Vec2::Y] };
        Fan { start: slice.centroid + e1 * from.x + e2 * from.y, tangents: [e1, e2], axes }
    }

    /// Share of a polygon about the deepest point that lies over the object's cut at `depth`, and how far its centroid moves.
    pub fn kept(&self, corners: &[Vec2; RAYS], depth: f32) -> (f32, Vec2) {
        let cut = self.cut(&Ring::new(*corners), Vec2::ZERO, self.lift(depth));
        cut.map_or((1.0, Vec2::ZERO), |cut| (cut.share, cut.after - cut.before))
    }

    /// Cuts a polygon about the point `inner` by the object's faces and by tangents of its round side, seen from there; `None` where nothing is cut off.
    fn cut(&self, ring: &Ring, inner: Vec2, lift: f32) -> Option<Cut> {
        let limit = |face: &Face| face.slack - face.rise * lift - face.along.dot(inner);
        let cuts = |face: &&Face| face.slack < f32::MAX && ring.reach(face.along) > limit(face);
        let mut faces = self.faces.iter().filter(cuts);
        let first = faces.next();
        let side = self.side.filter(|side| side.is_left_by(&ring.corners(), inner, lift));
        match (first, faces.next(), side) {
            (None, None, None) => None,
            (Some(face), None, None) => Some(Cut::new(ring.cut(face.along, limit(face)))),
            (first, second, side) => {
                let corners = ring.corners();
                let mut polygon = Polygon::of(&corners);
                for face in first.into_iter().chain(second).chain(faces) {
                    polygon.clip(face.along, limit(face));
                }
                for &corner in side.iter().flat_map(|_| &corners) {
                    if let Some((normal, limit)) = side.and_then(|side| side.tangent(inner, inner + corner, lift)) {
                        polygon.clip(normal, limit - normal.dot(inner));
                    }
                }
                Some(Cut::new([spanned(&corners), spanned(&polygon.corners)]))
            }
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

impl Cut {
    fn new([whole, left]: [Spanned; 2]) -> Self {
        let before = whole.centroid;
        if whole.area > 0.0 && left.area > 0.0 {
            Self { whole: whole.area, share: min(left.area / whole.area, 1.0), before, after: left.centroid }
        } else {
            Self { whole: whole.area, share: 0.0, before, after: before }
        }
    }
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
    fn is_left_by(&self, corners: &[Vec2], inner: Vec2, lift: f32) -> bool {
        corners.iter().any(|&corner| self.across(inner + corner, lift).length_squared() > self.radius * self.radius)
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

/// A polygon while it is cut more than once.
struct Polygon {
    corners: Corners,
}

type Corners = heapless::Vec<Vec2, MAX_CORNERS>;

impl Polygon {
    fn of(corners: &[Vec2]) -> Self {
        Self { corners: Corners::from_slice(corners).unwrap_or_default() }
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
        self.corners = kept;
    }
}

/// Area and centroid of a polygon.
fn spanned(corners: &[Vec2]) -> Spanned {
    let Some(&origin) = corners.first() else { return Spanned { area: 0.0, centroid: Vec2::ZERO } };
    let (mut twice, mut moment) = (0.0, Vec2::ZERO);
    for pair in corners.windows(2) {
        if let [u, v] = *pair {
            let (u, v) = (u - origin, v - origin);
            let cross = u.perp_dot(v);
            twice += cross;
            moment += (u + v) * cross;
        }
    }
    let moved = if twice > 0.0 { moment / (3.0 * twice) } else { Vec2::ZERO };
    Spanned { area: max(0.5 * twice, 0.0), centroid: origin + moved }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::slice::slice;
    use crate::math::perpendicular;

    /// A ring cut by a half plane is the polygon that is left, area and centroid, also where nothing or nearly all is left.
    #[test]
    fn a_cut_ring_is_the_polygon_that_is_left() {
        for i in 0..2000 {
            let f = i as f32;
            let stretch = 1.0 + 3.0 * libm::fabsf(libm::sinf(1.7 * f));
            let corners = crate::geometry::outline::DIRECTIONS
                .map(|ray| Vec2::new(ray.x * stretch, ray.y) * 0.002 + Vec2::new(libm::sinf(f), libm::cosf(f)) * 0.001);
            let normal = Vec2::new(libm::sinf(2.3 * f), libm::cosf(2.3 * f)) * (0.1 + libm::fabsf(libm::sinf(0.1 * f)));
            let limit = 0.003 * libm::sinf(0.61 * f) * normal.length() * stretch;
            let mut polygon = Polygon::of(&corners);
            polygon.clip(normal, limit);
            let (expected, [whole, left]) = (spanned(&polygon.corners), Ring::new(corners).cut(normal, limit));
            let size = spanned(&corners);
            assert!((whole.area / size.area - 1.0).abs() < 1.0e-5 && (whole.centroid - size.centroid).length() < 1.0e-7, "{i}");
            assert!((left.area - expected.area).abs() < 1.0e-5 * size.area, "{i}: {left:?} {expected:?}");
            let told = expected.area > 1.0e-3 * size.area;
            assert!(!told || (left.centroid - expected.centroid).length() < 1.0e-5 * 0.01, "{i}: {left:?} {expected:?}");
        }
    }

    /// The rectangle about a capsule's slice holds it: no ray from within leaves it.
    #[test]
    fn a_slice_keeps_within_its_rectangle() {
        for (i, (radius, height)) in (0..3000).zip([(0.006, 0.02), (0.006, 1.0e-4), (0.001, 0.03)].into_iter().cycle()) {
            let (f, shape) = (i as f32, ProbeShape::Capsule { radius, height });
            let tilt = [1.0, 1.0e-3, 0.05][i % 3] * libm::sinf(0.37 * f);
            let d = Vec3::new(libm::cosf(tilt), 0.0, -libm::sinf(tilt));
            let d = if i % 2 == 0 { d } else { Vec3::new(-d.z, 0.0, -d.x) };
            let cut = slice(&shape, d, radius * libm::fabsf(libm::sinf(1.9 * f)));
            let tangents = [perpendicular(d), d.cross(perpendicular(d))];
            let fan = Fan { start: cut.centroid, tangents, axes: [Vec2::X, Vec2::Y] };
            for at in fan.ends(&shape).corners() {
                let at = tangents[0] * at.x + tangents[1] * at.y;
                let [long, wide] = cut.within;
                let long = if cut.along == Vec3::ZERO { at.length() } else { at.dot(cut.along).abs() } - long;
                let wide = at.dot(cut.along.cross(d)).abs() - wide;
                assert!(long < 1.0e-4 * radius && wide < 1.0e-4 * radius, "{shape:?} {d} {cut:?}: {at} {long} {wide}");
            }
        }
    }
}

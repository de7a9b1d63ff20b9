//! The deepest point of a convex probe part in a convex object.
//!
//! The signed distance to a convex object is convex, so over a convex part it has one least value, and the overlap of the two
//! is connected: one part makes at most one contact. Spheres and the half space are closed forms; the rest is a bounded
//! descent with a fixed number of steps (theory.md, section 2).

use core::cell::Cell;

use glam::{Mat3, Vec3};

use crate::frames::Pose;
use crate::geometry::align::align;
use crate::geometry::curvature;
use crate::geometry::faces::{self, Spine};
use crate::geometry::field::{self, Field};
use crate::geometry::gap::{self, Gap, gap};
use crate::geometry::rim;
use crate::geometry::support::{closest, farthest_sample, reach, support};
use crate::math::{direction, perpendicular, root};
use crate::mesh_shape::MeshShape;
use crate::model::{ObjectShape, ProbePart, ProbeShape};
use crate::{ProbeFrame, World};

/// Deepest point of one part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deepest {
    /// The point on the part, `p_wq` \[m\].
    pub point: Vec3,
    /// Gap there: negative = penetration.
    pub gap: Gap,
}

/// Marker of a part's own frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartFrame;

/// Pose of a part in world.
pub fn part_pose(part: &ProbePart<'_>, x_wp: &Pose<World, ProbeFrame>) -> Pose<World, PartFrame> {
    x_wp.then(&Pose::new(part.position, part.rotation))
}

/// True when the part's bounding ball stays clear of the object: the cheap test that most ticks of most parts end with.
pub fn is_clear(object: &ObjectShape<'_>, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>) -> bool {
    gap::slope(object, x_wa.position).distance > reach(&part.shape)
}

/// Deepest point of `part`, whose frame stands at `x_wa`.
pub fn deepest(object: &ObjectShape<'_>, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>) -> Deepest {
    deepest_asking(object, part, x_wa, &Cell::new(0))
}

/// The same; adds to `asked` how often the searches by edges asked the part for a point.
pub fn deepest_asking(
    object: &ObjectShape<'_>,
    part: &ProbePart<'_>,
    x_wa: &Pose<World, PartFrame>,
    asked: &Cell<u32>,
) -> Deepest {
    match (*object, part.shape) {
        (ObjectShape::Mesh(_), ProbeShape::Sphere { radius }) => of_ball_on_mesh(object, x_wa.position, radius),
        (_, ProbeShape::Sphere { radius }) => of_ball(object, x_wa.position, radius),
        (ObjectShape::HalfSpace, _) => at(object, support_in_world(part, x_wa, -Vec3::Z)),
        (_, ProbeShape::Mesh(mesh)) => of_mesh(object, &mesh, x_wa),
        (ObjectShape::Sphere { radius }, _) => of_part_in_ball(part, x_wa, radius),
        (ObjectShape::Box { size }, _) => of_part_in_box((object, 0.5 * size), part, x_wa, asked),
        (ObjectShape::Cylinder { radius, height }, _) => of_part_in_can((object, [radius, height]), part, x_wa, asked),
        (ObjectShape::Ellipsoid { .. } | ObjectShape::Mesh(_), _) => {
            let (found, proof) = descend(object, part, x_wa);
            if proof == Proof::Apart { found } else { roll_down(object, part, x_wa, found) }
        }
    }
}

fn of_ball(object: &ObjectShape<'_>, centre: Vec3, radius: f32) -> Deepest {
    let Gap { distance, normal } = gap(object, centre);
    Deepest { point: centre - normal * radius, gap: Gap { distance: distance - radius, normal } }
}

/// A ball on a mesh: its centre may stand far off the grid, so that the normals are aligned where the two touch.
fn of_ball_on_mesh(object: &ObjectShape<'_>, centre: Vec3, radius: f32) -> Deepest {
    let start = centre - gap(object, centre).normal * radius;
    at(object, align(|q| field::of_object(object, q), |q| field::ball(centre, radius, q), start, radius))
}

/// Rounds of the sampled search: each asks the samples for the farthest against the normal at the last answer.
const SAMPLED_ROUNDS: usize = 3;

/// A mesh part: the deepest sample, then Newton's method on the two normals (theory.md, equation 2.5).
fn of_mesh(object: &ObjectShape<'_>, mesh: &MeshShape<'_>, x_wa: &Pose<World, PartFrame>) -> Deepest {
    let to_part = x_wa.rotation.conjugate();
    let mut best = at(object, x_wa.point(farthest_sample(mesh, to_part * (gap::centre(object) - x_wa.position))));
    let mut normal = gap(object, x_wa.position).normal;
    for _ in 0..SAMPLED_ROUNDS {
        let next = at(object, x_wa.point(farthest_sample(mesh, to_part * -normal)));
        normal = next.gap.normal;
        if next.gap.distance < best.gap.distance {
            best = next;
        }
    }
    let start = to_part * (best.point - x_wa.position);
    let (turn, back) = (Mat3::from_quat(to_part), Mat3::from_quat(x_wa.rotation));
    let object_in_part = |q: Vec3| {
        let Field { value, gradient, hessian } = field::of_object(object, x_wa.point(q));
        Field { value, gradient: turn * gradient, hessian: turn * hessian * back }
    };
    at(object, x_wa.point(align(object_in_part, |q| mesh.grid().field(q), start, mesh.reach())))
}

fn of_part_in_ball(part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>, radius: f32) -> Deepest {
    let centre = Vec3::Z * radius;
    let point = closest_in_world(part, x_wa, centre);
    let normal = direction(point - centre, Vec3::Z);
    Deepest { point, gap: Gap { distance: root((point - centre).length_squared()) - radius, normal } }
}

fn of_part_in_box(
    (object, half): (&ObjectShape<'_>, Vec3),
    part: &ProbePart<'_>,
    x_wa: &Pose<World, PartFrame>,
    asked: &Cell<u32>,
) -> Deepest {
    let centre = gap::centre(object);
    let (start, proof) = foothold(object, part, x_wa);
    if proof == Proof::Apart {
        return start;
    }
    let turned = turned_support(part, x_wa);
    let (spine, turned) = (spine(part, x_wa, asked), |d: Vec3| count(asked, 1, turned(d)));
    if proof == Proof::Open
        && let Some(over) = faces::over_edge(half, centre, &start, spine, turned)
    {
        return over;
    }
    if proof == Proof::Open {
        count(asked, DESCENT_STEPS as u32, ());
    }
    let (found, proof) = descend_on(object, part, x_wa, (start, proof));
    if proof == Proof::Apart {
        return found;
    }
    let under = faces::under_edge(half, centre, &found, reach(&part.shape), spine, turned);
    deeper(object, found, under)
}

/// In an upright cylinder of this radius and height.
fn of_part_in_can(
    (object, [radius, height]): (&ObjectShape<'_>, [f32; 2]),
    part: &ProbePart<'_>,
    x_wa: &Pose<World, PartFrame>,
    asked: &Cell<u32>,
) -> Deepest {
    let (start, proof) = descend(object, part, x_wa);
    if proof == Proof::Apart {
        return start;
    }
    let found = roll_down(object, part, x_wa, start);
    let turned = turned_support(part, x_wa);
    let under = rim::under_rim(radius, height, &found, reach(&part.shape), |d: Vec3| count(asked, 1, turned(d)));
    under.filter(|under| is_as_deep(gap::slope(object, under.point).distance, &found)).unwrap_or(found)
}

fn at(object: &ObjectShape<'_>, point: Vec3) -> Deepest {
    Deepest { point, gap: gap(object, point) }
}

/// What a search over the faces found, point and normal, unless descent is clearly deeper: of two that are as deep the search's normal is the surer.
fn deeper(object: &ObjectShape<'_>, found: Deepest, under: Option<(Vec3, Vec3)>) -> Deepest {
    let Some((point, normal)) = under else { return found };
    let distance = gap::slope(object, point).distance;
    if is_as_deep(distance, &found) { Deepest { point, gap: Gap { distance, normal } } } else { found }
}

fn is_as_deep(distance: f32, found: &Deepest) -> bool {
    distance <= found.gap.distance + faces::SETTLED * found.gap.distance.abs()
}

/// The spine of a part that has one, in world.
fn spine<'a>(part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>, asked: &'a Cell<u32>) -> Option<Spine<'a>> {
    let ProbeShape::Capsule { radius, height } = part.shape else { return None };
    let way = x_wa.rotation * (Vec3::Z * height);
    Some(Spine { start: x_wa.position - way * 0.5, way, radius, asked })
}

/// What was asked for, counted as so many.
pub fn count<T>(asked: &Cell<u32>, more: u32, found: T) -> T {
    asked.set(asked.get() + more);
    found
}

/// The support in world for a search that asks for it many times.
fn turned_support<'a>(part: &'a ProbePart<'_>, x_wa: &'a Pose<World, PartFrame>) -> impl Fn(Vec3) -> Vec3 + 'a {
    let (to_world, to_part) = (Mat3::from_quat(x_wa.rotation), Mat3::from_quat(x_wa.rotation.conjugate()));
    move |d_w| x_wa.position + to_world * support(&part.shape, to_part * d_w)
}

/// The part's farthest point along a direction, in world.
pub fn support_in_world(part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>, d_w: Vec3) -> Vec3 {
    x_wa.point(support(&part.shape, x_wa.rotation.conjugate() * d_w))
}

fn closest_in_world(part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>, q_w: Vec3) -> Vec3 {
    x_wa.point(closest(&part.shape, x_wa.rotation.conjugate() * (q_w - x_wa.position)))
}

/// Steps of the descent: the step length falls from 64 to 1/512 of the body size, by half each time.
const DESCENT_STEPS: usize = 16;

/// What the plane at right angles to the normal at a point of the part proves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Proof {
    /// No point of the part is deeper.
    Deepest,
    /// Part and object lie on different sides of it: what was found is a gap, and need not be the least.
    Apart,
    /// Nothing.
    Open,
}

/// The deepest point by descent, or a point of a part that keeps apart.
fn descend(object: &ObjectShape<'_>, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>) -> (Deepest, Proof) {
    descend_on(object, part, x_wa, foothold(object, part, x_wa))
}

/// The same from a foothold.
fn descend_on(
    object: &ObjectShape<'_>,
    part: &ProbePart<'_>,
    x_wa: &Pose<World, PartFrame>,
    (start, proof): (Deepest, Proof),
) -> (Deepest, Proof) {
    if proof == Proof::Open { descend_from(object, part, x_wa, start) } else { (start, proof) }
}

/// Where a descent starts, and what is proven there already.
fn foothold(object: &ObjectShape<'_>, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>) -> (Deepest, Proof) {
    let here = at(object, closest_in_world(part, x_wa, gap::centre(object)));
    let against = support_in_world(part, x_wa, -here.gap.normal);
    if is_apart(object, part, &here, against) {
        return (here, Proof::Apart);
    }
    let there = gap::slope(object, against);
    let (best, farthest) = if there.distance > here.gap.distance {
        (here, against)
    } else {
        let there = Deepest { point: against, gap: there.gap() };
        (there, support_in_world(part, x_wa, -there.gap.normal))
    };
    if is_apart(object, part, &best, farthest) {
        return (best, Proof::Apart);
    }
    // a convex distance lies above its tangent plane: no point of the part is deeper than the farthest one against the normal makes it
    let is_found = best.gap.normal.dot(best.point - farthest) <= ROUNDING * (reach(&part.shape) + object.height());
    (best, if is_found { Proof::Deepest } else { Proof::Open })
}

/// True where the normal at a point outside the object separates the two: the part's `farthest` point against it lies beyond the object's farthest along it, clear of rounding
/// (theory.md, equation 2.8).
fn is_apart(object: &ObjectShape<'_>, part: &ProbePart<'_>, at: &Deepest, farthest: Vec3) -> bool {
    if at.gap.distance <= 0.0 {
        return false;
    }
    let (n, extent) = (at.gap.normal, gap::extent(object, at.gap.normal));
    n.dot(farthest - gap::centre(object)) - extent > APART * (reach(&part.shape) + extent)
}

/// Projected descent on the gap, largest step first; keeps the best point seen. A long step lands on the support point, which is
/// the answer on flat faces and corners; the short ones settle on curved bodies. Ends where a better point proves that the two keep apart.
fn descend_from(
    object: &ObjectShape<'_>,
    part: &ProbePart<'_>,
    x_wa: &Pose<World, PartFrame>,
    start: Deepest,
) -> (Deepest, Proof) {
    let size = reach(&part.shape) + object.height();
    let mut best = start;
    let mut length = 64.0 * size;
    for _ in 0..DESCENT_STEPS {
        let next = closest_in_world(part, x_wa, best.point - best.gap.normal * length);
        // corners come again, to the bit
        let candidate = if next == best.point { None } else { Some(gap::slope(object, next)) };
        if let Some(candidate) = candidate.filter(|candidate| candidate.distance < best.gap.distance) {
            best = Deepest { point: next, gap: candidate.gap() };
            let is_outside = best.gap.distance > 0.0;
            if is_outside && is_apart(object, part, &best, support_in_world(part, x_wa, -best.gap.normal)) {
                return (best, Proof::Apart);
            }
        } else {
            length *= 0.5;
        }
    }
    (best, Proof::Open)
}

/// Steps on osculating balls. Each shrinks the error at least by the curvatures' relative difference: 1e-5 for radii up to 1:2.
const ROLLING_STEPS: usize = 8;

/// Refines the deepest point on a curved object: the part's closest point to the centre of the ball that osculates the object under the
/// present point. On a sphere one such step is the answer; the normal then no longer jitters as the probe turns.
fn roll_down(object: &ObjectShape<'_>, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>, start: Deepest) -> Deepest {
    let mut best = start;
    for _ in 0..ROLLING_STEPS {
        let n = best.gap.normal;
        let e1 = perpendicular(n);
        let bent = curvature::of_object(object, best.point, n, e1, n.cross(e1));
        let steepest = if matches!(object, ObjectShape::Cylinder { .. }) { bent.principal().0 } else { bent.mean() };
        if steepest <= 0.0 {
            break;
        }
        let centre = best.point - n * (best.gap.distance + 1.0 / steepest);
        let point = closest_in_world(part, x_wa, centre);
        let next = gap::slope(object, point);
        // a step that does not go down by more than rounding is still a better normal
        if next.distance > best.gap.distance + ROUNDING * reach(&part.shape) {
            break;
        }
        best = Deepest { point, gap: next.gap() };
    }
    best
}

/// Rounding of a gap, as a share of the part's size.
const ROUNDING: f32 = 1.0e-6;

/// How far apart two bodies must lie for a proof of it, as a share of the sizes whose digits are compared: thirty units in the last place, which a turned point and a turned
/// normal do not come to. What is nearer is searched.
const APART: f32 = 4.0e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::support::tests::SHAPES;
    use crate::math::max;
    use glam::Quat;

    fn depth(object: ObjectShape<'_>, shape: ProbeShape<'_>, position: Vec3, rotation: Quat) -> f32 {
        let part = ProbePart::at_origin(shape);
        -deepest(&object, &part, &part_pose(&part, &Pose::new(position, rotation))).gap.distance
    }

    #[test]
    fn depths_of_known_overlaps() {
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let ellipsoid = ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) };
        let punch = ProbeShape::Cylinder { radius: 0.01, height: 0.04 };
        let capsule = ProbeShape::Capsule { radius: 0.005, height: 0.03 };
        let egg = ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.02, 0.03, 0.01) };
        let upright = Quat::IDENTITY;
        let cases = [
            (cube, ProbeShape::Sphere { radius: 0.02 }, Vec3::new(0.0, 0.0, 0.119), upright, 0.001),
            (cube, punch, Vec3::new(0.01, 0.0, 0.119), upright, 0.001),
            (cube, capsule, Vec3::new(0.0, 0.0, 0.104), Quat::from_rotation_y(1.570_796_4), 0.001),
            (cube, egg, Vec3::new(0.0, 0.0, 0.109), upright, 0.001),
            (ellipsoid, egg, Vec3::new(0.0, 0.0, 0.089), upright, 0.001),
            (ellipsoid, punch, Vec3::new(0.0, 0.0, 0.099), upright, 0.001),
            (ObjectShape::HalfSpace, ProbeShape::Cone { radius: 0.01, height: 0.03 }, Vec3::Z * (0.0225 - 0.001), upright, 0.001),
            (ObjectShape::Sphere { radius: 0.05 }, ProbeShape::Box { size: Vec3::splat(0.02) }, Vec3::Z * 0.109, upright, 0.001),
            (ObjectShape::Cylinder { radius: 0.03, height: 0.1 }, capsule, Vec3::Z * 0.119, upright, 0.001),
        ];
        for (object, shape, position, rotation, expected) in cases {
            let found = depth(object, shape, position, rotation);
            assert!((found - expected).abs() < 2.0e-6, "{object:?} {shape:?}: {found}");
        }
    }

    #[test]
    fn a_plate_wider_than_the_cube_rests_on_its_top() {
        let plate = ProbeShape::Box { size: Vec3::new(0.3, 0.3, 0.01) };
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let found = depth(cube, plate, Vec3::Z * 0.1045, Quat::IDENTITY);
        assert!((found - 0.0005).abs() < 1.0e-6, "{found}");
    }

    /// Numbers for a test, evenly spread (Steele's splitmix).
    struct Numbers(u64);

    impl Numbers {
        /// From -1 to 1.
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((mixed >> 40) as f32) / 8_388_608.0 - 1.0
        }

        fn vector(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next())
        }

        /// A share of a size, as many between one power of ten and the next.
        fn share(&mut self, least: f32, most: f32) -> f32 {
            least * libm::powf(most / least, 0.5 + 0.5 * self.next())
        }

        /// Every third turn lays an axis of the part on the normal `n`, as flats lie.
        fn turn(&mut self, n: Vec3) -> Quat {
            let free = Quat::from_vec4(self.vector().extend(self.next())).normalize();
            let laid = |axis: Vec3| Quat::from_rotation_arc(axis, n).normalize();
            match (3.0 + 3.0 * self.next()) as u32 {
                0 => laid(Vec3::Z),
                1 => laid(Vec3::X),
                _ => free,
            }
        }
    }

    /// Objects whose extent along a normal is known, a wide and flat one among them.
    const KNOWN: [ObjectShape<'_>; 4] = [
        ObjectShape::Box { size: Vec3::new(0.1, 0.08, 0.05) },
        ObjectShape::Box { size: Vec3::new(1.0, 0.6, 0.01) },
        ObjectShape::Cylinder { radius: 0.03, height: 0.1 },
        ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) },
    ];

    /// A part where its farthest point against the object's normal on a face, an edge or a corner stands at `distance` from the surface, as a share of both sizes; and that point.
    fn placed<'a>(
        numbers: &mut Numbers,
        object: &ObjectShape<'_>,
        shape: ProbeShape<'a>,
        distance: f32,
    ) -> (ProbePart<'a>, Pose<World, PartFrame>, Vec3) {
        let widest = max(gap::extent(object, Vec3::X), gap::extent(object, Vec3::Z));
        let from = gap::centre(object) + direction(numbers.vector(), Vec3::Z) * (2.0 * widest);
        let Gap { distance: away, normal } = gap(object, from);
        let size = reach(&shape) + gap::extent(object, normal);
        let (part, turn) = (ProbePart::at_origin(shape), numbers.turn(normal));
        let farthest = support(&shape, turn.conjugate() * -normal);
        let x_wa = Pose::new(from - normal * (away - distance * size) - turn * farthest, turn);
        (part, x_wa, x_wa.point(farthest))
    }

    /// Every known object with every shape of a part, many times.
    fn pairs() -> impl Iterator<Item = (ObjectShape<'static>, ProbeShape<'static>)> {
        let objects = || KNOWN.into_iter().flat_map(|object| SHAPES.into_iter().map(move |shape| (object, shape)));
        (0..PLACES).flat_map(move |_| objects())
    }

    /// Places that a test tries of every pair of shapes.
    const PLACES: usize = 2_000;

    /// No overlap is taken for a gap, down to those of a millionth of the size.
    #[test]
    fn no_overlap_is_proven_apart() {
        let mut numbers = Numbers(1);
        let (mut tried, mut shallow) = (0, 0);
        for (object, shape) in pairs() {
            let depth = numbers.share(1.0e-6, 0.1);
            let (part, x_wa, inside) = placed(&mut numbers, &object, shape, -depth);
            // rounding may have put it outside
            if gap(&object, inside).distance >= 0.0 {
                continue;
            }
            let (found, proof) = descend(&object, &part, &x_wa);
            assert!(proof != Proof::Apart, "{object:?} {shape:?} {x_wa:?}, {depth} deep: {found:?}");
            tried += 1;
            shallow += usize::from(depth < 4.0e-6);
        }
        assert!(tried > 20 * PLACES && shallow > 2 * PLACES, "{tried}, {shallow} of them shallow");
    }

    /// Most gaps are proven, by the first look or on the way down, and none is taken for an overlap.
    #[test]
    fn gaps_are_proven() {
        let mut numbers = Numbers(2);
        let (mut tried, mut proven) = (0, 0);
        for (object, shape) in pairs() {
            let distance = numbers.share(1.0e-4, 0.3);
            let (part, x_wa, _) = placed(&mut numbers, &object, shape, distance);
            let found = deepest(&object, &part, &x_wa);
            assert!(found.gap.distance > 0.0, "{object:?} {shape:?} {x_wa:?}, {distance} apart: {found:?}");
            let (_, proof) = descend(&object, &part, &x_wa);
            tried += 1;
            proven += usize::from(proof == Proof::Apart);
        }
        assert!(proven > 4 * tried / 5, "{proven} of {tried}");
    }

    /// A flat of 40 mm laid on an edge by micrometres has the flat's normal, wherever the edge is: not one that jitters by what the few digits of a slack leave of it.
    #[test]
    fn a_flat_on_an_edge_keeps_its_normal_however_shallow() {
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let part = ProbePart::at_origin(ProbeShape::Box { size: Vec3::splat(0.04) });
        for i in 0..400 {
            let f = i as f32;
            let turn = Quat::from_rotation_y(0.3 + 0.002 * f);
            let out = turn * Vec3::Z;
            let depth = libm::powf(10.0, -6.0 + 3.0 * libm::fabsf(libm::sinf(f)));
            let edge = Vec3::new(0.05, 0.01 * libm::sinf(1.7 * f), 0.1);
            let along = turn * Vec3::X * (0.01 * libm::sinf(2.3 * f));
            let found = deepest(&cube, &part, &part_pose(&part, &Pose::new(edge + along + out * (0.02 - depth), turn)));
            assert!((found.gap.normal - out).length() < 2.0 * (depth / 0.01) + 1.0e-5, "{i} {depth}: {:?} {out}", found.gap);
        }
    }

    /// Of a capsule at a corner, deep, shallow or missed by descent, no ball has a deeper point, and the search does not ask for ever.
    #[test]
    fn a_capsule_at_a_corner_is_its_deepest_ball() {
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let (radius, height) = (0.006, 0.02);
        let part = ProbePart::at_origin(ProbeShape::Capsule { radius, height });
        let mut numbers = Numbers(3);
        let (mut touching, mut all, mut most) = (0, 0, 0);
        for _ in 0..CAPSULES {
            let turn = Quat::from_vec4(numbers.vector().extend(numbers.next())).normalize();
            let x_wa = Pose::new(Vec3::new(0.05, 0.05, 0.1) + 0.012 * numbers.vector(), turn);
            let asked = Cell::new(0);
            let found = deepest_asking(&cube, &part, &x_wa, &asked).gap.distance;
            let under = |middle: Vec3| gap::slope(&cube, middle - gap(&cube, middle).normal * radius).distance;
            let balls = (0..=100).map(|i| under(x_wa.point(Vec3::Z * (height * (i as f32 / 100.0 - 0.5)))));
            let deepest = balls.fold(f32::MAX, |least, ball| if ball < least { ball } else { least });
            assert!(
                deepest >= -1.0e-7 || found <= deepest + 1.0e-7 + 1.0e-4 * found.abs(),
                "{x_wa:?}: {found}, a ball {deepest}"
            );
            touching += u32::from(found < 0.0);
            (all, most) = (all + asked.get(), most.max(asked.get()));
        }
        assert!(touching > CAPSULES / 2 && all < 25 * CAPSULES && most < 400, "{touching} touch, {all} asked for, {most} of one");
    }

    /// How many capsules are tried.
    const CAPSULES: u32 = 40_000;

    /// Round parts have one normal, whether the search says it or the gap where it ended.
    #[test]
    fn a_search_under_an_edge_ends_on_the_normal_of_its_point() {
        let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
        let part = ProbePart::at_origin(ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.03, 0.02, 0.015) });
        for (tilt, turn) in [(0.0, 0.4), (0.3, 0.0), (1.2, 0.0)] {
            let rotation = Quat::from_rotation_y(tilt) * Quat::from_rotation_z(turn);
            let lowest = (rotation * support(&part.shape, rotation.conjugate() * -Vec3::Z)).z;
            for i in 0..700 {
                let position = Vec3::new(0.04 + 0.05e-3 * i as f32, 0.003, 0.099 - lowest);
                let found = deepest(&cube, &part, &part_pose(&part, &Pose::new(position, rotation)));
                let (said, there) = (found.gap.normal, gap(&cube, found.point).normal);
                let is_shallow = found.gap.distance > -1.0e-5;
                assert!(is_shallow || (said - there).length() < 4.0e-3, "tilt {tilt}, turn {turn}, {i}: {said} {there}");
            }
        }
    }
}

//! A contact that is not looked at in a tick goes with its part.
//!
//! Where a tick's work does not suffice to look at every part that is near, the parts take turns ([`budget`](crate::budget)). Until its turn comes, a contact keeps its normal, its footprint
//! grows on as it grew, and its place and depth follow the part's motion to first order: the depth of the deepest point changes by the motion of the
//! material there along the normal, and by nothing else where no other point was as deep (theory.md, equation 2.9). Of a flat or a line that tips all points were: its farthest point against the normal
//! may have become the deepest.

use glam::Vec3;

use crate::frames::{Pose, ProbeFrame, World};
use crate::geometry::deepest::{part_pose, support_in_world};
use crate::geometry::gap;
use crate::model::{ObjectShape, ProbePart, ProbeShape};
use crate::scratch::Contact;

/// `last` as it is once the probe went from `before` to `now`, on this part; `None` where the two have parted.
pub fn carried(
    object: &ObjectShape<'_>,
    part: &ProbePart<'_>,
    last: &Contact,
    before: &Pose<World, ProbeFrame>,
    now: &Pose<World, ProbeFrame>,
) -> Option<Contact> {
    if now == before {
        return Some(*last);
    }
    let middle = last.normal * roundness(&part.shape);
    let carry = |place: Vec3| place + moved(place + middle, before, now);
    let depth = last.depth - last.normal.dot(moved(last.deepest + middle, before, now));
    let tipped = tipped(object, part, last.normal, now).filter(|tipped| tipped.depth > depth);
    let Spot { depth, deepest } = tipped.unwrap_or_else(|| Spot { depth, deepest: carry(last.deepest) });
    let contact = || Contact { centre: carry(last.centre), deepest, depth, seat: last.seat.stretched(depth), ..*last };
    // also none for a depth that is not a number
    (depth > 0.0).then(contact)
}

/// A point of a part, and how deep it lies \[m\].
struct Spot {
    depth: f32,
    deepest: Vec3,
}

/// The farthest point against the normal of a part with flats or straight lines; none of a mesh or on one, where it is dear.
fn tipped(object: &ObjectShape<'_>, part: &ProbePart<'_>, normal: Vec3, now: &Pose<World, ProbeFrame>) -> Option<Spot> {
    let is_round = matches!(part.shape, ProbeShape::Sphere { .. } | ProbeShape::Ellipsoid { .. } | ProbeShape::Mesh(_));
    if is_round || matches!(object, ObjectShape::Mesh(_)) {
        return None;
    }
    let deepest = support_in_world(part, &part_pose(part, now), -normal);
    Some(Spot { depth: -gap::slope(object, deepest).distance, deepest })
}

/// How far the probe's material at a place of world went \[m\]: nothing, to the bit, where the pose is the same.
fn moved(place: Vec3, before: &Pose<World, ProbeFrame>, now: &Pose<World, ProbeFrame>) -> Vec3 {
    let place = before.rotation.conjugate() * (place - before.position);
    now.point(place) - before.point(place)
}

/// Radius of the ball that the part is where it touches \[m\], none where it has flats and corners: a ball that turns touches at the same place.
fn roundness(shape: &ProbeShape<'_>) -> f32 {
    match *shape {
        ProbeShape::Sphere { radius } | ProbeShape::Capsule { radius, .. } => radius,
        ProbeShape::Ellipsoid { semi_axes } => semi_axes.min_element(),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Material, ModelSpec};
    use crate::stage::detect::{Seen, detect};
    use crate::{Input, Model, Params, ParamsSpec, Quat, Scratch, State, Tier, step};
    use heapless::Vec;

    const CUBE: ObjectShape<'_> = ObjectShape::Box { size: Vec3::splat(0.1) };
    const BALL: ObjectShape<'_> = ObjectShape::Sphere { radius: 0.05 };

    fn seen(model: &Model<'_>, pose: &Pose<World, ProbeFrame>) -> Option<Contact> {
        let mut contacts = Vec::<Contact, 1>::new();
        detect(model, pose, None, Seen { contacts: &[], pose: None }, &mut contacts);
        contacts.first().copied()
    }

    /// How far the carried depth is from the one that a look finds, for a motion of this many micrometres and as many tens of microradians.
    fn off(object: ObjectShape<'static>, shape: ProbeShape<'static>, from: Vec3, tilt: f32, size: f32) -> f32 {
        let parts = [ProbePart::at_origin(shape)];
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let model = Model::new(&ModelSpec::new(object, rubber, &parts)).unwrap();
        let before = Pose::new(from, Quat::from_rotation_x(tilt));
        let turn = Quat::from_scaled_axis(Vec3::new(0.6, -0.3, 0.2) * (10.0e-6 * size)).normalize();
        let now = Pose::new(from + Vec3::new(0.5, 0.7, -0.4) * (1.0e-6 * size), (turn * before.rotation).normalize());
        let last = seen(&model, &before).unwrap();
        let (carried, found) = (carried(&model.object, &parts[0], &last, &before, &now).unwrap(), seen(&model, &now).unwrap());
        assert_eq!(carried.normal, last.normal);
        (carried.depth - found.depth).abs()
    }

    #[test]
    fn a_carried_depth_is_right_to_first_order() {
        let capsule = ProbeShape::Capsule { radius: 0.006, height: 0.02 };
        let cases = [
            (CUBE, capsule, Vec3::new(0.01, 0.0, 0.1145), 0.3),
            (CUBE, capsule, Vec3::new(0.046, 0.0, 0.1145), 0.3),
            (CUBE, ProbeShape::Box { size: Vec3::splat(0.02) }, Vec3::new(0.01, 0.02, 0.111), 0.5),
            (CUBE, ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.02, 0.03, 0.01) }, Vec3::new(0.0, 0.01, 0.11), 0.2),
            (BALL, ProbeShape::Cylinder { radius: 0.01, height: 0.02 }, Vec3::new(0.003, 0.0, 0.1095), 0.1),
        ];
        for (object, shape, from, tilt) in cases {
            let (large, small) = (off(object, shape, from, tilt, 1000.0), off(object, shape, from, tilt, 100.0));
            // second order, and a few units in the last place of a tenth of a metre
            assert!(large < 6.0e-5 && small < 6.0e-7 + 6.0e-8, "{object:?} {shape:?}: {large} {small}");
        }
    }

    #[test]
    fn a_contact_that_does_not_move_stays_to_the_bit_and_one_that_is_lifted_parts() {
        let shape = ProbeShape::Box { size: Vec3::splat(0.02) };
        let parts = [ProbePart::at_origin(shape)];
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let model = Model::new(&ModelSpec::new(CUBE, rubber, &parts)).unwrap();
        let pose = Pose::new(Vec3::new(0.01, 0.02, 0.111), Quat::from_rotation_x(0.5));
        let last = seen(&model, &pose).unwrap();
        let held = carried(&CUBE, &parts[0], &last, &pose, &pose).unwrap();
        assert_eq!((held.centre, held.deepest, held.depth), (last.centre, last.deepest, last.depth));
        let lifted = Pose::new(pose.position + Vec3::Z * (1.01 * last.depth), pose.rotation);
        assert!(carried(&CUBE, &parts[0], &last, &pose, &lifted).is_none());
    }

    /// Ten capsules on a ring, every other one 0.1 mm lower.
    fn ring() -> [ProbePart<'static>; 10] {
        core::array::from_fn(|i| {
            let position = Quat::from_rotation_z(0.628 * i as f32) * Vec3::X * 0.035 - Vec3::Z * (1.0e-4 * (i % 2) as f32);
            ProbePart { position, ..ProbePart::at_origin(ProbeShape::Capsule { radius: 0.003, height: 0.01 }) }
        })
    }

    fn on_cube(parts: &[ProbePart<'static>; 10], mut with: impl FnMut(&Model<'_>, &dyn Fn(i16) -> Input)) {
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let model = Model::new(&ModelSpec::new(CUBE, rubber, parts)).unwrap();
        let pose = |tick: i16| Pose::new(Vec3::new(1.0e-6 * f32::from(tick), 0.0, 0.1078), Quat::IDENTITY);
        with(&model, &|tick| Input { pose: pose(tick), dt: 1.0e-3 });
    }

    fn point(work: Option<u32>) -> Params {
        Params::new(&ParamsSpec { tier: Tier::Point, work, ..ParamsSpec::default() }).unwrap()
    }

    #[test]
    fn a_budget_that_is_set_amid_contacts_leaves_them_all() {
        on_cube(&ring(), |model, input| {
            let (mut all, mut turns) = (State::<10, 0>::new(), State::<10, 0>::new());
            let mut scratch = Scratch::<10>::new();
            for t in 0..60 {
                let free = step(model, &point(None), &mut all, &mut scratch, input(t));
                let short = step(model, &point((t >= 20).then_some(60_000)), &mut turns, &mut scratch, input(t));
                assert_eq!(short.report.regions, free.report.regions, "tick {t}");
                let off = (short.contact.force - free.contact.force).length();
                assert!(off <= 1.0e-3 * free.contact.force.length(), "tick {t}: {off}");
            }
        });
    }

    #[test]
    fn where_few_contacts_find_room_those_of_the_patches_do() {
        on_cube(&ring(), |model, input| {
            let (mut state, mut scratch) = (State::<2, 0>::new(), Scratch::<10>::new());
            let mut held = None;
            for t in 0..60 {
                step(model, &point(Some(60_000)), &mut state, &mut scratch, input(t));
                let oldest = state.patches().first().map(|patch| patch.born);
                held = held.or(oldest);
                assert_eq!(oldest, held, "tick {t}");
            }
        });
    }

    #[test]
    fn a_ball_that_spins_stays_as_deep() {
        let shape = ProbeShape::Sphere { radius: 0.01 };
        let parts = [ProbePart::at_origin(shape)];
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let model = Model::new(&ModelSpec::new(CUBE, rubber, &parts)).unwrap();
        // 50 um deep; its lowest material rises by 72 um
        let before = Pose::new(Vec3::new(0.01, 0.02, 0.10995), Quat::IDENTITY);
        let now = Pose::new(before.position, Quat::from_rotation_y(0.12));
        let last = seen(&model, &before).unwrap();
        let spun = carried(&model.object, &parts[0], &last, &before, &now).unwrap();
        assert!((spun.depth - last.depth).abs() < 1.0e-8 && (spun.centre - last.centre).length() < 1.0e-8);
    }

    /// Whichever way it tips: the corner that stood for all may be the one that rises.
    #[test]
    fn a_flat_or_a_line_that_tips_stays_as_deep_as_its_lowest_end() {
        let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let lying = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2);
        let flats = [
            (ProbeShape::Box { size: Vec3::splat(0.02) }, Quat::IDENTITY, 0.01),
            (ProbeShape::Cylinder { radius: 0.01, height: 0.02 }, Quat::IDENTITY, 0.01),
            (ProbeShape::Capsule { radius: 0.005, height: 0.02 }, lying, 0.005),
            (ProbeShape::Cylinder { radius: 0.005, height: 0.02 }, lying, 0.005),
        ];
        for ((shape, rotation, under), tip) in flats.iter().flat_map(|flat| [-2.5e-3, 2.5e-3].map(|tip| (*flat, tip))) {
            let parts = [ProbePart::at_origin(shape)];
            let model = Model::new(&ModelSpec::new(CUBE, rubber, &parts)).unwrap();
            let before = Pose::new(Vec3::new(0.001, 0.002, 0.1 + under - 2.0e-5), rotation);
            let now = Pose::new(before.position, (Quat::from_rotation_y(tip) * rotation).normalize());
            let (last, found) = (seen(&model, &before).unwrap(), seen(&model, &now).unwrap());
            let tipped = carried(&model.object, &parts[0], &last, &before, &now).map(|tipped| tipped.depth);
            assert!(
                tipped.is_some_and(|depth| (depth - found.depth).abs() < 1.0e-7),
                "{shape:?} {tip}: {tipped:?} {}",
                found.depth
            );
        }
    }
}

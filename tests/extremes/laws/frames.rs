//! Units, directions and places do not matter.

use std::f32::consts::FRAC_PI_2;

use glam::{DVec3, Quat, Vec3};
use haptor_contact::{Invalid, ObjectShape, ProbePart, ProbeShape, Tier, Wrench};

use super::Outcome;
use super::place::{AGES, Walk, as_it_is, place, tick_at};
use crate::extremes::cases::Case;
use crate::extremes::rig::{Rig, Scene};

/// Ticks of a comparison.
const TICKS: u32 = 48;

/// The corner and its twin, moved alike, feel alike in their own units: forces go as E L^2, torques as E L^3. Powers of two scale every product exactly, so that only a
/// threshold told in SI units or the range of an f32 can show.
pub fn units(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    if !case.is_twinned() {
        return Ok(());
    }
    let (corner, mut rng) = (case.corner(), case.choices());
    let walk = Walk::new(case, at, &mut rng, TICKS, (-3.0, 1.0));
    let s = f64::from(case.length());
    let force = 2.0_f64.powi(case.moduli) * s * s;
    let told = |twin: &Wrench| (twin.force.as_dvec3() * force, twin.torque.as_dvec3() * (force * s));
    let tick =
        |[twin, own]: &mut [Rig<'_>; 2], pose: (Vec3, Quat)| [tick_at(own, case, pose, AGES), twin.tick(pose.0, pose.1, AGES)];
    walk.compare(outcome, [case.twin.rig()?, corner.rig()?], tick, told);
    Ok(())
}

/// A vector turned by a quarter about the vertical, exactly.
fn turned_vector(v: Vec3) -> Vec3 {
    Vec3::new(-v.y, v.x, v.z)
}

/// A rotation as a frame that is turned by a quarter along with everything tells it, exactly: its axis turns.
fn turned_rotation(q: Quat) -> Quat {
    Quat::from_xyzw(-q.y, q.x, q.z, q.w)
}

/// A part in a probe whose own frame is turned by a quarter along with it. A mesh cannot be told in other axes: it is turned as a whole, to rounding.
fn turned_part(part: &ProbePart<'static>) -> ProbePart<'static> {
    let swapped = |v: Vec3| Vec3::new(v.y, v.x, v.z);
    let rotation = turned_rotation(part.rotation);
    let (shape, rotation) = match part.shape {
        ProbeShape::Box { size } => (ProbeShape::Box { size: swapped(size) }, rotation),
        ProbeShape::Ellipsoid { semi_axes } => (ProbeShape::Ellipsoid { semi_axes: swapped(semi_axes) }, rotation),
        ProbeShape::Mesh(_) => (part.shape, Quat::from_rotation_z(FRAC_PI_2) * part.rotation),
        round => (round, rotation),
    };
    ProbePart { shape, position: turned_vector(part.position), rotation }
}

/// The scene turned by a quarter about the vertical; `None` for bodies that cannot be told turned.
fn quarter(scene: &Scene) -> Option<Scene> {
    let object = match scene.object {
        ObjectShape::Box { size } => ObjectShape::Box { size: Vec3::new(size.y, size.x, size.z) },
        ObjectShape::Ellipsoid { semi_axes: v } => ObjectShape::Ellipsoid { semi_axes: Vec3::new(v.y, v.x, v.z) },
        ObjectShape::Mesh(_) => return None,
        round => round,
    };
    Some(Scene { object, parts: scene.parts.iter().map(turned_part).collect(), ..scene.clone() })
}

/// The whole world turned by a quarter about the vertical: the wrenches turn with it. The probe's own axes are told turned too, so that the two worlds have the same digits: a probe that is turned in its
/// own axes has a pose rounded anew, and a contact of a few hundred steps of the pose's digits, or at the end of what touches at all, then feels another pose and not another direction.
pub fn turned(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let (corner, mut rng) = (case.corner(), case.choices());
    let Some(other) = quarter(&corner) else { return Ok(()) };
    let walk = Walk::new(case, at, &mut rng, TICKS, (-3.0, 1.0));
    let back = |v: Vec3| DVec3::new(v.y.into(), (-v.x).into(), v.z.into());
    let told = |turned: &Wrench| (back(turned.force), back(turned.torque));
    let tick = |[own, turned]: &mut [Rig<'_>; 2], (position, rotation): (Vec3, Quat)| {
        let along = (turned_vector(position), turned_rotation(rotation));
        [tick_at(own, case, (position, rotation), AGES), tick_at(turned, case, along, AGES)]
    };
    walk.compare(outcome, [corner.rig()?, other.rig()?], tick, told);
    Ok(())
}

/// On a half space x and y have no origin: the same poses, told up to 700 m away, feel alike. Both sessions have the digits of the far one, so that what differs is the core's own rounding.
pub fn moved(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    if case.twin.parts.iter().any(|part| matches!(part.shape, ProbeShape::Mesh(_))) || case.twin.params.tier == Tier::Green {
        return Ok(());
    }
    let flat = Scene { object: ObjectShape::HalfSpace, ..case.corner() };
    let Some(at) = place(case, &Scene { object: ObjectShape::HalfSpace, ..case.twin.clone() }, outcome)? else { return Ok(()) };
    let mut rng = case.choices();
    let walk = Walk::new(case, at, &mut rng, TICKS, (-1.0, 1.0));
    let far = Vec3::new(2.0_f32.powi(rng.i32(-6..=9)), -(2.0_f32.powi(rng.i32(-6..=9))), 0.0);
    let tick = |[near, away]: &mut [Rig<'_>; 2], (position, rotation): (Vec3, Quat)| {
        let there = position * case.length() + far;
        [near.tick(there - far, rotation, AGES), away.tick(there, rotation, AGES)]
    };
    walk.compare(outcome, [flat.rig()?, flat.rig()?], tick, as_it_is);
    Ok(())
}

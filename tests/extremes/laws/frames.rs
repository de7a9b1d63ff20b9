//! Units, directions and places do not matter.

use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec3};
use haptor_contact::{Invalid, ObjectShape, ProbeShape, Tier, Wrench};

use super::Outcome;
use super::place::{AGES, Apart, Loop, counts, moved as moved_by, place};
use crate::extremes::cases::{Case, decades};
use crate::extremes::rig::Scene;

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
    let (mut here, mut there) = (case.twin.rig()?, corner.rig()?);
    let (path, amplitude) = (Loop::new(&mut rng, TICKS), case.depth * decades(&mut rng, -3.0, 1.0));
    let (s, mut apart) = (f64::from(case.length()), Apart::default());
    let force = 2.0_f64.powi(case.moduli) * s * s;
    for tick in 0..TICKS {
        let (shift, spin) = path.at(tick);
        let (position, rotation) = moved_by(case, at, shift * amplitude, spin * (amplitude / case.size));
        let twin = here.tick(position, rotation, AGES);
        let own = there.tick(position * case.length(), rotation, AGES);
        if twin.report.depth > 0.0 && !counts(&twin) || own.report.depth > 0.0 && !counts(&own) {
            break;
        }
        // in units of the corner, in f64: the product may leave the range of an f32
        apart.take_scaled(&own.contact, &twin.contact, (1.0 / force, 1.0 / (force * s)), f64::from(own.report.radius));
    }
    apart.share().into_iter().for_each(|share| outcome.figure(share));
    outcome.add(&here.seen);
    outcome.add(&there.seen);
    Ok(())
}

/// The scene turned by a quarter about the vertical; `None` for bodies that cannot be told turned.
fn quarter(scene: &Scene) -> Option<Scene> {
    let object = match scene.object {
        ObjectShape::Box { size } => ObjectShape::Box { size: Vec3::new(size.y, size.x, size.z) },
        ObjectShape::Ellipsoid { semi_axes: v } => ObjectShape::Ellipsoid { semi_axes: Vec3::new(v.y, v.x, v.z) },
        ObjectShape::Mesh(_) => return None,
        round => round,
    };
    Some(Scene { object, ..scene.clone() })
}

/// The whole world turned by a quarter about the vertical: the wrenches turn with it.
pub fn turned(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let (corner, mut rng) = (case.corner(), case.choices());
    let Some(other) = quarter(&corner) else { return Ok(()) };
    let (mut here, mut there) = (corner.rig()?, other.rig()?);
    let (path, amplitude) = (Loop::new(&mut rng, TICKS), case.depth * decades(&mut rng, -3.0, 1.0));
    let (by, mut apart) = (Quat::from_rotation_z(FRAC_PI_2), Apart::default());
    for tick in 0..TICKS {
        let (shift, spin) = path.at(tick);
        let (position, rotation) = moved_by(case, at, shift * amplitude, spin * (amplitude / case.size));
        let position = position * case.length();
        let own = here.tick(position, rotation, AGES);
        let turned = there.tick(Vec3::new(-position.y, position.x, position.z), (by * rotation).normalize(), AGES);
        if own.report.depth > 0.0 && !counts(&own) || turned.report.depth > 0.0 && !counts(&turned) {
            break;
        }
        let back = |v: Vec3| Vec3::new(v.y, -v.x, v.z);
        apart.take(
            &own.contact,
            &Wrench::new(back(turned.contact.force), back(turned.contact.torque)),
            f64::from(own.report.radius),
        );
    }
    apart.share().into_iter().for_each(|share| outcome.figure(share));
    outcome.add(&here.seen);
    outcome.add(&there.seen);
    Ok(())
}

/// On a half space x and y have no origin: the same poses, told up to a kilometre away, feel alike. Both sessions have the digits of the far one, so that what differs is the core's own rounding.
pub fn moved(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    if case.twin.parts.iter().any(|part| matches!(part.shape, ProbeShape::Mesh(_))) || case.twin.params.tier == Tier::Green {
        return Ok(());
    }
    let flat = Scene { object: ObjectShape::HalfSpace, ..case.corner() };
    let Some(at) = place(case, &Scene { object: ObjectShape::HalfSpace, ..case.twin.clone() }, outcome)? else { return Ok(()) };
    let mut rng = case.choices();
    let (mut here, mut there) = (flat.rig()?, flat.rig()?);
    let (path, amplitude) = (Loop::new(&mut rng, TICKS), case.depth * decades(&mut rng, -1.0, 1.0));
    let far = Vec3::new(2.0_f32.powi(rng.i32(-6..=9)), -(2.0_f32.powi(rng.i32(-6..=9))), 0.0);
    let mut apart = Apart::default();
    for tick in 0..TICKS {
        let (shift, spin) = path.at(tick);
        let (position, rotation) = moved_by(case, at, shift * amplitude, spin * (amplitude / case.size));
        let there_at = position * case.length() + far;
        let (near, away) = (here.tick(there_at - far, rotation, AGES), there.tick(there_at, rotation, AGES));
        if near.report.depth > 0.0 && !counts(&near) || away.report.depth > 0.0 && !counts(&away) {
            break;
        }
        apart.take(&near.contact, &away.contact, f64::from(near.report.radius));
    }
    apart.share().into_iter().for_each(|share| outcome.figure(share));
    outcome.add(&here.seen);
    outcome.add(&there.seen);
    Ok(())
}

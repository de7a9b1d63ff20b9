//! Pressing deeper, and moving by very little.

use haptor_contact::{Invalid, ParamsSpec, Vec3};

use super::Outcome;
use super::place::{AGES, LEAST_COMPARED, counts, is_spoilt, moved, place, settle, tick_at};
use crate::extremes::cases::{Case, any_vector};
use crate::extremes::rig::{Scene, length};

/// Steps of a press, and the factor from one to the next: from a hundredth of the depth to all of it.
const PRESSES: i32 = 24;
const FACTOR: f32 = 1.212;

/// Deeper is not lighter, without friction: the force against the press does not fall. Figure: the largest fall over the largest force so far.
pub fn deeper(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let corner = case.corner();
    let smooth = Scene { params: ParamsSpec { friction_static: Some(0.0), friction_dynamic: 0.0, ..corner.params }, ..corner };
    let mut rig = smooth.rig()?;
    let up = if smooth.object == haptor_contact::ObjectShape::HalfSpace { Vec3::Z } else { case.side };
    let mut most = 0.0_f64;
    for press in 0..PRESSES {
        let lift = case.depth * (1.0 - FACTOR.powi(press + 1 - PRESSES));
        let output = settle(&mut rig, (at + up * lift) * case.length(), case.rotation);
        if is_spoilt(&output) {
            // too shallow for the digits at first, too deep for small strain at last
            most = 0.0;
            continue;
        }
        let force = output.contact.force.as_dvec3().dot(up.as_dvec3());
        if most > LEAST_COMPARED {
            outcome.figure((most - force) / most);
        }
        most = most.max(force);
    }
    outcome.add(&rig.seen);
    Ok(())
}

/// A motion this small, of the depth, cannot change much.
const SMALL: f32 = 1.0e-4;

/// Steps of that size.
const STEPS: u32 = 12;

/// Small motions change little. Figure: the largest change of force in a step of a ten-thousandth of the depth, over the force.
pub fn continuous(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let (corner, mut rng) = (case.corner(), case.choices());
    let mut rig = corner.rig()?;
    let (way, spin) = (any_vector(&mut rng) * (SMALL * case.depth), any_vector(&mut rng) * (SMALL * case.depth / case.size));
    let mut last = settle(&mut rig, at * case.length(), case.rotation);
    // a step below the digits of the pose is none
    let told = SMALL * case.depth > 8.0 * f32::EPSILON * at.abs().max_element();
    for step in 1..=STEPS {
        let next = tick_at(&mut rig, case, moved(case, at, way * step as f32, spin * step as f32), AGES);
        let force = length(last.contact.force).max(length(next.contact.force));
        if told && counts(&last) && counts(&next) && force > LEAST_COMPARED {
            outcome.figure(length(next.contact.force - last.contact.force) / force);
        }
        last = next;
    }
    outcome.add(&rig.seen);
    Ok(())
}

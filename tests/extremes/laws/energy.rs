//! What the hand puts in it gets back at most, and all of it while everything sticks.

use fastrand::Rng;
use glam::{DQuat, Quat, Vec3};
use haptor_contact::{Invalid, Wrench};

use super::Outcome;
use super::place::{AGES, LEAST_COMPARED, Walk, counts, is_spoilt, place, settle, tick_at};
use crate::extremes::cases::Case;
use crate::extremes::rig::length;

/// Ticks of a cycle: the trapezoidal rule then errs by less than a thousandth of what is exchanged where the contact lasts.
const TICKS: u32 = 240;

/// Cycles in the dearest tiers: in the first the contact runs in.
const CYCLES: u32 = 3;

/// Work over closed cycles of the pose. Figure: what came out over all that was exchanged, the worse of the cycles after the first.
pub fn cycle(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let (corner, mut rng) = (case.corner(), case.choices());
    let mut rig = corner.rig()?;
    let walk = Walk::new(case, at, &mut rng, TICKS, (-2.0, 0.5));
    let mut last = (walk.pose(0), settle(&mut rig, at * case.length(), case.rotation).contact);
    let (mut sound, mut worst) = (true, 0.0_f64);
    for lap in 0..CYCLES * case.longer() {
        let (mut work, mut exchanged) = (0.0, 0.0);
        for tick in 1..=TICKS {
            let next = walk.pose(tick);
            let output = tick_at(&mut rig, case, next, AGES);
            sound &= !is_spoilt(&output);
            let done = work_of(case, last, (next, output.contact));
            (work, exchanged) = (work + done, exchanged + done.abs());
            last = (next, output.contact);
        }
        if lap > 0 && exchanged > LEAST_COMPARED {
            worst = worst.max(-work / exchanged);
        }
    }
    if sound && rig.seen.touching > u64::from(TICKS) {
        outcome.figure(worst);
    }
    outcome.add(&rig.seen);
    Ok(())
}

/// A pose of the twin with the wrench that was felt at it.
type Felt = ((Vec3, Quat), Wrench);

/// Work that the hand does on the probe between two ticks \[J\].
fn work_of(case: &Case, (before, felt): Felt, (after, feels): Felt) -> f64 {
    let wide = |q: Quat| DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into()).normalize();
    let shift = (after.0.as_dvec3() - before.0.as_dvec3()) * f64::from(case.length());
    let turn = (wide(after.1) * wide(before.1).conjugate()).to_scaled_axis();
    let force = (felt.force.as_dvec3() + feels.force.as_dvec3()) * 0.5;
    let torque = (felt.torque.as_dvec3() + feels.torque.as_dvec3()) * 0.5;
    -(force.dot(shift) + torque.dot(turn))
}

/// Largest motion that still sticks, as a share of mu times the depth: Cattaneo's slip of a thousandth leaves less than that.
const STUCK: f32 = 1.0e-3;

/// Ticks out, and back.
const OUT: u32 = 16;

/// A small motion along the surface, out and back the same way: the wrench comes back. Figure: what is left over what was built up.
pub fn stick(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let mut rng = case.choices();
    let mu = case.twin.params.friction_dynamic;
    if mu <= 0.0 {
        return Ok(());
    }
    let corner = case.corner();
    let mut rig = corner.rig()?;
    let start = settle(&mut rig, at * case.length(), case.rotation);
    let way = along(&mut rng, &rig) * (STUCK * mu.min(1.0) * start.report.depth / case.length());
    let (mut sound, mut built) = (counts(&start), 0.0_f64);
    let mut end = start;
    for tick in 1..=2 * OUT {
        let share = if tick <= OUT { tick } else { 2 * OUT - tick } as f32 / OUT as f32;
        end = tick_at(&mut rig, case, (at + way * share, case.rotation), AGES);
        sound &= counts(&end) && end.report.regions == start.report.regions;
        built = built.max(change(&start.contact, &end.contact));
    }
    // a way of a few steps of the pose's digits tells nothing
    let told = way.length() > 1.0e2 * f32::EPSILON * at.abs().max_element();
    if sound && told && built > LEAST_COMPARED {
        outcome.figure(change(&start.contact, &end.contact) / built);
    }
    outcome.add(&rig.seen);
    Ok(())
}

/// A direction along the surface under the deepest patch.
fn along(rng: &mut Rng, rig: &crate::extremes::rig::Rig<'_>) -> Vec3 {
    let normal = rig.patches().first().map_or(Vec3::Z, |patch| patch.normal);
    let any = crate::extremes::cases::any_vector(rng);
    (any - normal * any.dot(normal)).normalize_or_zero()
}

fn change(a: &Wrench, b: &Wrench) -> f64 {
    length(a.force - b.force)
}

//! Anything goes: motions of any size at ticks of any length, and among them poses that are none.

use fastrand::Rng;
use glam::{Quat, Vec3};
use haptor_contact::{CouplingSpec, GuardSpec, Invalid, ParamsSpec, VirtualCoupling};

use super::Outcome;
use super::place::place;
use crate::extremes::cases::{Case, any_vector, decades};
use crate::extremes::rig::{Digest, Scene};

/// Ticks of a session in the dearest tiers.
const TICKS: u32 = 96;

/// Ticks on a coupling: it needs some to come to rest.
const COUPLED: u32 = 160;

/// Wanders twice over. Figure: excess over a friction budget; the two sessions must have the same bits.
pub fn wander(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let mut rng = case.choices();
    let corner = case.corner();
    // half of the cases with the limits of a device
    let guard = if rng.bool() { GuardSpec::default() } else { GuardSpec::OPEN };
    let scene = Scene { params: ParamsSpec { guard, ..corner.params }, ..corner };
    let first = session(case, &scene, at, TICKS, &mut rng.clone(), outcome)?;
    let second = session(case, &scene, at, TICKS, &mut rng, outcome)?;
    if first != second && outcome.seen.fault.is_none() {
        outcome.seen.fault = Some("two runs have different bits".to_owned());
    }
    outcome.figure(outcome.seen.excess.max(0.0));
    Ok(())
}

/// The same on a virtual coupling of any stiffness, with a probe of any mass, none included.
pub fn coupled(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let mut rng = case.choices();
    let corner = case.corner();
    let limit = |rng: &mut Rng| if rng.bool() { f32::INFINITY } else { decades(rng, -3.0, 3.0) };
    let coupling = VirtualCoupling {
        translational_stiffness: decades(&mut rng, 0.0, 6.0).clamp(1.0, 1.0e6),
        rotational_stiffness: decades(&mut rng, -4.0, 4.0).clamp(1.0e-4, 1.0e4),
        translational_damping: rng.bool().then(|| decades(&mut rng, -3.0, 5.0).min(1.0e5)),
        rotational_damping: rng.bool().then(|| decades(&mut rng, -6.0, 3.0).min(1.0e3)),
        max_force: limit(&mut rng),
        max_torque: limit(&mut rng),
    };
    let mass = if rng.u8(..4) == 0 { 0.0 } else { decades(&mut rng, -9.0, 4.0).min(1.0e4) };
    let params = ParamsSpec { coupling: CouplingSpec::Virtual(coupling), gravity: rng.bool(), ..corner.params };
    let scene = Scene { params, mass, ..corner };
    session(case, &scene, at, COUPLED, &mut rng, outcome)?;
    outcome.figure(outcome.seen.excess.max(0.0));
    Ok(())
}

/// One session of random steps; every twelfth pose is none, or the numbers of it are denormal.
fn session(case: &Case, scene: &Scene, at: Vec3, ticks: u32, rng: &mut Rng, outcome: &mut Outcome) -> Result<Digest, Invalid> {
    let mut rig = scene.rig()?;
    let stride = decades(rng, -6.0, 0.0);
    let (mut position, mut rotation) = (at, case.rotation);
    for _ in 0..ticks * case.longer() {
        position += any_vector(rng) * (case.size * stride);
        rotation = (Quat::from_scaled_axis(any_vector(rng) * stride) * rotation).normalize();
        let dt = decades(rng, -6.0, 0.0);
        if rng.u8(..12) == 0 {
            let (bad_at, bad_turn, bad_dt) = spoilt(rng, position * case.length(), rotation, dt);
            rig.tick(bad_at, bad_turn, bad_dt);
        }
        rig.tick(position * case.length(), rotation, dt);
    }
    outcome.add(&rig.seen);
    Ok(rig.seen.digest)
}

/// A pose with something wrong in it, or with numbers below the normal range.
fn spoilt(rng: &mut Rng, position: Vec3, rotation: Quat, dt: f32) -> (Vec3, Quat, f32) {
    const ODD: [f32; 8] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 2.0e3, 1.0e-40, -1.0e-45, -0.0];
    let odd = ODD[rng.usize(..ODD.len())];
    match rng.u8(..6) {
        0 => (Vec3::new(odd, position.y, position.z), rotation, dt),
        1 => (Vec3::new(position.x, odd, position.z), rotation, dt),
        2 => (position, Quat::from_xyzw(odd, rotation.y, rotation.z, rotation.w), dt),
        3 => (position, Quat::from_xyzw(odd, odd, odd, odd), dt),
        4 => (position, rotation, odd),
        _ => (position, -rotation, dt),
    }
}

//! Time, repetition and rest.

use haptor_contact::Invalid;

use super::Outcome;
use super::place::{AGES, Loop, Walk, as_it_is, moved, place, settle, tick_at};
use crate::extremes::cases::{Case, decades};
use crate::extremes::rig::Rig;

/// Ticks of a session.
const TICKS: u32 = 48;

/// The contact knows no time: the same poses at ticks of a microsecond to a second, where no speed limit refuses them, give the same wrenches to the bit. Figure: ticks that differ.
pub fn times(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let (corner, mut rng) = (case.corner(), case.choices());
    let (mut steady, mut uneven) = (corner.rig()?, corner.rig()?);
    // the slowest and the shortest tick of the box: 40 m/s at a microsecond
    let amplitude = (case.depth * decades(&mut rng, -3.0, 0.0)).min(1.0e-5 / case.length());
    let path = Loop::new(&mut rng, TICKS);
    let (mut differ, mut touched) = (0, false);
    for tick in 0..TICKS {
        let (shift, spin) = path.at(tick);
        let pose = moved(case, at, shift * amplitude, spin * (amplitude / case.size).min(1.0e-3));
        let (a, b) = (tick_at(&mut steady, case, pose, AGES), tick_at(&mut uneven, case, pose, decades(&mut rng, -6.0, 0.0)));
        if b.report.flags.contains(haptor_contact::Flags::POSE_REFUSED) {
            // the two sessions have parted
            break;
        }
        touched |= a.report.depth > 0.0;
        differ += u32::from(a.contact != b.contact);
    }
    if touched {
        outcome.figure(f64::from(differ));
    }
    outcome.add(&steady.seen);
    outcome.add(&uneven.seen);
    Ok(())
}

/// A stream that stutters, each pose up to four times over, ends at nearly the wrench of the even one. Figure: largest difference over the largest wrench.
pub fn repeated(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let (corner, mut rng) = (case.corner(), case.choices());
    let mut rigs = [corner.rig()?, corner.rig()?];
    let walk = Walk::new(case, at, &mut rng, TICKS, (-3.0, -1.0));
    for rig in &mut rigs {
        settle(rig, at * case.length(), case.rotation);
    }
    let tick = |[even, stutter]: &mut [Rig<'_>; 2], pose| {
        let (a, mut b) = (tick_at(even, case, pose, AGES), tick_at(stutter, case, pose, AGES));
        for _ in 0..rng.u8(..4) {
            b = tick_at(stutter, case, pose, AGES);
        }
        [a, b]
    };
    walk.compare(outcome, rigs, tick, as_it_is);
    Ok(())
}

/// Ticks after which a pose that does not change is at rest: a birth in each, the load handed over in sixty-four, and what a few sweeps left.
const SETTLED: u32 = 96;

/// Ticks of rest.
const REST: u32 = 160;

/// Holding still: once settled, every tick has the bits of the one before. Figure: ticks that differ.
pub fn hold(case: &Case, outcome: &mut Outcome) -> Result<(), Invalid> {
    let Some(at) = place(case, &case.twin, outcome)? else { return Ok(()) };
    let corner = case.corner();
    let mut rig = corner.rig()?;
    let mut last = settle(&mut rig, at * case.length(), case.rotation);
    let mut differ = 0;
    for tick in 0..REST {
        let next = tick_at(&mut rig, case, (at, case.rotation), AGES);
        differ += u32::from(tick > SETTLED && next.contact != last.contact);
        last = next;
    }
    if last.report.depth > 0.0 {
        outcome.figure(f64::from(differ));
    }
    outcome.add(&rig.seen);
    Ok(())
}

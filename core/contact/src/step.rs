//! One tick: seven stages in order.
//!
//! **Words.** *gap*: signed distance, negative = penetration. *Contact*: a part of the probe that overlaps the object in this tick.
//! *Patch*: a contact that is followed from tick to tick. *Region*: patches closer than `region_distance`. *Anchor*: where a patch
//! sticks. *Grip*: what friction holds. *Wrench*: force and torque on the probe about its mass centre, in world.

use glam::Vec3;
use heapless::VecView;

use crate::budget::{self, Rung};
use crate::coupling;
use crate::frames::{Pose, ProbeFrame, World};
use crate::guard::guard;
use crate::limits::{COARSE_STEPS, MAX_DISTANCE, MAX_SPEED, MAX_TICK, MAX_TURN_RATE, MIN_TICK, QUATERNION_TOLERANCE};
use crate::math::{atan2, max, min, root};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;
use crate::report::{Flags, PatchReport, Report};
use crate::scratch::{Contact, Scratch};
use crate::stage::detect::{self, Seen};
use crate::stage::{force, regions, torque, wrench};
use crate::state::{Memory, State};
use crate::tier::influence::Stored;
use crate::wrench::Wrench;

/// What a tick is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Pose `x_wh` of the handle in world, its origin where the probe's mass centre is when the coupling is slack: the probe's own pose when it is direct.
    pub pose: Pose<World, ProbeFrame>,
    /// Time since the previous tick \[s\], [`MIN_TICK`] to [`MAX_TICK`]; used by the guard's rates, the jump test and the virtual coupling only.
    pub dt: f32,
}

/// What a tick returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Wrench for the device: after the guard.
    pub wrench: Wrench<World>,
    /// Wrench of the contact, before the guard.
    pub contact: Wrench<World>,
    /// What was clamped, refused or lowered.
    pub report: Report,
}

/// Runs one tick. Cannot fail, cannot panic, reads no clock; every loop is bounded by a capacity (`bounds.md`), and where the
/// parameters set a work budget its estimated work fits that wherever the lowest rung and a look at one part do ([`budget`](crate::budget)).
pub fn step<const PATCHES: usize, const SAMPLES: usize, const TRACES: usize, const CONTACTS: usize>(
    model: &Model<'_>,
    params: &Params,
    state: &mut State<PATCHES, SAMPLES, TRACES>,
    scratch: &mut Scratch<CONTACTS>,
    input: Input,
) -> Output {
    scratch.poison();
    let State { memory, patches, seen, samples, traces } = state;
    let (handle, mut flags) = accept(memory, &input);
    let Some(handle) = handle else { return refused(params, memory, patches, input.dt, flags) };
    let elapsed = core::mem::take(&mut memory.since_last_pose);
    if is_still(params, memory, &handle) {
        budget::book_still(params, memory, patches.len());
        return finish(params, memory, patches, Some(&handle), input.dt, memory.flags);
    }
    let now = coupling::probe_pose(model, params, memory, &handle, elapsed, &mut flags);
    let births = memory.next_serial;
    // 1 detect
    let mut turns = params.work.map(|work| budget::turns_within(work, model, params, &mut memory.account, &now));
    let left_out =
        detect::detect(model, &now, turns.as_mut(), Seen { contacts: seen, pose: memory.last_pose }, &mut scratch.contacts);
    flags |= count_left_out(memory, left_out);
    // 2 regions
    flags |= regions::track(params, memory, &scratch.contacts, patches, &now);
    keep_seen(model, &scratch.contacts, patches, seen);
    // 3 force, which asks 5 deform for the dents of the neighbours where there are any
    let passes = budget::passes(model, params, turns.as_ref(), patches);
    let (pressed, strained) = force::press(model, params, &scratch.contacts, patches, passes);
    flags |= strained | coarseness(patches, &now);
    let (rung, lowered) = budget::rung(model, params, &mut memory.account, turns.as_ref(), (patches, pressed));
    // 4 torque
    let changed = take_up(params, rung, memory, patches);
    let stored = Stored { force: samples.as_flattened_mut(), trace: traces.as_flattened_mut() };
    let work = torque::Workspace {
        stored,
        per_slot: SAMPLES,
        traced: TRACES > 0,
        grounds: &mut scratch.grounds,
        discs: &mut scratch.discs,
    };
    flags |= lowered | torque::hold(model, params, rung, patches, work, &now, changed);
    // 6 wrench
    memory.contact = wrench::total(model, params, patches, &now);
    flags |= drop_what_is_not_finite(memory, patches, seen);
    coupling::linearise(model, params, memory, patches);
    ramp_if_started_inside(params, memory, patches);
    remember(params, memory, patches, now, births, flags);
    // 7 guard
    finish(params, memory, patches, Some(&handle), input.dt, flags)
}

/// Contacts that the next tick may carry on, without a budget too, which may be set from one tick to the next; a lone part is looked at in every tick. Where they find no room,
/// those that are followed go first: a patch whose contact is forgotten ends.
fn keep_seen(model: &Model<'_>, contacts: &[Contact], patches: &[Patch], seen: &mut VecView<Contact>) {
    seen.clear();
    if model.probe.len() < 2 || seen.extend_from_slice(contacts).is_ok() {
        return;
    }
    let is_followed = |contact: &&Contact| patches.iter().any(|patch| patch.part == contact.part);
    let followed = contacts.iter().filter(is_followed);
    let others = contacts.iter().filter(|contact| !is_followed(contact));
    // bound: contacts
    for &contact in followed.chain(others).take(seen.capacity()) {
        let _ = seen.push(contact);
    }
}

/// Whether some contact is too shallow for the digits of its place.
fn coarseness(patches: &[Patch], now: &Pose<World, ProbeFrame>) -> Flags {
    let largest = |v: Vec3| max(v.x.abs(), max(v.y.abs(), v.z.abs()));
    let place = largest(now.position);
    let is_coarse = |patch: &Patch| patch.depth < COARSE_STEPS * f32::EPSILON * max(place, largest(patch.centre));
    if patches.iter().any(is_coarse) { Flags::POSE_COARSE } else { Flags::CLEAN }
}

/// A contact that is not finite is dropped whole: nothing of it may live on.
fn drop_what_is_not_finite(memory: &mut Memory, patches: &mut VecView<Patch>, seen: &mut VecView<Contact>) -> Flags {
    if memory.contact.is_finite() {
        return Flags::CLEAN;
    }
    patches.clear();
    seen.clear();
    memory.contact = Wrench::ZERO;
    Flags::NON_FINITE
}

/// Notices new parameters and another rung. A new tier takes over what the patches hold; how it came about means nothing to it.
fn take_up(params: &Params, rung: Rung, memory: &mut Memory, patches: &mut [Patch]) -> bool {
    if memory.rung.map(|last| last.tier) != Some(rung.tier) {
        patches.iter_mut().for_each(Patch::forget_history);
    }
    let changed = memory.fingerprint != Some(params.fingerprint) || memory.rung != Some(rung);
    (memory.rung, memory.fingerprint) = (Some(rung), Some(params.fingerprint));
    changed
}

/// The first pose of a session may lie inside the object: its wrench is then let in slowly.
fn ramp_if_started_inside(params: &Params, memory: &mut Memory, patches: &[Patch]) {
    if memory.last_pose.is_none() && !patches.is_empty() && params.guard.ramp_in > 0.0 {
        memory.guard.ramp = 0.0;
    }
}

/// Keeps the pose, and whether the next tick may rest on this one.
fn remember(params: &Params, memory: &mut Memory, patches: &[Patch], now: Pose<World, ProbeFrame>, births: u32, flags: Flags) {
    let quiet = memory.last_pose == Some(now)
        && memory.coupled.as_ref().is_none_or(|coupled| coupled.at_rest)
        && memory.next_serial == births
        && memory.account.is_settled()
        && !regions::is_handing_over(patches)
        && !flags.contains(Flags::BIRTH_WAITS)
        && !flags.contains(Flags::NON_FINITE);
    memory.settled_for = if quiet { Some(params.fingerprint) } else { None };
    (memory.last_pose, memory.flags) = (Some(now), flags);
}

/// A quasi-static contact whose pose did not change for two ticks, with a coupling at rest, stays as it is, to the bit, as long as handle and parameters do.
fn is_still(params: &Params, memory: &Memory, handle: &Pose<World, ProbeFrame>) -> bool {
    memory.settled_for == Some(params.fingerprint) && memory.last_handle() == Some(*handle)
}

/// Checks the pose and normalises it; `None` keeps the last good state. Counts the time since the last good one.
fn accept(memory: &mut Memory, input: &Input) -> (Option<Pose<World, ProbeFrame>>, Flags) {
    let Input { pose, dt } = *input;
    if !(dt > 0.0 && dt.is_finite()) {
        return (None, Flags::POSE_REFUSED);
    }
    memory.since_last_pose = min(memory.since_last_pose + dt, MAX_TICK);
    if !(MIN_TICK..=MAX_TICK).contains(&dt) {
        return (None, Flags::POSE_REFUSED);
    }
    let norm = root(pose.rotation.length_squared());
    let sound = pose.position.is_finite() && pose.position.length() <= MAX_DISTANCE && (norm - 1.0).abs() <= QUATERNION_TOLERANCE;
    if !sound {
        return (None, Flags::POSE_REFUSED);
    }
    if memory.last_handle().is_some_and(|last| is_jump(&last, &pose, memory.since_last_pose)) {
        return (None, Flags::POSE_REFUSED | Flags::POSE_JUMP);
    }
    (Some(Pose::new(pose.position, pose.rotation * (1.0 / norm))), Flags::CLEAN)
}

fn is_jump(last: &Pose<World, ProbeFrame>, next: &Pose<World, ProbeFrame>, time: f32) -> bool {
    let q = next.rotation * last.rotation.conjugate();
    let sine = root(q.x * q.x + q.y * q.y + q.z * q.z);
    (next.position - last.position).length() > MAX_SPEED * time || 2.0 * atan2(sine, q.w.abs()) > MAX_TURN_RATE * time
}

fn count_left_out(memory: &mut Memory, left_out: u32) -> Flags {
    memory.refused = memory.refused.saturating_add(left_out);
    if left_out > 0 { Flags::REGION_REFUSED } else { Flags::CLEAN }
}

/// A refused pose keeps the contact as it was; what the device gets fades to zero at the guard's rates.
fn refused(params: &Params, memory: &mut Memory, patches: &[Patch], dt: f32, flags: Flags) -> Output {
    memory.poses_refused = memory.poses_refused.saturating_add(1);
    budget::book_still(params, memory, patches.len());
    let dt = if dt > 0.0 && dt.is_finite() { dt } else { 0.0 };
    finish(params, memory, patches, None, dt, flags)
}

/// Stage 7, and the report. Without a `handle` nothing is wanted.
fn finish(
    params: &Params,
    memory: &mut Memory,
    patches: &[Patch],
    handle: Option<&Pose<World, ProbeFrame>>,
    dt: f32,
    flags: Flags,
) -> Output {
    let wanted = if handle.is_some() { memory.wanted() } else { Wrench::ZERO };
    let (wrench, guarded) = guard(&params.guard, &mut memory.guard, &wanted, handle, dt);
    let report = report(params, memory, patches, flags | guarded);
    Output { wrench, contact: memory.contact, report }
}

fn report(params: &Params, memory: &Memory, patches: &[Patch], flags: Flags) -> Report {
    let deepest = patches.iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
    let rung = memory.rung.unwrap_or(params.rung);
    Report {
        tier: rung.tier,
        samples: rung.samples,
        sweeps: rung.sweeps,
        work: memory.account.work,
        regions: regions::count(patches),
        depth: deepest.map_or(0.0, |patch| patch.depth),
        radius: deepest.map_or(0.0, |patch| patch.footprint.radius),
        stick: deepest.map_or(1.0, |patch| patch.grip.stick),
        flags,
        refused: memory.refused,
        poses_refused: memory.poses_refused,
        high_water: memory.high_water,
    }
}

/// What a viewer shows of one patch.
pub fn patch_report(patch: &Patch) -> PatchReport {
    PatchReport {
        region: patch.region,
        centre: patch.centre,
        normal: patch.normal,
        depth: patch.depth,
        radius: patch.footprint.radius,
        stick: patch.grip.stick,
        force: wrench::patch_force(patch),
        torque: wrench::patch_torque(patch),
    }
}

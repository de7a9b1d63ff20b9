//! Stage 2: contacts -> patches that live on, are born or die, grouped into regions in birth order.
//!
//! A patch is followed from tick to tick by its part. At most one region is born per tick, the deepest first (the paper
//! assumes regions form one by one). Patches whose rims are closer than `region_distance` form one region; the group is a
//! label, each patch keeps its own friction, so that merging and splitting change no force.
//!
//! The rule of the eleventh region: the deepest are kept. A newcomer is refused and counted; while it is clearly deeper than the shallowest region,
//! that region hands its load over tick by tick, is dropped when it carries nothing, and the newcomer takes up its own load as slowly. A region that
//! splits at the limit keeps one label. So nothing jumps.

use glam::{Quat, Vec3};
use heapless::VecView;

use crate::frames::{Pose, ProbeFrame, World};
use crate::math::{atan2, clamp, max, min, root};
use crate::params::Params;
use crate::patch::{Motion, Patch, Shift};
use crate::report::Flags;
use crate::scratch::Contact;
use crate::state::Memory;

/// Updates the patches from this tick's contacts.
pub fn track(
    params: &Params,
    memory: &mut Memory,
    contacts: &[Contact],
    patches: &mut VecView<Patch>,
    now: &Pose<World, ProbeFrame>,
) -> Flags {
    let before = memory.last_pose.unwrap_or(*now);
    let turn = if patches.is_empty() { Vec3::ZERO } else { turn_between(before.rotation, now.rotation) };
    patches.retain(|patch| contacts.iter().any(|contact| contact.part == patch.part));
    for patch in patches.iter_mut() {
        if let Some(contact) = contacts.iter().find(|contact| contact.part == patch.part) {
            follow(patch, contact, &before, now, turn);
        }
    }
    let mut flags = bear(params, memory, contacts, patches);
    group(params.region_distance, patches);
    flags |= keep_to_limit(params.max_regions, patches);
    hand_over(params, memory, contacts, patches);
    let regions = count(patches);
    memory.high_water = if regions > memory.high_water { regions } else { memory.high_water };
    flags
}

/// Moves a patch to its new place and measures the motion that took it there, of which `turn` is the turn.
fn follow(patch: &mut Patch, contact: &Contact, before: &Pose<World, ProbeFrame>, now: &Pose<World, ProbeFrame>, turn: Vec3) {
    let old_centre = patch.centre;
    patch.carry_to(contact.centre, contact.normal);
    patch.previous = patch.footprint;
    patch.depth = contact.depth;
    patch.object_radius = contact.seat.object_radius();
    let moved = now.position - before.position;
    let arm = 0.5 * ((old_centre - before.position) + (contact.centre - now.position));
    let drag = patch.to_patch(moved + turn.cross(arm));
    let step = Shift { drag, twist: turn.dot(contact.normal) };
    let over_object = patch.to_patch(contact.centre - old_centre);
    patch.motion = Motion { turn, step, rolled: rolled(over_object, over_object - drag) };
    patch.total = patch.total + step;
}

/// Distance over which the patch left material of both bodies: the common part of its two paths.
fn rolled(over_object: glam::Vec2, over_probe: glam::Vec2) -> f32 {
    if over_object.dot(over_probe) <= 0.0 {
        return 0.0;
    }
    min(root(over_object.length_squared()), root(over_probe.length_squared()))
}

/// Rotation vector of a unit quaternion \[rad\], shorter way.
pub fn rotation_vector(q: Quat) -> Vec3 {
    of_half_turn(Vec3::new(q.x, q.y, q.z) * if q.w < 0.0 { -1.0 } else { 1.0 }, q.w.abs())
}

/// Rotation vector from one rotation to another \[rad\], shorter way; exactly zero where they are the same. It is read from the difference of the two, which has no rounding while they are near: the product
/// of the one and the other's inverse rounds at 1e-7 rad however little they differ, even where they are the same, and from tick to tick that adds up to a drag that nobody made.
pub fn turn_between(before: Quat, now: Quat) -> Vec3 {
    let cosine = now.dot(before);
    // q and -q are one rotation
    let now = if cosine < 0.0 { -now } else { now };
    let change = (now - before) * before.conjugate();
    of_half_turn(Vec3::new(change.x, change.y, change.z), cosine.abs())
}

/// Rotation vector \[rad\] from the sine of half of it along its axis and the cosine.
fn of_half_turn(v: Vec3, cosine: f32) -> Vec3 {
    let sine = root(v.length_squared());
    if sine < SMALL_SINE { v * 2.0 } else { v * (2.0 * atan2(sine, cosine) / sine) }
}

/// Below this half-angle sine, sin x = x to f32.
const SMALL_SINE: f32 = 1.0e-4;

/// At most one birth per tick, deepest first.
fn bear(params: &Params, memory: &mut Memory, contacts: &[Contact], patches: &mut VecView<Patch>) -> Flags {
    let unborn = |contact: &&Contact| patches.iter().all(|patch| patch.part != contact.part);
    let waiting = contacts.iter().filter(unborn).count();
    let Some(deepest) = contacts.iter().filter(unborn).max_by(|a, b| a.depth.total_cmp(&b.depth)) else {
        memory.handed_over = false;
        return Flags::CLEAN;
    };
    let flags = if waiting > 1 { Flags::BIRTH_WAITS } else { Flags::CLEAN };
    if patches.is_full() || !has_room(params, deepest, patches) {
        memory.refused = memory.refused.saturating_add(1);
        return flags | Flags::REGION_REFUSED;
    }
    let mut patch = Patch::born(deepest.part, free_slot(patches), memory.next_serial, deepest.centre, deepest.normal);
    patch.depth = deepest.depth;
    // a place that another region handed over is taken up as slowly
    patch.share = if memory.handed_over { 0.0 } else { 1.0 };
    memory.handed_over = false;
    patch.object_radius = deepest.seat.object_radius();
    memory.next_serial = memory.next_serial.wrapping_add(1);
    let _ = patches.push(patch);
    flags
}

/// Room for a newcomer: below the region limit, or close to an existing region.
fn has_room(params: &Params, newcomer: &Contact, patches: &[Patch]) -> bool {
    usize::from(count(patches)) < params.max_regions
        || patches.iter().any(|patch| rim_distance(patch, newcomer.centre, 0.0) < params.region_distance)
}

fn free_slot(patches: &[Patch]) -> u8 {
    let taken = |slot: u8| patches.iter().any(|patch| patch.slot == slot);
    (0..=u8::MAX).find(|&slot| !taken(slot)).unwrap_or(0)
}

fn rim_distance(patch: &Patch, centre: Vec3, radius: f32) -> f32 {
    root((patch.centre - centre).length_squared()) - patch.footprint.radius - radius
}

/// Labels patches by region. A patch joins the oldest patch it can reach through neighbours closer than `distance`.
fn group(distance: f32, patches: &mut [Patch]) {
    for (index, patch) in patches.iter_mut().enumerate() {
        patch.region = index as u8;
    }
    for i in 0..patches.len() {
        for j in 0..i {
            let (a, b) = (&patches[i], &patches[j]);
            if is_apart(distance, a, b) {
                continue;
            }
            let (a, b) = (a.region, b.region);
            join(patches, a, b);
        }
    }
    number_from_zero(patches);
}

/// True for patches of one group, and for patches farther from each other than `distance`.
fn is_apart(distance: f32, a: &Patch, b: &Patch) -> bool {
    a.region == b.region || rim_distance(a, b.centre, b.footprint.radius) >= distance
}

/// Gives the groups labelled `a` and `b` the older one's label. Groups can be joined one time fewer than there are patches, most of which stay apart.
#[cold]
fn join(patches: &mut [Patch], a: u8, b: u8) {
    let (kept, joined) = if a < b { (a, b) } else { (b, a) };
    for patch in patches.iter_mut().filter(|patch| patch.region == joined) {
        patch.region = kept;
    }
}

/// Makes the labels 0, 1, 2, ... in birth order.
fn number_from_zero(patches: &mut [Patch]) {
    let mut next = 0;
    for i in 0..patches.len() {
        let label = patches[i].region;
        if usize::from(label) == i {
            patches[i].region = next;
            next += 1;
        } else {
            patches[i].region = patches.get(usize::from(label)).map_or(0, |patch| patch.region);
        }
    }
}

/// Number of regions.
pub fn count(patches: &[Patch]) -> u8 {
    patches.iter().map(|patch| patch.region + 1).max().unwrap_or(0)
}

/// Gives the two closest regions one label while there are too many: what splits at the limit stays one.
fn keep_to_limit(max_regions: usize, patches: &mut VecView<Patch>) -> Flags {
    let mut flags = Flags::CLEAN;
    // every round joins two regions, and there are no more regions than patches
    for _ in 0..patches.len() {
        if usize::from(count(patches)) <= max_regions {
            break;
        }
        let Some((kept, joined)) = closest_regions(patches) else { break };
        for patch in patches.iter_mut() {
            let label = if patch.region == joined { kept } else { patch.region };
            patch.region = label - u8::from(label > joined);
        }
        flags = Flags::REGION_REFUSED;
    }
    flags
}

/// Labels of the two regions whose rims are closest, the older first.
fn closest_regions(patches: &[Patch]) -> Option<(u8, u8)> {
    let mut closest: Option<(f32, u8, u8)> = None;
    for (i, a) in patches.iter().enumerate() {
        for b in patches.iter().skip(i + 1).filter(|b| b.region != a.region) {
            let distance = rim_distance(a, b.centre, b.footprint.radius);
            if closest.is_none_or(|(least, ..)| distance < least) {
                let older_first = if a.region < b.region { (a.region, b.region) } else { (b.region, a.region) };
                closest = Some((distance, older_first.0, older_first.1));
            }
        }
    }
    closest.map(|(_, kept, joined)| (kept, joined))
}

/// The region whose deepest patch is the least deep.
fn shallowest(regions: u8, patches: &[Patch]) -> u8 {
    (0..regions).min_by(|&a, &b| depth_of(a, patches).total_cmp(&depth_of(b, patches))).unwrap_or(0)
}

/// Depth of a region's deepest patch \[m\].
fn depth_of(region: u8, patches: &[Patch]) -> f32 {
    patches.iter().filter(|patch| patch.region == region).fold(0.0, |deepest, patch| max(deepest, patch.depth))
}

/// Excess of a refused contact's depth over the shallowest region's, as a share, at which that region begins to give way: rows of equal tips do not take turns.
const CLEARLY_DEEPER: f32 = 0.1;

/// Share of its load that a region gives up or takes up in a tick when one gives way to another.
const HANDOVER: f32 = 1.0 / 64.0;

/// Hands load over where a refused contact is clearly deeper than the shallowest region; drops that region when it carries nothing.
fn hand_over(params: &Params, memory: &mut Memory, contacts: &[Contact], patches: &mut VecView<Patch>) {
    let regions = count(patches);
    let waiting = usize::from(regions) >= params.max_regions;
    let unborn = |contact: &&Contact| patches.iter().all(|patch| patch.part != contact.part);
    let outside =
        if waiting { contacts.iter().filter(unborn).fold(0.0, |deepest, contact| max(deepest, contact.depth)) } else { 0.0 };
    let last = shallowest(regions, patches);
    let gives_way = outside > (1.0 + CLEARLY_DEEPER) * depth_of(last, patches);
    for patch in patches.iter_mut() {
        let change = if gives_way && patch.region == last { -HANDOVER } else { HANDOVER };
        patch.share = clamp(patch.share + change, 0.0, 1.0);
    }
    if gives_way && patches.iter().all(|patch| patch.region != last || patch.share <= 0.0) {
        drop_region(last, patches);
        memory.handed_over = true;
        memory.refused = memory.refused.saturating_add(1);
    }
}

/// True while some patch carries less than its whole load: the next tick goes on with it.
pub fn is_handing_over(patches: &[Patch]) -> bool {
    patches.iter().any(|patch| patch.share < 1.0)
}

fn drop_region(region: u8, patches: &mut VecView<Patch>) {
    patches.retain(|patch| patch.region != region);
    for patch in patches.iter_mut() {
        patch.region -= u8::from(patch.region > region);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotation vector between two rotations in f64, whatever their lengths.
    fn exact(before: Quat, now: Quat) -> [f64; 3] {
        let [a, b] = [before, now].map(|q| q.to_array().map(f64::from));
        let w = b[3] * a[3] + b[0] * a[0] + b[1] * a[1] + b[2] * a[2];
        let part = |i: usize, j: usize, k: usize| a[3] * b[i] - b[3] * a[i] - (b[j] * a[k] - b[k] * a[j]);
        let v = [part(0, 1, 2), part(1, 2, 0), part(2, 0, 1)].map(|x| if w < 0.0 { -x } else { x });
        let sine = libm::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        v.map(|x| x * 2.0 * libm::atan2(sine, libm::fabs(w)) / sine)
    }

    /// Steps from a third of a radian down to ten digits of a quaternion.
    #[test]
    fn small_turns_keep_their_digits_and_no_turn_is_none() {
        let mut at = Quat::from_xyzw(0.3, -0.5, 0.1, 0.8).normalize();
        for i in 0..2000 {
            let f = i as f32;
            let size = libm::powf(10.0, -0.5 - 5.5 * (f / 2000.0));
            let step = Vec3::new(libm::sinf(f), libm::sinf(2.3 * f), libm::cosf(0.7 * f)) * size;
            let next = (Quat::from_scaled_axis(step) * at).normalize();
            let next = if i % 3 == 0 { -next } else { next };
            let (found, exact) = (turn_between(at, next), exact(at, next));
            let off = (found - Vec3::from_array(exact.map(|x| x as f32))).length();
            assert!(off <= 2.0e-6 * found.length(), "{step}: {found}, {exact:?}");
            assert_eq!(turn_between(next, next), Vec3::ZERO);
            assert_eq!(turn_between(next, -next), Vec3::ZERO);
            at = next;
        }
    }
}

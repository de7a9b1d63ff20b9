//! Stage 1: model x pose -> contacts.
//!
//! One convex part makes at most one contact (theory.md, section 2). The list is in part order, by turns in the order of their looks; when it is full the deepest
//! are kept and the rest is counted by the next stage. With a work budget the parts may take turns: a contact whose part is not looked at is carried.

use core::cell::Cell;

use heapless::VecView;

use crate::budget::Turns;
use crate::footprint::Seat;
use crate::frames::{Pose, ProbeFrame, World};
use crate::geometry::deepest::{PartFrame, deepest_asking, is_clear, part_pose};
use crate::limits::MAX_PARTS;
use crate::model::{Model, ProbePart};
use crate::scratch::Contact;
use crate::stage::carry::carried;

/// A set of the probe's parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts(u16);

const _: () = assert!(MAX_PARTS <= u16::BITS as usize, "a bit for each part");

impl Parts {
    /// No part.
    pub const NONE: Self = Self(0);

    /// Adds the part of this index.
    pub const fn add(&mut self, index: usize) {
        self.0 |= 1_u16.wrapping_shl(index as u32);
    }

    /// True where the part of this index is one of them.
    pub const fn has(self, index: usize) -> bool {
        self.0.wrapping_shr(index as u32) & 1 != 0
    }

    /// Those that are not among the others.
    pub const fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// How many they are.
    pub const fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// The parts, in their order in the probe, with their indices.
    pub fn of<'p, 'a>(self, probe: &'p [ProbePart<'a>]) -> impl Iterator<Item = (usize, &'p ProbePart<'a>)> {
        probe.iter().enumerate().filter(move |&(index, _)| self.has(index))
    }
}

/// Finds every part that overlaps the object at probe pose `x_wp`; returns how many contacts found no room. By `turns`, where there are any, parts that the tick
/// has no room to look at keep the contact they had, as `seen` by the tick before.
pub fn detect(
    model: &Model<'_>,
    x_wp: &Pose<World, ProbeFrame>,
    turns: Option<&mut Turns>,
    seen: Seen<'_>,
    contacts: &mut VecView<Contact>,
) -> u32 {
    match turns {
        None => look_at_all(model, x_wp, contacts),
        Some(turns) => look_by_turns(model, x_wp, turns, seen, contacts),
    }
}

fn look_at_all(model: &Model<'_>, x_wp: &Pose<World, ProbeFrame>, contacts: &mut VecView<Contact>) -> u32 {
    let mut left_out = 0;
    for (index, part) in model.probe.iter().enumerate() {
        let x_wa = part_pose(part, x_wp);
        if is_clear(&model.object, part, &x_wa) {
            continue;
        }
        if let Some(contact) = look_at(model, index, part, &x_wa).contact {
            left_out += keep_deepest(contacts, contact);
        }
    }
    left_out
}

#[cold]
#[inline(never)]
fn look_by_turns(
    model: &Model<'_>,
    x_wp: &Pose<World, ProbeFrame>,
    turns: &mut Turns,
    seen: Seen<'_>,
    contacts: &mut VecView<Contact>,
) -> u32 {
    let mut left_out = 0;
    for _ in 0..turns.near().count() {
        let Some((index, part)) = turns.next(model.probe) else { break };
        let contact = if turns.has_room_for(&model.object, index, part) {
            let look = look_at(model, index, &part.coarser(turns.asked()), &part_pose(part, x_wp));
            turns.book(&model.object, index, part, &look);
            look.contact
        } else {
            seen.carried(model, index, part, x_wp)
        };
        if let Some(contact) = contact {
            left_out += keep_deepest(contacts, contact);
        }
    }
    left_out
}

/// Parts whose bounding ball meets the object.
pub fn near(model: &Model<'_>, x_wp: &Pose<World, ProbeFrame>) -> Parts {
    let mut near = Parts::NONE;
    for (index, part) in model.probe.iter().enumerate() {
        if !is_clear(&model.object, part, &part_pose(part, x_wp)) {
            near.add(index);
        }
    }
    near
}

/// What the tick before saw.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Its contacts.
    pub contacts: &'a [Contact],
    /// The probe's pose then, `None` before the first tick.
    pub pose: Option<Pose<World, ProbeFrame>>,
}

impl Seen<'_> {
    fn carried(&self, model: &Model<'_>, index: usize, part: &ProbePart<'_>, now: &Pose<World, ProbeFrame>) -> Option<Contact> {
        let last = self.contacts.iter().find(|contact| usize::from(contact.part) == index)?;
        carried(&model.object, part, last, self.pose.as_ref()?, now)
    }
}

/// What looking at a part found, and what that took.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// The contact, if there is one.
    pub contact: Option<Contact>,
    /// How often the search asked the part for a point.
    pub asked: u32,
}

fn look_at(model: &Model<'_>, index: usize, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>) -> Look {
    let asked = Cell::new(0);
    let at = deepest_asking(&model.object, part, x_wa, &asked);
    let (depth, asked) = (-at.gap.distance, asked.get());
    // also false for a depth that is not a number
    if !(depth > 0.0 && at.gap.normal.is_finite()) {
        return Look { contact: None, asked };
    }
    let seat = Seat::new(model, part, x_wa, &at);
    // a sliver cut by an edge may have no centroid: the deepest point stands for it
    let centroid = seat.centroid().filter(|p_a| p_a.is_finite());
    let centre = centroid.map_or(at.point, |p_a| x_wa.point(p_a));
    let contact = Contact { part: index as u8, centre, deepest: at.point, normal: at.gap.normal, depth, seat };
    Look { contact: Some(contact), asked }
}

/// The rule of a full buffer: the shallowest gives way.
fn keep_deepest(contacts: &mut VecView<Contact>, contact: Contact) -> u32 {
    let Err(contact) = contacts.push(contact) else { return 0 };
    if let Some(shallowest) = contacts.iter_mut().min_by(|a, b| a.depth.total_cmp(&b.depth))
        && shallowest.depth < contact.depth
    {
        *shallowest = contact;
    }
    1
}

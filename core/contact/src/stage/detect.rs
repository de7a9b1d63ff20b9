//! Stage 1: model x pose -> contacts.
//!
//! One convex part makes at most one contact (theory.md, section 2). The list is in part order; when it is full the deepest
//! are kept and the rest is counted by the next stage.

use heapless::VecView;

use crate::footprint::Seat;
use crate::frames::{Pose, ProbeFrame, World};
use crate::geometry::deepest::{PartFrame, deepest, is_clear, part_pose};
use crate::geometry::support::ASKED_SAMPLES;
use crate::limits::MAX_PARTS;
use crate::model::{Model, ProbePart};
use crate::scratch::Contact;

/// What was found beside the contacts.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Contacts that found no room.
    pub left_out: u32,
    /// Parts that were looked at closely.
    pub near: Near,
}

/// Parts whose bounding ball meets the object: those that cost more than the test.
#[derive(Clone, Copy, Debug)]
pub struct Near(u16);

const _: () = assert!(MAX_PARTS <= u16::BITS as usize, "a bit for each part");

impl Near {
    /// The parts, in their order in the probe, with their indices.
    pub fn parts<'p, 'a>(self, probe: &'p [ProbePart<'a>]) -> impl Iterator<Item = (usize, &'p ProbePart<'a>)> {
        probe.iter().enumerate().filter(move |(index, _)| self.0.wrapping_shr(*index as u32) & 1 != 0)
    }
}

/// Finds every part that overlaps the object at probe pose `x_wp`; a mesh is asked for so many samples.
pub fn detect(model: &Model<'_>, x_wp: &Pose<World, ProbeFrame>, asked: usize, contacts: &mut VecView<Contact>) -> Found {
    let mut found = Found { left_out: 0, near: Near(0) };
    for (index, part) in model.probe.iter().enumerate() {
        let x_wa = part_pose(part, x_wp);
        if is_clear(&model.object, part, &x_wa) {
            continue;
        }
        found.near.0 |= 1_u16.wrapping_shl(index as u32);
        let coarser;
        let part = if asked < ASKED_SAMPLES {
            coarser = part.coarser(asked);
            &coarser
        } else {
            part
        };
        if let Some(contact) = contact_of(model, index as u8, part, &x_wa) {
            found.left_out += keep_deepest(contacts, contact);
        }
    }
    found
}

fn contact_of(model: &Model<'_>, index: u8, part: &ProbePart<'_>, x_wa: &Pose<World, PartFrame>) -> Option<Contact> {
    let at = deepest(&model.object, part, x_wa);
    let depth = -at.gap.distance;
    // also false for a depth that is not a number
    if !(depth > 0.0 && at.gap.normal.is_finite()) {
        return None;
    }
    let seat = Seat::new(model, part, x_wa, &at);
    // a sliver cut by an edge may have no centroid: the deepest point stands for it
    let centroid = seat.centroid().filter(|p_a| p_a.is_finite());
    let centre = centroid.map_or(at.point, |p_a| x_wa.point(p_a));
    Some(Contact { part: index, centre, normal: at.gap.normal, depth, seat })
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

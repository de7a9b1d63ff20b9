//! Stage 1: model x pose -> contacts.
//!
//! One convex part makes at most one contact (theory.md, section 2). The list is in part order; when it is full the deepest
//! are kept and the rest is counted by the next stage.

use heapless::VecView;

use crate::footprint::Seat;
use crate::frames::{Pose, ProbeFrame, World};
use crate::geometry::deepest::{deepest, is_clear, part_pose};
use crate::model::{Model, ProbePart};
use crate::scratch::Contact;

/// Finds every part that overlaps the object at probe pose `x_wp`. Returns how many found no room.
pub fn detect(model: &Model<'_>, x_wp: &Pose<World, ProbeFrame>, contacts: &mut VecView<Contact>) -> u32 {
    let mut left_out = 0;
    for (index, part) in model.probe.iter().enumerate() {
        if let Some(contact) = contact_of(model, index as u8, part, x_wp) {
            left_out += keep_deepest(contacts, contact);
        }
    }
    left_out
}

fn contact_of(model: &Model<'_>, index: u8, part: &ProbePart<'_>, x_wp: &Pose<World, ProbeFrame>) -> Option<Contact> {
    let x_wa = part_pose(part, x_wp);
    if is_clear(&model.object, part, &x_wa) {
        return None;
    }
    let at = deepest(&model.object, part, &x_wa);
    let depth = -at.gap.distance;
    // also false for a depth that is not a number
    if !(depth > 0.0 && at.gap.normal.is_finite()) {
        return None;
    }
    let seat = Seat::new(model, part, &x_wa, &at);
    let centre = seat.centroid(depth).map_or(at.point, |p_a| x_wa.point(p_a));
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

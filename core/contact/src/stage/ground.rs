//! How the ground under a patch moves when patches pull on the object: what the other grips move there, and what the patch's own grip moves beyond
//! the figure that the tiers take in series.
//!
//! Terms: the **ground** is the object's surface at a patch as far as the patch's own local contact does not move it. A tier counts on the probe's
//! motion less the ground's. Patches that pull together find the ground coming with them; patches that turn as a ring find the body turning
//! (theory.md, section 11). A single patch on the body's axis needs none of this, nor does a scene without friction.

use glam::Vec3;
use heapless::VecView;

use crate::body;
use crate::green::chart::Cell;
use crate::green::kernel::{Disc, Load, Move};
use crate::green::{Block, Green};
use crate::model::{Model, ObjectShape};
use crate::patch::{Patch, Shift};

/// What this tick needs to know about the ground of one patch.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// Rest place of the patch \[m\].
    place: Vec3,
    /// Closed form of what the patch moves elsewhere.
    disc: Disc,
    /// Where to read the body's table.
    cell: Cell,
    /// Drag compliance that other patches share \[m/N\].
    shared: f32,
    /// Turn of the body about its vertical axis per torque about it \[rad/(N m)\].
    torsion: f32,
    /// Part of the drag compliance, due to the patch's arm about the axis, that the tiers take in series \[m/N\].
    pub lever: f32,
}

/// Prepares the grounds of all patches, in their order; none where nothing but a patch's own series compliance moves any ground.
pub fn prepare(model: &Model<'_>, patches: &[Patch], grounds: &mut VecView<Ground>) {
    grounds.clear();
    let alone_on_axis = |patch: &Patch| arm(patch.at_rest()) == Vec3::ZERO || model.object == ObjectShape::HalfSpace;
    if patches.len() <= 1 && table(model).is_none() && patches.iter().all(alone_on_axis) {
        return;
    }
    for patch in patches {
        let _ = grounds.push(Ground::of(model, patch));
    }
}

impl Ground {
    fn of(model: &Model<'_>, patch: &Patch) -> Self {
        let place = patch.at_rest();
        // a patch that carries nothing moves nothing; its disc needs a radius all the same
        let radius = if patch.footprint.radius > 0.0 { patch.footprint.radius } else { f32::MAX };
        let by_table = table(model).is_some();
        let (shared, torsion) = if by_table { (0.0, 0.0) } else { body::common(model, place, patch.normal, patch.object_radius) };
        Self {
            place,
            disc: Disc::new(model, place, patch.normal, radius, patch.object_radius),
            cell: table(model).map_or(Cell::NONE, |green| green.chart().cell(place)),
            shared,
            torsion,
            // the mean of none along the arm and all across it
            lever: 0.5 * torsion * arm(place).length_squared(),
        }
    }
}

/// The table that tells what the body adds; a scene's own compliances go before it.
pub fn table<'m>(model: &'m Model<'_>) -> Option<&'m Green<'m>> {
    if model.compliance.is_none() { model.green.as_ref() } else { None }
}

/// Motion of the ground under patch `i`, in its frame, by all grips as they are now.
pub fn moved(model: &Model<'_>, grounds: &[Ground], patches: &[Patch], i: usize) -> Shift {
    let (Some(here), Some(ground)) = (patches.get(i), grounds.get(i)) else { return Shift::default() };
    let near = others(grounds, patches, i).fold(Move::default(), |sum, (other, patch)| {
        let rims = here.footprint.radius + patch.footprint.radius;
        sum + other.disc.at(&held(patch), ground.place, here.normal, rims)
    });
    let body = match table(model) {
        Some(green) => by_table(model, green, grounds, patches, i, here, ground),
        None => by_beam(grounds, patches, i, here, ground),
    };
    let Move { shift, turn } = near + body;
    Shift { drag: here.to_patch(shift), twist: turn }
}

/// How far the body's table lowers the place of patch `i` by all that the patches of the last tick did, beyond the dents of a half space and what
/// the patch's own load is counted for in series \[m\].
pub fn lowered(model: &Model<'_>, patches: &[Patch], i: usize) -> f32 {
    let (Some(green), Some(here)) = (table(model), patches.get(i)) else { return 0.0 };
    let at = green.chart().cell(here.at_rest());
    let others = patches.iter().enumerate().filter(|(j, other)| *j != i && other.footprint.load > 0.0);
    let crossed = others.fold(Vec3::ZERO, |sum, (_, other)| {
        sum + green.respond(&at, &green.chart().cell(other.at_rest()), &seen(model, other)).shift
    });
    let own = own(model, green, here).times(&held(here)).shift;
    -(crossed + own).dot(here.normal)
}

/// The other patches that carry load, with their grounds.
fn others<'a>(grounds: &'a [Ground], patches: &'a [Patch], i: usize) -> impl Iterator<Item = (&'a Ground, &'a Patch)> {
    let all = grounds.iter().zip(patches).enumerate();
    all.filter(move |(j, (_, patch))| *j != i && patch.footprint.load > 0.0).map(|(_, pair)| pair)
}

/// What friction holds, as a load on the object.
pub fn held(patch: &Patch) -> Load {
    Load { force: patch.to_world(patch.grip.force), torque: patch.grip.torque }
}

/// The same with what presses.
pub fn whole(patch: &Patch) -> Load {
    let held = held(patch);
    Load { force: held.force - patch.normal * patch.footprint.load, ..held }
}

/// A whole load as far as the table's columns see it: the stiffness of a wide patch already holds part of what its drag moves.
pub fn seen(model: &Model<'_>, patch: &Patch) -> Load {
    let held = held(patch);
    let share = body::wide(model, patch.normal, patch.footprint.radius);
    Load { force: held.force * share - patch.normal * patch.footprint.load, ..held }
}

fn own(model: &Model<'_>, green: &Green<'_>, patch: &Patch) -> Block {
    body::own(model, green, patch.at_rest(), patch.normal, patch.footprint.radius, 1.0 / patch.object_radius)
}

/// What the table adds: of the others between the places, and of the patch itself beyond the scalars that the tiers take in series.
fn by_table(
    model: &Model<'_>,
    green: &Green<'_>,
    grounds: &[Ground],
    patches: &[Patch],
    i: usize,
    here: &Patch,
    ground: &Ground,
) -> Move {
    let crossed = others(grounds, patches, i)
        .fold(Move::default(), |sum, (other, patch)| sum + green.respond(&ground.cell, &other.cell, &seen(model, patch)));
    let counted = held(here);
    let serial = Move { shift: counted.force * -here.body.drag, turn: counted.torque * -here.body.twist };
    crossed + own(model, green, here).times(&whole(here)) + serial
}

/// Without a table: shear and bending are common to all patches, and forces beside the body's axis turn it.
fn by_beam(grounds: &[Ground], patches: &[Patch], i: usize, here: &Patch, ground: &Ground) -> Move {
    let swept = others(grounds, patches, i).fold(Vec3::ZERO, |sum, (_, patch)| sum + held(patch).force) * ground.shared;
    let crossed = others(grounds, patches, i).fold(0.0, |sum, (other, patch)| sum + torque_about_axis(other.place, patch, true));
    // the patch's own torque turns itself by the compliance in series, but its arm by this
    let turned = ground.torsion * (crossed + torque_about_axis(ground.place, here, false));
    let own = ground.torsion * here.grip.torque * here.normal.z;
    let serial = held(here).force * ground.lever;
    Move { shift: swept + Vec3::Z.cross(arm(ground.place)) * (turned + own) - serial, turn: here.normal.z * turned }
}

/// Torque of a grip about the body's vertical axis \[N m\], with or without the grip's own torque.
fn torque_about_axis(place: Vec3, patch: &Patch, own: bool) -> f32 {
    let lever = arm(place).cross(held(patch).force).z;
    if own { lever + patch.grip.torque * patch.normal.z } else { lever }
}

/// Arm of a place about the body's vertical axis \[m\].
fn arm(place: Vec3) -> Vec3 {
    Vec3::new(place.x, place.y, 0.0)
}

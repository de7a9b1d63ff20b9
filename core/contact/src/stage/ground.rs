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
use crate::green::drawn::{Discs, Place};
use crate::green::kernel::{Disc, Load, Move};
use crate::green::{Block, Green};
use crate::model::{Model, ObjectShape};
use crate::patch::{Patch, Shift};

/// What this tick needs to know about the ground of one patch.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// Rest place of the patch \[m\].
    place: Vec3,
    /// Contact radius \[m\].
    radius: f32,
    /// How far up the normal points.
    up: f32,
    /// What friction holds there by now.
    held: Load,
    /// Closed form of what the patch moves elsewhere, where there is another patch.
    disc: Option<Disc>,
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
pub fn prepare(model: &Model<'_>, patches: &[Patch], grounds: &mut VecView<Ground>, discs: &mut Discs) {
    grounds.clear();
    let alone_on_axis = |patch: &Patch| arm(patch.at_rest()) == Vec3::ZERO || model.object == ObjectShape::HalfSpace;
    if patches.len() <= 1 && model.table().is_none() && patches.iter().all(alone_on_axis) {
        return;
    }
    discs.clear();
    let alone = patches.len() <= 1;
    for patch in patches {
        let ground = Ground::of(model, patch, alone);
        if let (Some(disc), None) = (&ground.disc, model.table()) {
            discs.push(disc, &ground.held);
        }
        let _ = grounds.push(ground);
    }
}

/// Contact radius up to which a patch has no extent \[m\]: a hundredth of an atom. Third powers of it and of one over it, times any modulus, stay within an f32.
const LEAST_EXTENT: f32 = 1.0e-12;

impl Ground {
    fn of(model: &Model<'_>, patch: &Patch, alone: bool) -> Self {
        let (place, radius) = (patch.at_rest(), patch.footprint.radius);
        let table = model.table();
        let torsion = if table.is_some() { 0.0 } else { body::torsion(model, place) };
        let by_beam = table.is_none() && !alone;
        // a patch without extent holds nothing; its disc needs a radius all the same, since two of them on one corner are no distance apart
        let extent = if radius > LEAST_EXTENT { radius } else { 1.0 };
        Self {
            place,
            radius,
            up: patch.normal.z,
            held: held(patch),
            disc: if alone { None } else { Some(Disc::new(model, place, patch.normal, extent, patch.object_radius)) },
            cell: table.map_or(Cell::NONE, |green| green.chart().cell(place)),
            shared: if by_beam { body::shared_drag(model, place, patch.normal, 1.0 / patch.object_radius) } else { 0.0 },
            torsion,
            // the mean of none along the arm and all across it
            lever: 0.5 * torsion * arm(place).length_squared(),
        }
    }

    /// Torque of the held force about the body's vertical axis \[N m\].
    fn about_axis(&self) -> f32 {
        self.place.x * self.held.force.y - self.place.y * self.held.force.x
    }
}

/// Motion of the ground under patch `i`, in its frame, by all grips as they are now.
pub fn moved(model: &Model<'_>, grounds: &[Ground], discs: &Discs, patches: &[Patch], i: usize) -> Shift {
    let (Some(here), Some(ground)) = (patches.get(i), grounds.get(i)) else { return Shift::default() };
    let Move { shift, turn } = match model.table() {
        Some(green) => by_table(model, green, grounds, patches, here, i),
        None => by_beam(grounds, discs, ground, here.normal, i),
    };
    Shift { drag: here.to_patch(shift), twist: turn }
}

/// Takes up what a patch holds now.
pub fn take_up(grounds: &mut [Ground], discs: &mut Discs, i: usize, patch: &Patch) {
    if let Some(ground) = grounds.get_mut(i) {
        ground.held = held(patch);
        discs.load(i, &ground.held);
    }
}

/// How far the body's table lowers the place of patch `i` by all that the patches of the last tick did, beyond the dents of a half space and what
/// the patch's own load is counted for in series \[m\].
pub fn lowered(model: &Model<'_>, patches: &[Patch], i: usize) -> f32 {
    let (Some(green), Some(here)) = (model.table(), patches.get(i)) else { return 0.0 };
    let at = green.chart().cell(here.at_rest());
    let others = patches.iter().enumerate().filter(|(j, other)| *j != i && other.footprint.load > 0.0);
    let crossed = others.fold(Vec3::ZERO, |sum, (_, other)| {
        sum + green.respond(&at, &green.chart().cell(other.at_rest()), &seen(model, other)).shift
    });
    let own = own(model, green, here).times(&held(here)).shift;
    -(crossed + own).dot(here.normal)
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

/// With a table: the closed forms it was computed beside, and what it adds; of the patch itself what is beyond the scalars that the tiers take in series.
fn by_table(model: &Model<'_>, green: &Green<'_>, grounds: &[Ground], patches: &[Patch], here: &Patch, i: usize) -> Move {
    let Some(ground) = grounds.get(i) else { return Move::default() };
    let others = grounds.iter().zip(patches).enumerate().filter(|(j, (_, patch))| *j != i && patch.footprint.load > 0.0);
    let crossed = others.fold(Move::default(), |sum, (_, (other, patch))| {
        let rims = ground.radius + other.radius;
        let near = other.disc.map_or(Move::default(), |disc| disc.at(&other.held, ground.place, here.normal, rims));
        sum + near + green.respond(&ground.cell, &other.cell, &seen(model, patch))
    });
    let serial = Move { shift: ground.held.force * -here.body.drag, turn: ground.held.torque * -here.body.twist };
    crossed + own(model, green, here).times(&whole(here)) + serial
}

/// Without a table: shear and bending are common to all patches, and forces beside the body's axis turn it.
fn by_beam(grounds: &[Ground], discs: &Discs, ground: &Ground, normal: Vec3, i: usize) -> Move {
    let (mut swept, mut torque) = (Vec3::ZERO, 0.0);
    for other in grounds.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other) {
        swept += other.held.force;
        torque += other.about_axis() + other.held.torque * other.up;
    }
    // the patch's own torque turns itself by the compliance in series, but its arm by this
    let turned = ground.torsion * (torque + ground.about_axis());
    let own = ground.torsion * ground.held.torque * ground.up;
    let shift = swept * ground.shared + Vec3::Z.cross(arm(ground.place)) * (turned + own) - ground.held.force * ground.lever;
    let place = Place { p_w: ground.place, normal, radius: ground.radius, index: i };
    discs.drawn(&place) + Move { shift, turn: ground.up * turned }
}

/// Arm of a place about the body's vertical axis \[m\].
fn arm(place: Vec3) -> Vec3 {
    Vec3::new(place.x, place.y, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::footprint::Footprint;
    use crate::{Material, ModelSpec, ProbePart, ProbeShape};
    use glam::Vec2;

    /// Parts that just begin to reach over a box's corner touch it at the same point, with no area yet, or next to none: they move neither each other nor
    /// what lies beside them.
    #[test]
    fn patches_without_extent_on_one_corner_leave_the_ground_where_it_is() {
        for (young_modulus, edge) in [(2.2e11, 5.909_602_4e-6), (1.0e2, 1.0e-5), (1.0e12, 1.0e2)] {
            let material = Material { young_modulus, poisson_ratio: 0.277_522_4, density: 1.0e3 };
            let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.5 * edge })];
            let cube = ObjectShape::Box { size: Vec3::splat(edge) };
            let model = Model::new(&ModelSpec::new(cube, material, &ball)).unwrap();
            let corner = Vec3::new(-0.5 * edge, -0.5 * edge, edge);
            for radius in [0.0, 1.0e-20, 1.0e-13] {
                let bare = |part: u8, normal: Vec3| Patch {
                    footprint: Footprint { radius, ..Footprint::NONE },
                    ..Patch::born(part, part, 0, corner, normal.normalize())
                };
                let held = Patch {
                    footprint: Footprint { radius: 0.1 * edge, load: 1.0, ..Footprint::NONE },
                    ..Patch::born(2, 2, 0, Vec3::Z * edge, Vec3::Z)
                };
                let patches = [bare(0, Vec3::new(-0.33, -0.72, 0.61)), bare(1, Vec3::new(-0.53, -0.48, 0.7)), held];
                let mut grounds = heapless::Vec::<Ground, 3>::new();
                let mut discs = Discs::new();
                prepare(&model, &patches, &mut grounds, &mut discs);
                for i in 0..patches.len() {
                    let found = moved(&model, &grounds, &discs, &patches, i);
                    assert_eq!((found.drag, found.twist), (Vec2::ZERO, 0.0), "E {young_modulus}, radius {radius}, patch {i}");
                }
            }
        }
    }
}

//! Motion of the body by its own Green's function: the table's moves of all nodes, summed over the patches once per update, then read between them
//! (theory.md, section 9.3).
//!
//! The table continues the closed forms of [`crate::green::kernel`], not those of the patch's own profile and slip: a field goes over from the patch's own
//! forms close to it to the kernel's far from it.

use glam::Vec3;
use heapless::Vec;

use crate::green::Green;
use crate::green::chart::{Cell, Chart, MAX_PLACES};
use crate::green::kernel::{Disc, Load};
use crate::limits::MAX_PARTS;
use crate::math::{clamp, root};
use crate::model::Model;
use crate::patch::Patch;
use crate::stage::ground;

use super::block::{BLOCK, Block};
use super::field::Field;
use super::local::turned_disc;

/// The body under all its patches.
#[derive(Clone, Debug)]
pub struct TableMotion {
    chart: Chart,
    base: f32,
    moves: [Vec3; MAX_PLACES],
    sources: Vec<Source, MAX_PARTS>,
}

/// A patch as the far field sees it.
#[derive(Clone, Copy, Debug)]
struct Source {
    disc: Disc,
    load: Load,
    /// What the table, read between its nodes, lacks of the patch's own turn \[rad\].
    lack: f32,
    normal: Vec3,
    centre: Vec3,
    inverse_radius: f32,
}

/// Distances over the contact radius between which a patch's own forms give way to the kernel's: profile and slip are felt to 1 % at the far one.
const NEAR: f32 = 1.5;
const FAR: f32 = 4.0;

impl TableMotion {
    /// Nothing moved, and nothing to be read before it is prepared: zeros, so that a static of it needs no image in flash.
    pub const REST: Self = Self {
        chart: Chart { centre: Vec3::ZERO, half_size: Vec3::ZERO, per_edge: 0 },
        base: 0.0,
        moves: [Vec3::ZERO; MAX_PLACES],
        sources: Vec::new(),
    };

    /// Becomes the motion under `patches`; false where the model has no table, or the scene's own compliances go before it.
    pub fn prepare(&mut self, model: &Model<'_>, patches: &[Patch]) -> bool {
        let Some(green) = model.table() else { return false };
        (self.chart, self.base) = (*green.chart(), model.fixed_below);
        self.moves.fill(Vec3::ZERO);
        self.sources.clear();
        for patch in patches.iter().filter(|patch| patch.footprint.radius > 0.0) {
            let loaded = green.chart().cell(patch.at_rest());
            let seen = ground::seen(model, patch);
            for (node, moved) in self.moves.iter_mut().enumerate().take(green.chart().places()) {
                let [x, y, z, _] = green.at_node(node, &loaded, &seen);
                *moved += Vec3::new(x, y, z);
            }
            // a probe has at most as many patches as there is room for
            let _ = self.sources.push(Source::new(model, green, patch, &loaded, &seen));
        }
        true
    }

    /// What the table adds at the rest point `p_w` \[m\].
    pub fn at(&self, p_w: Vec3) -> Vec3 {
        if p_w.z <= self.base {
            return Vec3::ZERO;
        }
        let cell = self.chart.cell(p_w);
        let nodes = cell.place.into_iter().zip(cell.weight);
        nodes.fold(Vec3::ZERO, |sum, (place, weight)| sum + self.moves.get(place).copied().unwrap_or(Vec3::ZERO) * weight)
    }

    /// Adds what the table adds to a block of points.
    pub(super) fn add(&self, block: &mut Block) {
        for i in 0..BLOCK {
            let moved = self.at(Vec3::new(block.x[i], block.y[i], block.z[i]));
            block.ux[i] += moved.x;
            block.uy[i] += moved.y;
            block.uz[i] += moved.z;
        }
    }

    /// Adds the field of patch `k`: its own forms close to it, the kernel's far from it.
    pub(super) fn add_field(&self, k: usize, field: &Field, block: &mut Block) {
        let Some(source) = self.sources.get(k) else { return field.add(block) };
        let mut near = Block { ux: [0.0; BLOCK], uy: [0.0; BLOCK], uz: [0.0; BLOCK], ..*block };
        field.add(&mut near);
        for i in 0..BLOCK {
            let p = Vec3::new(block.x[i], block.y[i], block.z[i]);
            let q = source.distance(p);
            let share = Source::far(q);
            let far = if share > 0.0 { source.disc.displacement(&source.load, p) } else { Vec3::ZERO };
            let own = Vec3::new(near.ux[i], near.uy[i], near.uz[i]) + source.lacking(p, q);
            let found = own + (far - own) * share;
            block.ux[i] += found.x;
            block.uy[i] += found.y;
            block.uz[i] += found.z;
        }
    }
}

impl Source {
    /// The source that `patch` is; `seen` is its load as the table's columns of `loaded` see it.
    fn new(model: &Model<'_>, green: &Green<'_>, patch: &Patch, loaded: &Cell, seen: &Load) -> Self {
        let (centre, normal, radius) = (patch.at_rest(), patch.normal, patch.footprint.radius);
        let read = |p: Vec3| green.respond(&green.chart().cell(p), loaded, seen).shift;
        let across = |e: Vec3| (read(centre + e * radius) - read(centre - e * radius)) / (2.0 * radius);
        let (e1, e2) = (patch.tangent, patch.second_tangent());
        let turn = 0.5 * (across(e1).dot(e2) - across(e2).dot(e1));
        let load = ground::whole(patch);
        Self {
            disc: Disc::new(model, centre, normal, radius, patch.object_radius),
            lack: patch.body.twist * load.torque - turn,
            load,
            normal,
            centre,
            inverse_radius: 1.0 / radius,
        }
    }

    /// Distance of `p_w` from the centre, over the contact radius.
    fn distance(&self, p_w: Vec3) -> f32 {
        root((p_w - self.centre).length_squared()) * self.inverse_radius
    }

    /// What the forms of the patch's own profile and slip lack at `p_w`, the distance `q` away: the curvature's part, and what the table lacks of the
    /// patch's turn, fading as that around a disc.
    fn lacking(&self, p_w: Vec3, q: f32) -> Vec3 {
        let turned = self.normal.cross(p_w - self.centre) * (self.lack * turned_disc(q));
        self.disc.bent(&self.load, p_w) + turned
    }

    /// Share of the kernel at the distance `q`.
    fn far(q: f32) -> f32 {
        let share = clamp((q - NEAR) / (FAR - NEAR), 0.0, 1.0);
        share * share * (3.0 - 2.0 * share)
    }
}

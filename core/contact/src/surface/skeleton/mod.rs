//! The beam skeleton: how the whole body follows its loaded patches, down to the fixed base (PHYSICS section 4; theory.md, section 9.2).
//!
//! ```text
//!   patch            A main beam (`beam`) runs from every patch to the fixed base: axial force, shear, bending, torsion.
//!     |              At stations of equal distance along z the motions of all beams' sections are summed.
//!  o--+--o  station  From each station cross beams reach out to the surface and end in **anchors** (`anchors`): two at
//!     |              right angles and two along the diagonals, so eight anchors and the axis.
//!  o--+--o           Between the anchors of a station the surface is the thin plate through them (biharmonic), between
//!     |              stations the natural cubic spline (`spline`): both have least bending energy.
//! ====+====  base    Station 0 does not move.
//! ```
//!
//! Work at an update: patches x stations, then a table over the height, 64 intervals; after that a few operations per point,
//! whatever the number of patches.

#![expect(clippy::needless_range_loop, reason = "one index over several arrays is the form that becomes vector instructions")]

mod anchors;
mod beam;
mod estimate;
mod spline;

use glam::{Vec2, Vec3};

use crate::math::{clamp, max};
use crate::model::Model;
use crate::patch::Patch;

use super::block::{BLOCK, Block, more};
use super::section::Section;
pub use anchors::{ANCHORS, STATIONS, Station};
use beam::Beam;
pub use estimate::estimate;
use spline::{Plate, Span};

/// Intervals of the height between which displacements are taken as linear: 1/64^2/8 of a bent beam's curvature is 1e-4 of its tip.
const LEVELS: usize = 64;

/// The skeleton of a body under all its patches.
#[derive(Clone, Copy, Debug)]
pub struct Skeleton {
    base: f32,
    /// Levels per length \[1/m\].
    rate: f32,
    /// One over the section's half widths \[1/m\].
    per_half: Vec2,
    /// The plates from the base to the top.
    spans: [Span; LEVELS],
}

impl Skeleton {
    /// Nothing moved.
    pub const REST: Self = Self { base: 0.0, rate: 0.0, per_half: Vec2::ZERO, spans: [Span::REST; LEVELS] };

    /// Becomes the skeleton of the model's object under `patches`; false for a half space.
    pub fn prepare(&mut self, model: &Model<'_>, patches: &[Patch]) -> bool {
        let Some(section) = Section::of(&model.object) else { return false };
        self.base = model.fixed_below;
        self.rate = LEVELS as f32 / (model.object.height() - self.base);
        self.per_half = Vec2::new(1.0 / section.half.x, 1.0 / section.half.y);
        spline::spans(&plates(model, &section, patches), &mut self.spans);
        true
    }

    /// Displacement \[m\] of the rest point `p_w`.
    pub fn at(&self, p_w: Vec3) -> Vec3 {
        let (index, share) = self.level(p_w.z);
        let mut found = [0.0; 4];
        self.span(index).at(share, p_w.x * self.per_half.x, p_w.y * self.per_half.y, &mut found);
        Vec3::new(found[0], found[1], found[2])
    }

    /// Adds the displacements of a block of points.
    pub(super) fn add(&self, block: &mut Block) {
        let (mut index, mut share) = ([0_u32; BLOCK], [0.0; BLOCK]);
        for i in 0..BLOCK {
            (index[i], share[i]) = self.level(block.z[i]);
        }
        let mut found = [[0.0; 4]; BLOCK];
        for i in 0..BLOCK {
            self.span(index[i]).at(share[i], block.x[i] * self.per_half.x, block.y[i] * self.per_half.y, &mut found[i]);
        }
        for i in 0..BLOCK {
            block.ux[i] += found[i][0];
            block.uy[i] += found[i][1];
            block.uz[i] += found[i][2];
        }
    }

    /// Interval that holds the height `z`, in the low bits, and the share of the way through it.
    #[inline(always)]
    fn level(&self, z: f32) -> (u32, f32) {
        let t = (z - self.base) * self.rate;
        let t = if t > 0.0 { t } else { 0.0 };
        let t = if t < LEVELS as f32 { t } else { LEVELS as f32 };
        // the nearest integer to t - 1/2 is the interval; where t is an integer it may be either neighbour, but never the one past the last
        let rounded = more(t - 0.500_01, 0.0) + ROUNDER;
        (rounded.to_bits(), t - (rounded - ROUNDER))
    }

    /// The interval in the low bits of `index`.
    #[inline(always)]
    fn span(&self, index: u32) -> &Span {
        &self.spans[index as usize % LEVELS]
    }
}

/// 1.5 x 2^23: added to a small number, it leaves the nearest integer in the low bits.
const ROUNDER: f32 = 12_582_912.0;

/// The plates through the stations. A function of its own, so that the stations lie on the stack no longer than they are needed.
#[inline(never)]
fn plates(model: &Model<'_>, section: &Section, patches: &[Patch]) -> [Plate; STATIONS] {
    let mut stations = [Station::REST; STATIONS];
    set_stations(model, section, patches, &mut stations);
    let mut plates = [Plate::ZERO; STATIONS];
    for (plate, station) in plates.iter_mut().zip(&stations) {
        *plate = Plate::through(station);
    }
    plates
}

/// Sets the stations of a body under `patches`, from the base up, with their anchors' displacements.
fn set_stations(model: &Model<'_>, section: &Section, patches: &[Patch], stations: &mut [Station; STATIONS]) {
    let base = model.fixed_below;
    let step = (model.object.height() - base) / (STATIONS - 1) as f32;
    for (k, station) in stations.iter_mut().enumerate() {
        let z = base + step * k as f32;
        *station = Station::at_rest(&model.object, section, z);
    }
    let middle = middle_of_forces(patches);
    for patch in patches {
        let Some(beam) = Beam::new(model, section, patch, base, middle) else { continue };
        // the base, station 0, is held
        for (k, station) in stations.iter_mut().enumerate().skip(1) {
            station.motion += beam.motion(step * k as f32);
        }
    }
    stations.iter_mut().for_each(Station::carry_anchors);
}

/// Mean place of the patches, by the force that each holds \[m\]: forces that are opposed about it make a couple that twists the body.
fn middle_of_forces(patches: &[Patch]) -> Vec2 {
    let (mut moment, mut all) = (Vec2::ZERO, 0.0);
    for patch in patches {
        let (place, force) = (patch.at_rest(), patch.grip.force.length());
        moment += Vec2::new(place.x, place.y) * force;
        all += force;
    }
    if all > 0.0 { moment / all } else { Vec2::ZERO }
}

/// Clamped share of `x` between 0 and 1.
fn share(x: f32) -> f32 {
    clamp(x, 0.0, 1.0)
}

/// Positive part.
fn positive(x: f32) -> f32 {
    max(x, 0.0)
}

//! The main beam of one patch: a Timoshenko cantilever along z from the patch to the fixed base, which carries the patch's force and torque.
//!
//! Shear, bending and length are the beam's; their sum is scaled so that the patch itself moves by the body's compliance times its load,
//! which finite elements gave. Twist: a long way below the patch the sections turn as the beam does, by T/(G J) per length. Near the loaded end
//! they stop doing so, because the half space under the patch already holds that turn.
//!
//! Sections do not keep their form: where the axis stretches they shrink by nu times the strain, and where it bends the compressed side grows wider
//! and the stretched side narrower (anticlastic), but for the layer above the base that is held. Free sides give way to the force of a
//! patch more than the half space around it does: [`Rim`], fitted to finite elements.

use glam::{Vec2, Vec3};

use crate::math::root;
use crate::model::Model;
use crate::patch::Patch;
use crate::surface::section::{Section, is_round};

use super::anchors::{Motion, Rim};
use super::{positive, share};

/// Turn of the sections of a column below mid height, over the turn of the patch that the body adds: 0.92/0.67 (cube, bonded discs).
const COLUMN_SLOPE: f32 = 1.37;
/// What the middles of the sides and the corners of a column's loaded end turn more than its axis.
const RIM_EXCESS: [f32; 2] = [0.12, 0.19];
/// A round body turns mostly in the cap it is held by: t (1 + k)/(t + k), fitted to an ellipsoid held below an eighth of its height.
const CAP_SHARE: f32 = 0.13;

/// The main beam of one patch.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    length: f32,
    poisson: f32,
    /// F_i/(E I_i) and F_i/(G A), scaled.
    bend: Vec2,
    shear: Vec2,
    /// Strain along z by the axial force, scaled.
    axial: f32,
    /// Slope of the tip by the torque about a level axis, along x and y.
    tilted: Vec2,
    /// Turn about z at the patch \[rad\], by its own torque about itself and by the couple with the other patches about the body's axis.
    twist: f32,
    couple: f32,
    /// The vertical line about which the patch turns.
    line: Vec2,
    /// Level force over G and the section's width \[m\]; none for round bodies.
    rim: Vec2,
    /// The section's width \[m\].
    width: f32,
    round: bool,
}

impl Beam {
    /// The beam that the patch's grip (and, where the body gives along the normal, its load) bends; `base` is the fixed height, `middle` the mean place
    /// of all patches' forces. A single force has no lever arm about it: the patch's compliance holds all of its shift already. `None` where there is no body between patch and base.
    pub fn new(model: &Model<'_>, section: &Section, patch: &Patch, base: f32, middle: Vec2) -> Option<Self> {
        let place = patch.at_rest();
        let length = place.z - base;
        if length <= 0.0 || patch.footprint.radius <= 0.0 {
            return None;
        }
        let torque = patch.normal * (patch.grip.torque * patch.body.twist);
        let force = patch.to_world(patch.grip.force);
        let arm = Vec2::new(place.x, place.y) - middle;
        let width = root(section.area);
        let round = is_round(&model.object);
        let per_width = if round { 0.0 } else { 1.0 / (model.material.shear_modulus() * width) };
        let mut beam = Self {
            length,
            poisson: model.material.poisson_ratio,
            bend: Vec2::ZERO,
            shear: Vec2::ZERO,
            axial: 0.0,
            // a torque about a level axis m tilts the section: slope along x is m_y, along y is -m_x
            tilted: Vec2::new(torque.y, -torque.x),
            twist: torque.z,
            couple: arm.perp_dot(Vec2::new(force.x, force.y)) * patch.body.twist,
            line: Vec2::new(place.x, place.y),
            rim: Vec2::new(force.x, force.y) * per_width,
            width,
            round,
        };
        beam.load(model, section, force, patch.body.drag);
        beam.load(model, section, patch.normal * -patch.footprint.load, patch.body.normal);
        Some(beam)
    }

    /// Adds a force at the patch, scaled so that the tip moves by `compliance` times the force in its direction.
    fn load(&mut self, model: &Model<'_>, section: &Section, force: Vec3, compliance: f32) {
        let g = model.material.shear_modulus();
        let e = model.material.young_modulus;
        let level = Vec2::new(force.x, force.y);
        let (bend, shear) = (level / (section.bending * e), level / (g * section.area));
        let axial = force.z / (e * section.area);
        let l3 = self.length * self.length * self.length / 3.0;
        // work of the force over its own displacement: size^2 times the beam's compliance along it
        let work = level.dot(bend) * l3 + (level.dot(shear) + force.z * axial) * self.length;
        if work > 0.0 && compliance > 0.0 {
            let scale = compliance * force.length_squared() / work;
            self.bend += bend * scale;
            self.shear += shear * scale;
            self.axial += axial * scale;
        }
    }

    /// Motion of the section at `s` above the base. Above the patch the body moves rigidly on.
    pub fn motion(&self, s: f32) -> Motion {
        let l = self.length;
        let (inside, beyond) = if s < l { (s, 0.0) } else { (l, s - l) };
        let t = inside / l;
        let slope = self.bend * (inside * (l - 0.5 * inside)) + self.tilted * t;
        let level = self.bend * (inside * inside * (0.5 * l - inside / 6.0))
            + self.shear * inside
            + self.tilted * (0.5 * inside * t)
            + slope * beyond;
        let (share_of_turn, rim_turn) = self.turn(t);
        let own = self.twist * share_of_turn;
        let turn = own + self.couple * share_of_turn;
        let free = unheld(t) * self.poisson;
        let strained = if beyond > 0.0 { 0.0 } else { 1.0 };
        Motion {
            shift: Vec3::new(level.x + own * self.line.y, level.y - own * self.line.x, self.axial * inside),
            slope,
            turn,
            rim_turn: rim_turn.map(|excess| (self.twist + self.couple) * excess),
            curved: (self.bend * (l - inside) + self.tilted * (strained / l)) * free,
            swell: -self.axial * (strained * free),
            rim: Rim::under(self.rim * unheld(t), share(1.0 - positive(l - s) / self.width), self.poisson),
        }
    }

    /// Turn at the height share `t` over the patch's, and what the middles of the sides and the corners turn more.
    ///
    /// A column turns in proportion to height below and levels off above: 1.37 t - 0.37 t^6.
    fn turn(&self, t: f32) -> (f32, [f32; 2]) {
        if self.round {
            return (t * (1.0 + CAP_SHARE) / (t + CAP_SHARE), [0.0; 2]);
        }
        let t2 = t * t;
        let t6 = t2 * t2 * t2;
        (COLUMN_SLOPE * t - (COLUMN_SLOPE - 1.0) * t6, RIM_EXCESS.map(|excess| excess * t6))
    }
}

/// 0 at the base, where sections keep their form, and 1 from a quarter of the height on: 1 - (1 - t)^8.
fn unheld(t: f32) -> f32 {
    let missing = (1.0 - t) * (1.0 - t);
    let missing = missing * missing;
    1.0 - missing * missing
}

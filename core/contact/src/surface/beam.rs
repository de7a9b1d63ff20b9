//! The main beam of the skeleton: how the whole body follows a loaded patch, from the patch down to the fixed base.
//!
//! A Timoshenko cantilever along z carries the patch's force and torque. Every surface point moves with its section: with the
//! section's shift, and with its tilt times the point's distance from the body's axis. Shear, bending and length are the beam's;
//! their sum is scaled so that the patch itself moves by the body's compliance times its load, which finite elements gave.
//!
//! Twist: a long way below the patch the sections turn as the beam does, by T/(G J) per length. Near the loaded end they stop doing so,
//! because the half space under the patch already holds that turn (`twist_share`).

use glam::{Vec2, Vec3};

use crate::math::{PI, clamp, max, root};
use crate::model::{Model, ObjectShape};
use crate::patch::Patch;

/// Section of the body normal to z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Area \[m^2\].
    pub area: f32,
    /// Second moments of area against bending along x and along y \[m^4\].
    pub bending: Vec2,
    /// Distance of the farthest point from the axis \[m\].
    pub reach: f32,
}

impl Section {
    /// The section of a shape, the equator's for round bodies; `None` for a half space.
    pub fn of(object: &ObjectShape) -> Option<Self> {
        let ellipse = |a: f32, b: f32| Self {
            area: PI * a * b,
            bending: Vec2::new(0.25 * PI * a * a * a * b, 0.25 * PI * a * b * b * b),
            reach: max(a, b),
        };
        match *object {
            ObjectShape::HalfSpace => None,
            ObjectShape::Box { size: Vec3 { x, y, .. } } => Some(Self {
                area: x * y,
                bending: Vec2::new(y * x * x * x / 12.0, x * y * y * y / 12.0),
                reach: 0.5 * root(x * x + y * y),
            }),
            ObjectShape::Cylinder { radius, .. } | ObjectShape::Sphere { radius } => Some(ellipse(radius, radius)),
            ObjectShape::Ellipsoid { semi_axes } => Some(ellipse(semi_axes.x, semi_axes.y)),
        }
    }
}

/// Turn of the sections of a column below mid height, over the turn of the patch that the body adds: 0.92/0.67 (cube, bonded discs).
const COLUMN_SLOPE: f32 = 1.37;
/// What the corners of a column's loaded end turn more than its middle.
const CORNER_EXCESS: f32 = 0.167;
/// A round body turns mostly in the cap it is held by: t (1 + k)/(t + k), fitted to an ellipsoid held below an eighth of its height.
const CAP_SHARE: f32 = 0.13;

/// The beam of one patch.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    length: f32,
    /// Shift of the tip's section per unit of the two shapes: F_i/(E I_i) and F_i/(G A), scaled.
    bend: Vec2,
    shear: Vec2,
    /// Shift along z at the tip \[m\].
    axial: f32,
    /// Tilt of the tip by the torque about a level axis: slope along x and y.
    tilted: Vec2,
    /// Turn about z at the patch \[rad\].
    twist: f32,
    /// The vertical line about which the patch turns.
    line: Vec2,
    reach: f32,
    round: bool,
}

impl Beam {
    /// The beam that the patch's grip (and, where the body gives along the normal, its load) bends; `base` is the fixed height.
    /// `None` where there is no body between patch and base.
    pub fn new(model: &Model<'_>, patch: &Patch, base: f32) -> Option<Self> {
        let section = Section::of(&model.object)?;
        let place = patch.at_rest();
        let length = place.z - base;
        if length <= 0.0 {
            return None;
        }
        let torque = patch.normal * (patch.grip.torque * patch.body.twist);
        let mut beam = Self {
            length,
            bend: Vec2::ZERO,
            shear: Vec2::ZERO,
            axial: 0.0,
            // a torque about a level axis m tilts the section: slope along x is m_y, along y is -m_x
            tilted: Vec2::new(torque.y, -torque.x),
            twist: torque.z,
            line: Vec2::new(place.x, place.y),
            reach: section.reach,
            round: matches!(model.object, ObjectShape::Sphere { .. } | ObjectShape::Ellipsoid { .. }),
        };
        beam.load(model, &section, patch.to_world(patch.grip.force), patch.body.drag);
        beam.load(model, &section, patch.normal * -patch.footprint.load, patch.body.normal);
        Some(beam)
    }

    /// Adds a force at the patch, scaled so that the tip moves by `compliance` times the force in its direction.
    fn load(&mut self, model: &Model<'_>, section: &Section, force: Vec3, compliance: f32) {
        let g = model.material.shear_modulus();
        let e = model.material.young_modulus;
        let level = Vec2::new(force.x, force.y);
        let (bend, shear) = (level / (section.bending * e), level / (g * section.area));
        let axial = force.z * self.length / (e * section.area);
        let l3 = self.length * self.length * self.length / 3.0;
        // work of the force over its own displacement: size^2 times the beam's compliance along it
        let work = level.dot(bend) * l3 + level.dot(shear) * self.length + force.z * axial;
        if work > 0.0 && compliance > 0.0 {
            let scale = compliance * force.length_squared() / work;
            self.bend += bend * scale;
            self.shear += shear * scale;
            self.axial += axial * scale;
        }
    }

    /// Displacement of the surface point `p_w` that lies `above_base` over the base. Above the patch the body moves rigidly on.
    pub fn displacement(&self, p_w: Vec3, above_base: f32) -> Vec3 {
        let s = max(above_base, 0.0);
        let (inside, beyond) = if s < self.length { (s, 0.0) } else { (self.length, s - self.length) };
        let slope = self.slope(inside);
        let l = self.length;
        let level = self.bend * (inside * inside * (0.5 * l - inside / 6.0))
            + self.shear * inside
            + self.tilted * (0.5 * inside * inside / l)
            + slope * beyond;
        let share = inside / l;
        let xy = Vec2::new(p_w.x, p_w.y);
        let around = xy - self.line;
        let turn = self.twist * self.twist_share(share, root(around.length_squared()) / self.reach);
        Vec3::new(level.x - turn * around.y, level.y + turn * around.x, self.axial * share - slope.dot(xy))
    }

    /// Rotation vector of the tip's tilt.
    pub fn tip_tilt(&self) -> Vec3 {
        let slope = self.slope(self.length);
        Vec3::new(-slope.y, slope.x, 0.0)
    }

    /// Slope of the axis along x and y at `s` above the base.
    fn slope(&self, s: f32) -> Vec2 {
        self.bend * (s * (self.length - 0.5 * s)) + self.tilted * (s / self.length)
    }

    /// Turn at the height share `t` over the patch's, `far` = distance from the patch's line over the section's reach.
    ///
    /// A column turns in proportion to height below and levels off above: 1.37 t - (0.37 - excess) t^6.
    fn twist_share(&self, t: f32, far: f32) -> f32 {
        if self.round {
            return t * (1.0 + CAP_SHARE) / (t + CAP_SHARE);
        }
        let far = clamp(far, 0.0, 1.0);
        let excess = CORNER_EXCESS * far * far * (3.0 - 2.0 * far);
        let t2 = t * t;
        COLUMN_SLOPE * t - (COLUMN_SLOPE - 1.0 - excess) * t2 * t2 * t2
    }
}

//! What a load on one small disc of the surface moves elsewhere: the half space's closed forms, faded out towards the held base.
//!
//! This is the part of the Green's function that needs no table. The table holds what the body adds to exactly these formulas, and patches feel each
//! other through them in every tier (theory.md, section 11).

use glam::Vec3;

use crate::math::{PI, ln, max, min, root};
use crate::model::Model;
use crate::surface::local::{disc, disc_across, turned_disc};

/// A force on the object and a torque about the disc's normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force on the object, in world \[N\].
    pub force: Vec3,
    /// Torque on the object about the outward normal \[N m\].
    pub torque: f32,
}

/// Displacement of a place and turn about its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Move {
    /// Displacement, in world \[m\].
    pub shift: Vec3,
    /// Turn about the place's own outward normal \[rad\].
    pub turn: f32,
}

impl core::ops::Add for Move {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { shift: self.shift + other.shift, turn: self.turn + other.turn }
    }
}

/// A loaded disc.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    pub(super) centre: Vec3,
    pub(super) normal: Vec3,
    pub(super) radius: f32,
    /// Curvature of the object under the disc \[1/m\].
    pub(super) curvature: f32,
    pub(super) base: f32,
    pub(super) height: f32,
    pub(super) poisson: f32,
    /// nu/(2 - nu).
    pub(super) lateral: f32,
    /// 1 - 2 nu.
    pub(super) sinking: f32,
    /// Shift per force along the normal, 1/(2 E* a) \[m/N\].
    pressed: f32,
    /// Shift per force along the surface, (2 - nu)/(8 G a) \[m/N\].
    pub(super) dragged: f32,
    /// Turn per torque, 3/(16 G a^3) \[rad/(N m)\].
    pub(super) turned: f32,
    /// 1/(4 pi G) \[m^2/N\].
    pub(super) unit: f32,
}

impl Disc {
    /// A disc of `radius` about the rest place `p_wc` with the outward `normal`, on an object whose mean radius of curvature there is `object_radius`.
    pub fn new(model: &Model<'_>, p_wc: Vec3, normal: Vec3, radius: f32, object_radius: f32) -> Self {
        let (g, nu) = (model.material.shear_modulus(), model.material.poisson_ratio);
        let base = model.base();
        Self {
            centre: p_wc,
            normal,
            radius,
            curvature: 1.0 / object_radius,
            base,
            height: max(p_wc.z - base, radius),
            poisson: nu,
            lateral: nu / (2.0 - nu),
            sinking: 1.0 - 2.0 * nu,
            pressed: 0.5 / (model.material.contact_modulus() * radius),
            dragged: (2.0 - nu) / (8.0 * g * radius),
            turned: 3.0 / (16.0 * g * radius * radius * radius),
            unit: 1.0 / (4.0 * PI * g),
        }
    }

    /// Displacement of the rest point `p_w` under `load`, in world \[m\].
    pub fn displacement(&self, load: &Load, p_w: Vec3) -> Vec3 {
        self.local(load, p_w, 0.0) * self.fade(p_w.z)
    }

    /// Displacement of the rest place `p_w`, and turn about the outward normal `n` there: that of Cerruti's and of the point torque's field, which
    /// grows no further inside the disc. Nearer than `least` \[m\] both are as at that distance: two discs that overlap would otherwise move each
    /// other as much as themselves, and how they share a load would be open.
    pub fn at(&self, load: &Load, p_w: Vec3, n: Vec3, least: f32) -> Move {
        let offset = p_w - self.centre;
        let r = max(root(offset.length_squared()), max(self.radius, least));
        let swirl = load.force.cross(offset).dot(n) - 0.5 * load.torque * self.normal.dot(n);
        let turn = self.unit * swirl / (r * r * r);
        let fade = self.fade(p_w.z);
        Move { shift: self.local(load, p_w, least) * fade, turn: turn * fade }
    }

    /// The curvature's part of [`Disc::displacement`] under a drag alone: what the forms of a patch's own profile and slip lack.
    pub(crate) fn bent(&self, load: &Load, p_w: Vec3) -> Vec3 {
        let along = load.force - self.normal * load.force.dot(self.normal);
        along * (self.bent_drag(root((p_w - self.centre).length_squared())) * self.fade(p_w.z))
    }

    /// 1 at the disc, 0 at the base and level at the disc.
    fn fade(&self, z: f32) -> f32 {
        let above = z - self.base;
        if above <= 0.0 {
            return 0.0;
        }
        let share = if above < self.height { above / self.height } else { 1.0 };
        1.0 - (1.0 - share) * (1.0 - share)
    }

    fn local(&self, load: &Load, p_w: Vec3, least: f32) -> Vec3 {
        let offset = p_w - self.centre;
        let below = -offset.dot(self.normal);
        let level = offset + self.normal * below;
        let r2 = level.length_squared();
        // a convex body falls away without being deep
        let z = max(below - 0.5 * r2 * self.curvature, 0.0);
        let distance = max(root(r2 + z * z), least);
        let q = distance / self.radius;
        let e = level / max(distance, f32::MIN_POSITIVE);
        let into = -load.force.dot(self.normal);
        let along = load.force + self.normal * into;
        self.pressed(into, q, e, z, distance)
            + self.dragged(along, q, e, distance)
            + along * self.bent_drag(distance)
            + self.normal.cross(level)
                * (load.torque * self.turned * turned_disc(q) * bent_twist(self.curvature, self.radius, distance))
    }

    /// What it adds to a drag: the surface that falls away is drawn along by (3 - 2 nu (1 - 2 nu))/(8 pi G R) ln(R/d) (11.5).
    fn bent_drag(&self, distance: f32) -> f32 {
        if self.curvature == 0.0 {
            return 0.0;
        }
        bent_drag(self.curvature, self.poisson, max(distance, self.radius)) * 2.0 * PI * self.unit
    }

    /// Boussinesq's field of a flat disc: into the object, and outwards along `e`.
    fn pressed(&self, into: f32, q: f32, e: Vec3, z: f32, distance: f32) -> Vec3 {
        let smooth2 = distance * distance + self.radius * self.radius;
        let inwards = self.pressed * disc(q) * (1.0 + z * z / (2.0 * (1.0 - self.poisson) * smooth2));
        let outwards = z / (smooth2 * root(smooth2)) * distance - self.sinking * self.enclosed(q, z, distance);
        (self.normal * -inwards + e * (self.unit * outwards)) * into
    }

    /// Share of a flat disc's force inside the distance, over the distance: what a force draws along the surface where nu < 1/2.
    fn enclosed(&self, q: f32, z: f32, distance: f32) -> f32 {
        let share = if q < 1.0 { q * q / (1.0 + root(1.0 - q * q)) } else { 1.0 };
        share / max(distance + z, f32::MIN_POSITIVE)
    }

    /// Cerruti's field of a flat disc; where nu < 1/2 it sinks ahead of the force and rises behind.
    fn dragged(&self, along: Vec3, q: f32, e: Vec3, distance: f32) -> Vec3 {
        let (straight, across) = (disc(q), self.lateral * disc_across(q));
        let ahead = e.dot(along);
        let sinks = self.unit * self.sinking * ahead * self.enclosed(q, 0.0, distance);
        (along * (straight - across) + e * (2.0 * across * ahead)) * self.dragged - self.normal * sinks
    }
}

/// What the body's `curvature` \[1/m\] makes of the twist of a disc of this radius, to first order (11.4): on a sphere 1 + 3/2 d/R far away, 1 + 0.735 a/R on the disc.
pub(super) fn bent_twist(curvature: f32, radius: f32, distance: f32) -> f32 {
    if curvature == 0.0 {
        return 1.0;
    }
    let share = min(curvature * max(distance, radius), 1.0);
    1.0 + 1.5 * share - 0.765 * curvature * radius
}

/// Shift per force, times 2 G, that a surface of `curvature` \[1/m\] adds at the distance `d` from a drag; none beyond its radius.
pub(crate) fn bent_drag(curvature: f32, poisson: f32, d: f32) -> f32 {
    let share = curvature * d;
    if share <= 0.0 || share >= 1.0 {
        return 0.0;
    }
    -curvature * (3.0 - 2.0 * poisson * (1.0 - 2.0 * poisson)) * ln(share) / (4.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Material, ModelSpec, ObjectShape, ProbePart, ProbeShape};

    fn on_half_space(nu: f32, check: impl Fn(&Disc, f32)) {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: nu, density: 1100.0 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, material, &ball)).unwrap();
        check(&Disc::new(&model, Vec3::ZERO, Vec3::Z, 0.004, f32::INFINITY), material.shear_modulus());
    }

    #[test]
    fn far_away_the_fields_are_boussinesq_s_and_cerruti_s() {
        for nu in [0.0, 0.3, 0.5] {
            on_half_space(nu, |disc, g| {
                let (r, p) = (0.08, Vec3::new(0.08, 0.0, 0.0));
                let near = |found: f32, exact: f32| assert!((found - exact).abs() < 2.0e-3 / (g * r), "nu {nu}: {found} {exact}");
                let unit = 1.0 / (4.0 * PI * g * r);
                let pressed = disc.displacement(&Load { force: -Vec3::Z, torque: 0.0 }, p);
                near(pressed.z, -2.0 * (1.0 - nu) * unit);
                near(pressed.x, -(1.0 - 2.0 * nu) * unit);
                let ahead = disc.displacement(&Load { force: Vec3::X, torque: 0.0 }, p);
                near(ahead.x, 2.0 * unit);
                near(ahead.z, -(1.0 - 2.0 * nu) * unit);
                let beside = disc.displacement(&Load { force: Vec3::Y, torque: 0.0 }, p);
                near(beside.y, 2.0 * (1.0 - nu) * unit);
                let around = disc.at(&Load { force: Vec3::ZERO, torque: 1.0 }, p, Vec3::Z, 0.0);
                assert!((around.shift.y * 4.0 * PI * g * r * r - 1.0).abs() < 0.01, "{around:?}");
                let beside = disc.at(&Load { force: Vec3::X, torque: 0.0 }, Vec3::new(0.0, r, 0.0), Vec3::Z, 0.0);
                assert!((beside.turn * 4.0 * PI * g * r * r - 1.0).abs() < 0.01, "{beside:?}");
                // rigid turn of a vortex outside its core is minus half of what decays: curl of 1/r^2 around
                assert!((around.turn * 8.0 * PI * g * r * r * r + 1.0).abs() < 0.02, "{around:?}");
            });
        }
    }
}

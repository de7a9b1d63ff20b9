//! Tier `paper`: equations (1) to (9) and (14) of Luo and Xiao, and the case split of their section V.
//!
//! Faithful, and **not predictive**: against finite elements its torque is 6.6 to 68 times too small, because the twist per length
//! is taken over the whole height of the body. Each equation is a function that carries its number; (1) is `stage::wrench`, (3) is
//! `Material::shear_modulus`. How unclear places are read is written in theory.md, section 6.3.

use glam::{Vec2, Vec3};

use crate::frames::{Pose, ProbeFrame, World};
use crate::math::{PI, direction, max, root};
use crate::model::{Model, ObjectShape};
use crate::params::Params;
use crate::patch::{Grip, Patch};
use crate::report::Flags;
use crate::stage::regions;

/// Memory of one patch: what turned and slid since the region was born, or since it last stopped sliding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PaperMemory {
    /// Rotation of the probe \[rad\], vector in world; sums turns beyond a full one.
    pub turned: Vec3,
    /// Shift from which translation is counted, in c \[m\].
    pub anchor: Vec2,
    /// The region slides ("translates" in equations 7 and 12).
    pub sliding: bool,
    /// Torsional torque on the probe \[N m\], world (equation 9 or 14).
    pub torque: Vec3,
}

/// Equation (2): twisting shear stress tau = r G Phi at distance `r` from the axis, with Phi = phi / l.
pub fn shear_stress(r: f32, shear_modulus: f32, twist_per_length: f32) -> f32 {
    r * shear_modulus * twist_per_length
}

/// Equations (4) and (5): torsional force of one small region of area `ds` while nothing slides.
pub fn torsional_force(stress: f32, ds: f32, static_limit: f32, kinetic: f32) -> f32 {
    let stuck = stress * ds;
    if static_limit >= stuck { stuck } else { kinetic }
}

/// Equation (6), and its kinetic twin r_md: radius inside which the surface moves with the probe. Unbounded without twist.
pub fn stick_radius(friction: f32, shear_modulus: f32, twist_per_length: f32, ds: f32) -> f32 {
    let slope = shear_modulus * twist_per_length * ds;
    if slope > 0.0 { friction / slope } else { f32::INFINITY }
}

/// Equation (7): torsional force of one small region while the probe translates.
pub fn torsional_force_sliding(r: f32, stress: f32, ds: f32, kinetic: f32, r_md: f32) -> f32 {
    if r <= r_md { stress * ds } else { kinetic }
}

/// Equation (8): torque of one small region about the axis.
pub fn torque_of_sample(r: f32, torsional_force: f32) -> f32 {
    r * torsional_force
}

/// Shortest l, in contact radii. As printed the twist per length is unbounded as l -> 0; below the contact radius the notion of a
/// twisted column ends.
pub const SHORTEST_LENGTH: f32 = 1.0;

/// Sets grip and torsion of every patch, with `count` samples each.
pub fn hold(model: &Model<'_>, params: &Params, count: usize, patches: &mut [Patch], x_wp: &Pose<World, ProbeFrame>) -> Flags {
    let several = regions::count(patches) > 1;
    let mut flags = Flags::CLEAN;
    for patch in patches.iter_mut() {
        patch.paper.turned += patch.motion.turn;
        if !super::is_followed(params, patch) || patch.footprint.radius <= 0.0 {
            let_go(patch);
            continue;
        }
        let l = Length::of(model, patch, direction(patch.paper.turned, patch.normal));
        translate(model, params, patch, &l);
        let (torque, stick) = twist(&Samples::of(model, params, count, patch, x_wp.position), several);
        patch.paper.torque = torque;
        patch.grip.stick = stick;
        if l.floored && patch.paper.torque != Vec3::ZERO {
            flags |= Flags::LENGTH_FLOORED;
        }
    }
    flags
}

/// Without load nothing is held.
fn let_go(patch: &mut Patch) {
    patch.grip = Grip::default();
    patch.paper = PaperMemory { anchor: patch.total.drag, ..PaperMemory::default() };
}

/// The paper's l.
struct Length {
    value: f32,
    floored: bool,
}

impl Length {
    /// Projection on the axis of the way from the patch to the fixed point (the base centre, the world's origin).
    fn of(model: &Model<'_>, patch: &Patch, axis: Vec3) -> Self {
        let projected = match model.object {
            ObjectShape::HalfSpace => model.paper_length,
            _ => patch.centre.dot(axis).abs(),
        };
        let shortest = SHORTEST_LENGTH * patch.footprint.radius;
        if projected < shortest { Self { value: shortest, floored: true } } else { Self { value: projected, floored: false } }
    }
}

/// Translation: resisted by G s / l per area up to f_max, then by f_D against the motion. A region that stops sliding starts anew.
fn translate(model: &Model<'_>, params: &Params, patch: &mut Patch, l: &Length) {
    let area = PI * patch.footprint.radius * patch.footprint.radius;
    let stiffness = model.material.shear_modulus() * area / l.value;
    let (f_max, f_d) = (params.mu_s * patch.footprint.load, params.mu_d * patch.footprint.load);
    let stretched = patch.total.drag - patch.paper.anchor;
    let pull = stretched * stiffness;
    let size = root(pull.length_squared());
    let moves_on = patch.motion.step.drag.dot(stretched) > 0.0;
    if patch.paper.sliding && !moves_on {
        patch.paper.sliding = false;
        patch.paper.turned = Vec3::ZERO;
    }
    if !patch.paper.sliding && size <= f_max {
        patch.grip = Grip { force: pull, torque: 0.0, stick: 1.0 };
        return;
    }
    let along = pull / max(size, f32::MIN_POSITIVE);
    patch.paper.anchor = patch.total.drag - along * (f_d / stiffness);
    patch.grip = Grip { force: along * f_d, torque: 0.0, stick: 0.0 };
    patch.paper.sliding = true;
}

/// Section V: torsion acts where the axis goes through the region, kinetic everywhere when there are several regions.
fn twist(samples: &Samples<'_, '_>, several: bool) -> (Vec3, f32) {
    let patch = samples.patch;
    let phi = root(patch.paper.turned.length_squared());
    if phi <= 0.0 || !goes_through(patch, samples.origin, samples.axis) {
        return (Vec3::ZERO, if patch.paper.sliding { 0.0 } else { 1.0 });
    }
    let (torque, stick) = if several { (samples.kinetic_torque(), 0.0) } else { samples.torque(phi) };
    (samples.axis * -torque, stick)
}

/// True when the line through `p` along `axis` crosses the patch's disc.
fn goes_through(patch: &Patch, p: Vec3, axis: Vec3) -> bool {
    let slope = axis.dot(patch.normal);
    if slope.abs() < 1.0e-6 {
        return false;
    }
    let crossing = p + axis * ((patch.centre - p).dot(patch.normal) / slope);
    (crossing - patch.centre).length_squared() <= patch.footprint.radius * patch.footprint.radius
}

/// The n small regions of equal area over the disc of radius a.
struct Samples<'s, 'm> {
    model: &'s Model<'m>,
    params: &'s Params,
    count: usize,
    patch: &'s Patch,
    axis: Vec3,
    origin: Vec3,
}

/// Turn between neighbours of the sunflower, the golden angle 2.39996 rad, as the unit complex number (cos, sin).
const GOLDEN: Vec2 = Vec2::new(-0.737_368_9, 0.675_490_3);

impl<'s, 'm> Samples<'s, 'm> {
    fn of(model: &'s Model<'m>, params: &'s Params, count: usize, patch: &'s Patch, origin: Vec3) -> Self {
        Self { model, params, count, patch, axis: direction(patch.paper.turned, patch.normal), origin }
    }

    fn ds(&self) -> f32 {
        let a = self.patch.footprint.radius;
        PI * a * a / self.count as f32
    }

    fn f_max(&self) -> f32 {
        self.params.mu_s * self.patch.footprint.load / self.count as f32
    }

    fn f_d(&self) -> f32 {
        self.params.mu_d * self.patch.footprint.load / self.count as f32
    }

    /// For each sample its distance r_i from the axis, and l_i to the fixed point along it.
    fn places(&self) -> impl Iterator<Item = (f32, f32)> {
        let mut around = Vec2::X;
        (0..self.count).map(move |i| {
            let place = self.place(i, around);
            around = GOLDEN.rotate(around);
            place
        })
    }

    /// Sample i, which stands in direction `around` on the disc.
    fn place(&self, i: usize, around: Vec2) -> (f32, f32) {
        let a = self.patch.footprint.radius;
        let radius = a * root((i as f32 + 0.5) / self.count as f32);
        let p = self.patch.centre + self.patch.to_world(around * radius);
        let arm = p - self.origin;
        let across = arm - self.axis * arm.dot(self.axis);
        let l = match self.model.object {
            ObjectShape::HalfSpace => self.model.paper_length,
            _ => p.dot(self.axis).abs(),
        };
        (root(across.length_squared()), max(l, SHORTEST_LENGTH * a))
    }

    /// Equations (2) and (4) to (9): torque about the axis, and the stuck share of the samples.
    fn torque(&self, phi: f32) -> (f32, f32) {
        let (g, ds) = (self.model.material.shear_modulus(), self.ds());
        let (f_max, f_d) = (self.f_max(), self.f_d());
        let (mut torque, mut stuck) = (0.0, 0);
        for (r, l) in self.places() {
            let stress = shear_stress(r, g, phi / l);
            let (force, sticks) = if self.patch.paper.sliding {
                let r_md = stick_radius(f_d, g, phi / l, ds);
                (torsional_force_sliding(r, stress, ds, f_d, r_md), false)
            } else {
                (torsional_force(stress, ds, f_max, f_d), f_max >= stress * ds)
            };
            torque += torque_of_sample(r, force);
            stuck += usize::from(sticks);
        }
        (torque, stuck as f32 / self.count as f32)
    }

    /// Equation (14): every small region slides.
    fn kinetic_torque(&self) -> f32 {
        self.places().fold(0.0, |sum, (r, _)| sum + torque_of_sample(r, self.f_d()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_equations_one_by_one() {
        assert_eq!(shear_stress(0.25, 1.0e6, 0.5), 125_000.0);
        assert_eq!(torsional_force(1000.0, 1.0e-6, 2.0e-3, 1.5e-3), 1.0e-3);
        assert_eq!(torsional_force(3000.0, 1.0e-6, 2.0e-3, 1.5e-3), 1.5e-3);
        assert_eq!(stick_radius(2.0e-3, 1.0e6, 0.5, 1.0e-6), 0.004);
        assert_eq!(stick_radius(2.0e-3, 1.0e6, 0.0, 1.0e-6), f32::INFINITY);
        assert_eq!(torsional_force_sliding(0.001, 1000.0, 1.0e-6, 5.0e-4, 0.002), 1.0e-3);
        assert_eq!(torsional_force_sliding(0.003, 1000.0, 1.0e-6, 5.0e-4, 0.002), 5.0e-4);
        assert_eq!(torque_of_sample(0.5, 4.0), 2.0);
    }
}

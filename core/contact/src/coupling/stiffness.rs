//! How stiff the contact is against small motions of the probe (theory.md, equations 10.6 and 10.7).
//!
//! Every patch is a spring along its normal, two along the surface, one of twist and, where it is flat, two of tilt. It need not be exact: at rest it drops
//! out, too stiff only slows the probe. Along the surface there are two answers: friction that is being loaded has the tangent of what still sticks,
//! friction that is being unloaded that of full stick (Masing).

use glam::Vec3;

use super::sym::Sym6;
use crate::World;
use crate::footprint::law_load;
use crate::frames::{Pose, ProbeFrame};
use crate::math::{clamp, max, root};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;

/// The contact at the probe's pose of the last tick, about its mass centre, in world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Linear {
    /// While friction is being loaded or slips.
    pub loading: Sym6,
    /// While friction is being unloaded.
    pub unloading: Sym6,
    /// Force \[N\] and torque \[N m\] of friction on the probe: what tells the two apart.
    pub friction: (Vec3, Vec3),
    /// What the patches do not know of: the centre of a flat that wanders as the probe tilts, an edge, a neighbour.
    pub missing: Sym6,
}

/// Stiffnesses of one patch: normal, along the surface \[N/m\], twist, tilt \[N m/rad\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stiffness {
    normal: f32,
    drag: f32,
    twist: f32,
    tilt: f32,
}

/// Relative step of the difference quotient of a given force law: six times the root of f32's resolution.
const LAW_STEP: f32 = 2.0e-3;

/// Share of the missing spring that stays from tick to tick: it fades over ten, by when the probe is elsewhere or still asks for it.
const FADE: f32 = 0.9;

/// Motions below this say nothing about stiffness \[m, rad\]: a pose a tenth of a metre from the origin is rounded by a seventieth of it.
const LEAST_MOTION: f32 = 5.0e-7;

/// What is missing counts from this share of the known stiffness on; below, curvature and rounding make it.
const LEAST_SHARE: f32 = 0.1;

/// Least fullness that tells a shape: that of a radius that grows with the square of the depth, the steepest of an overlap's polynomials. A patch that begins short of its full
/// depth, as one that has just reached over an edge, has less, and none to the last digit: its load and its fullness then come from what the polynomials are off.
const LEAST_FULLNESS: f32 = 1.0 / 3.0;

impl Linear {
    /// Measures, from the last motion of the probe and the wrench it lost by it, whether the contact is stiffer than its patches say, and adds
    /// the shortfall r r^T / (r . s) (the symmetric rank-one secant update) to what was `missing` before.
    /// Fades while the probe moves or touches nothing.
    pub fn take_up(&mut self, missing: Sym6, moved: (Vec3, Vec3), lost: (Vec3, Vec3)) {
        let touches = self.unloading != Sym6::default();
        if !touches || moved.0.length() > LEAST_MOTION || moved.1.length() > LEAST_MOTION {
            self.missing = missing.scaled(FADE);
            let (force, torque) = self.unloading.plus(&self.missing).times(moved.0, moved.1);
            let rest = (lost.0 - force, lost.1 - torque);
            let work = rest.0.dot(moved.0) + rest.1.dot(moved.1);
            let scale = 1.0 / root(work);
            let (u, w) = (rest.0 * scale, rest.1 * scale);
            if work > LEAST_SHARE * (force.dot(moved.0) + torque.dot(moved.1)) && u.is_finite() && w.is_finite() {
                self.missing.add_spring(u, w, 1.0);
            }
        } else {
            self.missing = missing;
        }
        self.loading = self.loading.plus(&self.missing);
        self.unloading = self.unloading.plus(&self.missing);
    }
}

/// Sums the patches.
pub fn linearise(model: &Model<'_>, params: &Params, patches: &[Patch], x_wp: &Pose<World, ProbeFrame>) -> Linear {
    let mut sum = Linear::default();
    for patch in patches.iter().filter(|patch| patch.footprint.load > 0.0) {
        let arm = patch.centre - x_wp.position;
        let full = stiffness(model, params, patch, 1.0);
        add(&mut sum.unloading, patch, arm, &full);
        // share of the radius that sticks
        let stuck = root(clamp(patch.grip.stick, 0.0, 1.0));
        add(&mut sum.loading, patch, arm, &stiffness(model, params, patch, stuck));
        let force = -patch.to_world(patch.grip.force);
        let (force_sum, torque_sum) = sum.friction;
        sum.friction = (force_sum + force, torque_sum + arm.cross(force) - patch.normal * patch.grip.torque);
    }
    sum
}

fn add(sum: &mut Sym6, patch: &Patch, arm: Vec3, k: &Stiffness) {
    let (n, t, s) = (patch.normal, patch.tangent, patch.second_tangent());
    for (u, k) in [(n, k.normal), (t, k.drag), (s, k.drag)] {
        sum.add_spring(u, arm.cross(u), k);
    }
    for (w, k) in [(n, k.twist), (t, k.tilt), (s, k.tilt)] {
        sum.add_spring(Vec3::ZERO, w, k);
    }
}

/// Tangents of a stuck disc of `stuck` times the radius, each in series with the body.
fn stiffness(model: &Model<'_>, params: &Params, patch: &Patch, stuck: f32) -> Stiffness {
    let (a, body) = (patch.footprint.radius, &patch.body);
    let g = model.material.shear_modulus();
    let rubs = if params.mu_s > 0.0 { stuck } else { 0.0 };
    let normal = series(along_normal(model, params, patch), body.normal);
    // a flat end resists tilting as a rigid punch does, 4/3 E* a^3; a ball does not
    let flat = clamp(3.0 * patch.footprint.fullness - 2.0, 0.0, 1.0);
    Stiffness {
        normal,
        drag: series(8.0 * g * a * rubs / (2.0 - model.material.poisson_ratio), body.drag),
        twist: series(16.0 / 3.0 * g * a * a * a * rubs * rubs * rubs, body.twist),
        tilt: 2.0 / 3.0 * normal * a * a * flat,
    }
}

/// dP/d(depth): 2 E* a for any footprint of the dimensionality reduction; a given force law by its difference quotient.
fn along_normal(model: &Model<'_>, params: &Params, patch: &Patch) -> f32 {
    let at = |depth: f32| law_load(&params.force_law, depth);
    let step = LAW_STEP * patch.depth;
    if let (Some(high), Some(low)) = (at(patch.depth + step), at(patch.depth - step)) {
        return max(high - low, 0.0) / (2.0 * step);
    }
    // a long footprint is stiffer than its disc of equal area: P / (rho depth) has that factor
    let shape = patch.footprint.load / (max(patch.footprint.fullness, LEAST_FULLNESS) * patch.depth);
    max(2.0 * model.material.contact_modulus() * patch.footprint.radius, shape)
}

/// Stiffness `k` in series with the compliance `c`.
fn series(k: f32, c: f32) -> f32 {
    k / (1.0 + c * k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::footprint::Footprint;
    use crate::patch::Patch;
    use crate::{Material, ModelSpec, ObjectShape, ParamsSpec, ProbePart, ProbeShape};

    /// A sliver that begins at its full depth has no fullness; its stiffness is that of its disc, or of as much load as the steepest overlap carries.
    #[test]
    fn a_patch_without_fullness_is_as_stiff_as_its_disc() {
        let material = Material { young_modulus: 1.5e4, poisson_ratio: 0.5, density: 1.0e3 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 1.0e-5 })];
        let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, material, &ball)).unwrap();
        let params = Params::new(&ParamsSpec::default()).unwrap();
        let disc = 2.0 * material.contact_modulus() * 4.7e-11;
        for (fullness, load, expected) in [
            (0.0, 2.4e-16, disc),
            (1.0e-30, 2.4e-16, disc),
            (0.0, 1.0e-12, 3.0 * 1.0e-12 / 2.0e-8),
            (0.5, 1.0e-12, 2.0 * 1.0e-12 / 2.0e-8),
        ] {
            let footprint = Footprint { radius: 4.7e-11, load, fullness, aspect: 1.7, large_strain: false };
            let patch = Patch { depth: 2.0e-8, footprint, ..Patch::born(0, 0, 0, Vec3::ZERO, Vec3::Z) };
            let Stiffness { normal, drag, twist, tilt } = stiffness(&model, &params, &patch, 1.0);
            assert!((normal / expected - 1.0).abs() < 1.0e-5, "fullness {fullness}: {normal} {expected}");
            assert!(drag > 0.0 && drag.is_finite() && twist.is_finite() && tilt == 0.0);
        }
    }
}

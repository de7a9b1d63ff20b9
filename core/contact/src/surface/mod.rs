//! The deformed surface: where every point of the object's surface goes, given the patches of a tick (theory.md, section 9).
//!
//! Terms: the **rest surface** is the undeformed one; a **field** is the displacement \[m\] that one patch makes at a rest point, in
//! world. Fields are summed in the patches' order, oldest first. A field is the half space's closed form around the patch (dent, drag,
//! twist; [`local`]) faded out towards the base, plus the motion of the whole body (`beam`). It is zero at the fixed base and below,
//! and continuous everywhere; inside the contact the surface follows the probe where it sticks.
//!
//! **Traction decides.** What friction holds (the patch's grip) sets the field, through the inverse of the tier's loading curves,
//! and not the probe's motion since birth: a patch that lost its grip leaves no field, a thousand turns of sliding do not wind the
//! surface up, and all tiers share one field. After a reversal the field is that of fresh loading to the same grip.
//!
//! Pure functions, no state, no allocation; work is vertices times patches.
//!
//! ```
//! use haptor_contact::*;
//!
//! let rubber = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
//! let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
//! let cube = ObjectShape::Box { size: Vec3::splat(0.1) };
//! let model = Model::new(&ModelSpec::new(cube, rubber, &ball))?;
//! let params = Params::new(&ParamsSpec::default())?;
//! let (mut state, mut scratch) = (State::<10, 64>::new(), Scratch::<16>::new());
//! let place = Vec3::new(0.0, 0.0, 0.119);
//! step(&model, &params, &mut state, &mut scratch, Input { pose: Pose::new(place, Quat::IDENTITY), dt: 1.0e-3 });
//!
//! let rest = [Vec3::new(0.0, 0.0, 0.1), Vec3::new(0.05, 0.0, 0.0)];
//! let mut moved = [Vec3::ZERO; 2];
//! let surface = surface::Surface { model: &model, params: &params, patches: state.patches(), p_wp: place, body: true };
//! surface.update(&rest, &mut moved);
//! assert!((moved[0].z + 0.001).abs() < 1.0e-6 && moved[1] == Vec3::ZERO);
//! # Ok::<(), Invalid>(())
//! ```

mod beam;
pub mod local;
pub mod paper;
pub mod slip_table;

use core::ops::Range;

use glam::Vec3;

use crate::math::{PI, cbrt, clamp, max, min, root};
use crate::model::{Model, ObjectShape};
use crate::params::{Params, Tier};
use crate::patch::Patch;
use crate::profile::{FULLNESS_HERTZ, FULLNESS_PUNCH};
use crate::tier::Hold;
use crate::tier::point::curve::Curve;
use beam::Beam;
use local::{bowl, bowl_across, disc, disc_across, turned_disc};

/// Everything the deformed surface of one tick follows from.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// The scene.
    pub model: &'a Model<'a>,
    /// The parameters the patches were computed under.
    pub params: &'a Params,
    /// The patches in contact, oldest first.
    pub patches: &'a [Patch],
    /// Mass centre of the probe in world \[m\]; only tier `paper` asks for it.
    pub p_wp: Vec3,
    /// With the motion of the whole body; without it only the surroundings of the contacts move.
    pub body: bool,
}

impl Surface<'_> {
    /// Displacement \[m\], in world, of the rest surface point `p_w`.
    pub fn displacement(&self, p_w: Vec3) -> Vec3 {
        self.patches.iter().fold(Vec3::ZERO, |sum, patch| sum + self.field(patch).at(p_w))
    }

    /// Displacements of all `rest` points. The shorter slice bounds the work.
    pub fn update(&self, rest: &[Vec3], moved: &mut [Vec3]) {
        moved.fill(Vec3::ZERO);
        for patch in self.patches {
            let field = self.field(patch);
            for (u, &p) in moved.iter_mut().zip(rest) {
                *u += field.at(p);
            }
        }
    }

    /// Displacements of the points in `block` only, so that a whole surface may be spread over ticks; gives the same bits as `update`.
    /// What of the block lies beyond the slices is left out.
    pub fn update_block(&self, rest: &[Vec3], moved: &mut [Vec3], block: Range<usize>) {
        let end = block.end.min(rest.len()).min(moved.len());
        if block.start < end {
            self.update(&rest[block.start..end], &mut moved[block.start..end]);
        }
    }

    /// The field of one patch.
    pub fn field(&self, patch: &Patch) -> Field {
        let field = Field::new(self.model, self.params, patch, self.p_wp);
        if self.body { field } else { field.without_body() }
    }
}

/// The field of one patch, prepared for many points.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Base of the body \[m\]; minus infinity for a half space.
    base: f32,
    /// Height of the patch over the base \[m\].
    height: f32,
    centre: Vec3,
    normal: Vec3,
    radius: f32,
    /// Curvature of the object under the patch \[1/m\].
    object_curvature: f32,
    /// 0 for Hertz pressure and fuller towards the middle, 1 for a flat punch.
    flat: f32,
    dent: Dent,
    drag: Drag,
    twist: Turn,
    paper: paper::Twist,
    beam: Option<Beam>,
    /// Rotation of the body's end, which the contact does not take part in, and the body's own motion along the normal there.
    tilt: Vec3,
    rise: f32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Dent {
    /// Depth of the paraboloid with the patch's load and radius \[m\].
    bowl: f32,
    /// Depth of the flat punch with the patch's load and radius \[m\].
    disc: f32,
    /// Depth at the centre that the load does not account for \[m\].
    rest: f32,
    /// (1 + nu) P/(2 pi E) \[m^2\].
    force: f32,
    poisson: f32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Drag {
    /// Direction of the grip, in world.
    along: Vec3,
    /// Shift that would make the whole Hertz patch slip, 1.5 mu P/K_t \[m\].
    full: f32,
    /// Stick radius over a.
    stuck: f32,
    /// Shift of the flat punch under the same force, Q/K_t \[m\].
    disc: f32,
    /// nu/(2 - nu).
    across: f32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Turn {
    /// Rotation of the patch that holds the same torque when freshly loaded \[rad\].
    hertz: f32,
    /// z = K_theta phi/T_max of that rotation.
    z: f32,
    /// Rotation of the flat punch under the same torque, T/K_theta \[rad\].
    disc: f32,
}

/// Largest part of the dent's depth that is attributed to the probe's true shape rather than to other patches.
const SHAPE_SHARE: f32 = 0.1;

/// Stick radii below this share of a are none: what the innermost thousandth holds is below a millionth of the field.
const LEAST_STUCK: f32 = 1.0e-3;

impl Field {
    /// Prepares the field of `patch`; `p_wp` is the probe's mass centre.
    pub fn new(model: &Model<'_>, params: &Params, patch: &Patch, p_wp: Vec3) -> Self {
        let base = if model.object == ObjectShape::HalfSpace { f32::NEG_INFINITY } else { model.fixed_below };
        let centre = patch.at_rest();
        let beam = Beam::new(model, patch, base);
        let (tilt, rise) = beam.map_or((Vec3::ZERO, 0.0), |beam| {
            let moved = beam.displacement(centre, centre.z - base);
            (beam.tip_tilt(), moved.dot(patch.normal) + patch.body.normal * patch.footprint.load)
        });
        let hold = Hold::new(model, params, patch, patch.ground, 0.0);
        let is_paper = params.tier == Tier::Paper;
        Self {
            base,
            height: max(centre.z - base, patch.footprint.radius),
            centre,
            normal: patch.normal,
            radius: patch.footprint.radius,
            object_curvature: 1.0 / patch.object_radius,
            flat: clamp((patch.footprint.fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ), 0.0, 1.0),
            dent: Dent::new(model, patch),
            drag: Drag::new(model, params, patch, &hold),
            twist: if is_paper { Turn::default() } else { Turn::new(params, patch, &hold) },
            paper: if is_paper { paper::Twist::new(model, params, patch, p_wp) } else { paper::Twist::None },
            beam,
            tilt,
            rise,
        }
    }

    /// The field without the motion of the whole body.
    #[must_use]
    pub fn without_body(self) -> Self {
        Self { beam: None, tilt: Vec3::ZERO, rise: 0.0, ..self }
    }

    /// Displacement \[m\], in world, of the rest point `p_w`.
    pub fn at(&self, p_w: Vec3) -> Vec3 {
        let above = p_w.z - self.base;
        if above <= 0.0 || self.radius <= 0.0 {
            return Vec3::ZERO;
        }
        let body = self.beam.map_or(Vec3::ZERO, |beam| beam.displacement(p_w, above));
        let share = if above < self.height { above / self.height } else { 1.0 };
        // 1 at the patch, 0 at the base, level at the patch
        let fade = 1.0 - (1.0 - share) * (1.0 - share);
        body + self.local(p_w) * fade + self.paper.displacement(p_w, above, share)
    }

    /// The half space's part.
    fn local(&self, p_w: Vec3) -> Vec3 {
        let offset = p_w - self.centre;
        let below = -offset.dot(self.normal);
        let level = offset + self.normal * below;
        let r2 = level.length_squared();
        // depth under the surface as curved at the patch: a convex body falls away without being deep
        let z = max(below - 0.5 * r2 * self.object_curvature, 0.0);
        let distance = root(r2 + z * z);
        let q = distance / self.radius;
        let (inwards, outwards) = self.dent.at(q, r2, z, self.radius, self.flat);
        let turn = self.twist.at(q, self.flat);
        let held = (self.rise + self.normal.dot(self.tilt.cross(offset))) * turned_disc(q);
        self.normal * (-inwards - held)
            + level * outwards
            + self.drag.at(level / max(distance, f32::MIN_POSITIVE), q, self.flat)
            + self.normal.cross(level) * turn
    }
}

impl Dent {
    fn new(model: &Model<'_>, patch: &Patch) -> Self {
        let (a, load) = (patch.footprint.radius, patch.footprint.load);
        if a <= 0.0 || load <= 0.0 {
            return Self::default();
        }
        let nu = model.material.poisson_ratio;
        let per_radius = load / (model.material.contact_modulus() * a);
        let (bowl, disc) = (0.75 * per_radius, 0.5 * per_radius);
        let flat = clamp((patch.footprint.fullness - FULLNESS_HERTZ) / (FULLNESS_PUNCH - FULLNESS_HERTZ), 0.0, 1.0);
        let found = bowl + (disc - bowl) * flat;
        let wanted = patch.depth - patch.body.normal * load - found;
        let rest = clamp(wanted, -SHAPE_SHARE * found, SHAPE_SHARE * found);
        Self { bowl, disc, rest, force: (1.0 + nu) * load / (2.0 * PI * model.material.young_modulus), poisson: nu }
    }

    /// Displacement into the object, and outwards per distance from the axis. Below the surface the vertical part grows and the
    /// radial part turns outwards as Boussinesq's do.
    fn at(&self, q: f32, r2: f32, z: f32, a: f32, flat: f32) -> (f32, f32) {
        let shape = if q < 1.0 { self.rest * (1.0 - q * q) } else { 0.0 };
        let (bowl, disc) = (self.bowl * bowl(q), self.disc * disc(q));
        let distance2 = r2 + z * z;
        let smooth2 = distance2 + a * a;
        let inwards = (bowl + (disc - bowl) * flat + shape) * (1.0 + z * z / (2.0 * (1.0 - self.poisson) * smooth2));
        // share of the load inside r, over r^2: what draws the surface inwards where nu < 1/2
        let enclosed = if q < 1.0 { enclosed_load(q) / (a * a) } else { 1.0 / distance2 };
        let drawn = (1.0 - 2.0 * self.poisson) * enclosed;
        (inwards, self.force * (z / (smooth2 * root(smooth2)) - drawn / (1.0 + z / max(root(distance2), a))))
    }
}

/// (1 - (1 - q^2)^1.5)/q^2, the Hertz load inside q; 1.5 at the centre.
fn enclosed_load(q: f32) -> f32 {
    let q2 = q * q;
    if q2 < 1.0e-3 {
        return 1.5 - 0.375 * q2;
    }
    let rest = 1.0 - q2;
    (1.0 - rest * root(rest)) / q2
}

impl Drag {
    fn new(model: &Model<'_>, params: &Params, patch: &Patch, hold: &Hold) -> Self {
        let pull = root(patch.grip.force.length_squared());
        if pull <= 0.0 || hold.radius <= 0.0 {
            return Self::default();
        }
        let nu = model.material.poisson_ratio;
        // never less than what is held: static friction may hold more than dynamic
        let full = max(params.mu_d * hold.load, pull);
        Self {
            along: patch.to_world(patch.grip.force / pull),
            full: 1.5 * full / hold.drag_stiffness,
            stuck: cbrt(max(1.0 - pull / full, 0.0)),
            disc: pull / hold.drag_stiffness,
            across: nu / (2.0 - nu),
        }
    }

    /// Cattaneo's field: that of a patch in full slip, less that of a smaller one in place of its stuck middle. `e` points from
    /// the axis to the point.
    fn at(&self, e: Vec3, q: f32, flat: f32) -> Vec3 {
        let (mut along, mut across) = (bowl(q), bowl_across(q));
        if self.stuck > LEAST_STUCK {
            let (inner, area) = (q / self.stuck, self.stuck * self.stuck);
            along -= area * bowl(inner);
            across -= area * bowl_across(inner);
        }
        let along = self.full * along * (1.0 - flat) + self.disc * disc(q) * flat;
        let across = self.across * (self.full * across * (1.0 - flat) + self.disc * disc_across(q) * flat);
        self.along * (along - across) + e * (2.0 * across * e.dot(self.along))
    }
}

impl Turn {
    fn new(params: &Params, patch: &Patch, hold: &Hold) -> Self {
        let torque = patch.grip.torque;
        let curve = Curve::twist(hold, params.mu_d);
        if torque == 0.0 || hold.radius <= 0.0 || curve.full() <= 0.0 {
            return Self::default();
        }
        let z = min(curve.inverse(torque.abs()) / curve.slope_reach(), slip_table::LARGEST_TURN);
        let hertz = z * curve.slope_reach() * torque.signum();
        Self { hertz, z, disc: torque / hold.twist_stiffness }
    }

    /// Rotation at the distance `q`.
    fn at(&self, q: f32, flat: f32) -> f32 {
        let mut turn = 0.0;
        if flat < 1.0 {
            // below the table's first row the rim sticks more and more, up to the whole patch
            let slipping = min(self.z / slip_table::SMALLEST_TURN, 1.0);
            let share = slip_table::slip_field(self.z, q);
            turn += (1.0 - flat) * self.hertz * (share + (turned_disc(q) - share) * (1.0 - slipping));
        }
        if flat > 0.0 {
            turn += flat * self.disc * turned_disc(q);
        }
        turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Pose;
    use crate::model::{Material, ModelSpec, ProbePart, ProbeShape};
    use crate::params::ParamsSpec;
    use crate::{Input, Quat, Scratch, State, step};

    /// Presses a ball to 2 mm, drags it 0.3 mm and turns it by 0.2 rad, then hands the surface to `look`.
    fn after_a_mixed_motion(object: ObjectShape, tier: Tier, look: impl Fn(&Surface<'_>)) {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.45, density: 1100.0 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let model = Model::new(&ModelSpec::new(object, material, &ball)).unwrap();
        let params = Params::new(&ParamsSpec { tier, ..ParamsSpec::default() }).unwrap();
        let (mut state, mut scratch) = (State::<2, 64>::new(), Scratch::<2>::new());
        let mut place = Vec3::new(0.01, 0.0, object.height() + 0.018);
        for i in 0..=20 {
            let share = i as f32 / 20.0;
            place.x = 0.01 + 3.0e-4 * share;
            let pose = Pose::new(place, Quat::from_rotation_z(0.2 * share));
            step(&model, &params, &mut state, &mut scratch, Input { pose, dt: 1.0e-2 });
        }
        assert_eq!(state.patches().len(), 1);
        look(&Surface { model: &model, params: &params, patches: state.patches(), p_wp: place, body: true });
    }

    const SHAPES: [ObjectShape; 5] = [
        ObjectShape::HalfSpace,
        ObjectShape::Box { size: Vec3::splat(0.1) },
        ObjectShape::Cylinder { radius: 0.05, height: 0.1 },
        ObjectShape::Sphere { radius: 0.05 },
        ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) },
    ];

    #[test]
    fn zero_at_the_base_finite_and_without_steps() {
        for (object, tier) in SHAPES.into_iter().flat_map(|o| [(o, Tier::Point), (o, Tier::Bristle), (o, Tier::Paper)]) {
            after_a_mixed_motion(object, tier, |surface| {
                let top = object.height();
                if top > 0.0 {
                    let held = Vec3::new(0.03, 0.01, surface.model.fixed_below);
                    assert_eq!(surface.displacement(held), Vec3::ZERO, "{object:?} {tier:?}");
                }
                // along a slanted way from the patch to the base, and across the top
                for (from, to) in [
                    (Vec3::new(0.01, 0.0, top), Vec3::new(0.05, 0.01, top - 0.1)),
                    (Vec3::new(-0.05, 0.0, top), Vec3::new(0.05, 1.0e-3, top)),
                ] {
                    let steps = 5_000;
                    let mut last = surface.displacement(from);
                    for i in 1..=steps {
                        let now = surface.displacement(from + (to - from) * (i as f32 / steps as f32));
                        assert!(now.is_finite(), "{object:?} {tier:?} {i}");
                        assert!((now - last).length() < 4.0e-5, "{object:?} {tier:?} {i}: {last} {now}");
                        last = now;
                    }
                }
            });
        }
    }

    #[test]
    fn blocks_give_the_bits_of_the_whole() {
        after_a_mixed_motion(SHAPES[1], Tier::Bristle, |surface| {
            let rest: [Vec3; 100] = core::array::from_fn(|i| Vec3::new(5.0e-4 * i as f32, 0.01, 0.1 - 1.0e-3 * i as f32));
            let (mut whole, mut parts) = ([Vec3::ONE; 100], [Vec3::ZERO; 100]);
            surface.update(&rest, &mut whole);
            [0..32, 32..64, 64..128, 200..300].into_iter().for_each(|block| surface.update_block(&rest, &mut parts, block));
            assert_eq!(whole, parts);
            assert!(rest.iter().zip(&whole).all(|(&p, &u)| surface.displacement(p) == u));
        });
    }

    #[test]
    fn inside_the_contact_the_surface_follows_the_probe() {
        for object in SHAPES {
            after_a_mixed_motion(object, Tier::Point, |surface| {
                let patch = surface.patches[0];
                let moved = surface.displacement(patch.at_rest());
                assert!((-moved.dot(patch.normal) / patch.depth - 1.0).abs() < 0.02, "{object:?}: {moved} {}", patch.depth);
                let dragged = moved.dot(Vec3::X) / 3.0e-4;
                assert!(dragged > 0.8 && dragged < 1.2 || object.height() > 0.0 && patch.normal.z < 0.999, "{object:?}: {moved}");
            });
        }
    }

    #[test]
    fn without_contact_nothing_moves() {
        let surface_of_nothing = |surface: &Surface<'_>| {
            let empty = Surface { patches: &[], ..*surface };
            assert_eq!(empty.displacement(Vec3::new(0.0, 0.0, 0.1)), Vec3::ZERO);
        };
        after_a_mixed_motion(SHAPES[1], Tier::Point, surface_of_nothing);
    }
}

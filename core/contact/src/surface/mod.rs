//! The deformed surface: where every point of the object's surface goes, given the patches of a tick (theory.md, section 9).
//!
//! Terms: the **rest surface** is the undeformed one; a **field** is the displacement \[m\] that one patch makes at a rest point, in
//! world. Fields are summed in the patches' order, oldest first. A field is the half space's closed form around the patch (dent, drag,
//! twist; [`local`]) faded out towards the base. The **motion of the whole body** under all patches ([`motion`], [`skeleton`]) comes on top. Both are
//! zero at the fixed base and below, and continuous everywhere; inside the contact the surface follows the probe where it sticks.
//!
//! **Traction decides.** What friction holds (the patch's grip) sets the field, through the inverse of the tier's loading curves,
//! and not the probe's motion since birth: a patch that lost its grip leaves no field, a thousand turns of sliding do not wind the
//! surface up, and all tiers share one field. After a reversal the field is that of fresh loading to the same grip.
//!
//! Pure functions, no allocation; work is vertices times patches. What does not depend on the point is prepared once ([`Prepared::prepare`]); points
//! then go in fixed blocks of arrays that a compiler vectorises, with the same bits in every build. [`SurfaceState`] spreads a surface over ticks.
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

mod block;
mod field;
pub mod local;
pub mod motion;
mod near;
pub mod paper;
pub mod section;
pub mod skeleton;
pub mod slip_table;
mod state;
pub mod table;

use glam::Vec3;
use heapless::Vec;

use crate::limits::MAX_PARTS;
use crate::model::Model;
use crate::params::{Params, Tier};
use crate::patch::Patch;
use block::{BLOCK, Block};
use field::Field;
use motion::BodyMotion;
pub use state::{SurfaceState, Updated};

/// Everything the deformed surface of one tick follows from.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// The scene.
    pub model: &'a Model<'a>,
    /// The parameters the patches were computed under.
    pub params: &'a Params,
    /// The patches in contact, oldest first; no more than a probe has parts, [`MAX_PARTS`].
    pub patches: &'a [Patch],
    /// Mass centre of the probe in world \[m\]; only tier `paper` asks for it.
    pub p_wp: Vec3,
    /// With the motion of the whole body; without it only the surroundings of the contacts move.
    pub body: bool,
}

impl Surface<'_> {
    /// Displacement \[m\], in world, of the rest surface point `p_w`. For many points [`Prepared::prepare`] once.
    pub fn displacement(&self, p_w: Vec3) -> Vec3 {
        let mut moved = [Vec3::ZERO];
        self.update(&[p_w], &mut moved);
        moved[0]
    }

    /// Displacements of all `rest` points. The shorter slice bounds the work. Takes the memory of a [`Prepared`] from the stack; [`Prepared::update`] is for those who
    /// have it elsewhere.
    pub fn update(&self, rest: &[Vec3], moved: &mut [Vec3]) {
        let mut prepared = Prepared::new();
        prepared.prepare(self);
        prepared.update(rest, moved);
    }
}

/// A surface prepared for many points. 41 kB of memory that the caller holds, in a static or a box: it is filled where it lies, and a call needs little stack
/// beside it.
#[derive(Clone, Debug)]
pub struct Prepared {
    base: f32,
    fields: Vec<(Field, paper::Twist), MAX_PARTS>,
    body: BodyMotion,
}

impl Default for Prepared {
    fn default() -> Self {
        Self::new()
    }
}

impl Prepared {
    /// Of a surface that no patch moves.
    pub const fn new() -> Self {
        Self { base: 0.0, fields: Vec::new(), body: BodyMotion::REST }
    }

    /// Prepares what does not depend on the point: the motion of the body, and every patch's field. Patches beyond [`MAX_PARTS`] are left out.
    pub fn prepare(&mut self, surface: &Surface<'_>) {
        let Surface { model, params, patches, p_wp, body } = *surface;
        let patches = patches.get(..MAX_PARTS).unwrap_or(patches);
        self.base = model.base();
        self.fields.clear();
        if body {
            self.body.prepare(model, patches);
        } else {
            self.body.stop();
        }
        for patch in patches {
            let Some(field) = Field::new(model, params, patch) else { continue };
            let paper = match params.tier {
                Tier::Paper => paper::Twist::new(model, params, patch, p_wp),
                _ => paper::Twist::None,
            };
            // as many patches as there is room for
            let _ = self.fields.push((field.held_against(&self.body, patch), paper));
        }
    }

    /// Displacement \[m\], in world, of the rest surface point `p_w`.
    pub fn displacement(&self, p_w: Vec3) -> Vec3 {
        let mut moved = [Vec3::ZERO];
        self.update(&[p_w], &mut moved);
        moved[0]
    }

    /// Displacements of all `rest` points. The shorter slice bounds the work.
    pub fn update(&self, rest: &[Vec3], moved: &mut [Vec3]) {
        for (rest, moved) in rest.chunks(BLOCK).zip(moved.chunks_mut(BLOCK)) {
            let mut block = Block::load(rest);
            self.body.add(&mut block);
            for (k, (field, paper)) in self.fields.iter().enumerate() {
                self.body.add_field(k, field, &mut block);
                paper.add(field.frame.base, field.frame.height, &mut block);
            }
            block.store(self.base, rest.len(), moved);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Pose;
    use crate::model::{Material, ModelSpec, ObjectShape, ProbePart, ProbeShape};
    use crate::params::ParamsSpec;
    use crate::{Input, Quat, Scratch, State, step};

    /// Presses a ball to 2 mm, drags it 0.3 mm and turns it by 0.2 rad, then hands the surface to `look`.
    fn after_a_mixed_motion(object: ObjectShape<'_>, tier: Tier, look: impl Fn(&Surface<'_>)) {
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

    fn prepared(surface: &Surface<'_>) -> Prepared {
        // what another surface left is of no matter
        let mut prepared = Prepared::new();
        prepared.prepare(&Surface { patches: &[], ..*surface });
        prepared.prepare(surface);
        prepared
    }

    const SHAPES: [ObjectShape<'_>; 5] = [
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
                let (base, surface) = (surface.model.fixed_below, prepared(surface));
                if top > 0.0 {
                    let held = Vec3::new(0.03, 0.01, base);
                    assert_eq!(surface.displacement(held), Vec3::ZERO, "{object:?} {tier:?}");
                }
                // along a slanted way from the patch to the base, and across the top
                for (from, to) in [
                    (Vec3::new(0.01, 0.0, top), Vec3::new(0.05, 0.01, top - 0.1)),
                    (Vec3::new(-0.05, 0.0, top), Vec3::new(0.05, 1.0e-3, top)),
                ] {
                    const STEPS: usize = 5_000;
                    let rest: [Vec3; STEPS] = core::array::from_fn(|i| from + (to - from) * (i as f32 / STEPS as f32));
                    let mut moved = [Vec3::ZERO; STEPS];
                    surface.update(&rest, &mut moved);
                    for (i, pair) in moved.windows(2).enumerate() {
                        assert!(pair[1].is_finite(), "{object:?} {tier:?} {i}");
                        assert!((pair[1] - pair[0]).length() < 4.0e-5, "{object:?} {tier:?} {i}: {} {}", pair[0], pair[1]);
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
            let prepared = prepared(surface);
            [0..32, 32..64, 64..100].into_iter().for_each(|block| prepared.update(&rest[block.clone()], &mut parts[block]));
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

    #[test]
    fn a_twist_turned_back_leaves_a_ring_where_the_tier_remembers() {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, material, &ball)).unwrap();
        let params = Params::new(&ParamsSpec { tier: Tier::Point, ..ParamsSpec::default() }).unwrap();
        let (mut state, mut scratch) = (State::<2, 64>::new(), Scratch::<2>::new());
        let place = Vec3::new(0.0, 0.0, 0.018);
        // loaded to 0.3 rad and back until nothing is held: by Masing's rule the patch then still is turned
        for i in 0..200 {
            let turn = if i < 100 { 0.003 * i as f32 } else { 0.3 - 0.003 * (i - 100) as f32 };
            let input = Input { pose: Pose::new(place, Quat::from_rotation_z(turn)), dt: 1.0e-2 };
            step(&model, &params, &mut state, &mut scratch, input);
            if i > 100 && state.patches()[0].grip.torque <= 0.0 {
                break;
            }
        }
        let patch = state.patches()[0];
        let surface = Surface { model: &model, params: &params, patches: &[patch], p_wp: place, body: true };
        let turn = |q: f32| surface.displacement(Vec3::X * (q * patch.footprint.radius)).y / (q * patch.footprint.radius);
        let fresh = patch.grip.torque.abs() / (16.0 / 3.0 * 1.0e6 * patch.footprint.radius.powi(3));
        assert!(turn(0.1) > 0.02 && turn(0.1) > 10.0 * fresh, "{} {fresh}", turn(0.1));
        assert!(turn(0.95) < 0.8 * turn(0.1), "{} {}", turn(0.95), turn(0.1));
        assert!(turn(8.0).abs() < 1.0e-3 * turn(0.1), "no torque, no far field: {}", turn(8.0));
    }

    #[test]
    fn extremes_stay_finite() {
        for (scale, nu, young) in [(1.0e-4, 0.0, 1.0e12), (1.0e-4, 0.5, 1.0e2), (500.0, 0.5, 1.0e12), (500.0, 0.0, 1.0e2)] {
            let material = Material { young_modulus: young, poisson_ratio: nu, density: 1100.0 };
            let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 * scale })];
            for object in [ObjectShape::Box { size: Vec3::splat(0.1 * scale) }, ObjectShape::Sphere { radius: 0.05 * scale }] {
                let model = Model::new(&ModelSpec::new(object, material, &ball)).unwrap();
                for (tier, friction_dynamic) in [(Tier::Point, 0.0), (Tier::Bristle, 10.0), (Tier::Paper, 0.7)] {
                    let params = Params::new(&ParamsSpec { tier, friction_dynamic, ..ParamsSpec::default() }).unwrap();
                    let (mut state, mut scratch) = (State::<2, 64>::new(), Scratch::<2>::new());
                    let place = |i: f32| Vec3::new(1.0e-3 * i, 0.0, 0.118) * scale;
                    for i in 0..10 {
                        let pose = Pose::new(place(i as f32), Quat::from_rotation_z(0.1 * i as f32));
                        step(&model, &params, &mut state, &mut scratch, Input { pose, dt: 1.0 });
                    }
                    let p_wp = place(9.0);
                    let surface = Surface { model: &model, params: &params, patches: state.patches(), p_wp, body: true };
                    let surface = prepared(&surface);
                    let centre = state.patches()[0].at_rest();
                    let rest: [Vec3; 600] = core::array::from_fn(|i| match i % 3 {
                        0 => Vec3::new(2.0e-4 * i as f32 - 0.05, 0.0, 0.1) * scale,
                        1 => centre + Vec3::X * (5.0e-8 * scale * (i - 1) as f32),
                        _ => Vec3::Z * (1.0e3 * i as f32),
                    });
                    let mut moved = [Vec3::ZERO; 600];
                    surface.update(&rest, &mut moved);
                    for (p, u) in rest.iter().zip(moved) {
                        assert!(u.is_finite() && u.length() < 0.1 * scale, "{scale} {nu} {young} {object:?} {tier:?} {p}: {u}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_build_gives_these_bits() {
        let digest = core::cell::Cell::new(0xcbf2_9ce4_8422_2325_u64);
        for (object, tier) in SHAPES.into_iter().flat_map(|o| [(o, Tier::Bristle), (o, Tier::Paper)]) {
            after_a_mixed_motion(object, tier, |surface| {
                let rest: [Vec3; 300] = core::array::from_fn(|i| {
                    Vec3::new(3.0e-4 * i as f32 - 0.04, 1.0e-4 * (i % 17) as f32, object.height() - 3.0e-4 * (i % 211) as f32)
                });
                let mut moved = [Vec3::ZERO; 300];
                surface.update(&rest, &mut moved);
                let bytes = moved.iter().flat_map(Vec3::to_array).flat_map(|x| x.to_bits().to_le_bytes());
                // FNV-1a
                let add = |digest: u64, byte: u8| (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                digest.set(bytes.fold(digest.get(), add));
            });
        }
        assert_eq!(digest.get(), 0xbb76_e9dc_1770_af80, "{:#x}", digest.get());
    }
}

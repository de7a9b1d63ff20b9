//! What loads along the surface and about the normal move at another patch's place: four discs at a time.
//!
//! The fields are those of [`Disc::at`], with the distance in space for that along the surface. Ten patches ask for ninety of them a tick.

use glam::Vec3;

use crate::green::kernel::{Disc, Load, Move, bent_drag, bent_twist};
use crate::lanes::{LANES, Lanes};
use crate::limits::MAX_PARTS;
use crate::math::{PI, max, min};
use crate::surface::local::{disc, disc_across, turned_disc};

/// Vectors side by side: x, y and z.
type Vectors = [Lanes; 3];

/// Blocks of four that the most patches fill.
const BLOCKS: usize = MAX_PARTS.div_ceil(LANES);

/// The discs of all patches, in their order, and their loads.
#[derive(Clone, Debug, Default)]
pub struct Discs {
    blocks: heapless::Vec<Four, BLOCKS>,
    /// Patches.
    len: usize,
    poisson: f32,
    base: f32,
    /// 1/(4 pi G) \[m^2/N\], and the same times 1 - 2 nu.
    unit: f32,
    sinking: f32,
    /// nu/(2 - nu).
    lateral: f32,
}

/// Four discs. Those that are missing have the radius of the first and no load.
#[derive(Clone, Copy, Debug)]
struct Four {
    centre: Vectors,
    normal: Vectors,
    radius: Lanes,
    height: Lanes,
    dragged: Lanes,
    turned: Lanes,
    curvature: Lanes,
    force: Vectors,
    torque: Lanes,
}

/// A place that discs move.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// At rest, in world \[m\].
    pub p_w: Vec3,
    /// Outward normal.
    pub normal: Vec3,
    /// Radius of the patch there \[m\]. Discs nearer than the sum of both radii move it as at that distance: two that overlap would otherwise move each other as much as
    /// themselves, and how they share a load would be open.
    pub radius: f32,
    /// Which patch it is: its own disc is left out.
    pub index: usize,
}

impl Discs {
    /// No discs.
    pub const fn new() -> Self {
        Self { blocks: heapless::Vec::new(), len: 0, poisson: 0.0, base: 0.0, unit: 0.0, sinking: 0.0, lateral: 0.0 }
    }

    /// Forgets all discs.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.len = 0;
    }

    /// Takes up the disc of the next patch and its load.
    pub fn push(&mut self, disc: &Disc, load: &Load) {
        let (block, lane) = (self.len / LANES, self.len % LANES);
        if lane == 0 {
            (self.poisson, self.base, self.lateral) = (disc.poisson, disc.base, disc.lateral);
            (self.unit, self.sinking) = (disc.unit, disc.unit * disc.sinking);
            let _ = self.blocks.push(Four::all(disc));
        }
        if let Some(four) = self.blocks.get_mut(block) {
            four.set(lane, disc);
            four.load(lane, load);
        }
        self.len += 1;
    }

    /// Sets the load of patch `i`.
    pub fn load(&mut self, i: usize, load: &Load) {
        if let Some(four) = self.blocks.get_mut(i / LANES) {
            four.load(i % LANES, load);
        }
    }

    /// What the other patches' discs move at a place, and turn about its normal.
    pub fn drawn(&self, place: &Place) -> Move {
        let mut sum = Move::default();
        for (block, four) in self.blocks.iter().enumerate() {
            let mut counts = Lanes::splat(1.0);
            if let Some(own) = place.index.checked_sub(LANES * block).and_then(|lane| counts.0.get_mut(lane)) {
                *own = 0.0;
            }
            sum = sum + self.of_four(four, place, counts);
        }
        sum
    }

    /// What those of four discs that count move.
    #[inline(never)]
    fn of_four(&self, four: &Four, place: &Place, counts: Lanes) -> Move {
        let (p, n) = (place.p_w, [place.normal.x, place.normal.y, place.normal.z]);
        let offset = [p.x - four.centre[0], p.y - four.centre[1], p.z - four.centre[2]];
        let rise = dot(&offset, &four.normal);
        let level = [offset[0] - four.normal[0] * rise, offset[1] - four.normal[1] * rise, offset[2] - four.normal[2] * rise];
        let distance = dot(&offset, &offset).roots().larger(four.radius + Lanes::splat(place.radius));
        let near = Lanes::splat(1.0) / distance;
        let [along, across, swirl] = self.fields(four, distance, near);
        let ahead = dot(&level, &four.force) * near * near;
        let (out, sinks, hoop) = (across * ahead, ahead * self.sinking, swirl * four.torque);
        let around = cross(&four.normal, &level);
        let fade = fade(p.z - self.base, four.height) * counts;
        let shift: [Lanes; 3] =
            core::array::from_fn(|i| (four.force[i] * along + level[i] * out - four.normal[i] * sinks + around[i] * hoop) * fade);
        let spun = cross(&four.force, &offset);
        let spin = spun[0] * n[0] + spun[1] * n[1] + spun[2] * n[2];
        let facing = four.normal[0] * n[0] + four.normal[1] * n[1] + four.normal[2] * n[2];
        let turn = (spin - four.torque * facing * 0.5) * (near * near * near) * fade * self.unit;
        Move { shift: Vec3::new(shift[0].total(), shift[1].total(), shift[2].total()), turn: turn.total() }
    }

    /// Displacement along a force and, per place ahead, across it \[m/N\], and around a torque per arm \[1/(N m)\].
    fn fields(&self, four: &Four, distance: Lanes, near: Lanes) -> [Lanes; 3] {
        let [straight, across, turned] = around(four.radius * near);
        let across = across * self.lateral;
        let (mut along, mut swirl) = (four.dragged * (straight - across), four.turned * turned);
        if four.curvature != Lanes::default() {
            self.bend(four, distance, &mut along, &mut swirl);
        }
        [along, four.dragged * across * 2.0, swirl]
    }

    /// What the curvature of the object makes of them.
    fn bend(&self, four: &Four, distance: Lanes, along: &mut Lanes, swirl: &mut Lanes) {
        let figures = four.curvature.0.into_iter().zip(distance.0).zip(four.radius.0);
        for (((curvature, d), radius), (along, swirl)) in figures.zip(along.0.iter_mut().zip(&mut swirl.0)) {
            *along += bent_drag(curvature, self.poisson, max(d, radius)) * 2.0 * PI * self.unit;
            *swirl *= bent_twist(curvature, radius, d);
        }
    }
}

impl Four {
    /// Four times the same disc without a load.
    fn all(disc: &Disc) -> Self {
        let splat = |v: Vec3| [Lanes::splat(v.x), Lanes::splat(v.y), Lanes::splat(v.z)];
        Self {
            centre: splat(disc.centre),
            normal: splat(disc.normal),
            radius: Lanes::splat(disc.radius),
            height: Lanes::splat(disc.height),
            dragged: Lanes::splat(disc.dragged),
            turned: Lanes::splat(disc.turned),
            curvature: Lanes::splat(disc.curvature),
            force: [Lanes::default(); 3],
            torque: Lanes::default(),
        }
    }

    fn set(&mut self, lane: usize, disc: &Disc) {
        put(&mut self.centre, lane, disc.centre);
        put(&mut self.normal, lane, disc.normal);
        let figures = [disc.radius, disc.height, disc.dragged, disc.turned, disc.curvature];
        let Self { radius, height, dragged, turned, curvature, .. } = self;
        for (lanes, figure) in [radius, height, dragged, turned, curvature].into_iter().zip(figures) {
            lanes.0[lane % LANES] = figure;
        }
    }

    fn load(&mut self, lane: usize, load: &Load) {
        put(&mut self.force, lane, load.force);
        self.torque.0[lane % LANES] = load.torque;
    }
}

/// Sets one of four vectors.
fn put(vectors: &mut Vectors, lane: usize, v: Vec3) {
    for (lanes, figure) in vectors.iter_mut().zip([v.x, v.y, v.z]) {
        lanes.0[lane % LANES] = figure;
    }
}

/// 1 at a disc of this `height` above the base, 0 for a place at the base, `above` it by so much, and level at the disc.
fn fade(above: f32, height: Lanes) -> Lanes {
    let share = Lanes::splat(max(above, 0.0)) / height;
    let rest = Lanes(share.0.map(|share| 1.0 - min(share, 1.0)));
    Lanes::splat(1.0) - rest * rest
}

/// `disc`, `disc_across` and `turned_disc` at the radius over the distance `s`.
#[inline]
fn around(s: Lanes) -> [Lanes; 3] {
    let s2 = s * s;
    let cubic = |[a, b, c, d]: [f32; 4]| a + s2 * (b + s2 * (c + s2 * d));
    let series = [s * cubic(DISC), s * cubic(DISC_ACROSS), s * s2 * cubic(TURNED)];
    if s.0.iter().all(|&s| s <= SERIES) { series } else { around_near(s, &series) }
}

/// The same where one of them is near, from the series for those that are not.
#[inline(never)]
fn around_near(s: Lanes, series: &[Lanes; 3]) -> [Lanes; 3] {
    let exact: [fn(f32) -> f32; 3] = [disc, disc_across, turned_disc];
    core::array::from_fn(|i| {
        let one = |s: f32, far: f32| if s > SERIES { exact[i](1.0 / s) } else { far };
        let ([a, b, c, d], [e, f, g, h]) = (s.0, series[i].0);
        Lanes([one(a, e), one(b, f), one(c, g), one(d, h)])
    })
}

/// Coefficients of s, s^3, s^5, s^7 in `disc` and `disc_across`, and of s^3, s^5, s^7, s^9 in `turned_disc`.
const DISC: [f32; 4] = [2.0 / PI, 1.0 / (3.0 * PI), 3.0 / (20.0 * PI), 5.0 / (56.0 * PI)];
const DISC_ACROSS: [f32; 4] = [2.0 / PI, -1.0 / PI, -1.0 / (4.0 * PI), -1.0 / (8.0 * PI)];
const TURNED: [f32; 4] = [4.0 / (3.0 * PI), 2.0 / (5.0 * PI), 3.0 / (14.0 * PI), 5.0 / (36.0 * PI)];

/// Radius over distance up to which the series are good to 1e-4: what patches that do not overlap are apart, where they are alike.
const SERIES: f32 = 0.5;

fn dot(a: &Vectors, b: &Vectors) -> Lanes {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &Vectors, b: &Vectors) -> Vectors {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{cos, direction, perpendicular, sin};
    use crate::model::{Material, Model, ModelSpec, ObjectShape, ProbePart, ProbeShape};

    /// One after the other by the forms of a single disc, which agree with these in its plane.
    #[test]
    fn ten_discs_move_a_place_as_one_after_the_other_does() {
        let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];
        for (nu, object_radius, slant) in [(0.3, f32::INFINITY, 0.4), (0.0, 0.08, 0.9), (0.5, 0.2, 0.0)] {
            let material = Material { young_modulus: 3.0e6, poisson_ratio: nu, density: 1100.0 };
            let cube = ObjectShape::Box { size: Vec3::splat(0.2) };
            let model = Model::new(&ModelSpec::new(cube, material, &ball)).unwrap();
            let normal = direction(Vec3::new(slant, -0.5 * slant, 1.0), Vec3::Z);
            let (e1, place_normal) = (perpendicular(normal), direction(Vec3::new(0.7, 0.2, 0.3), Vec3::Z));
            let e2 = normal.cross(e1);
            let at = |i: usize| {
                let (angle, far) = (2.4 * i as f32, 0.004 + 0.003 * i as f32);
                Vec3::Z * 0.15 + e1 * (far * cos(angle)) + e2 * (far * sin(angle))
            };
            let radius = |i: usize| 0.0015 + 4.0e-4 * (i % 3) as f32;
            let load =
                |i: usize| Load { force: e1 * sin(i as f32) + e2 * cos(1.7 * i as f32), torque: 0.003 * sin(2.0 * i as f32) };
            let discs: [Disc; 10] = core::array::from_fn(|i| Disc::new(&model, at(i), normal, radius(i), object_radius));
            let mut four = Discs::new();
            for (i, disc) in discs.iter().enumerate() {
                four.push(disc, &Load { force: Vec3::ZERO, torque: 0.0 });
                four.load(i, &load(i));
            }
            for index in 0..discs.len() {
                let place = Place { p_w: at(index), normal: place_normal, radius: radius(index), index };
                let found = four.drawn(&place);
                let others = discs.iter().enumerate().filter(|(i, _)| *i != index);
                let each = |(i, disc): (usize, &Disc)| disc.at(&load(i), place.p_w, place_normal, radius(index) + radius(i));
                let want = others.map(each).fold(Move::default(), |sum, one| sum + one);
                let off = (found.shift - want.shift).length() / want.shift.length();
                assert!(off < 5.0e-4, "nu {nu}, place {index}: {found:?} {want:?}");
                assert!(
                    (found.turn - want.turn).abs() < 1.0e-3 * want.turn.abs() + 1.0e-7,
                    "nu {nu}, place {index}: {found:?} {want:?}"
                );
            }
        }
    }
}

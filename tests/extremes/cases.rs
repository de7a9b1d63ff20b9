//! Random corners of the whole box: a case from a seed.
//!
//! A case is drawn in the middle of the box, where an f32 has digits to spare, and then multiplied by powers of two to its corner: 2^`lengths` and 2^`moduli`. Meshes keep
//! their own sizes.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::{Arc, LazyLock};

use fastrand::Rng;
use glam::{Quat, Vec3};
use haptor_contact::geometry::gap::deepest_meaningful;
use haptor_contact::{
    Breakaway, GuardSpec, MAX_PARTS, MAX_REGIONS, Material, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Tier,
};

use super::bodies::{BODY, CUBE, OwnGreen, STUFF, object_mesh, probe_mesh};
use super::rig::Scene;

/// The box: lengths \[m\] and moduli \[Pa\].
pub const LENGTHS: (f32, f32) = (1.0e-6, 1.0e2);
/// See [`LENGTHS`].
pub const MODULI: (f32, f32) = (1.0e2, 1.0e12);

/// Size of a twin's probe \[m\].
const MIDDLE: f32 = 0.015_625;

/// Least depth of the box \[m\].
const LEAST_DEPTH: f32 = 1.0e-12;

/// Which tier a case is for, as places in [`Tier::ALL`]: the dear ones less often.
const SHARES: [usize; 16] = [0, 0, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2, 3, 3, 4];

/// The table of every twin in tier `green`.
static OWN: LazyLock<Arc<OwnGreen>> = LazyLock::new(|| Arc::new(OwnGreen::scaled(1.0, 1.0)));

/// A random scene, and where its probe begins.
#[derive(Clone, Debug)]
pub struct Case {
    /// The seed that makes it again.
    pub seed: u64,
    /// The scene in the middle of the box.
    pub twin: Scene,
    /// Turn of the probe.
    pub rotation: Quat,
    /// Side from which the object is touched, seen from its middle.
    pub side: Vec3,
    /// Size of the probe in the twin \[m\].
    pub size: f32,
    /// Depth in the twin that the case asks for \[m\].
    pub depth: f32,
    /// Power of two of the lengths.
    pub lengths: i32,
    /// Power of two of the moduli.
    pub moduli: i32,
}

impl Case {
    /// The case of a seed.
    pub fn new(seed: u64) -> Self {
        let mut rng = Rng::with_seed(seed);
        let tier = Tier::ALL[SHARES[rng.usize(..SHARES.len())]];
        let mut size = MIDDLE;
        let object = any_object(&mut rng, &mut size, tier);
        let parts = any_probe(&mut rng, &mut size, object);
        let (mut lengths, moduli) = exponents(&mut rng, object, &parts);
        let has_mesh = is_mesh_object(object) || parts.iter().any(|part| matches!(part.shape, ProbeShape::Mesh(_)));
        if has_mesh {
            lengths = 0;
        }
        let own =
            Material { young_modulus: 2.0_f32.powf(rng.f32()) * 2_097_152.0, poisson_ratio: any_nu(&mut rng), density: 1.0e3 };
        let material = if tier == Tier::Green { STUFF } else { own };
        let green = (tier == Tier::Green).then(|| Arc::clone(&OWN));
        let params = any_params(&mut rng, tier, size);
        let twin = Scene { object, material, parts, green, mass: 1.0, paper_length: 0.125, compliance: None, params };
        let thin = twin.parts.iter().map(|part| thickness(&part.shape)).fold(deepest_meaningful(&twin.object), f32::min);
        let least = LEAST_DEPTH / 2.0_f32.powi(lengths);
        let shallowest = if rng.u8(..4) == 0 { -9.0 } else { -4.0 };
        let depth = (thin * decades(&mut rng, shallowest, 0.0)).max(least);
        Self { seed, twin, rotation: any_rotation(&mut rng), side: any_side(&mut rng), size, depth, lengths, moduli }
    }

    /// Random choices for what is done to the case, apart from those that made it.
    pub fn choices(&self) -> Rng {
        Rng::with_seed(self.seed ^ 0x9e37_79b9_7f4a_7c15)
    }

    /// The scene at its corner of the box.
    pub fn corner(&self) -> Scene {
        let (length, modulus) = (self.length(), 2.0_f32.powi(self.moduli));
        let twin = &self.twin;
        let parts = twin.parts.iter().map(|part| ProbePart {
            shape: scaled_part(part.shape, length),
            position: part.position * length,
            rotation: part.rotation,
        });
        Scene {
            object: scaled_object(twin.object, length),
            material: Material { young_modulus: twin.material.young_modulus * modulus, ..twin.material },
            parts: parts.collect(),
            green: twin.green.as_ref().map(|_| Arc::new(OwnGreen::scaled(length, modulus))),
            paper_length: (twin.paper_length * length).clamp(LENGTHS.0, LENGTHS.1),
            params: ParamsSpec { region_distance: (twin.params.region_distance * length).min(LENGTHS.1), ..twin.params },
            ..*twin
        }
    }

    /// How many times longer than in the dearest tiers a session is: a tick of a cheap one tells as much.
    pub fn longer(&self) -> u32 {
        match self.twin.params.tier {
            Tier::Point => 4,
            Tier::Paper | Tier::Bristle => 2,
            Tier::Influence | Tier::Green => 1,
        }
    }

    /// Metres of the corner per metre of the twin.
    pub fn length(&self) -> f32 {
        2.0_f32.powi(self.lengths)
    }

    /// True when the twin is the corner in other units, to the bit: meshes have a size of their own, and what is clamped at the end of a range is no longer the same.
    pub fn is_twinned(&self) -> bool {
        let kept = self.twin.paper_length * self.length();
        (LENGTHS.0..=LENGTHS.1).contains(&kept) && self.twin.params.region_distance * self.length() <= LENGTHS.1
    }
}

fn is_mesh_object(object: ObjectShape<'_>) -> bool {
    matches!(object, ObjectShape::Mesh(_))
}

/// Log-uniform between powers of ten.
pub fn decades(rng: &mut Rng, low: f32, high: f32) -> f32 {
    10.0_f32.powf(low + (high - low) * rng.f32())
}

/// Uniform between `low` and `high`.
pub fn between(rng: &mut Rng, low: f32, high: f32) -> f32 {
    low + (high - low) * rng.f32()
}

/// A vector of the cube from -1 to 1.
pub fn any_vector(rng: &mut Rng) -> Vec3 {
    Vec3::new(between(rng, -1.0, 1.0), between(rng, -1.0, 1.0), between(rng, -1.0, 1.0))
}

/// Poisson's ratio, its ends as often as all between.
fn any_nu(rng: &mut Rng) -> f32 {
    match rng.u8(..4) {
        0 => 0.0,
        1 => 0.5,
        _ => 0.5 * rng.f32(),
    }
}

fn extents(rng: &mut Rng, size: f32) -> Vec3 {
    let level = rng.u8(..3) == 0;
    let mut one = || size * between(rng, 0.2, 1.0);
    if level { Vec3::splat(one()) } else { Vec3::new(one(), one(), one()) }
}

fn any_object(rng: &mut Rng, size: &mut f32, tier: Tier) -> ObjectShape<'static> {
    if tier == Tier::Green {
        *size = CUBE * decades(rng, -1.5, 0.0);
        return BODY;
    }
    let ratio = if rng.u8(..8) == 0 { decades(rng, -3.0, 3.0) } else { decades(rng, -1.0, 1.0) };
    let e = extents(rng, *size * ratio);
    match rng.u8(..40) {
        0..10 => ObjectShape::HalfSpace,
        10..19 => ObjectShape::Box { size: e },
        19..26 => ObjectShape::Sphere { radius: e.x },
        26..32 => ObjectShape::Ellipsoid { semi_axes: e },
        32..39 => ObjectShape::Cylinder { radius: e.x, height: e.y },
        _ => {
            let (object, own) = object_mesh(rng.usize(..));
            *size = own * between(rng, 0.3, 1.0);
            object
        }
    }
}

fn any_part(rng: &mut Rng, size: f32, object: ObjectShape<'static>) -> ProbeShape<'static> {
    let e = extents(rng, size);
    // surfaces that coincide with the object's
    if rng.u8(..12) == 0 {
        match object {
            ObjectShape::Box { size } => return ProbeShape::Box { size },
            ObjectShape::Sphere { radius } => return ProbeShape::Sphere { radius },
            ObjectShape::Ellipsoid { semi_axes } => return ProbeShape::Ellipsoid { semi_axes },
            ObjectShape::Cylinder { radius, height } => return ProbeShape::Cylinder { radius, height },
            ObjectShape::HalfSpace | ObjectShape::Mesh(_) => {}
        }
    }
    match rng.u8(..7) {
        0 | 1 => ProbeShape::Sphere { radius: e.x },
        2 => ProbeShape::Box { size: e },
        3 => ProbeShape::Cylinder { radius: e.x, height: e.y },
        4 => ProbeShape::Cone { radius: e.x, height: e.y },
        5 => ProbeShape::Capsule { radius: e.x, height: e.y },
        _ => ProbeShape::Ellipsoid { semi_axes: e },
    }
}

/// One part mostly, up to all there may be; one probe in forty is a mesh.
fn any_probe(rng: &mut Rng, size: &mut f32, object: ObjectShape<'static>) -> Vec<ProbePart<'static>> {
    if rng.u8(..40) == 0 {
        let (shape, own) = probe_mesh(rng.usize(..));
        let fits = match object {
            ObjectShape::HalfSpace => true,
            _ => (0.1..10.0).contains(&(own / *size)),
        };
        if fits {
            *size = own;
            return vec![ProbePart::at_origin(shape)];
        }
    }
    if rng.u8(..8) > 0 {
        return vec![ProbePart::at_origin(any_part(rng, *size, object))];
    }
    let (count, spread) = (rng.usize(2..=MAX_PARTS), *size * decades(rng, -1.0, 1.0));
    (0..count)
        .map(|_| ProbePart {
            shape: any_part(rng, *size, object),
            position: any_vector(rng) * spread * Vec3::new(1.0, 1.0, 0.1),
            rotation: any_rotation(rng),
        })
        .collect()
}

/// Powers of two that keep every length and the modulus within the box; the ends as often as all between.
fn exponents(rng: &mut Rng, object: ObjectShape<'static>, parts: &[ProbePart<'static>]) -> (i32, i32) {
    let mut lengths: Vec<f32> = parts.iter().flat_map(|part| part_lengths(&part.shape)).collect();
    lengths.extend(object_lengths(&object));
    let (least, most) = lengths.iter().fold((f32::MAX, 0.0_f32), |(a, b), &x| (a.min(x), b.max(x)));
    let (low, high) = ((LENGTHS.0 / least).log2().ceil() as i32, (LENGTHS.1 / most).log2().floor() as i32);
    let mut pick = |low: i32, high: i32| match rng.u8(..4) {
        0 => low,
        1 => high,
        _ => rng.i32(low.min(high)..=low.max(high)),
    };
    let (low_e, high_e) = ((MODULI.0 / 2_097_152.0).log2().ceil() as i32, (MODULI.1 / 4_194_304.0).log2().floor() as i32);
    (pick(low, high.max(low)), pick(low_e, high_e))
}

fn any_params(rng: &mut Rng, tier: Tier, size: f32) -> ParamsSpec {
    let mu = match rng.u8(..5) {
        0 => 0.0,
        1 => 10.0,
        _ => decades(rng, -3.0, 1.0),
    };
    let mu_d = if rng.bool() { mu } else { mu * rng.f32() };
    let samples = match tier {
        Tier::Point => 64,
        Tier::Paper => rng.usize(16..=256),
        Tier::Bristle => [16, 32, 64, 64, 256][rng.usize(..5)],
        Tier::Influence | Tier::Green => [52, 52, 52, 112][rng.usize(..4)],
    };
    ParamsSpec {
        friction_static: Some(mu),
        friction_dynamic: mu_d,
        region_distance: size * decades(rng, -3.0, 0.0),
        max_regions: if rng.bool() { MAX_REGIONS } else { rng.usize(1..=MAX_REGIONS) },
        tier,
        samples,
        sweeps: [1, 4, 4, 8][rng.usize(..4)],
        breakaway: if rng.bool() { Breakaway::Smooth } else { Breakaway::Sharp },
        guard: GuardSpec::OPEN,
        ..ParamsSpec::default()
    }
}

/// Level, tilted at random, or level to a hair.
pub fn any_rotation(rng: &mut Rng) -> Quat {
    match rng.u8(..6) {
        0 => Quat::IDENTITY,
        1 => Quat::from_rotation_x(FRAC_PI_2),
        2 => Quat::from_rotation_y(PI),
        3 => Quat::from_scaled_axis(any_vector(rng) * 1.0e-4).normalize(),
        _ => Quat::from_scaled_axis(any_vector(rng) * PI).normalize(),
    }
}

/// The top mostly; faces, edges, corners; anywhere above the lower third.
fn any_side(rng: &mut Rng) -> Vec3 {
    let v = match rng.u8(..4) {
        0 => Vec3::Z,
        1 => Vec3::new(f32::from(rng.i8(-1..=1)), f32::from(rng.i8(-1..=1)), f32::from(rng.i8(0..=1))),
        _ => Vec3::new(between(rng, -1.0, 1.0), between(rng, -1.0, 1.0), between(rng, -0.3, 1.0)),
    };
    if v.length() > 1.0e-3 { v.normalize() } else { Vec3::Z }
}

/// Smallest extent of a shape from its surface inwards \[m\].
pub fn thickness(shape: &ProbeShape<'_>) -> f32 {
    match *shape {
        ProbeShape::Sphere { radius } | ProbeShape::Capsule { radius, .. } => radius,
        ProbeShape::Box { size } => 0.5 * size.min_element(),
        ProbeShape::Cylinder { radius, height } => radius.min(0.5 * height),
        ProbeShape::Cone { radius, height } => 0.3 * radius.min(height),
        ProbeShape::Ellipsoid { semi_axes } => semi_axes.min_element(),
        ProbeShape::Mesh(mesh) => mesh.grid().inmost(),
    }
}

fn part_lengths(shape: &ProbeShape<'_>) -> Vec<f32> {
    match *shape {
        ProbeShape::Sphere { radius } => vec![radius],
        ProbeShape::Box { size: v } | ProbeShape::Ellipsoid { semi_axes: v } => v.to_array().to_vec(),
        ProbeShape::Cylinder { radius, height }
        | ProbeShape::Cone { radius, height }
        | ProbeShape::Capsule { radius, height } => {
            vec![radius, height]
        }
        ProbeShape::Mesh(_) => vec![MIDDLE],
    }
}

fn object_lengths(object: &ObjectShape<'_>) -> Vec<f32> {
    match *object {
        ObjectShape::HalfSpace | ObjectShape::Mesh(_) => vec![MIDDLE],
        ObjectShape::Sphere { radius } => vec![radius],
        ObjectShape::Box { size: v } | ObjectShape::Ellipsoid { semi_axes: v } => v.to_array().to_vec(),
        ObjectShape::Cylinder { radius, height } => vec![radius, height],
    }
}

fn scaled_part(shape: ProbeShape<'static>, s: f32) -> ProbeShape<'static> {
    match shape {
        ProbeShape::Sphere { radius } => ProbeShape::Sphere { radius: radius * s },
        ProbeShape::Box { size } => ProbeShape::Box { size: size * s },
        ProbeShape::Cylinder { radius, height } => ProbeShape::Cylinder { radius: radius * s, height: height * s },
        ProbeShape::Cone { radius, height } => ProbeShape::Cone { radius: radius * s, height: height * s },
        ProbeShape::Capsule { radius, height } => ProbeShape::Capsule { radius: radius * s, height: height * s },
        ProbeShape::Ellipsoid { semi_axes } => ProbeShape::Ellipsoid { semi_axes: semi_axes * s },
        ProbeShape::Mesh(_) => shape,
    }
}

fn scaled_object(object: ObjectShape<'static>, s: f32) -> ObjectShape<'static> {
    match object {
        ObjectShape::HalfSpace | ObjectShape::Mesh(_) => object,
        ObjectShape::Box { size } => ObjectShape::Box { size: size * s },
        ObjectShape::Sphere { radius } => ObjectShape::Sphere { radius: radius * s },
        ObjectShape::Ellipsoid { semi_axes } => ObjectShape::Ellipsoid { semi_axes: semi_axes * s },
        ObjectShape::Cylinder { radius, height } => ObjectShape::Cylinder { radius: radius * s, height: height * s },
    }
}

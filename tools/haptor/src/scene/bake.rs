//! From the scene file to the baked scene that the host reads.

use haptor_contact::geometry::support::support;
use haptor_contact::{Breakaway, ForceLaw, GuardSpec, ObjectShape, ProbePart, ProbeShape, SurfaceSample, Vec3};
use haptor_engine::settings::tier_to_wire;
use haptor_mesh::Baked;
use haptor_wire as wire;
use haptor_wire::{BakedScene, Place, ProbeParts};

use super::{Scene, Skin};

/// Gap between probe and object where a session starts \[m\]: clear of contact, a short way to go.
const HOVER: f32 = 0.005;

impl Scene {
    /// Everything the host needs, with the device placed so that its origin puts the probe 5 mm above the object.
    ///
    /// # Errors
    /// In words, what the scene holds that the host does not take.
    pub fn bake(&self) -> Result<BakedScene, String> {
        let (spec, params, material) = (self.model_spec(), &self.params, &self.object.material);
        Ok(BakedScene {
            object: object_shape(self.object.shape),
            fixed_below: self.object.fixed_below.unwrap_or(self.object.shape.default_fixed_below()),
            young_modulus: material.young_modulus,
            poisson_ratio: material.poisson_ratio,
            density: material.density,
            compliance: self.object.compliance.map(|c| wire::Compliance { normal: c.normal, drag: c.drag, twist: c.twist }),
            probe: parts(&self.probe.parts, self.object.skin.iter().count())?,
            mass: self.probe.mass,
            inertia: self.probe.inertia.map(|i| wire::Inertia { moments: i.moments.to_array(), products: i.products.to_array() }),
            friction_static: params.friction_static.unwrap_or(params.friction_dynamic),
            friction_dynamic: params.friction_dynamic,
            region_distance: params.region_distance,
            // at most 10 and 1024: the scene has been validated
            max_regions: params.max_regions as u8,
            tier: tier_to_wire(params.tier),
            samples: params.samples as u16,
            sweeps: self.extras.sweeps,
            deformation: self.extras.deformation,
            coupling: self.extras.coupling,
            breakaway: breakaway(params.breakaway),
            gravity: params.gravity,
            work: params.work,
            force_law: force_law(&params.force_law),
            guard: guard(&self.extras.asked),
            paper_length: spec.paper_length,
            place: Place { p_wd: self.hover().to_array(), q_wd: [1.0, 0.0, 0.0, 0.0] },
        })
    }

    /// Position of the unturned probe 5 mm above the object's top \[m\].
    fn hover(&self) -> Vec3 {
        Vec3::new(0.0, 0.0, self.touch_height() + HOVER)
    }

    /// Height of the unturned probe's origin when its lowest point is level with the object's top \[m\].
    pub fn touch_height(&self) -> f32 {
        let lowest = self.probe.parts.iter().map(lowest).fold(f32::INFINITY, f32::min);
        self.object.shape.height() - lowest
    }
}

/// Height of a part's lowest point in the probe's frame \[m\].
///
/// The support of a convex shape in direction -z, taken in the part's own frame: the part's lowest point is where its direction
/// towards the ground leaves it.
fn lowest(part: &ProbePart<'_>) -> f32 {
    let down = part.rotation.conjugate() * -Vec3::Z;
    let across = (down.x * down.x + down.y * down.y).sqrt();
    let reach = match part.shape {
        ProbeShape::Sphere { radius } => radius,
        ProbeShape::Box { size } => (0.5 * size * down.abs()).element_sum(),
        ProbeShape::Ellipsoid { semi_axes } => (semi_axes * down).length(),
        ProbeShape::Cylinder { radius, height } => radius * across + 0.5 * height * down.z.abs(),
        ProbeShape::Capsule { radius, height } => radius + 0.5 * height * down.z.abs(),
        ProbeShape::Cone { radius, height } => (-0.75 * height * down.z).max(radius * across + 0.25 * height * down.z),
        ProbeShape::Mesh(_) => support(&part.shape, down).dot(down),
    };
    part.position.z - reach
}

fn object_shape(shape: ObjectShape<'_>) -> wire::ObjectShape {
    match shape {
        ObjectShape::HalfSpace => wire::ObjectShape::HalfSpace,
        ObjectShape::Box { size } => wire::ObjectShape::Box { size: size.to_array() },
        ObjectShape::Sphere { radius } => wire::ObjectShape::Sphere { radius },
        ObjectShape::Ellipsoid { semi_axes } => wire::ObjectShape::Ellipsoid { semi_axes: semi_axes.to_array() },
        ObjectShape::Cylinder { radius, height } => wire::ObjectShape::Cylinder { radius, height },
        // the first of the scene's skins
        ObjectShape::Mesh(_) => wire::ObjectShape::Mesh { grid: 0 },
    }
}

/// The parts; the first that is a mesh has the skin number `first`.
fn parts(parts: &[ProbePart<'_>], first: usize) -> Result<ProbeParts, String> {
    let mut skins = first..;
    let converted: Vec<_> = parts.iter().map(|from| part(from, &mut skins)).collect();
    ProbeParts::from_slice(&converted)
        .ok_or_else(|| format!("probe.part: {} parts, the host takes {}", parts.len(), wire::scene::MAX_PARTS))
}

fn part(part: &ProbePart<'_>, skins: &mut impl Iterator<Item = usize>) -> wire::ProbePart {
    let q = part.rotation;
    wire::ProbePart { shape: probe_shape(part.shape, skins), position: part.position.to_array(), rotation: [q.w, q.x, q.y, q.z] }
}

fn probe_shape(shape: ProbeShape<'_>, skins: &mut impl Iterator<Item = usize>) -> wire::ProbeShape {
    match shape {
        ProbeShape::Sphere { radius } => wire::ProbeShape::Sphere { radius },
        ProbeShape::Box { size } => wire::ProbeShape::Box { size: size.to_array() },
        ProbeShape::Cylinder { radius, height } => wire::ProbeShape::Cylinder { radius, height },
        ProbeShape::Cone { radius, height } => wire::ProbeShape::Cone { radius, height },
        ProbeShape::Capsule { radius, height } => wire::ProbeShape::Capsule { radius, height },
        ProbeShape::Ellipsoid { semi_axes } => wire::ProbeShape::Ellipsoid { semi_axes: semi_axes.to_array() },
        // at most an object's and 16 parts'
        ProbeShape::Mesh(_) => wire::ProbeShape::Mesh { grid: skins.next().unwrap_or_default() as u8 },
    }
}

impl Skin {
    /// Contents of the section of kind [`GRID`](wire::sections::GRID) that carries the skin.
    pub fn contents(&self) -> Vec<u8> {
        grid_contents(self.baked)
    }
}

/// Contents of the section of kind [`GRID`](wire::sections::GRID) that carries a baked mesh.
pub fn grid_contents(baked: &Baked) -> Vec<u8> {
    let Baked { origin, spacing, counts, coefficients, samples, low, high, volume, reach, .. } = baked;
    // counts of 128 and 2048 at most: exact
    let counts = counts.map(|count| count as f32);
    let head = [
        &origin.to_array()[..],
        &[*spacing],
        &counts,
        &low.to_array(),
        &high.to_array(),
        &[*volume, *reach, samples.len() as f32],
    ];
    let sample = |s: &SurfaceSample| [s.position.to_array(), s.normal.to_array()].concat().into_iter().chain([s.area]);
    let numbers = head.concat().into_iter().chain(coefficients.iter().copied()).chain(samples.iter().flat_map(sample));
    numbers.flat_map(f32::to_le_bytes).collect()
}

fn breakaway(breakaway: Breakaway) -> wire::Breakaway {
    match breakaway {
        Breakaway::Smooth => wire::Breakaway::Smooth,
        Breakaway::Sharp => wire::Breakaway::Sharp,
    }
}

fn force_law(law: &ForceLaw) -> wire::ForceLaw {
    match *law {
        ForceLaw::Hertz => wire::ForceLaw::Hertz,
        ForceLaw::Cubic { k1, k3 } => wire::ForceLaw::Cubic { k1, k3 },
        ForceLaw::Table { step, force } => wire::ForceLaw::Table { step, force },
    }
}

fn guard(asked: &GuardSpec) -> wire::GuardLimits {
    let GuardSpec { max_force, max_torque, max_force_rate, max_torque_rate, ramp_in, passivity } = *asked;
    let passivity = passivity.map(|p| wire::Passivity {
        max_damping: p.max_damping,
        max_spin_damping: p.max_spin_damping,
        allowance: p.allowance,
        reserve: p.reserve,
        // at most 8: the scene has been validated
        delay_ticks: p.delay_ticks as u8,
    });
    wire::GuardLimits { max_force, max_torque, max_force_rate, max_torque_rate, ramp_in, passivity }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use haptor_contact::Quat;

    use super::*;

    const SCENE: &str = "object = { shape = 'half_space', young_modulus = 3e6, poisson_ratio = 0.5, density = 1100 }\n\
        probe = { shape = 'sphere', radius = 0.02, mass = 1 }\nfriction = { dynamic = 0.75 }\n";

    fn baked(more: &str) -> BakedScene {
        Scene::parse("s.toml", &format!("{SCENE}{more}")).unwrap().bake().unwrap()
    }

    #[test]
    fn a_scene_s_limits_and_force_law_reach_the_host_and_what_it_leaves_out_is_the_device_s() {
        let own = wire::GuardLimits::DEVICE_S_OWN;
        assert_eq!((baked("").guard, baked("").force_law), (own, wire::ForceLaw::Hertz));
        assert_eq!(
            baked("guard = { max_force = 3, ramp_in = 0 }").guard,
            wire::GuardLimits { max_force: 3.0, ramp_in: 0.0, ..own }
        );
        assert_eq!(baked("guard = { max_force_rate = inf, max_torque = 1 }").guard, wire::GuardLimits { max_torque: 1.0, ..own });
        let cubic = baked("model = { force_law = { kind = 'cubic', k1 = 1e3, k3 = 2e9 } }").force_law;
        assert_eq!(cubic, wire::ForceLaw::Cubic { k1: 1.0e3, k3: 2.0e9 });
        let table = "model = { force_law = { kind = 'table', step = 1e-4, force = [0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15] } }";
        assert!(matches!(baked(table).force_law, wire::ForceLaw::Table { force, .. } if force[15] == 15.0));
    }

    #[test]
    fn a_coupling_reaches_the_host_as_far_as_the_scene_says_and_passivity_whole() {
        let own = wire::VirtualCoupling::DEVICE_S_OWN;
        assert_eq!(baked("").coupling, wire::Coupling::Direct);
        assert_eq!(baked("model = { coupling = 'virtual' }").coupling, wire::Coupling::Virtual(own));
        let more = "model = { coupling = 'virtual' }\ncoupling = { translational_stiffness = 500, rotational_damping = 0, max_force = 4 }";
        let given =
            wire::VirtualCoupling { translational_stiffness: Some(500.0), rotational_damping: Some(0.0), max_force: 4.0, ..own };
        assert_eq!(baked(more).coupling, wire::Coupling::Virtual(given));
        assert_eq!(baked("guard = { max_force = 3 }").guard.passivity, None);
        let core = wire::Passivity { max_damping: 5.0, max_spin_damping: 0.004, allowance: 1.0e-6, reserve: 0.1, delay_ticks: 2 };
        assert_eq!(baked("guard = { passivity = { delay_ticks = 2 } }").guard.passivity, Some(core));
    }

    #[test]
    fn the_core_and_the_wire_agree_on_what_a_scene_without_limits_means() {
        assert_eq!(GuardSpec::default().ramp_in, wire::GuardLimits::DEVICE_S_OWN.ramp_in);
    }

    #[test]
    fn the_lowest_point_of_each_shape_lying_and_standing() {
        let lying = Quat::from_rotation_x(FRAC_PI_2);
        let upside_down = Quat::from_rotation_x(2.0 * FRAC_PI_2);
        let (radius, height) = (0.01, 0.08);
        let size = Vec3::new(0.02, 0.04, 0.06);
        let table = [
            ("ball", ProbeShape::Sphere { radius }, lying, 0.01),
            ("box standing", ProbeShape::Box { size }, Quat::IDENTITY, 0.03),
            ("box lying", ProbeShape::Box { size }, lying, 0.02),
            ("ellipsoid lying", ProbeShape::Ellipsoid { semi_axes: size }, lying, 0.04),
            ("cylinder standing", ProbeShape::Cylinder { radius, height }, Quat::IDENTITY, 0.04),
            ("cylinder lying", ProbeShape::Cylinder { radius, height }, lying, 0.01),
            ("capsule standing", ProbeShape::Capsule { radius, height }, Quat::IDENTITY, 0.05),
            ("cone, tip down", ProbeShape::Cone { radius, height }, Quat::IDENTITY, 0.06),
            ("cone, tip up", ProbeShape::Cone { radius, height }, upside_down, 0.02),
            ("cone lying", ProbeShape::Cone { radius, height }, lying, 0.01),
        ];
        for (name, shape, rotation, reach) in table {
            let found = lowest(&ProbePart { shape, position: Vec3::new(0.0, 0.0, 0.5), rotation });
            assert!((found - (0.5 - reach)).abs() < 1e-6, "{name}: {found}");
        }
    }
}

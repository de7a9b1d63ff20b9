//! The scene that sessions run on.

use haptor_firmware_sim::script::CLEARANCE;
use haptor_wire::{
    BakedScene, Breakaway, Coupling, Deformation, ForceLaw, GuardLimits, ObjectShape, Place, ProbePart, ProbeParts, ProbeShape,
    Tier,
};

/// The ball on the rubber cube of the reference scenes; the device stands so that the ball hovers over the middle of the top.
pub fn ball_on_cube() -> BakedScene {
    let ball = ProbePart { shape: ProbeShape::Sphere { radius: 0.02 }, ..ProbePart::UNUSED };
    BakedScene {
        object: ObjectShape::Box { size: [0.1; 3] },
        fixed_below: 0.0,
        young_modulus: 3.0e6,
        poisson_ratio: 0.5,
        density: 1100.0,
        compliance: None,
        probe: ProbeParts::from_slice(&[ball]).expect("one part"),
        mass: 1.0,
        inertia: None,
        friction_static: 0.75,
        friction_dynamic: 0.75,
        region_distance: 0.004,
        max_regions: 10,
        tier: Tier::Bristle,
        samples: 64,
        sweeps: 4,
        deformation: Deformation::Full,
        coupling: Coupling::Direct,
        breakaway: Breakaway::Smooth,
        gravity: false,
        force_law: ForceLaw::Hertz,
        guard: GuardLimits::DEVICE_S_OWN,
        paper_length: 0.1,
        place: Place { p_wd: [0.0, 0.0, 0.12 + CLEARANCE], q_wd: [1.0, 0.0, 0.0, 0.0] },
    }
}

//! The scene to begin with: a ball in the hand on a body of the paper's rubber.

use crate::scene::{
    BakedScene, Breakaway, Coupling, Deformation, ForceLaw, GuardLimits, MAX_PARTS, ObjectShape, Place, ProbePart, ProbeParts,
    ProbeShape, Tier,
};

impl BakedScene {
    /// A ball of 20 mm and 1 kg on `object` of the paper's rubber (3 MPa, friction 0.75), all else as a scene file leaves it, the
    /// device at the world's origin: what tests and first trials begin with.
    #[must_use]
    pub const fn ball_on(object: ObjectShape) -> Self {
        let mut parts = [ProbePart::UNUSED; MAX_PARTS];
        parts[0].shape = ProbeShape::Sphere { radius: 0.02 };
        Self {
            object,
            fixed_below: 0.0,
            young_modulus: 3.0e6,
            poisson_ratio: 0.5,
            density: 1100.0,
            compliance: None,
            probe: ProbeParts { count: 1, parts },
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
            work: None,
            force_law: ForceLaw::Hertz,
            guard: GuardLimits::DEVICE_S_OWN,
            paper_length: 0.1,
            place: Place { p_wd: [0.0; 3], q_wd: [1.0, 0.0, 0.0, 0.0] },
        }
    }
}

//! The baked scene: everything the host needs to run, in one file.
//!
//! A tool reads the scene file people write (TOML, meshes, tables) and bakes this; the host reads this and nothing else. Lengths
//! \[m\], Pa, kg; poses in world `w`: the base centre of the object is the origin, +z up. What a value may be is checked by the
//! core's constructors; here only the shape of the bytes is.

use serde::{Deserialize, Serialize};

use crate::device::{ENUM, F32, U16, U32};

pub use crate::scene_file::{FILE_MAX, MAGIC, SceneFileError, decode_file, digest, encode_file};

/// Everything the host needs to run a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakedScene {
    /// Shape of the elastic body.
    pub object: ObjectShape,
    /// Surface points with z at or below this are held \[m\].
    pub fixed_below: f32,
    /// Young's modulus of the object \[Pa\].
    pub young_modulus: f32,
    /// Poisson's ratio of the object, 0 to 0.5.
    pub poisson_ratio: f32,
    /// Density of the object \[kg/m^3\].
    pub density: f32,
    /// Compliances of the body beyond the half space's; `None` = the core's closed forms.
    pub compliance: Option<Compliance>,
    /// The rigid body in the hand.
    pub probe: ProbeParts,
    /// Mass of the probe \[kg\].
    pub mass: f32,
    /// Inertia of the probe; `None` = the mass spread evenly over its parts.
    pub inertia: Option<Inertia>,
    /// Static friction coefficient.
    pub friction_static: f32,
    /// Dynamic friction coefficient, at most the static one.
    pub friction_dynamic: f32,
    /// Contacts closer than this are one region \[m\].
    pub region_distance: f32,
    /// Regions at most.
    pub max_regions: u8,
    /// Fidelity.
    pub tier: Tier,
    /// Samples per region.
    pub samples: u16,
    /// Gauss-Seidel sweeps of the `influence` and `green` tiers.
    pub sweeps: u8,
    /// How much of the surface's deformation is computed.
    pub deformation: Deformation,
    /// How the handle moves the probe.
    pub coupling: Coupling,
    /// How stick gives way to slip.
    pub breakaway: Breakaway,
    /// Whether the probe's weight is felt.
    pub gravity: bool,
    /// What a tick may spend \[instructions of the core's x86-64 release build\]; `None` is no limit.
    pub work: Option<u32>,
    /// Normal force over depth.
    pub force_law: ForceLaw,
    /// The scene's own limits on the wrench; the device's hold beside them.
    pub guard: GuardLimits,
    /// Axial distance to the fixed points, the `l` of the `paper` tier \[m\].
    pub paper_length: f32,
    /// Where the device stands in the world.
    pub place: Place,
}

impl BakedScene {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ObjectShape::MAX_ENCODED
        + 4 * F32
        + (1 + Compliance::MAX_ENCODED)
        + ProbeParts::MAX_ENCODED
        + (1 + Inertia::MAX_ENCODED)
        + 4 * F32
        + 1
        + ENUM
        + U16
        + 1
        + 2 * ENUM
        + Coupling::MAX_ENCODED
        + 1
        + (1 + U32)
        + ForceLaw::MAX_ENCODED
        + GuardLimits::MAX_ENCODED
        + F32
        + Place::MAX_ENCODED;
}

/// Shape of the elastic body; its base centre is the origin of the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ObjectShape {
    /// Solid below z = 0.
    HalfSpace,
    /// A box standing on z = 0.
    Box {
        /// Edges along x, y, z \[m\].
        size: [f32; 3],
    },
    /// A ball touching z = 0 from above.
    Sphere {
        /// Radius \[m\].
        radius: f32,
    },
    /// An ellipsoid touching z = 0 from above.
    Ellipsoid {
        /// Semi-axes along x, y, z \[m\].
        semi_axes: [f32; 3],
    },
    /// An upright cylinder standing on z = 0.
    Cylinder {
        /// Radius \[m\].
        radius: f32,
        /// Height \[m\].
        height: f32,
    },
    /// A body given by a mesh whose base lies at z = 0.
    Mesh {
        /// Its place among the file's sections of kind [`GRID`](crate::sections::GRID), from 0.
        grid: u8,
    },
}

impl ObjectShape {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM + 3 * F32;
}

/// Compliances of the body minus those of the half space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compliance {
    /// C_n \[m/N\].
    pub normal: f32,
    /// C_t \[m/N\].
    pub drag: f32,
    /// C_theta [rad/(N m)].
    pub twist: f32,
}

impl Compliance {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 3 * F32;
}

/// Inertia tensor of the probe about its mass centre, in its frame `p` \[kg m^2\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inertia {
    /// About x, y, z.
    pub moments: [f32; 3],
    /// xy, xz, yz, as they stand in the tensor.
    pub products: [f32; 3],
}

impl Inertia {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 6 * F32;
}

/// The probe as a bounded list of rigid parts about its mass centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeParts {
    /// Parts in use, from the front.
    pub count: u8,
    /// The parts; those beyond `count` mean nothing.
    pub parts: [ProbePart; MAX_PARTS],
}

/// Parts of a probe at most: more than any tool in the reference scenes, few enough to keep by value.
pub const MAX_PARTS: usize = 16;

impl ProbeParts {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 1 + MAX_PARTS * ProbePart::MAX_ENCODED;

    /// A probe of the given parts; `None` when there are more than [`MAX_PARTS`].
    #[must_use]
    pub fn from_slice(parts: &[ProbePart]) -> Option<Self> {
        let mut all = [ProbePart::UNUSED; MAX_PARTS];
        all.get_mut(..parts.len())?.copy_from_slice(parts);
        let count = u8::try_from(parts.len()).ok()?;
        Some(Self { count, parts: all })
    }

    /// The parts in use.
    #[must_use]
    pub fn as_slice(&self) -> &[ProbePart] {
        self.parts.get(..usize::from(self.count)).unwrap_or(&self.parts)
    }
}

/// One rigid part of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbePart {
    /// Its shape.
    pub shape: ProbeShape,
    /// Its origin in the probe's frame `p` \[m\].
    pub position: [f32; 3],
    /// Its rotation in `p`, unit quaternion (w, x, y, z).
    pub rotation: [f32; 4],
}

impl ProbePart {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ProbeShape::MAX_ENCODED + 7 * F32;
    /// What fills the places beyond the count.
    pub const UNUSED: Self =
        Self { shape: ProbeShape::Sphere { radius: 0.0 }, position: [0.0; 3], rotation: [1.0, 0.0, 0.0, 0.0] };
}

/// Shape of a part; its origin is its own mass centre, its axis z.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ProbeShape {
    /// A ball.
    Sphere {
        /// Radius \[m\].
        radius: f32,
    },
    /// A box.
    Box {
        /// Edges along x, y, z \[m\].
        size: [f32; 3],
    },
    /// A cylinder, a flat punch.
    Cylinder {
        /// Radius \[m\].
        radius: f32,
        /// Height \[m\].
        height: f32,
    },
    /// A cone, tip towards -z; the origin is 3/4 of the height above the tip.
    Cone {
        /// Radius of the base \[m\].
        radius: f32,
        /// Height \[m\].
        height: f32,
    },
    /// A cylinder with half balls at both ends.
    Capsule {
        /// Radius \[m\].
        radius: f32,
        /// Height of the straight part \[m\].
        height: f32,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Semi-axes along x, y, z \[m\].
        semi_axes: [f32; 3],
    },
    /// A convex body given by a mesh.
    Mesh {
        /// Its place among the file's sections of kind [`GRID`](crate::sections::GRID), from 0.
        grid: u8,
    },
}

impl ProbeShape {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM + 3 * F32;
}

/// Fidelity of the contact, from cheap to dear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Tier {
    /// Closed forms, no samples.
    Point,
    /// The source paper's equations.
    Paper,
    /// Calibrated bristles.
    #[default]
    Bristle,
    /// Influence matrix on the unit disc.
    Influence,
    /// Influence matrix and the body's own compliance fields.
    Green,
}

impl Tier {
    /// The tier as scene files spell it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Paper => "paper",
            Self::Bristle => "bristle",
            Self::Influence => "influence",
            Self::Green => "green",
        }
    }
}

/// How much of the surface's deformation is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Deformation {
    /// None: forces only.
    None,
    /// Near the regions.
    Local,
    /// The whole surface.
    #[default]
    Full,
}

/// How the handle moves the probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Coupling {
    /// The probe is where the handle is.
    #[default]
    Direct,
    /// A spring and damper pull the probe after the handle.
    Virtual(VirtualCoupling),
}

impl Coupling {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM + VirtualCoupling::MAX_ENCODED;
}

/// The spring and damper between handle and probe. What is left out the host fits to the device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VirtualCoupling {
    /// Stiffness in translation \[N/m\]; `None` = by the device's largest force.
    pub translational_stiffness: Option<f32>,
    /// Stiffness in rotation \[N m/rad\]; `None` = by the device's largest torque.
    pub rotational_stiffness: Option<f32>,
    /// Damping in translation \[N s/m\]; `None` = critical with the probe's mass.
    pub translational_damping: Option<f32>,
    /// Damping in rotation \[N m s/rad\]; `None` = critical with the probe's inertia.
    pub rotational_damping: Option<f32>,
    /// Largest pull of the spring \[N\]; of this and the device's largest force the lower one holds, infinity is no limit.
    pub max_force: f32,
    /// Largest torque of the spring \[N m\], likewise.
    pub max_torque: f32,
}

impl VirtualCoupling {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 4 * (1 + F32) + 2 * F32;

    /// Nothing of the scene's own: all is fitted to the device.
    pub const DEVICE_S_OWN: Self = Self {
        translational_stiffness: None,
        rotational_stiffness: None,
        translational_damping: None,
        rotational_damping: None,
        max_force: f32::INFINITY,
        max_torque: f32::INFINITY,
    };
}

impl Default for VirtualCoupling {
    fn default() -> Self {
        Self::DEVICE_S_OWN
    }
}

/// How stick gives way to slip when static friction exceeds dynamic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Breakaway {
    /// Bounded change per tick.
    #[default]
    Smooth,
    /// At once, as in the source paper.
    Sharp,
}

/// Normal force over depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum ForceLaw {
    /// From the shapes in contact: Hertz and its relatives.
    #[default]
    Hertz,
    /// F = k1 d + k3 d^3.
    Cubic {
        /// Linear stiffness \[N/m\].
        k1: f32,
        /// Cubic stiffness \[N/m^3\].
        k3: f32,
    },
    /// Measured: `force[i]` at depth `i * step`, linear between, held beyond the last.
    Table {
        /// Depth between entries \[m\].
        step: f32,
        /// Forces \[N\], the first 0, not falling.
        force: [f32; FORCE_TABLE_LEN],
    },
}

/// Entries of a measured force law: those of the core.
pub const FORCE_TABLE_LEN: usize = 16;

impl ForceLaw {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM + F32 + FORCE_TABLE_LEN * F32;
}

/// What a scene allows the wrench, beside what the device renders: of the two limits the lower one holds. Infinity is no limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GuardLimits {
    /// Largest force \[N\]; direction is kept.
    pub max_force: f32,
    /// Largest torque \[N m\]; direction is kept.
    pub max_torque: f32,
    /// Largest rate of change of the force \[N/s\].
    pub max_force_rate: f32,
    /// Largest rate of change of the torque \[N m/s\].
    pub max_torque_rate: f32,
    /// Time over which the wrench is ramped in when the first pose is inside the object \[s\].
    pub ramp_in: f32,
    /// Watches the energy that leaves at the handle and damps what is too much; `None` is off.
    pub passivity: Option<Passivity>,
}

/// Passivity observer and controller at the handle. Force and torque are counted apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passivity {
    /// Most damping \[N s/m\].
    pub max_damping: f32,
    /// Most angular damping \[N m s/rad\].
    pub max_spin_damping: f32,
    /// Energy that may come out before it acts \[J\].
    pub allowance: f32,
    /// Most energy that the hand is credited with \[J\]; infinity is no cap.
    pub reserve: f32,
    /// Delay of the link beyond the tick itself \[ticks\].
    pub delay_ticks: u8,
}

impl Passivity {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 4 * F32 + 1;
}

impl GuardLimits {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 5 * F32 + (1 + Passivity::MAX_ENCODED);

    /// No limits of the scene's own; the wrench is ramped in over half a second, as the core does.
    pub const DEVICE_S_OWN: Self = Self {
        max_force: f32::INFINITY,
        max_torque: f32::INFINITY,
        max_force_rate: f32::INFINITY,
        max_torque_rate: f32::INFINITY,
        ramp_in: 0.5,
        passivity: None,
    };
}

impl Default for GuardLimits {
    fn default() -> Self {
        Self::DEVICE_S_OWN
    }
}

/// Pose `x_wd` of the device's base in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// `p_wd` \[m\].
    pub p_wd: [f32; 3],
    /// `q_wd`, unit quaternion (w, x, y, z).
    pub q_wd: [f32; 4],
}

impl Place {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 7 * F32;
}

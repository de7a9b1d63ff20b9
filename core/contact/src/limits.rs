//! Every capacity and every limit of the core, each with its reason.

/// Contact regions at once. The paper's bound (section VI: "a reasonable number of contact regions (<= 10)").
pub const MAX_REGIONS: usize = 10;

/// Convex parts of a compound probe. A region may hold several parts that are closer than `region_distance`, so there
/// are more parts than regions; 16 keeps a state of 64 samples at 37 kB, which fits the tightly coupled memory of a Cortex-M7.
pub const MAX_PARTS: usize = 16;

/// Most samples of a region in tier `paper`. Above it the continuum limits are met to 0.1 % and more buys nothing.
pub const MAX_SAMPLES: usize = 1024;

/// Most bristles of a patch. At 256 pure twist and drag are within 0.3 % of the exact curves and mixed paths no longer improve.
pub const MAX_BRISTLES: usize = 256;

/// Fewest samples of a region: below it a turning path errs by more than the tier's stated bound.
pub const MIN_SAMPLES: usize = 16;

/// Most sweeps of tier `influence` per tick: at 16 a step is solved to a fraction of what its cells resolve, twice that is room for coarse ticks.
pub const MAX_SWEEPS: usize = 32;

/// Least work budget of a tick \[instructions\]: one ball without friction takes a third of it.
pub const MIN_WORK: u32 = 10_000;

/// Largest work budget \[instructions\]: a core of today is at it for a third of a second.
pub const MAX_WORK: u32 = 1_000_000_000;

/// Largest distance of probe and object from the world origin \[m\]. At 1 km an f32 resolves 0.06 mm.
pub const MAX_DISTANCE: f32 = 1.0e3;

/// A contact less deep than so many steps of the pose's own digits is flagged ([`Flags::POSE_COARSE`](crate::Flags::POSE_COARSE)). Place and depth are then known to a
/// sixty-fourth, the force to three per cent, as `cargo xtask extremes` measures it.
pub const COARSE_STEPS: f32 = 64.0;

/// Largest speed of the probe between two ticks \[m/s\]. A hand reaches 5 m/s; ten times that is a fault of the device or the link.
pub const MAX_SPEED: f32 = 50.0;

/// Largest rate of turn between two ticks \[rad/s\]. A wrist reaches 40 rad/s; at 1 kHz, half a turn per tick is where the sense of a
/// turn becomes ambiguous (3100 rad/s), and a quarter turn is where a chord stops being an arc.
pub const MAX_TURN_RATE: f32 = 1500.0;

/// Longest tick \[s\], an hour: longer ones are a stopped clock. Squares of it times the stiffest coupling stay far within an f32.
pub const MAX_TICK: f32 = 3600.0;

/// Shortest tick \[s\], a nanosecond: a thousandth of what any device does. The heaviest probe over the square of it stays far within an f32.
pub const MIN_TICK: f32 = 1.0e-9;

/// Least friction budget mu P of a patch that is followed \[N\]; below it friction is none. The squares of its shares among 256 samples stay above the smallest normal f32.
pub const LEAST_FRICTION: f32 = 1.0e-14;

/// How far a quaternion's length may be from 1 before the pose is refused.
pub const QUATERNION_TOLERANCE: f32 = 1.0e-3;

/// Most surface samples of a mesh. The search for a deepest point starts from a prefix and is refined on the distance grid: 2048 samples of
/// a 20 mm ball stand 1.6 mm apart, closer than any contact is wide.
pub const MAX_SURFACE_SAMPLES: usize = 2048;

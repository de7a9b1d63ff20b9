//! What a tick has to say beside its wrench: nothing is clamped, dropped or lowered silently.

use core::fmt;
use core::ops::{BitOr, BitOrAssign};

use glam::Vec3;

use crate::params::Tier;

/// Conditions of one tick as bits; 0 is a clean tick. The bits are part of the file formats and never change meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(pub u32);

impl Flags {
    /// A clean tick.
    pub const CLEAN: Self = Self(0);
    /// A pose component or dt was not finite or absurd; the tick kept the last good state.
    pub const POSE_REFUSED: Self = Self(1 << 0);
    /// The pose moved faster than [`MAX_SPEED`](crate::MAX_SPEED) or [`MAX_TURN_RATE`](crate::MAX_TURN_RATE); the tick kept the last good state.
    pub const POSE_JUMP: Self = Self(1 << 1);
    /// More regions than allowed: the shallowest were left out.
    pub const REGION_REFUSED: Self = Self(1 << 2);
    /// The force was scaled down to its limit, direction kept.
    pub const FORCE_LIMITED: Self = Self(1 << 3);
    /// The torque was scaled down to its limit, direction kept.
    pub const TORQUE_LIMITED: Self = Self(1 << 4);
    /// The change of force in this tick was limited.
    pub const FORCE_SLEWED: Self = Self(1 << 5);
    /// The change of torque in this tick was limited.
    pub const TORQUE_SLEWED: Self = Self(1 << 6);
    /// The probe started inside the object and the wrench is still being ramped in.
    pub const RAMPING_IN: Self = Self(1 << 7);
    /// The paper's length l was floored.
    pub const LENGTH_FLOORED: Self = Self(1 << 8);
    /// The contact left small strain (a/R > 0.35 or depth beyond a part's or the object's size): figures are not calibrated there.
    pub const LARGE_STRAIN: Self = Self(1 << 9);
    /// A result was not finite; the wrench was set to zero.
    pub const NON_FINITE: Self = Self(1 << 10);
    /// Something was done less finely to fit the work budget: parts waited for their turn, or the tier, its samples or the passes of a birth were lowered.
    pub const TIER_LOWERED: Self = Self(1 << 11);
    /// A region was born while another waited (one birth per tick).
    pub const BIRTH_WAITS: Self = Self(1 << 12);
    /// The handle's port had given out more energy than it took; damping was added to the wrench.
    pub const PASSIVITY_DAMPED: Self = Self(1 << 13);
    /// A contact is so shallow, or so far from the origin, that the pose's digits no longer tell its depth ([`COARSE_STEPS`](crate::COARSE_STEPS)): move the
    /// scene nearer to the origin, or press deeper.
    pub const POSE_COARSE: Self = Self(1 << 14);

    /// Names of the bits, lowest first.
    pub const NAMES: [&'static str; 15] = [
        "pose refused",
        "pose jump",
        "region refused",
        "force limited",
        "torque limited",
        "force slewed",
        "torque slewed",
        "ramping in",
        "length floored",
        "large strain",
        "non-finite",
        "tier lowered",
        "birth waits",
        "passivity damped",
        "pose coarse",
    ];

    /// True when every bit of `other` is set.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl BitOr for Flags {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Flags {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl fmt::Display for Flags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        for (bit, name) in Self::NAMES.iter().enumerate() {
            if self.0 & (1 << bit) != 0 {
                write!(f, "{}{name}", if first { "" } else { ", " })?;
                first = false;
            }
        }
        if first { f.write_str("clean") } else { Ok(()) }
    }
}

/// One patch as a viewer or a log wants it. Everything in world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchReport {
    /// Index of the region (birth order, 0 = oldest) the patch belongs to.
    pub region: u8,
    /// Centre `p_wc` \[m\].
    pub centre: Vec3,
    /// Unit normal out of the object.
    pub normal: Vec3,
    /// Depth \[m\].
    pub depth: f32,
    /// Contact radius \[m\].
    pub radius: f32,
    /// Stuck share of the contact area, 0..1.
    pub stick: f32,
    /// Force on the probe \[N\].
    pub force: Vec3,
    /// Torque of the patch about its own centre \[N m\].
    pub torque: Vec3,
}

/// The report of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Tier that computed this tick: what the parameters ask for, or less where the work budget is short.
    pub tier: Tier,
    /// Its samples, or cells of a fresh contact; of no meaning for tier `point`.
    pub samples: u16,
    /// Its sweeps; of no meaning for tiers without cells.
    pub sweeps: u8,
    /// Estimated work of this tick \[instructions\]; 0 where no budget is set.
    pub work: u32,
    /// Regions in contact.
    pub regions: u8,
    /// Largest depth \[m\]; 0 without contact.
    pub depth: f32,
    /// Contact radius of the deepest patch \[m\].
    pub radius: f32,
    /// Stuck share of the deepest patch's area, 0..1; 1 without contact.
    pub stick: f32,
    /// Conditions of this tick.
    pub flags: Flags,
    /// Regions refused since the state was made, saturating.
    pub refused: u32,
    /// Poses refused since the state was made, saturating.
    pub poses_refused: u32,
    /// Most regions ever held at once by this state.
    pub high_water: u8,
}

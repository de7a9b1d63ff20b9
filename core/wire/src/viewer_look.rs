//! What a viewer sees: snapshots of ticks, the deformed surface in blocks, the session in figures. See [`crate::viewer`].

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::device::{ENUM, F32, Mode, U16, U32, U64};
use crate::scene::{MAX_PARTS, Tier};
use crate::status::{HostFault, Summary};
use crate::viewer::{LENGTH, POINTS_IN_MESSAGE};

/// What one tick was like.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// Time since the session began \[us\].
    pub t_us: u64,
    /// Position `p_wp` of the probe \[m\].
    pub position: [f32; 3],
    /// Rotation `q_wp` of the probe, unit quaternion (w, x, y, z).
    pub rotation: [f32; 4],
    /// Contact force on the probe, in `w` \[N\].
    pub contact_force: [f32; 3],
    /// Contact torque on the probe about its mass centre, in `w` \[N m\].
    pub contact_torque: [f32; 3],
    /// Force sent to the handle, in `w` \[N\].
    pub sent_force: [f32; 3],
    /// Torque sent to the handle about its origin, in `w` \[N m\].
    pub sent_torque: [f32; 3],
    /// The contacts, oldest first.
    pub patches: Vec<PatchLook, MAX_PARTS>,
    /// Largest depth \[m\].
    pub depth: f32,
    /// Tier used.
    pub tier: Tier,
    /// What the core and the host had to say: 0 = clean; the bits are in [`crate::flags`].
    pub flags: u32,
    /// How late the thread woke \[ns\].
    pub wake_ns: u32,
    /// What the step of the core took \[ns\].
    pub step_ns: u32,
    /// From sending the previous wrench to the report that echoed it \[ns\]; 0 = none seen.
    pub round_trip_ns: u32,
    /// Share of ticks in time so far \[1/1000\].
    pub in_time_permille: u16,
    /// The device's mode.
    pub mode: Mode,
    /// What the output does.
    pub output: OutputState,
    /// The latched fault, if any.
    pub fault: Option<HostFault>,
}

impl Snapshot {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = 2 * U64
        + 19 * F32
        + LENGTH_OF_FEW
        + MAX_PARTS * PatchLook::MAX_ENCODED
        + F32
        + ENUM
        + 4 * U32
        + U16
        + 2 * ENUM
        + HostFault::MAX_OPTION;
}

/// The contact of one part of the probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PatchLook {
    /// The region it belongs to, 0 = oldest.
    pub region: u8,
    /// Centre `p_wc` \[m\].
    pub centre: [f32; 3],
    /// Unit normal out of the object, in `w`.
    pub normal: [f32; 3],
    /// Contact radius \[m\].
    pub radius: f32,
    /// Radius of the core that sticks \[m\], 0 to `radius`.
    pub stick_radius: f32,
    /// Force on the probe, in `w` \[N\].
    pub force: [f32; 3],
    /// Torque on the probe about the centre, in `w` \[N m\].
    pub torque: [f32; 3],
    /// Depth \[m\].
    pub depth: f32,
}

impl PatchLook {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 1 + 15 * F32;
}

/// What the output does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum OutputState {
    /// Zero: after a fault, a pause or a change of scene, until the wrench is small.
    #[default]
    Closed,
    /// The device renders what the core says.
    Open,
    /// Zero, and the core stands.
    Frozen,
    /// Zero, and the device brakes: an emergency stop.
    Stopped,
}

impl OutputState {
    /// Every state, in the order of the wire.
    pub const ALL: [Self; 4] = [Self::Closed, Self::Open, Self::Frozen, Self::Stopped];

    /// The state in one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Open => "open",
            Self::Frozen => "frozen",
            Self::Stopped => "stopped",
        }
    }
}

/// Displacements of rest points, in order; the blocks of a tick come one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceBlock {
    /// The tick.
    pub tick: u64,
    /// Points of the whole surface.
    pub of: u32,
    /// The number of the first point.
    pub offset: u32,
    /// Unit of `moved` \[m\]: chosen so that the tick's largest component is 32,767; half of it is the error.
    pub step: f32,
    /// Displacements in `w` \[`step`\].
    pub moved: Vec<[i16; 3], POINTS_IN_MESSAGE>,
}

impl SurfaceBlock {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + 2 * U32 + F32 + LENGTH + 3 * U16 * POINTS_IN_MESSAGE;

    /// The unit for displacements whose largest component is `largest` \[m\].
    #[must_use]
    pub fn step_for(largest: f32) -> f32 {
        largest / f32::from(i16::MAX)
    }

    /// A displacement \[m\] in units of `step`; what is not finite is nothing.
    #[must_use]
    pub fn quantised(moved: [f32; 3], step: f32) -> [i16; 3] {
        // `as` takes NaN to 0 and saturates
        moved.map(|u| if step > 0.0 { round(u / step) as i16 } else { 0 })
    }

    /// The displacements in `w` \[m\].
    pub fn displacements(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        self.moved.iter().map(|moved| moved.map(|u| f32::from(u) * self.step))
    }
}

/// Nearest whole number, halves away from zero; `core` has none.
fn round(x: f32) -> f32 {
    if x < 0.0 { x - 0.5 } else { x + 0.5 }
}

/// The session in figures, so far, and what the link cost this viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// The session.
    pub session: Summary,
    /// Viewers that look on, this one included.
    pub viewers: u8,
    /// Snapshots sent to this viewer.
    pub sent: u64,
    /// Snapshots and surfaces left out because this viewer read too slowly.
    pub dropped: u64,
    /// Surfaces computed for this viewer; none while it asks for none.
    pub surfaces: u64,
    /// Passes that they took, each of bounded work.
    pub passes: u64,
    /// Points in them.
    pub points: u64,
    /// Surfaces left out because the one before was still being computed.
    pub behind: u64,
    /// Snapshots left out for all because the server was too slow.
    pub missed: u64,
    /// Frames of this viewer that were no messages.
    pub rejected: u32,
}

impl Statistics {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = Summary::MAX_ENCODED + 1 + 7 * U64 + U32;
}

/// Postcard bytes of the length of a list of less than 128.
const LENGTH_OF_FEW: usize = 1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displacement_comes_back_within_half_a_step() {
        let largest = 3.0e-3;
        let step = SurfaceBlock::step_for(largest);
        for moved in [[largest, -largest, 0.0], [1.0e-6, -2.0e-7, 4.321e-4]] {
            let mut block = SurfaceBlock { tick: 0, of: 1, offset: 0, step, moved: Vec::new() };
            block.moved.push(SurfaceBlock::quantised(moved, step)).unwrap();
            let back = block.displacements().next().unwrap();
            for (a, b) in moved.iter().zip(back) {
                assert!((a - b).abs() <= 0.5001 * step, "{a} {b}");
            }
        }
        assert_eq!(SurfaceBlock::quantised([f32::NAN, 1.0, f32::NEG_INFINITY], 0.0), [0; 3]);
        assert_eq!(SurfaceBlock::quantised([f32::NAN, 1.0, f32::NEG_INFINITY], step), [0, i16::MAX, i16::MIN]);
    }
}

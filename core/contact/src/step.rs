//! One tick: seven stages in order.

use crate::frames::{Pose, ProbeFrame, World};
use crate::report::Report;
use crate::wrench::Wrench;

/// What a tick is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Pose `x_wp` of the probe in world.
    pub pose: Pose<World, ProbeFrame>,
    /// Time since the previous tick \[s\]; used by the guard's rates and the jump test only.
    pub dt: f32,
}

/// What a tick returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Wrench for the device: after the guard.
    pub wrench: Wrench<World>,
    /// Wrench of the contact, before the guard.
    pub contact: Wrench<World>,
    /// What was clamped, refused or lowered.
    pub report: Report,
}

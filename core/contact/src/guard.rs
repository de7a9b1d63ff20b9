//! The last stage: what leaves a tick is finite, bounded, and changes no faster than stated.

use crate::error::{Invalid, require};

/// Limits of the last stage. A limit of `f32::INFINITY` is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardSpec {
    /// Largest force \[N\]; direction is kept.
    pub max_force: f32,
    /// Largest torque \[N m\]; direction is kept, the force is not touched.
    pub max_torque: f32,
    /// Largest rate of change of the force \[N/s\].
    pub max_force_rate: f32,
    /// Largest rate of change of the torque \[N m/s\].
    pub max_torque_rate: f32,
    /// Time over which the wrench is ramped in when the first pose is inside the object \[s\].
    pub ramp_in: f32,
}

impl Default for GuardSpec {
    /// Limits of a PHANTOM Premium 1.5/6DOF (8.5 N, 0.188 N m), full scale in 20 ms, half a second of ramp.
    fn default() -> Self {
        Self { max_force: 8.5, max_torque: 0.188, max_force_rate: 425.0, max_torque_rate: 9.4, ramp_in: 0.5 }
    }
}

impl GuardSpec {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let positive = |name, value: f32| {
            if value == f32::INFINITY { Ok(()) } else { require(value > 0.0, name, value, "above 0, or infinity for none") }
        };
        positive("guard.max_force [N]", self.max_force)?;
        positive("guard.max_torque [N m]", self.max_torque)?;
        positive("guard.max_force_rate [N/s]", self.max_force_rate)?;
        positive("guard.max_torque_rate [N m/s]", self.max_torque_rate)?;
        require((0.0..=60.0).contains(&self.ramp_in), "guard.ramp_in", self.ramp_in, "0 to 60 s")
    }
}

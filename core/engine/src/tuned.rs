//! What changes an engine between two ticks, checked beforehand: tuning and place. Checking may fail and is done on an ordinary thread; taking over what was
//! checked cannot fail and allocates nothing.

use haptor_contact::{Invalid, ParamsSpec, Pose, Vec3, World};
use haptor_wire as wire;
use haptor_wire::Tuning;

use crate::error::SceneError;
use crate::frames::DeviceBase;
use crate::link::quaternion;
use crate::settings::params_spec;
use crate::setup::Setup;

/// A tuning that a scene's engine can take over between two ticks.
#[derive(Clone, Copy, Debug)]
pub struct Tuned {
    pub(crate) tuning: Tuning,
    /// Parameters on a device of the core's defaults.
    pub(crate) spec: ParamsSpec,
}

impl Tuned {
    /// Checks a tuning against a scene; `table` = the scene's file carries the body's own table, which tier `green` reads.
    ///
    /// # Errors
    /// [`SceneError`] names the first value that does not pass.
    pub fn new(setup: &Setup, table: bool, tuning: &Tuning) -> Result<Self, SceneError> {
        Self::check(&setup.baked().coupling, table, tuning)
    }

    pub(crate) fn check(coupling: &wire::Coupling, table: bool, tuning: &Tuning) -> Result<Self, SceneError> {
        if tuning.tier == wire::Tier::Green && !table {
            return Err(SceneError::NoTable);
        }
        Ok(Self { tuning: *tuning, spec: params_spec(coupling, tuning)? })
    }

    /// What was checked.
    #[must_use]
    pub const fn tuning(&self) -> &Tuning {
        &self.tuning
    }
}

/// Where a device stands, checked.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    pub(crate) place: wire::Place,
    pub(crate) x_wd: Pose<World, DeviceBase>,
}

impl Placed {
    /// Checks a place.
    ///
    /// # Errors
    /// [`Invalid`] when its position is not finite or its quaternion is none.
    pub fn new(place: &wire::Place) -> Result<Self, Invalid> {
        Ok(Self { place: *place, x_wd: stands(place)? })
    }

    /// What was checked.
    #[must_use]
    pub const fn place(&self) -> &wire::Place {
        &self.place
    }
}

/// Pose `x_wd` of a place.
pub(crate) fn stands(place: &wire::Place) -> Result<Pose<World, DeviceBase>, Invalid> {
    let refused = |name, value, allowed| Invalid { name, value, allowed };
    if let Some(&value) = place.p_wd.iter().find(|value| !value.is_finite()) {
        return Err(refused("place.p_wd", value, "finite, m"));
    }
    let rotation = quaternion(place.q_wd).ok_or(refused("place.q_wd (length)", f32::NAN, "a unit quaternion, within 1e-3"))?;
    Ok(Pose::new(Vec3::from_array(place.p_wd), rotation))
}

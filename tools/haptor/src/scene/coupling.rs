//! `[coupling]` and `[guard.passivity]`: what stands between handle and probe, and what watches the energy there.
//!
//! What `[coupling]` leaves out is fitted to the device by the host. Without a device (`eval`, pictures) it is that of a Premium, as the guard's limits are.

use haptor_contact::{CouplingSpec, GuardSpec, Passivity, VirtualCoupling};
use haptor_wire as wire;

use super::document::{Key, SceneError, Section, key};

const COUPLING: Key = key("coupling", "the section of the spring and damper", "{ translational_stiffness = 800.0 }");
const TRANSLATIONAL_STIFFNESS: Key = key("translational_stiffness", "a number, 1 to 1e6 N/m", "800.0");
const ROTATIONAL_STIFFNESS: Key = key("rotational_stiffness", "a number, 1e-4 to 1e4 N m/rad", "0.3");
const TRANSLATIONAL_DAMPING: Key = key("translational_damping", "a number, 0 to 1e5 N s/m", "20.0");
const ROTATIONAL_DAMPING: Key = key("rotational_damping", "a number, 0 to 1e3 N m s/rad", "0.01");
const MAX_FORCE: Key = key("max_force", "a number above 0, or inf for the device's, N", "8.5");
const MAX_TORQUE: Key = key("max_torque", "a number above 0, or inf for the device's, N m", "0.188");

const PASSIVITY: Key =
    key("passivity", "a table of max_damping, max_spin_damping, allowance, reserve and delay_ticks", "{ max_damping = 5.0 }");
const MAX_DAMPING: Key = key("max_damping", "a number, 0 to 1e3 N s/m", "5.0");
const MAX_SPIN_DAMPING: Key = key("max_spin_damping", "a number, 0 to 10 N m s/rad", "0.004");
const ALLOWANCE: Key = key("allowance", "a number, 0 to 1 J", "1.0e-6");
const RESERVE: Key = key("reserve", "a number above 0, or inf for no cap, J", "0.1");
const DELAY_TICKS: Key = key("delay_ticks", "a whole number, 0 to 8", "0");

/// Reads `[coupling]` of the file; `virtually` is what `[model] coupling` says.
///
/// # Errors
/// [`SceneError`] at the first wrong key, or at the section when the coupling is direct.
pub fn coupling(root: &Section<'_, '_>, virtually: bool) -> Result<wire::Coupling, SceneError> {
    match (root.optional_section(COUPLING)?, virtually) {
        (None, false) => Ok(wire::Coupling::Direct),
        (None, true) => Ok(wire::Coupling::Virtual(wire::VirtualCoupling::DEVICE_S_OWN)),
        (Some(_), false) => {
            Err(root.error("coupling", "needs coupling = \"virtual\" in [model]; add that, or remove the section"))
        }
        (Some(section), true) => spring_and_damper(&section).map(wire::Coupling::Virtual),
    }
}

fn spring_and_damper(section: &Section<'_, '_>) -> Result<wire::VirtualCoupling, SceneError> {
    let none = f32::INFINITY;
    let spec = wire::VirtualCoupling {
        translational_stiffness: section.optional_number(TRANSLATIONAL_STIFFNESS)?,
        rotational_stiffness: section.optional_number(ROTATIONAL_STIFFNESS)?,
        translational_damping: section.optional_number(TRANSLATIONAL_DAMPING)?,
        rotational_damping: section.optional_number(ROTATIONAL_DAMPING)?,
        max_force: section.optional_number(MAX_FORCE)?.unwrap_or(none),
        max_torque: section.optional_number(MAX_TORQUE)?.unwrap_or(none),
    };
    section.finish("[coupling]")?;
    Ok(spec)
}

/// The coupling where there is no device: on a Premium.
pub fn without_device(asked: &wire::Coupling) -> CouplingSpec {
    let GuardSpec { max_force, max_torque, .. } = GuardSpec::default();
    limited(asked, max_force, max_torque)
}

/// The coupling with the limits that the scene itself gives, for its values to be checked.
pub fn as_written(asked: &wire::Coupling) -> CouplingSpec {
    limited(asked, f32::INFINITY, f32::INFINITY)
}

fn limited(asked: &wire::Coupling, max_force: f32, max_torque: f32) -> CouplingSpec {
    let wire::Coupling::Virtual(asked) = asked else { return CouplingSpec::Direct };
    let spring = VirtualCoupling::default();
    CouplingSpec::Virtual(VirtualCoupling {
        translational_stiffness: asked.translational_stiffness.unwrap_or(spring.translational_stiffness),
        rotational_stiffness: asked.rotational_stiffness.unwrap_or(spring.rotational_stiffness),
        translational_damping: asked.translational_damping,
        rotational_damping: asked.rotational_damping,
        max_force: asked.max_force.min(max_force),
        max_torque: asked.max_torque.min(max_torque),
    })
}

/// Reads `passivity` of `[guard]`; `None` when it is not there.
///
/// # Errors
/// [`SceneError`] at the first wrong key.
pub fn passivity(guard: &Section<'_, '_>) -> Result<Option<Passivity>, SceneError> {
    let Some(section) = guard.optional_section(PASSIVITY)? else { return Ok(None) };
    let core = Passivity::default();
    let spec = Passivity {
        max_damping: section.optional_number(MAX_DAMPING)?.unwrap_or(core.max_damping),
        max_spin_damping: section.optional_number(MAX_SPIN_DAMPING)?.unwrap_or(core.max_spin_damping),
        allowance: section.optional_number(ALLOWANCE)?.unwrap_or(core.allowance),
        reserve: section.optional_number(RESERVE)?.unwrap_or(core.reserve),
        delay_ticks: section.optional_count(DELAY_TICKS)?.unwrap_or(core.delay_ticks),
    };
    section.finish("[guard.passivity]")?;
    Ok(Some(spec))
}

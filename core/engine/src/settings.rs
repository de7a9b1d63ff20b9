//! Parameters and limits: of the scene, of the device, and the lower of both.

use haptor_contact as contact;
use haptor_contact::{GuardSpec, Params, ParamsSpec};
use haptor_wire as wire;
use haptor_wire::Tuning;

use crate::engine::SAMPLES;
use crate::error::SceneError;

/// The core's parameters of a scene so tuned, on the device of the core's defaults.
///
/// # Errors
/// [`SceneError`] names the first value that does not pass.
pub(crate) fn params_spec(coupling: &wire::Coupling, tuning: &Tuning) -> Result<ParamsSpec, SceneError> {
    if usize::from(tuning.samples) > SAMPLES {
        return Err(SceneError::Samples(tuning.samples));
    }
    let spec = ParamsSpec {
        friction_static: Some(tuning.friction_static),
        friction_dynamic: tuning.friction_dynamic,
        region_distance: tuning.region_distance,
        max_regions: usize::from(tuning.max_regions),
        tier: tier_to_core(tuning.tier),
        samples: usize::from(tuning.samples),
        sweeps: usize::from(tuning.sweeps),
        breakaway: match tuning.breakaway {
            wire::Breakaway::Smooth => contact::Breakaway::Smooth,
            wire::Breakaway::Sharp => contact::Breakaway::Sharp,
        },
        force_law: force_law(&tuning.force_law),
        gravity: tuning.gravity,
        work: tuning.work,
        coupling: contact::CouplingSpec::Direct,
        guard: guard_spec(&tuning.guard),
    };
    // the scene's own numbers are checked before the device's, or the core's until a device has said its own, are laid over them
    let core = GuardSpec::default();
    let asked = coupling_spec(coupling, &GuardSpec { max_force: f32::INFINITY, max_torque: f32::INFINITY, ..core });
    Params::new(&ParamsSpec { coupling: asked, ..spec })?;
    let (guard, coupling) = (lower_limits(&spec.guard, &core), coupling_spec(coupling, &core));
    Ok(ParamsSpec { guard, coupling, ..spec })
}

fn force_law(law: &wire::ForceLaw) -> contact::ForceLaw {
    match *law {
        wire::ForceLaw::Hertz => contact::ForceLaw::Hertz,
        wire::ForceLaw::Cubic { k1, k3 } => contact::ForceLaw::Cubic { k1, k3 },
        wire::ForceLaw::Table { step, force } => contact::ForceLaw::Table { step, force },
    }
}

pub(crate) fn guard_spec(limits: &wire::GuardLimits) -> GuardSpec {
    let wire::GuardLimits { max_force, max_torque, max_force_rate, max_torque_rate, ramp_in, passivity } = *limits;
    let passivity = passivity.map(|p| contact::Passivity {
        max_damping: p.max_damping,
        max_spin_damping: p.max_spin_damping,
        allowance: p.allowance,
        reserve: p.reserve,
        delay_ticks: p.delay_ticks.into(),
    });
    GuardSpec { max_force, max_torque, max_force_rate, max_torque_rate, ramp_in, passivity }
}

/// The coupling of a scene on a device with these limits.
///
/// What the scene leaves out comes from the device's full force and torque, which is all that a device says of its strength. Its stiffness is then such that full
/// force comes at the stretch at which it does on the device of the core's defaults (a Premium: 8.5 N on 800 N/m, 10.6 mm; 0.188 N m on 0.3 N m/rad, 36 degrees),
/// which is at or below what the makers of stronger devices say that theirs close; and the spring pulls no harder than the device can show.
pub(crate) fn coupling_spec(asked: &wire::Coupling, device: &GuardSpec) -> contact::CouplingSpec {
    let wire::Coupling::Virtual(asked) = asked else { return contact::CouplingSpec::Direct };
    let (premium, full) = (contact::VirtualCoupling::default(), GuardSpec::default());
    // a device without a limit has none to scale by
    let share = |own: f32, full: f32| if own.is_finite() { own / full } else { 1.0 };
    let scaled = contact::VirtualCoupling::closable(
        premium.translational_stiffness * share(device.max_force, full.max_force),
        premium.rotational_stiffness * share(device.max_torque, full.max_torque),
    );
    contact::CouplingSpec::Virtual(contact::VirtualCoupling {
        translational_stiffness: asked.translational_stiffness.unwrap_or(scaled.translational_stiffness),
        rotational_stiffness: asked.rotational_stiffness.unwrap_or(scaled.rotational_stiffness),
        translational_damping: asked.translational_damping,
        rotational_damping: asked.rotational_damping,
        max_force: lower(asked.max_force, device.max_force),
        max_torque: lower(asked.max_torque, device.max_torque),
    })
}

/// The lower of a scene's limit and the device's; one that is not a number stays, so that it is refused by its name.
fn lower(scene: f32, device: f32) -> f32 {
    if scene.is_nan() { scene } else { scene.min(device) }
}

/// The lower of each two limits; how long the ramp is, the scene says.
pub(crate) const fn lower_limits(scene: &GuardSpec, other: &GuardSpec) -> GuardSpec {
    GuardSpec {
        max_force: scene.max_force.min(other.max_force),
        max_torque: scene.max_torque.min(other.max_torque),
        max_force_rate: scene.max_force_rate.min(other.max_force_rate),
        max_torque_rate: scene.max_torque_rate.min(other.max_torque_rate),
        ramp_in: scene.ramp_in,
        passivity: scene.passivity,
    }
}

pub(crate) const fn tier_to_core(tier: wire::Tier) -> contact::Tier {
    match tier {
        wire::Tier::Point => contact::Tier::Point,
        wire::Tier::Paper => contact::Tier::Paper,
        wire::Tier::Bristle => contact::Tier::Bristle,
        wire::Tier::Influence => contact::Tier::Influence,
        wire::Tier::Green => contact::Tier::Green,
    }
}

/// The level as the wire names it.
#[must_use]
pub const fn tier_to_wire(tier: contact::Tier) -> wire::Tier {
    match tier {
        contact::Tier::Point => wire::Tier::Point,
        contact::Tier::Paper => wire::Tier::Paper,
        contact::Tier::Bristle => wire::Tier::Bristle,
        contact::Tier::Influence => wire::Tier::Influence,
        contact::Tier::Green => wire::Tier::Green,
    }
}

//! Between handle and probe.
//!
//! `direct`: the probe is where the handle is (the paper). `virtual`: a spring and a damper in all six directions tie the probe to the handle; the probe has
//! its mass and inertia, its motion is integrated here, and the hand feels the coupling. The hand then never meets more stiffness than the coupling has, however
//! stiff the contact: a 6-DoF desktop device closes about 0.8 kN/m at 1 kHz, rubber under a ball of 20 mm has 25 kN/m.
//!
//! **Words.** *Stretch*: from probe to handle, a vector and a rotation vector. *Pull*: the coupling's wrench on the probe; the handle gets its opposite. *Held*: what
//! the damper carries. *Lag*: motion that was too small for the pose's digits, owed to the next tick.
//!
//! Order in a tick: the coupling moves the probe with the contact's wrench and stiffness of the last tick, the stages run at the probe's new pose,
//! the contact is linearised there, the guard gets the coupling's wrench. References: Colgate, Stanley and Brown 1995 (the coupling, and what a
//! device can close); McNeely, Puterbaugh and Troy 1999 (six directions, critical damping); Otaduy and Lin 2006 (implicit step with the contact linearised, so that the mass
//! may be small); Barbic and James 2008 (the limit without mass, saturation). Equations: theory.md, section 10.

pub mod inertia;
mod integrate;
pub mod passivity;
mod spring;
mod stiffness;
mod sym;
#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::World;
use crate::error::{Invalid, require};
use crate::frames::{Pose, ProbeFrame};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;
use crate::report::Flags;
use crate::state::Memory;
use crate::wrench::Wrench;
use spring::Spring;
use stiffness::Linear;

/// What ties the probe to the handle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CouplingSpec {
    /// The probe's pose is the handle's; the hand feels the contact.
    #[default]
    Direct,
    /// A spring and a damper; the hand feels them.
    Virtual(VirtualCoupling),
}

/// The coupling of [`CouplingSpec::Virtual`]. Handle and probe more than half a turn apart are pulled together the short way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualCoupling {
    /// Stiffness in translation \[N/m\], 1 to 1e6.
    pub translational_stiffness: f32,
    /// Stiffness in rotation \[N m/rad\], 1e-4 to 1e4.
    pub rotational_stiffness: f32,
    /// Damping in translation \[N s/m\], 0 to 1e5; `None` is critical with the probe's mass.
    pub translational_damping: Option<f32>,
    /// Damping in rotation \[N m s/rad\], 0 to 1e3; `None` is critical with the mean of the probe's moments of inertia.
    pub rotational_damping: Option<f32>,
    /// Largest pull of the spring \[N\], above 0; infinity for none. The probe is never pressed harder than this.
    pub max_force: f32,
    /// Largest torque of the spring \[N m\], above 0; infinity for none.
    pub max_torque: f32,
}

impl Default for VirtualCoupling {
    /// What a 6-DoF desktop device of the PHANTOM Premium class closes at 1 kHz: 800 N/m and 0.3 N m/rad, critically damped, no saturation.
    fn default() -> Self {
        Self::closable(800.0, 0.3)
    }
}

impl VirtualCoupling {
    /// The coupling for a device that closes these stiffnesses \[N/m, N m/rad\] at its rate, critically damped, without saturation.
    pub const fn closable(translational: f32, rotational: f32) -> Self {
        Self {
            translational_stiffness: translational,
            rotational_stiffness: rotational,
            translational_damping: None,
            rotational_damping: None,
            max_force: f32::INFINITY,
            max_torque: f32::INFINITY,
        }
    }

    /// The springs for a probe of this mass and mean moment of inertia.
    fn springs(&self, mass: f32, inertia: f32) -> (Spring, Spring) {
        let spring = |stiffness: f32, damping: Option<f32>, mass: f32, most: f32| {
            let damping = damping.unwrap_or_else(|| Spring::critical(stiffness, mass));
            Spring { stiffness, damping, most }
        };
        (
            spring(self.translational_stiffness, self.translational_damping, mass, self.max_force),
            spring(self.rotational_stiffness, self.rotational_damping, inertia, self.max_torque),
        )
    }
}

impl CouplingSpec {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let Self::Virtual(spec) = self else { return Ok(()) };
        let VirtualCoupling { translational_stiffness: k, rotational_stiffness: k_turn, .. } = *spec;
        require((1.0..=1.0e6).contains(&k), "coupling.translational_stiffness", k, "1 to 1e6 N/m")?;
        require((1.0e-4..=1.0e4).contains(&k_turn), "coupling.rotational_stiffness", k_turn, "1e-4 to 1e4 N m/rad")?;
        let b = spec.translational_damping.unwrap_or(0.0);
        require((0.0..=1.0e5).contains(&b), "coupling.translational_damping", b, "0 to 1e5 N s/m")?;
        let b = spec.rotational_damping.unwrap_or(0.0);
        require((0.0..=1.0e3).contains(&b), "coupling.rotational_damping", b, "0 to 1e3 N m s/rad")?;
        let limit = |name, value: f32| {
            if value == f32::INFINITY { Ok(()) } else { require(value > 0.0, name, value, "above 0, or infinity for none") }
        };
        limit("coupling.max_force [N]", spec.max_force)?;
        limit("coupling.max_torque [N m]", spec.max_torque)
    }

    /// All numbers, for the fingerprint of the parameters.
    pub(crate) fn words(&self) -> [u32; 7] {
        let Self::Virtual(spec) = self else { return [0; 7] };
        // a given damping of -1 cannot be
        let damping = |given: Option<f32>| given.unwrap_or(-1.0);
        [
            1,
            spec.translational_stiffness.to_bits(),
            spec.rotational_stiffness.to_bits(),
            damping(spec.translational_damping).to_bits(),
            damping(spec.rotational_damping).to_bits(),
            spec.max_force.to_bits(),
            spec.max_torque.to_bits(),
        ]
    }
}

/// What the coupling keeps from tick to tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coupled {
    /// Handle `x_wh` of the last accepted tick.
    pub handle: Pose<World, ProbeFrame>,
    /// Probe `x_wp`.
    probe: Pose<World, ProbeFrame>,
    /// Lag \[m\], \[rad\].
    lag: (Vec3, Vec3),
    /// Velocity of the mass centre \[m/s\].
    velocity: Vec3,
    /// Angular momentum \[N m s\].
    angular_momentum: Vec3,
    /// What the damper holds \[N\], \[N m\].
    held: (Vec3, Vec3),
    /// Pull on the probe.
    pull: Wrench<World>,
    /// Motion of the probe's pose in the last tick \[m\], \[rad\], and the contact before it.
    moved: (Vec3, Vec3),
    contact_before: Wrench<World>,
    contact: Linear,
    /// Handle, probe and pull did not change in the last tick and will not until handle or contact do.
    pub at_rest: bool,
}

impl Coupled {
    /// At rest, with the probe at `probe` and the handle at `handle`.
    fn at(probe: Pose<World, ProbeFrame>, handle: Pose<World, ProbeFrame>) -> Self {
        Self {
            handle,
            probe,
            lag: (Vec3::ZERO, Vec3::ZERO),
            velocity: Vec3::ZERO,
            angular_momentum: Vec3::ZERO,
            held: (Vec3::ZERO, Vec3::ZERO),
            pull: Wrench::ZERO,
            moved: (Vec3::ZERO, Vec3::ZERO),
            contact_before: Wrench::ZERO,
            contact: Linear::default(),
            at_rest: false,
        }
    }

    /// Wrench of the coupling on the handle.
    pub fn on_handle(&self) -> Wrench<World> {
        Wrench::new(-self.pull.force, -self.pull.torque)
    }
}

/// Pose of the probe in the tick that begins with the handle at `handle`, `dt` after its last pose. A coupling that was not there before begins at rest at the probe's last pose.
#[inline]
pub(crate) fn probe_pose(
    model: &Model<'_>,
    params: &Params,
    memory: &mut Memory,
    handle: &Pose<World, ProbeFrame>,
    dt: f32,
    flags: &mut Flags,
) -> Pose<World, ProbeFrame> {
    let CouplingSpec::Virtual(spec) = &params.coupling else {
        memory.coupled = None;
        return *handle;
    };
    let start = memory.last_pose.unwrap_or(*handle);
    let contact = memory.contact;
    let coupled = memory.coupled.get_or_insert_with(|| Coupled::at(start, *handle));
    coupled.contact_before = contact;
    *flags |= integrate::advance(model, spec, coupled, handle, &contact, dt);
    coupled.probe
}

/// Keeps the contact's stiffness at the pose of this tick for the next.
#[inline]
pub(crate) fn linearise(model: &Model<'_>, params: &Params, memory: &mut Memory, patches: &[Patch]) {
    let Memory { coupled: Some(coupled), contact, .. } = memory else { return };
    let lost = (coupled.contact_before.force - contact.force, coupled.contact_before.torque - contact.torque);
    let missing = coupled.contact.missing;
    coupled.contact = stiffness::linearise(model, params, patches, &coupled.probe);
    coupled.contact.take_up(missing, coupled.moved, lost);
}

//! Force and torque about one point, expressed in one frame.

use core::marker::PhantomData;

use glam::Vec3;

use crate::frames::World;

/// Wrench **on the probe, about its mass centre**, expressed in frame `F`.
///
/// ```compile_fail
/// use haptor_contact::{ProbeFrame, Wrench, World};
/// fn command_device(_: Wrench<ProbeFrame>) {}
/// command_device(Wrench::<World>::ZERO); // a world wrench must not reach the device
/// ```
#[derive(Debug)]
pub struct Wrench<F = World> {
    /// Force \[N\].
    pub force: Vec3,
    /// Torque about the probe's mass centre \[N m\].
    pub torque: Vec3,
    frame: PhantomData<F>,
}

impl<F> Wrench<F> {
    /// No force, no torque.
    pub const ZERO: Self = Self::new(Vec3::ZERO, Vec3::ZERO);

    /// Wrench from force \[N\] and torque \[N m\].
    pub const fn new(force: Vec3, torque: Vec3) -> Self {
        Self { force, torque, frame: PhantomData }
    }

    /// True when every component is finite.
    pub fn is_finite(&self) -> bool {
        self.force.is_finite() && self.torque.is_finite()
    }
}

impl<F> Clone for Wrench<F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F> Copy for Wrench<F> {}

impl<F> PartialEq for Wrench<F> {
    fn eq(&self, other: &Self) -> bool {
        self.force == other.force && self.torque == other.torque
    }
}

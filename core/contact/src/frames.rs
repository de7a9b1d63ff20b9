//! Poses whose frames are part of the type, so that a pose of the handle cannot stand where one of the probe is meant.

use core::marker::PhantomData;

use glam::{Quat, Vec3};

/// Marker of the world frame `w`: origin at the object's base centre, +z up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct World;

/// Marker of the probe frame `p`: origin at the probe's mass centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProbeFrame;

/// Pose `x_ab` of frame `B` in frame `A`: a point q has `p_aq = position + rotation * p_bq`.
#[derive(Debug)]
pub struct Pose<A, B> {
    /// Position of B's origin in A \[m\].
    pub position: Vec3,
    /// Rotation from B to A, unit quaternion.
    pub rotation: Quat,
    frames: PhantomData<(A, B)>,
}

impl<A, B> Pose<A, B> {
    /// Pose from position \[m\] and unit quaternion.
    pub const fn new(position: Vec3, rotation: Quat) -> Self {
        Self { position, rotation, frames: PhantomData }
    }

    /// Both frames coincide.
    pub const IDENTITY: Self = Self::new(Vec3::ZERO, Quat::IDENTITY);

    /// Expresses the point `p_bq` in A \[m\].
    pub fn point(&self, p_bq: Vec3) -> Vec3 {
        self.position + self.rotation * p_bq
    }

    /// `x_ac = x_ab * x_bc`: the inner letters cancel.
    pub fn then<C>(&self, x_bc: &Pose<B, C>) -> Pose<A, C> {
        Pose::new(self.point(x_bc.position), self.rotation * x_bc.rotation)
    }

    /// `x_ba`.
    pub fn inverse(&self) -> Pose<B, A> {
        let rotation = self.rotation.conjugate();
        Pose::new(rotation * -self.position, rotation)
    }
}

impl<A, B> Clone for Pose<A, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A, B> Copy for Pose<A, B> {}

impl<A, B> PartialEq for Pose<A, B> {
    fn eq(&self, other: &Self) -> bool {
        self.position == other.position && self.rotation == other.rotation
    }
}

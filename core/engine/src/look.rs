//! What can be seen of an engine between two ticks, and the surface that follows from it, computed wherever there is time.

use haptor_contact::surface::Surface;
use haptor_contact::{Params, Patch, Pose, ProbeFrame, Vec3, World, Wrench};

use crate::engine::Engine;
use crate::frames::DeviceBase;

impl<'a> Engine<'a> {
    /// The patches in contact as of the last tick, oldest first.
    #[must_use]
    pub fn patches(&self) -> &[Patch] {
        self.state.patches()
    }

    /// The parameters that hold.
    #[must_use]
    pub const fn params(&self) -> &Params {
        &self.params
    }

    /// Pose `x_wp` of the probe as of the last tick; `None` before the first.
    #[must_use]
    pub fn probe_pose(&self) -> Option<Pose<World, ProbeFrame>> {
        self.state.probe_pose()
    }

    /// A wrench on the handle in world.
    #[must_use]
    pub fn in_world(&self, wrench: &Wrench<DeviceBase>) -> Wrench<World> {
        let q_wd = self.x_wd.rotation;
        Wrench::new(q_wd * wrench.force, q_wd * wrench.torque)
    }

    /// The deformed surface under patches of a tick of this scene, this engine's or another's; `p_wp` is where the probe's mass centre was in it \[m\].
    #[must_use]
    pub const fn surface<'b>(&'b self, params: &'b Params, patches: &'b [Patch], p_wp: Vec3, body: bool) -> Surface<'b>
    where
        'a: 'b,
    {
        Surface { model: &self.model, params, patches, p_wp, body }
    }
}

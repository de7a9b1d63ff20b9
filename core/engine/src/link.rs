//! Poses and wrenches of the device link, to and from the core's types.

use haptor_contact::{Pose, QUATERNION_TOLERANCE, Quat, Vec3, Wrench};
use haptor_wire::units::{NOT_A_NUMBER, newton_metres_to_unm, newtons_to_un, nm_to_metres, q30_to_unit};
use haptor_wire::{PoseReport, WrenchCommand};

use crate::frames::{DeviceBase, Handle};

/// The handle's pose `x_dh` of a report, renormalised; `None` when it is not a pose.
#[must_use]
pub fn handle_pose(report: &PoseReport) -> Option<Pose<DeviceBase, Handle>> {
    if report.position_nm.contains(&NOT_A_NUMBER) {
        return None;
    }
    let position = report.position_nm.map(nm_to_metres);
    Some(Pose::new(Vec3::from_array(position), quaternion(report.rotation_q30.map(q30_to_unit))?))
}

/// Unit quaternion of (w, x, y, z); `None` when it is not finite or too far from unit length.
pub(crate) fn quaternion([w, x, y, z]: [f32; 4]) -> Option<Quat> {
    let q = Quat::from_xyzw(x, y, z, w);
    // a NaN compares false
    ((q.length() - 1.0).abs() <= QUATERNION_TOLERANCE).then(|| q.normalize())
}

/// The command that answers report `echo` with `wrench`, to be rendered for `hold_us` \[us\] at most.
#[must_use]
pub fn command(seq: u32, echo: u32, wrench: &Wrench<DeviceBase>, hold_us: u32) -> WrenchCommand {
    let force_un = wrench.force.to_array().map(newtons_to_un);
    let torque_unm = wrench.torque.to_array().map(newton_metres_to_unm);
    WrenchCommand { seq, echo, force_un, torque_unm, hold_us }
}

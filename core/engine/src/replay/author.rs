//! Recordings without a device: the ticks that somebody asks for, answered by an engine.

use haptor_wire::TickRecord;

use crate::engine::Felt;

/// A tick as it is recorded: what `asked` says went in, what `felt` says came out. Times of a host are not touched.
#[must_use]
pub fn answered(asked: &TickRecord, felt: &Felt) -> TickRecord {
    TickRecord {
        force: felt.wrench.force.to_array(),
        torque: felt.wrench.torque.to_array(),
        contact_force: felt.contact_force,
        contact_torque: felt.contact_torque,
        regions: felt.regions,
        depth: felt.depth,
        radius: felt.radius,
        stick: felt.stick,
        tier: felt.tier,
        flags: felt.flags,
        ..*asked
    }
}

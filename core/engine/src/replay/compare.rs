//! What was recorded against what comes out again, to the bit.

use core::fmt;

use haptor_wire::{Digest, TickRecord, Tier, flags};

use crate::engine::Felt;

/// The core's bits of a tick's flags.
const CORE_FLAGS: u32 = (1 << 24) - 1;

/// With one of the host's bits but this, what went out was not what the core gave.
const AS_FELT: u32 = CORE_FLAGS | flags::LATE;

/// The first thing that differs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The tick.
    pub tick: u64,
    /// The field of [`TickRecord`], with its axis.
    pub field: &'static str,
    /// What was recorded.
    pub recorded: Value,
    /// What came out.
    pub computed: Value,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tick, field, recorded, computed } = self;
        write!(f, "tick {tick}, {field}: recorded {recorded}, computed {computed}")
    }
}

/// A field's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number; told in decimals and in bits.
    Number(f32),
    /// A count.
    Count(u8),
    /// A tier.
    Tier(Tier),
    /// Flags.
    Flags(u32),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Number(value) => write!(f, "{value} ({:#010x})", value.to_bits()),
            Self::Count(count) => write!(f, "{count}"),
            Self::Tier(tier) => f.write_str(tier.name()),
            Self::Flags(bits) => write!(f, "{bits:#x}"),
        }
    }
}

impl Value {
    /// Two values that are not numbers are the same: which bits they have is the machine's choice.
    fn is(self, other: Self) -> bool {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()),
            (a, b) => a == b,
        }
    }
}

const CONTACT_FORCE: [&str; 3] = ["contact_force.x [N]", "contact_force.y [N]", "contact_force.z [N]"];
const CONTACT_TORQUE: [&str; 3] = ["contact_torque.x [N m]", "contact_torque.y [N m]", "contact_torque.z [N m]"];
const FORCE: [&str; 3] = ["force.x [N]", "force.y [N]", "force.z [N]"];
const TORQUE: [&str; 3] = ["torque.x [N m]", "torque.y [N m]", "torque.z [N m]"];

/// The first field in which a tick's record and what came out differ.
#[must_use]
pub fn compare(recorded: &TickRecord, felt: &Felt) -> Option<Difference> {
    let (r, c) = (recorded, felt);
    let vectors = [(CONTACT_FORCE, r.contact_force, c.contact_force), (CONTACT_TORQUE, r.contact_torque, c.contact_torque)];
    let sent = [(FORCE, r.force, c.wrench.force.to_array()), (TORQUE, r.torque, c.wrench.torque.to_array())];
    let (number, went_out) = (Value::Number, r.flags & !AS_FELT == 0);
    let scalars = [
        ("regions", Value::Count(r.regions), Value::Count(c.regions)),
        ("depth [m]", number(r.depth), number(c.depth)),
        ("radius [m]", number(r.radius), number(c.radius)),
        ("stick", number(r.stick), number(c.stick)),
        ("tier", Value::Tier(r.tier), Value::Tier(c.tier)),
        ("flags of the core", Value::Flags(r.flags & CORE_FLAGS), Value::Flags(c.flags & CORE_FLAGS)),
    ];
    let axes = |(names, r, c): ([&'static str; 3], [f32; 3], [f32; 3])| {
        names.into_iter().zip(r.into_iter().zip(c)).map(|(name, (r, c))| (name, Value::Number(r), Value::Number(c)))
    };
    let sent = sent.into_iter().filter(|_| went_out).flat_map(axes);
    let mut all = vectors.into_iter().flat_map(axes).chain(scalars).chain(sent);
    let (field, recorded, computed) = all.find(|(_, recorded, computed)| !recorded.is(*computed))?;
    Some(Difference { tick: r.tick, field, recorded, computed })
}

/// Adds the bits of a tick's contact wrench to a digest of a session.
pub fn add_to_digest(digest: &mut Digest, felt: &Felt) {
    for value in felt.contact_force.iter().chain(&felt.contact_torque) {
        digest.add(&value.to_bits().to_le_bytes());
    }
}

//! The tool link: what the host tells whoever started it, over a pipe or a socket, as COBS + CRC32 frames.
//!
//! One way: host to tool. It carries no command and nothing of it is needed for the loop to run, so a slow or dead reader costs
//! the real-time thread nothing. f32 is allowed here, both ends are computers with floating point. Forces and torques are those
//! of the contact on the probe, about its mass centre, in world `w`.

use serde::{Deserialize, Serialize};

use crate::device::{ENUM, F32, FaultCause, U16, U32, U64};

/// Everything the host says to a tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum FromHost {
    /// The device has answered and the loop is about to start.
    Hello(SessionHello),
    /// How it goes, some ten times a second.
    Progress(Progress),
    /// A fault has latched.
    Fault(FaultRecord),
    /// The session has ended; the last message.
    Summary(Summary),
}

impl FromHost {
    /// Postcard bytes at most, the byte that names the message included.
    pub const MAX_ENCODED: usize = 1 + Summary::MAX_ENCODED;
}

/// Who is talking, and to which device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SessionHello {
    /// [`crate::PROTOCOL_VERSION`] of the host.
    pub version: u16,
    /// [`crate::TOOL_SCHEMA_HASH`] of the host.
    pub schema: u32,
    /// Length of a tick \[us\].
    pub period_us: u32,
    /// The device's model, ASCII, padded with zeros.
    pub device_name: [u8; 12],
    /// The device's serial number, ASCII, padded with zeros.
    pub device_serial: [u8; 12],
    /// Largest force it renders \[uN\].
    pub max_force_un: u32,
    /// Largest torque it renders \[uN m\]; 0 = none.
    pub max_torque_unm: u32,
    /// What the real-time policy obtained.
    pub rt: RtReport,
    /// What a tick may spend at first \[instructions of the core's x86-64 release build\]; `None` is no limit.
    pub work: Option<u32>,
}

impl SessionHello {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U16 + 2 * U32 + 24 + 2 * U32 + RtReport::MAX_ENCODED + (1 + U32);
}

/// How the session goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Ticks so far.
    pub tick: u64,
    /// Regions in the last tick.
    pub regions: u8,
    /// Contact force on the probe, in `w` \[N\].
    pub force: [f32; 3],
    /// Contact torque on the probe about its mass centre, in `w` \[N m\].
    pub torque: [f32; 3],
    /// What the last step of the core took \[ns\].
    pub step_ns: u32,
    /// Share of ticks in time so far \[1/1000\].
    pub in_time_permille: u16,
    /// The latched fault, if any.
    pub fault: Option<HostFault>,
}

impl Progress {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = U64 + 1 + 6 * F32 + U32 + U16 + HostFault::MAX_OPTION;
}

/// A fault and when it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// What went wrong.
    pub cause: HostFault,
    /// The tick in which it latched.
    pub tick: u64,
    /// Ticks from the first sign to zero wrench.
    pub after_ticks: u32,
}

impl FaultRecord {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = HostFault::MAX_ENCODED + U64 + U32;
}

/// Why the host took the wrench to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum HostFault {
    /// The link closed, reported an error, or took nothing for [`Overrun`](Self::Overrun)'s time.
    LinkLost,
    /// No new pose for longer than the hold.
    Stale,
    /// What arrived was mostly not messages.
    Garbage,
    /// The device began its counting again within a session.
    DeviceRestarted,
    /// The device reported a fault that has no name of its own here, or never granted force.
    DeviceFault,
    /// The device's watchdog ran out.
    DeviceWatchdog,
    /// The handle moved faster than the device allows.
    DeviceOverSpeed,
    /// The device refused a command as non-finite.
    DeviceNonFinite,
    /// Device and host speak different versions or tables.
    VersionMismatch,
    /// A pose or a wrench was not finite.
    NonFinite,
    /// Too many ticks were late.
    Overrun,
}

impl HostFault {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = ENUM;
    /// Postcard bytes at most of an `Option` of it.
    pub const MAX_OPTION: usize = 1 + Self::MAX_ENCODED;

    /// Every fault, in the order of the wire.
    pub const ALL: [Self; 11] = [
        Self::LinkLost,
        Self::Stale,
        Self::Garbage,
        Self::DeviceRestarted,
        Self::DeviceFault,
        Self::DeviceWatchdog,
        Self::DeviceOverSpeed,
        Self::DeviceNonFinite,
        Self::VersionMismatch,
        Self::NonFinite,
        Self::Overrun,
    ];

    /// The fault in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LinkLost => "link lost",
            Self::Stale => "pose stale",
            Self::Garbage => "garbage on the link",
            Self::DeviceRestarted => "device restarted",
            Self::DeviceFault => "device fault",
            Self::DeviceWatchdog => "device watchdog ran out",
            Self::DeviceOverSpeed => "device over-speed",
            Self::DeviceNonFinite => "device refused a non-finite command",
            Self::VersionMismatch => "version mismatch",
            Self::NonFinite => "non-finite pose or wrench",
            Self::Overrun => "too many ticks late",
        }
    }
}

impl From<FaultCause> for HostFault {
    /// How the host names a fault that the device reported.
    fn from(cause: FaultCause) -> Self {
        match cause {
            FaultCause::Watchdog => Self::DeviceWatchdog,
            FaultCause::OverSpeed => Self::DeviceOverSpeed,
            FaultCause::NonFinite => Self::DeviceNonFinite,
            FaultCause::VersionMismatch => Self::VersionMismatch,
            FaultCause::Protocol | FaultCause::Hardware => Self::DeviceFault,
        }
    }
}

/// The session in figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Ticks run.
    pub ticks: u64,
    /// Ticks whose wrench was sent within their period.
    pub in_time: u64,
    /// Ticks that were not.
    pub late: u64,
    /// Poses that never came, by gaps in their numbers.
    pub lost: u64,
    /// Frames rejected: checksum, length or contents.
    pub rejected: u64,
    /// Poses older than one already used.
    pub out_of_order: u64,
    /// Ticks that the recorder could not keep up with.
    pub recorder_dropped: u64,
    /// Largest magnitude of the contact force over the ticks that were felt ([`crate::TickRecord::was_felt`]) \[N\].
    pub peak_force: f32,
    /// Largest magnitude of the contact torque about the probe's mass centre over the same ticks \[N m\].
    pub peak_torque: f32,
    /// What a step of the core took.
    pub step_ns: Quantiles,
    /// How late the thread woke.
    pub wake_ns: Quantiles,
    /// From sending a wrench to the report that echoes it.
    pub round_trip_ns: Quantiles,
    /// What the real-time policy obtained.
    pub rt: RtReport,
    /// The latched fault, if any.
    pub fault: Option<HostFault>,
}

impl Summary {
    /// Postcard bytes at most, without the byte that names the message.
    pub const MAX_ENCODED: usize = 7 * U64 + 2 * F32 + 3 * Quantiles::MAX_ENCODED + RtReport::MAX_ENCODED + HostFault::MAX_OPTION;
}

/// Quantiles of a duration over a session \[ns\]; each is the upper edge of its histogram bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Quantiles {
    /// Median.
    pub p50: u32,
    /// 99 in 100.
    pub p99: u32,
    /// 999 in 1,000.
    pub p999: u32,
    /// 9,999 in 10,000.
    pub p9999: u32,
    /// Largest.
    pub max: u32,
}

impl Quantiles {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 5 * U32;
}

/// What the real-time policy asked of the system and got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RtReport {
    /// The thread runs under `SCHED_FIFO`.
    pub fifo: bool,
    /// Memory is locked.
    pub locked: bool,
    /// The thread is pinned to one CPU.
    pub pinned: bool,
    /// Deep CPU sleep is held off through `/dev/cpu_dma_latency`.
    pub dma_latency: bool,
}

impl RtReport {
    /// Postcard bytes at most.
    pub const MAX_ENCODED: usize = 4;
}

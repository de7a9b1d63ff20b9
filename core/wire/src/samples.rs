//! One value of every message, at the extremes of its encoding and in between, for the tests of this crate.

use crate::{
    BakedScene, Breakaway, Chunk, Compliance, Coupling, Deformation, DeviceFault, DeviceHello, Event, FaultCause, FaultRecord,
    ForceLaw, GuardLimits, HostFault, HostHello, Inertia, Mode, ObjectShape, Passivity, Place, PoseReport, ProbePart, ProbeParts,
    ProbeShape, Progress, Quantiles, RecordHeader, RtReport, SessionHello, Summary, TickRecord, Tier, Tuning, VirtualCoupling,
    What, WrenchCommand,
};

pub const DEVICE_HELLO: DeviceHello = DeviceHello {
    version: u16::MAX,
    schema: u32::MAX,
    name: [0xFF; 12],
    serial: [0xFF; 12],
    max_force_un: u32::MAX,
    max_torque_unm: u32::MAX,
    watchdog_ticks: u16::MAX,
};
pub const HOST_HELLO: HostHello = HostHello { version: u16::MAX, schema: u32::MAX, period_us: u32::MAX };
pub const POSE: PoseReport = PoseReport {
    seq: u32::MAX,
    t_us: u32::MAX,
    position_nm: [i32::MIN; 3],
    rotation_q30: [i32::MIN; 4],
    buttons: u8::MAX,
    mode: Mode::Brake,
    flags: u8::MAX,
    echo: u32::MAX,
};
pub const WRENCH: WrenchCommand =
    WrenchCommand { seq: u32::MAX, echo: u32::MAX, force_un: [i32::MIN; 3], torque_unm: [i32::MIN; 3], hold_us: u32::MAX };
pub const FAULT: DeviceFault = DeviceFault { cause: FaultCause::Hardware, seq: u32::MAX, detail: i32::MIN };
pub const RT: RtReport = RtReport { fifo: true, locked: true, pinned: true, dma_latency: true };
pub const SESSION: SessionHello = SessionHello {
    version: u16::MAX,
    schema: u32::MAX,
    period_us: u32::MAX,
    device_name: [0xFF; 12],
    device_serial: [0xFF; 12],
    max_force_un: u32::MAX,
    max_torque_unm: u32::MAX,
    rt: RT,
    work: Some(u32::MAX),
};
pub const PROGRESS: Progress = Progress {
    tick: u64::MAX,
    regions: u8::MAX,
    force: [f32::MIN; 3],
    torque: [f32::MIN; 3],
    step_ns: u32::MAX,
    in_time_permille: u16::MAX,
    fault: Some(HostFault::Overrun),
};
pub const FAULT_RECORD: FaultRecord = FaultRecord { cause: HostFault::Overrun, tick: u64::MAX, after_ticks: u32::MAX };
pub const QUANTILES: Quantiles = Quantiles { p50: u32::MAX, p99: u32::MAX, p999: u32::MAX, p9999: u32::MAX, max: u32::MAX };
pub const SUMMARY: Summary = Summary {
    ticks: u64::MAX,
    in_time: u64::MAX,
    late: u64::MAX,
    lost: u64::MAX,
    rejected: u64::MAX,
    out_of_order: u64::MAX,
    recorder_dropped: u64::MAX,
    peak_force: f32::MAX,
    peak_torque: f32::MAX,
    step_ns: QUANTILES,
    wake_ns: QUANTILES,
    round_trip_ns: QUANTILES,
    rt: RT,
    fault: Some(HostFault::Overrun),
};
pub const HEADER: RecordHeader = RecordHeader {
    version: u16::MAX,
    schema: u32::MAX,
    rate_hz: u32::MAX,
    scene_digest: u64::MAX,
    start_unix_s: u32::MAX,
    schema_bytes: u32::MAX,
    scene_bytes: u32::MAX,
};
pub const CHUNK: Chunk<'static> = Chunk { at: u32::MAX, bytes: &[0; crate::recording::CHUNK_BYTES] };
pub const EVENT: Event = Event { tick: u64::MAX, what: What::Mark };
pub const TICK: TickRecord = TickRecord {
    tick: u64::MAX,
    t_us: u64::MAX,
    position: [f32::MIN; 3],
    rotation: [f32::MIN; 4],
    force: [f32::MIN; 3],
    torque: [f32::MIN; 3],
    contact_force: [f32::MIN; 3],
    contact_torque: [f32::MIN; 3],
    regions: u8::MAX,
    depth: f32::MIN,
    radius: f32::MIN,
    stick: f32::MIN,
    tier: Tier::Green,
    flags: u32::MAX,
    wake_ns: u32::MAX,
    step_ns: u32::MAX,
    round_trip_ns: u32::MAX,
};
pub const COMPLIANCE: Compliance = Compliance { normal: 1e-5, drag: 2e-5, twist: 3e-2 };
pub const INERTIA: Inertia = Inertia { moments: [1e-4, 2e-4, 2.5e-4], products: [0.0, 1e-5, -1e-5] };
pub const PLACE: Place = Place { p_wd: [0.0, 0.0, 0.125], q_wd: [1.0, 0.0, 0.0, 0.0] };
pub const PART: ProbePart = ProbePart {
    shape: ProbeShape::Ellipsoid { semi_axes: [0.01, 0.02, 0.03] },
    position: [0.0, 0.0, 0.01],
    rotation: [0.0, 1.0, 0.0, 0.0],
};

pub const LAW: ForceLaw = ForceLaw::Table { step: 1e-4, force: [0.5; 16] };
pub const GUARD: GuardLimits = GuardLimits {
    max_force: 3.0,
    max_torque: f32::INFINITY,
    max_force_rate: 100.0,
    max_torque_rate: f32::INFINITY,
    ramp_in: 0.25,
    passivity: Some(PASSIVITY),
};
pub const PASSIVITY: Passivity =
    Passivity { max_damping: 5.0, max_spin_damping: 0.004, allowance: 1e-6, reserve: 0.1, delay_ticks: 8 };
pub const COUPLING: VirtualCoupling = VirtualCoupling {
    translational_stiffness: Some(800.0),
    rotational_stiffness: Some(0.3),
    translational_damping: Some(20.0),
    rotational_damping: Some(0.01),
    max_force: 8.5,
    max_torque: f32::INFINITY,
};

pub const TUNING: Tuning = Tuning {
    tier: Tier::Green,
    samples: u16::MAX,
    sweeps: 4,
    friction_static: 0.8,
    friction_dynamic: 0.75,
    region_distance: 0.004,
    max_regions: 10,
    breakaway: Breakaway::Smooth,
    deformation: Deformation::Full,
    gravity: true,
    work: Some(u32::MAX),
    force_law: LAW,
    guard: GUARD,
};

/// The largest scene: every part in use, every option given.
pub fn scene() -> BakedScene {
    BakedScene {
        object: ObjectShape::Box { size: [0.1; 3] },
        fixed_below: 0.0,
        young_modulus: 3e6,
        poisson_ratio: 0.5,
        density: 1100.0,
        compliance: Some(COMPLIANCE),
        probe: ProbeParts::from_slice(&[PART; 16]).unwrap(),
        mass: 1.0,
        inertia: Some(INERTIA),
        friction_static: 0.8,
        friction_dynamic: 0.75,
        region_distance: 0.004,
        max_regions: 10,
        tier: Tier::Bristle,
        samples: u16::MAX,
        sweeps: 4,
        deformation: Deformation::Full,
        coupling: Coupling::Virtual(COUPLING),
        breakaway: Breakaway::Smooth,
        gravity: true,
        work: Some(u32::MAX),
        force_law: LAW,
        guard: GUARD,
        paper_length: 0.1,
        place: PLACE,
    }
}

//! The messages of the topics, as their schemas say.

use haptor_wire::TickRecord;
use serde::Serialize;

use crate::session::recording::Happening;

/// Nanoseconds since 1970 as Foxglove's schemas want them.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Time {
    sec: u64,
    nsec: u64,
}

/// Nanoseconds of a second.
const SECOND: u64 = 1_000_000_000;

impl Time {
    /// Of nanoseconds since 1970.
    pub const fn of(ns: u64) -> Self {
        Self { sec: ns / SECOND, nsec: ns % SECOND }
    }

    /// As nanoseconds since 1970.
    pub const fn ns(self) -> u64 {
        self.sec * SECOND + self.nsec
    }
}

#[derive(Serialize)]
struct Vector {
    x: f32,
    y: f32,
    z: f32,
}

impl From<[f32; 3]> for Vector {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

#[derive(Serialize)]
struct Quaternion {
    x: f32,
    y: f32,
    z: f32,
    w: f32,
}

impl From<[f32; 4]> for Quaternion {
    /// From the scalar first, as the wire has it.
    fn from([w, x, y, z]: [f32; 4]) -> Self {
        Self { x, y, z, w }
    }
}

/// `haptor.Tick`.
#[derive(Serialize)]
pub struct Tick {
    timestamp: Time,
    tick: u64,
    contact_force: Vector,
    contact_torque: Vector,
    sent_force: Vector,
    sent_torque: Vector,
    regions: u8,
    depth: f32,
    radius: f32,
    stick: f32,
    tier: &'static str,
    flags: u32,
    felt: bool,
    wake_us: f64,
    step_us: f64,
    round_trip_us: f64,
}

impl Tick {
    /// Of a record.
    pub fn new(timestamp: Time, tick: &TickRecord) -> Self {
        let [wake_us, step_us, round_trip_us] = [tick.wake_ns, tick.step_ns, tick.round_trip_ns].map(|ns| f64::from(ns) / 1.0e3);
        Self {
            timestamp,
            tick: tick.tick,
            contact_force: tick.contact_force.into(),
            contact_torque: tick.contact_torque.into(),
            sent_force: tick.force.into(),
            sent_torque: tick.torque.into(),
            regions: tick.regions,
            depth: tick.depth,
            radius: tick.radius,
            stick: tick.stick,
            tier: tick.tier.name(),
            flags: tick.flags,
            felt: tick.was_felt(),
            wake_us,
            step_us,
            round_trip_us,
        }
    }
}

#[derive(Serialize)]
struct Pose {
    position: Vector,
    orientation: Quaternion,
}

/// `foxglove.PoseInFrame`.
#[derive(Serialize)]
pub struct Handle {
    timestamp: Time,
    frame_id: &'static str,
    pose: Pose,
}

impl Handle {
    /// The handle in the device's frame.
    pub fn new(timestamp: Time, tick: &TickRecord) -> Self {
        let pose = Pose { position: tick.position.into(), orientation: tick.rotation.into() };
        Self { timestamp, frame_id: "device", pose }
    }
}

/// `foxglove.FrameTransform`.
#[derive(Serialize)]
pub struct Moved {
    timestamp: Time,
    parent_frame_id: &'static str,
    child_frame_id: &'static str,
    translation: Vector,
    rotation: Quaternion,
}

impl Moved {
    /// The device in the world.
    pub fn new(timestamp: Time, p_wd: [f32; 3], q_wd: [f32; 4]) -> Self {
        let (translation, rotation) = (p_wd.into(), q_wd.into());
        Self { timestamp, parent_frame_id: "world", child_frame_id: "device", translation, rotation }
    }
}

/// `foxglove.Log`.
#[derive(Serialize)]
pub struct Log {
    timestamp: Time,
    level: u8,
    message: String,
    name: &'static str,
    file: &'static str,
    line: u32,
}

/// Levels of `foxglove.Log`.
const INFO: u8 = 2;
const WARNING: u8 = 3;
const ERROR: u8 = 4;

impl Log {
    /// What happened, in words.
    pub fn new(timestamp: Time, what: &Happening, message: String) -> Self {
        let level = match what {
            Happening::Fault(_) => ERROR,
            Happening::Lost(_) | Happening::Damaged(_) => WARNING,
            _ => INFO,
        };
        Self { timestamp, level, message, name: "haptor", file: "", line: 0 }
    }
}

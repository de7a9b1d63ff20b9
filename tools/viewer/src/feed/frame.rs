//! One moment: what the probe, the object and the session are like at a tick.

use std::sync::Arc;

use glam::{DQuat, DVec3, Vec3};

/// What one moment looks like. Values that are not finite are drawn as nothing and counted.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Number of the tick.
    pub tick: u64,
    /// Time since the session began \[s\].
    pub time: f64,
    /// Pose `x_wp` of the probe.
    pub probe: Pose,
    /// Wrench of the contact on the probe.
    pub contact: Wrench,
    /// Wrench sent to the device; `None` when none was.
    pub sent: Option<Wrench>,
    /// Regions in contact, oldest first.
    pub regions: Vec<Region>,
    /// How far the vertices of [`Stage::object`](super::Stage::object) have moved; `None` = the object at rest.
    pub displacement: Option<Displacement>,
    /// Largest depth \[m\]; 0 without contact.
    pub depth: f64,
    /// Tier that computed the tick, in words.
    pub tier: String,
    /// What was clamped, refused or late in this tick, in words; empty = clean.
    pub flags: Vec<String>,
    /// How long things took; `None` where there is no clock, as in a table of poses.
    pub timing: Option<Timing>,
    /// The latched fault.
    pub fault: Option<Fault>,
    /// What the session is doing.
    pub mode: Mode,
    /// A recording is being written.
    pub recording: bool,
}

/// Where a body is: its frame in world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position in world \[m\].
    pub position: DVec3,
    /// Rotation to world, unit quaternion.
    pub rotation: DQuat,
}

impl Pose {
    /// Every part a number, the rotation not zero.
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite() && self.rotation.length_squared() > 0.0
    }
}

/// Force and torque in world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force \[N\].
    pub force: DVec3,
    /// Torque \[N m\].
    pub torque: DVec3,
}

/// A contact region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Centre in world \[m\].
    pub centre: DVec3,
    /// Unit normal out of the object.
    pub normal: DVec3,
    /// Contact radius \[m\].
    pub radius: f64,
    /// Radius of the stuck core \[m\], 0 to `radius`.
    pub stick_radius: f64,
    /// Force on the probe \[N\].
    pub force: DVec3,
    /// Torque on the probe about the region's centre \[N m\].
    pub torque: DVec3,
    /// Pressure, where the source knows it; `None` = by Hertz from force and radius.
    pub pressure: Option<Pressure>,
}

impl Region {
    /// Radius \[m\] of the stuck core of a region of `radius` \[m\] of whose area the share `stuck` (0 to 1) sticks.
    pub fn core(radius: f64, stuck: f64) -> f64 {
        radius * stuck.clamp(0.0, 1.0).sqrt()
    }

    /// Largest pressure \[Pa\]: as given, or of Hertz' profile, 3/2 of the mean (Johnson, Contact Mechanics, eq. 4.24). 0 without extent.
    pub fn peak_pressure(&self) -> f64 {
        let area = std::f64::consts::PI * self.radius * self.radius;
        let hertz = || if area > 0.0 { 1.5 * self.force.dot(self.normal).max(0.0) / area } else { 0.0 };
        self.pressure.map_or_else(hertz, |pressure| pressure.peak)
    }

    /// Every part a number, the radii not negative, the normal not zero.
    pub fn is_finite(&self) -> bool {
        let vectors = [self.centre, self.normal, self.force, self.torque];
        let radii = self.radius >= 0.0 && self.stick_radius >= 0.0 && (self.radius + self.stick_radius).is_finite();
        vectors.iter().all(|v| v.is_finite()) && radii && self.normal.length_squared() > 0.0 && self.peak_pressure().is_finite()
    }
}

/// Pressure over a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressure {
    /// Mean \[Pa\].
    pub mean: f64,
    /// Largest \[Pa\].
    pub peak: f64,
}

/// How far the object's surface has moved. Shared: a surface comes more seldom than a pose.
#[derive(Clone, Debug)]
pub struct Displacement {
    /// Tick it belongs to; may be older than the frame's.
    pub tick: u64,
    /// One vector for each vertex of the stage's object, in world \[m\]; a list of another length is not drawn.
    pub moved: Arc<[Vec3]>,
}

/// How long things took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// One step of the core \[us\].
    pub step_us: f64,
    /// How late the thread woke \[us\].
    pub wake_us: f64,
    /// Share of the ticks so far that were in time, 0 to 1.
    pub in_time: f64,
}

/// A latched fault, for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What went wrong.
    pub what: String,
    /// What to do about it.
    pub advice: String,
}

/// What a session is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Mode {
    /// No host answers, or it has gone.
    #[default]
    Disconnected,
    /// Ticks run and the device feels them.
    Running,
    /// Ticks run on, the force is zero; contact and picture stand.
    Frozen,
    /// The device brakes and feels nothing until it is re-armed.
    Braked,
    /// A recording is played.
    Replaying(Playback),
}

/// Where the playing of a recording stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Playback {
    /// Time shown, from the recording's begin \[s\].
    pub at: f64,
    /// Length of the recording \[s\].
    pub end: f64,
    /// It runs by itself.
    pub playing: bool,
    /// Seconds of recording a second.
    pub speed: f64,
}

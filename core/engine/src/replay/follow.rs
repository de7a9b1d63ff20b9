//! Does with an engine what the records say was done.

use core::fmt;

use haptor_contact::{Pose, Vec3};
use haptor_wire::{Record, RecordHeader, TickRecord, flags};

use crate::engine::{Engine, Felt};
use crate::frames::{DeviceBase, Handle};
use crate::link::quaternion;
use crate::tuned::Placed;

/// Why a tick cannot be held against its record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unsure {
    /// The recording begins in the middle of a session, and no rest came yet.
    NoRest,
    /// Something before it is damaged, and no rest came since.
    Damaged,
    /// Something before it was never recorded, and no rest came since.
    Lost,
    /// The scene refuses the device, the tuning or the place that was recorded.
    Refused,
}

impl fmt::Display for Unsure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoRest => "the recording begins in the middle of a session",
            Self::Damaged => "the file is damaged before them",
            Self::Lost => "the recorder lost records before them",
            Self::Refused => "the scene refuses what the recording was tuned to",
        })
    }
}

/// What a record came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// No tick.
    Noted,
    /// A tick in which no pose came: the core did not run.
    Idle,
    /// A tick, computed; whether it can be held against its record.
    Felt(Felt, Result<(), Unsure>),
}

/// Follows the records of one scene.
#[derive(Clone, Copy, Debug)]
pub struct Follower {
    rate_hz: u32,
    /// Device, tuning and place are those of the recording.
    known: [bool; 3],
    sure: Result<(), Unsure>,
    /// The last tick in which the core ran.
    stepped_at: Option<u64>,
}

const DEVICE: usize = 0;
const TUNING: usize = 1;
const PLACE: usize = 2;

impl Follower {
    /// Behind a header: device, tuning and place are the scene's own until something else is said.
    #[must_use]
    pub const fn new(header: &RecordHeader) -> Self {
        Self { rate_hz: header.rate_hz, known: [true; 3], sure: Err(Unsure::NoRest), stepped_at: None }
    }

    /// Records are missing here: nothing that was said before is sure any more.
    pub const fn missed(&mut self, why: Unsure) {
        (self.known, self.sure) = ([false; 3], Err(why));
    }

    /// Does what `record` says was done. The engine is the scene's; after a header take a new one, and a new follower.
    pub fn take(&mut self, engine: &mut Engine<'_>, record: &Record<'_>) -> Step {
        match record {
            Record::Device(hello) => {
                // where it cannot be fitted the core's own limits stand, as they did in the host
                let _ = engine.fit_limits(hello.max_force_un, hello.max_torque_unm);
                self.known[DEVICE] = true;
            }
            Record::Tuning(tuning) => self.know(TUNING, engine.tuned(tuning).map(|tuned| engine.tune(&tuned)).is_ok()),
            Record::Place(place) => self.know(PLACE, Placed::new(place).map(|placed| engine.place(&placed)).is_ok()),
            Record::Rest => self.rest(engine),
            Record::Tick(tick) => return self.tick(engine, tick),
            Record::Lost { .. } => self.missed(Unsure::Lost),
            Record::Header(_) | Record::Schema(_) | Record::Scene(_) | Record::Event(_) | Record::Fault(_) | Record::End(_) => {}
        }
        Step::Noted
    }

    fn know(&mut self, which: usize, taken: bool) {
        self.known[which] = taken;
        if !taken {
            self.sure = Err(Unsure::Refused);
        }
    }

    fn rest(&mut self, engine: &mut Engine<'_>) {
        engine.rest();
        self.stepped_at = None;
        if self.known == [true; 3] {
            self.sure = Ok(());
        }
    }

    fn tick(&mut self, engine: &mut Engine<'_>, tick: &TickRecord) -> Step {
        match self.asked(tick) {
            Some((x_dh, dt)) => Step::Felt(engine.step(&x_dh, dt), self.sure),
            None => Step::Idle,
        }
    }

    /// What the core is to be stepped with at a tick: the handle's pose, and the time since the tick before \[s\]. `None` when no pose came.
    pub fn asked(&mut self, tick: &TickRecord) -> Option<(Pose<DeviceBase, Handle>, f32)> {
        if tick.flags & flags::NO_POSE != 0 {
            return None;
        }
        let since = self.stepped_at.map_or(Some(1), |at| tick.tick.checked_sub(at));
        // what the host stepped the core with was a pose: the frame's checksum agrees, so whoever wrote it was no host
        let Some(x_dh) = pose(tick) else {
            self.missed(Unsure::Damaged);
            return None;
        };
        if since.is_none() {
            self.missed(Unsure::Damaged);
        }
        let dt = (since.unwrap_or(1) as f64 / f64::from(self.rate_hz)) as f32;
        self.stepped_at = Some(tick.tick);
        Some((x_dh, dt))
    }
}

/// The pose that a tick was computed at; `None` when it is none.
fn pose(tick: &TickRecord) -> Option<Pose<DeviceBase, Handle>> {
    Some(Pose::new(Vec3::from_array(tick.position), quaternion(tick.rotation)?))
}

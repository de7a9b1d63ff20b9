//! What survives a tick.

use glam::Vec2;
use heapless::Vec;

use crate::budget::{Account, Rung};
use crate::coupling::Coupled;
use crate::frames::{Pose, ProbeFrame, World};
use crate::guard::GuardState;
use crate::patch::Patch;
use crate::report::Flags;
use crate::scratch::Contact;
use crate::tier::bristle::Bristle;
use crate::tier::influence::Trace;
use crate::wrench::Wrench;

/// Memory of a session: patches with their stick, samples, the guard's last wrench, counters.
///
/// `PATCHES` bounds the parts in contact at once (16 covers every probe), `SAMPLES` the bristles or cells of one patch: none for the tiers `point` and `paper`, 16 to 256 for `bristle`, at least
/// 80 (52 cells) or 156 (112 cells) for `influence` and `green`. `TRACES` is what those two remember beside the samples' forces: as many as samples, or none for the other tiers. A tier
/// that finds too little room is lowered, and the report says so.
#[derive(Clone, Debug)]
pub struct State<const PATCHES: usize, const SAMPLES: usize, const TRACES: usize = 0> {
    pub(crate) memory: Memory,
    pub(crate) patches: Vec<Patch, PATCHES>,
    /// Contacts of the last tick, those of patches first where there is no room for all: those that the next does not look at are carried on.
    pub(crate) seen: Vec<Contact, PATCHES>,
    pub(crate) samples: [[Bristle; SAMPLES]; PATCHES],
    pub(crate) traces: [[Trace; TRACES]; PATCHES],
}

/// The part of the state whose size does not depend on capacities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Memory {
    /// Last pose of the probe; `None` before the first tick.
    pub last_pose: Option<Pose<World, ProbeFrame>>,
    /// Time since it \[s\].
    pub since_last_pose: f32,
    /// Fingerprint of the parameters under which the last tick had the pose of the one before.
    pub settled_for: Option<u32>,
    /// Rung, and fingerprint of the parameters, of the last tick.
    pub rung: Option<Rung>,
    pub fingerprint: Option<u32>,
    /// Flags of the last tick that was computed.
    pub flags: Flags,
    /// Last contact wrench.
    pub contact: Wrench<World>,
    /// The virtual coupling; `None` when the handle is the probe.
    pub coupled: Option<Coupled>,
    pub guard: GuardState,
    /// The work budget's ladders.
    pub account: Account,
    /// Serial number of the next birth.
    pub next_serial: u32,
    pub refused: u32,
    pub poses_refused: u32,
    pub high_water: u8,
    /// A region has just given way to one that is not born yet.
    pub handed_over: bool,
}

impl Memory {
    /// Last accepted pose of the handle.
    pub fn last_handle(&self) -> Option<Pose<World, ProbeFrame>> {
        self.coupled.as_ref().map_or(self.last_pose, |coupled| Some(coupled.handle))
    }

    /// What the hand should feel: the coupling where there is one, else the contact.
    pub fn wanted(&self) -> Wrench<World> {
        self.coupled.as_ref().map_or(self.contact, Coupled::on_handle)
    }
}

impl<const PATCHES: usize, const SAMPLES: usize, const TRACES: usize> State<PATCHES, SAMPLES, TRACES> {
    /// A state without history.
    pub const fn new() -> Self {
        const { assert!(PATCHES >= 1 && PATCHES <= crate::limits::MAX_PARTS) };
        const { assert!(SAMPLES == 0 || SAMPLES >= crate::limits::MIN_SAMPLES && SAMPLES <= crate::limits::MAX_BRISTLES) };
        const { assert!(TRACES == 0 || TRACES == SAMPLES) };
        Self {
            memory: Memory {
                last_pose: None,
                since_last_pose: 0.0,
                settled_for: None,
                rung: None,
                fingerprint: None,
                flags: Flags::CLEAN,
                contact: Wrench::ZERO,
                coupled: None,
                guard: GuardState::START,
                account: Account::NEW,
                next_serial: 0,
                refused: 0,
                poses_refused: 0,
                high_water: 0,
                handed_over: false,
            },
            patches: Vec::new(),
            seen: Vec::new(),
            samples: [[Bristle { force: Vec2::ZERO, slipped: 0.0 }; SAMPLES]; PATCHES],
            traces: [[Trace { lack: Vec2::ZERO, change: Vec2::ZERO }; TRACES]; PATCHES],
        }
    }

    /// Pose `x_wp` of the probe as of the last tick: the handle's when the coupling is direct. `None` before the first tick.
    pub fn probe_pose(&self) -> Option<Pose<World, ProbeFrame>> {
        self.memory.last_pose
    }

    /// The patches in contact, oldest first.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }
}

impl<const PATCHES: usize, const SAMPLES: usize, const TRACES: usize> Default for State<PATCHES, SAMPLES, TRACES> {
    fn default() -> Self {
        Self::new()
    }
}

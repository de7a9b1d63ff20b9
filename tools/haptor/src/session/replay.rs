//! A recording played: for any tick its record, and the contact computed again as it was felt.
//!
//! The whole recording is computed once, and the engine's memory kept every so many ticks; a tick asked for later is computed from the last memory before it, or from where the
//! player stands. Memories are bounded: when there are too many every other one is forgotten, and they are kept half as often.

use std::fmt::Write;

use haptor_contact::{PatchReport, Pose, ProbeFrame, Vec3, World, patch_report};
use haptor_engine::replay::{Follower, Step, Unsure, compare};
use haptor_engine::{Felt, Kept, OwnedEngine};
use haptor_wire::{Deformation, Record, TickRecord};
use serde_json::{Value, json};

use super::recording::{Happening, Recording};

/// Ticks between two memories at first: some milliseconds of computing.
const KEEP_EVERY: usize = 256;

/// Memories at most: 130 kB each, 50 MB in all, every 2048 ticks of ten minutes at 1 kHz.
const KEPT_MAX: usize = 400;

/// Ticks between two words about how far the first run is.
const TELL_EVERY: usize = 4096;

/// A recording and an engine for each of its scenes.
#[derive(Debug)]
pub struct Player {
    recording: Recording,
    engines: Vec<Option<OwnedEngine>>,
    kept: Vec<Memory>,
    every: usize,
    now: Place,
    /// What the tick before `now` came to.
    last: Option<Step>,
}

/// Where in the recording the player stands.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// The next tick, by its index.
    tick: usize,
    /// The next thing that happens.
    happening: usize,
    /// The scene, and what follows its records; `None` before the first.
    scene: Option<(usize, Follower)>,
}

/// What the engine remembered at a place.
#[derive(Debug)]
struct Memory {
    place: Place,
    kept: Option<Box<Kept>>,
}

/// A tick and its contact.
#[derive(Clone, Debug)]
pub struct Moment {
    /// As it was recorded.
    pub record: TickRecord,
    /// As it was computed again; `None` when no pose came in it.
    pub felt: Option<Felt>,
    /// Whether the one can be held against the other.
    pub sure: Result<(), Unsure>,
    /// Where the probe was; `None` before the first pose.
    pub pose: Option<Pose<World, ProbeFrame>>,
    /// The patches in contact, oldest first: centre, normal, radius, stuck share, force, torque.
    pub patches: Vec<PatchReport>,
    /// How far the surface moves at each patch's centre \[m\].
    pub moved: Vec<Vec3>,
}

impl Player {
    /// Computes the whole recording once; `at` hears how many ticks are done.
    pub fn new(recording: Recording, mut at: impl FnMut(usize)) -> Self {
        let engines = recording.scenes.iter().map(|(_, scene)| scene.as_ref().ok().and_then(|scene| scene.engine().ok()));
        let mut player = Self {
            engines: engines.collect(),
            recording,
            kept: Vec::new(),
            every: KEEP_EVERY,
            now: Place::default(),
            last: None,
        };
        while player.now.tick < player.recording.ticks.len() {
            player.keep();
            player.advance();
            if player.now.tick.is_multiple_of(TELL_EVERY) {
                at(player.now.tick);
            }
        }
        player
    }

    /// What is played.
    pub const fn recording(&self) -> &Recording {
        &self.recording
    }

    /// The tick of that index; `None` beyond the last, or where there is no scene to compute it.
    pub fn at(&mut self, index: usize) -> Option<Moment> {
        let record = *self.recording.ticks.get(index)?;
        self.go_to(index);
        let (scene, _) = self.now.scene?;
        let (felt, sure) = match self.last? {
            Step::Felt(felt, sure) => (Some(felt), sure),
            Step::Noted | Step::Idle => (None, Ok(())),
        };
        let engine = self.engines[scene].as_ref()?.get();
        let (pose, patches) = (engine.probe_pose(), engine.patches().iter().map(patch_report).collect::<Vec<_>>());
        let centres: Vec<_> = patches.iter().map(|patch| patch.centre).collect();
        let mut moved = vec![Vec3::ZERO; centres.len()];
        self.displacement(&centres, &mut moved);
        Some(Moment { record, felt, sure, pose, patches, moved })
    }

    /// Displacements \[m\], in world, of points of the undeformed surface at the tick that was last asked for; zero where nothing moves.
    pub fn displacement(&self, rest: &[Vec3], moved: &mut [Vec3]) {
        moved.fill(Vec3::ZERO);
        let engine = self.now.scene.and_then(|(scene, _)| self.engines[scene].as_ref()).map(OwnedEngine::get);
        let Some((engine, pose)) = engine.and_then(|engine| Some((engine, engine.probe_pose()?))) else { return };
        let shown = engine.tuning().deformation;
        if shown != Deformation::None {
            let body = shown == Deformation::Full;
            engine.surface(engine.params(), engine.patches(), pose.position, body).update(rest, moved);
        }
    }

    /// Computes on, or from the last memory before, until tick `index` has been.
    fn go_to(&mut self, index: usize) {
        let before = self.kept.partition_point(|memory| memory.place.tick <= index);
        let memory = before.checked_sub(1).map(|memory| &self.kept[memory]);
        if let Some(memory) = memory.filter(|memory| self.now.tick > index + 1 || self.now.tick < memory.place.tick) {
            self.now = memory.place;
            if let (Some((scene, _)), Some(kept)) = (self.now.scene, &memory.kept)
                && let Some(engine) = &mut self.engines[scene]
            {
                engine.with(|engine| engine.go_on_from(kept));
            }
        }
        while self.now.tick <= index {
            self.advance();
        }
    }

    /// Keeps a memory where one is due.
    fn keep(&mut self) {
        if !self.now.tick.is_multiple_of(self.every) {
            return;
        }
        if self.kept.len() == KEPT_MAX {
            self.every *= 2;
            self.kept.retain(|memory| memory.place.tick.is_multiple_of(self.every));
            return self.keep();
        }
        let engine = self.now.scene.and_then(|(scene, _)| self.engines[scene].as_ref());
        self.kept.push(Memory { place: self.now, kept: engine.map(|engine| Box::new(engine.get().keep())) });
    }

    /// What happens before the next tick, and the tick.
    fn advance(&mut self) {
        while let Some((_, what)) = self.recording.happened.get(self.now.happening).filter(|(at, _)| *at <= self.now.tick) {
            self.now.happening += 1;
            match *what {
                Happening::Scene(scene) => self.begin(scene),
                Happening::Device(device) => drop(self.take(&Record::Device(device))),
                Happening::Tuned(tuning) => drop(self.take(&Record::Tuning(tuning))),
                Happening::Placed(place) => drop(self.take(&Record::Place(place))),
                Happening::Rested => drop(self.take(&Record::Rest)),
                Happening::Lost(count) => drop(self.take(&Record::Lost { count })),
                Happening::Damaged(_) => self.now.scene.iter_mut().for_each(|(_, follower)| follower.missed(Unsure::Damaged)),
                Happening::Done(_) | Happening::Fault(_) => {}
            }
        }
        if let Some(tick) = self.recording.ticks.get(self.now.tick).copied() {
            self.last = self.take(&Record::Tick(tick));
            self.now.tick += 1;
        }
    }

    /// A scene begins: its engine as new.
    fn begin(&mut self, scene: usize) {
        if let Some((header, made)) = self.recording.scenes.get(scene) {
            self.engines[scene] = made.as_ref().ok().and_then(|made| made.engine().ok());
            self.now.scene = Some((scene, Follower::new(header)));
        }
    }

    fn take(&mut self, record: &Record<'_>) -> Option<Step> {
        let (scene, follower) = self.now.scene.as_mut()?;
        let engine = self.engines[*scene].as_mut()?;
        Some(engine.with(|engine| follower.take(engine, record)))
    }
}

impl Moment {
    /// Whether record and computation agree, in words.
    fn agreement(&self) -> String {
        match (&self.felt, self.sure) {
            (None, _) => "no pose came in this tick".to_owned(),
            (_, Err(why)) => format!("computed without proof: {why}"),
            (Some(felt), Ok(())) => {
                compare(&self.record, felt).map_or("as recorded, to the bit".to_owned(), |difference| difference.to_string())
            }
        }
    }

    /// For people.
    pub fn table(&self) -> String {
        let r = &self.record;
        let mut text = String::new();
        // writing to a string cannot fail
        let _ = writeln!(text, "tick          {}, {} s, tier {}", r.tick, r.t_us as f64 * 1.0e-6, r.tier.name());
        let _ = writeln!(text, "contact       force {:?} N, torque {:?} N m, in world", r.contact_force, r.contact_torque);
        let _ = writeln!(text, "computed      {}", self.agreement());
        for (patch, moved) in self.patches.iter().zip(&self.moved) {
            let (centre, normal) = (patch.centre.to_array(), patch.normal.to_array());
            let _ = writeln!(text, "region {}      centre {centre:?} m, normal {normal:?}", patch.region);
            let (radius, stuck) = (1.0e3 * patch.radius, 1.0e3 * stick_radius(patch));
            let _ = writeln!(text, "              depth {} mm, radius {radius} mm, stuck within {stuck} mm", 1.0e3 * patch.depth);
            let (force, torque) = (patch.force.to_array(), patch.torque.to_array());
            let _ = writeln!(text, "              force {force:?} N, torque about its centre {torque:?} N m");
            let _ = writeln!(text, "              surface moved by {} mm", 1.0e3 * moved.length());
        }
        text
    }

    /// For programs.
    pub fn value(&self) -> Value {
        let regions = self.patches.iter().zip(&self.moved).map(|(patch, moved)| {
            json!({ "region": patch.region, "centre": patch.centre.to_array(), "normal": patch.normal.to_array(),
                    "depth": patch.depth, "radius": patch.radius, "stick_radius": stick_radius(patch),
                    "force": patch.force.to_array(), "torque": patch.torque.to_array(), "moved": moved.to_array() })
        });
        json!({ "tick": self.record.tick, "t_s": self.record.t_us as f64 * 1.0e-6, "computed": self.agreement(),
                "contact_force": self.record.contact_force, "contact_torque": self.record.contact_torque,
                "regions": regions.collect::<Vec<_>>() })
    }
}

/// Radius of the disc that has the stuck share of the contact's area \[m\].
pub fn stick_radius(patch: &PatchReport) -> f32 {
    patch.radius * patch.stick.max(0.0).sqrt()
}

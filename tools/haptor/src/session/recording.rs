//! A recording read back: ticks, what happened between them, summary, and how much of the file was damaged.

use std::path::Path;

use haptor_engine::Scene;
use haptor_engine::replay::{Gather, NoScene};
use haptor_mesh::Mesh;
use haptor_wire::recording::written_by;
use haptor_wire::{
    BakedScene, Damage, FaultRecord, HostFault, Place, Record, RecordHeader, RecordReader, SessionHello, Summary, TickRecord,
    Tuning, What, check_tool_version,
};

use crate::failure::Failure;
use crate::skins;

/// What a recording holds.
#[derive(Debug, Default)]
pub struct Recording {
    /// What was recorded; of joined recordings the last.
    pub header: Option<RecordHeader>,
    /// The scenes, in order, each with the header that names it.
    pub scenes: Vec<(RecordHeader, Result<Box<Scene>, NoScene>)>,
    /// The meshes to look at that each scene's file carries.
    pub skins: Vec<Vec<Mesh>>,
    /// The device, when one was there.
    pub device: Option<SessionHello>,
    /// Ticks in order.
    pub ticks: Vec<TickRecord>,
    /// What happened, and the index of the tick before which it did.
    pub happened: Vec<(usize, Happening)>,
    /// Faults that latched.
    pub faults: Vec<FaultRecord>,
    /// The summary, when the session ended in order.
    pub summary: Option<Summary>,
    /// Damaged places, the cut end of an unfinished file among them.
    pub damaged: usize,
}

/// What happens between two ticks.
#[derive(Clone, Debug)]
pub enum Happening {
    /// The scene of that index begins.
    Scene(usize),
    /// The device that was there.
    Device(SessionHello),
    /// Other parameters hold.
    Tuned(Tuning),
    /// The device stands elsewhere.
    Placed(Place),
    /// The core was put at rest.
    Rested,
    /// Somebody did something.
    Done(What),
    /// A fault latched.
    Fault(FaultRecord),
    /// Records that were never written.
    Lost(u64),
    /// Bytes that are no record; of several in a row the first.
    Damaged(Damage),
}

impl Recording {
    /// Reads a recording as far as it goes.
    ///
    /// # Errors
    /// When the file cannot be read at all.
    pub fn read(path: &Path) -> std::io::Result<Self> {
        Ok(Self::of(&mut std::fs::read(path)?))
    }

    /// Reads a file that must be a recording of this version.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it is none, or of another version, with both versions.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        Ok(Self::of(&mut load(path)?))
    }

    fn of(file: &mut [u8]) -> Self {
        let (mut recording, mut gather) = (Self::default(), None);
        for record in RecordReader::new(file) {
            match record {
                Ok(Record::Header(header)) => {
                    recording.leave_scene(gather.take());
                    gather = Some((header, Gather::new(&header)));
                    recording.header = Some(header);
                    recording.note(Happening::Scene(recording.scenes.len()));
                }
                Ok(Record::Scene(chunk)) => {
                    if let Some((_, gather)) = &mut gather {
                        gather.push(&chunk);
                    }
                }
                Ok(record) => recording.take(&record),
                Err(damage) => recording.damage(damage),
            }
        }
        recording.leave_scene(gather);
        recording
    }

    fn leave_scene(&mut self, gather: Option<(RecordHeader, Gather)>) {
        let Some((header, gather)) = gather else { return };
        // what is damaged in them, the scene says
        self.skins.push(skins::read(gather.file()).unwrap_or_default());
        self.scenes.push((header, gather.scene().map(Box::new)));
    }

    fn note(&mut self, what: Happening) {
        self.happened.push((self.ticks.len(), what));
    }

    fn take(&mut self, record: &Record<'_>) {
        let happened = match *record {
            Record::Tick(tick) => return self.ticks.push(tick),
            Record::End(summary) => {
                self.summary = Some(summary);
                return;
            }
            Record::Device(device) => {
                self.device = Some(device);
                Happening::Device(device)
            }
            Record::Fault(fault) => {
                self.faults.push(fault);
                Happening::Fault(fault)
            }
            Record::Tuning(tuning) => Happening::Tuned(tuning),
            Record::Place(place) => Happening::Placed(place),
            Record::Rest => Happening::Rested,
            Record::Event(event) => Happening::Done(event.what),
            Record::Lost { count } => Happening::Lost(count),
            Record::Header(_) | Record::Schema(_) | Record::Scene(_) => return,
        };
        self.note(happened);
    }

    fn damage(&mut self, damage: Damage) {
        self.damaged += 1;
        let before = self.ticks.len();
        if !matches!(self.happened.last(), Some((at, Happening::Damaged(_))) if *at == before) {
            self.note(Happening::Damaged(damage));
        }
    }

    /// The first fault that latched, wherever it was written.
    pub fn fault(&self) -> Option<HostFault> {
        self.faults.first().map(|fault| fault.cause).or(self.summary.and_then(|summary| summary.fault))
    }

    /// The last scene, when its file is whole.
    pub fn scene(&self) -> Option<&BakedScene> {
        self.scenes.last().and_then(|(_, scene)| scene.as_ref().ok()).map(|scene| scene.setup().baked())
    }

    /// Records that the recorder lost, as far as it said.
    pub fn lost(&self) -> u64 {
        let counts = self.happened.iter().map(|(_, what)| if let Happening::Lost(count) = what { *count } else { 0 });
        counts.sum()
    }
}

/// The bytes of a recording of this version.
///
/// # Errors
/// [`Failure::BadInput`] when it cannot be read, is no recording, or one of another version.
pub fn load(path: &Path) -> Result<Vec<u8>, Failure> {
    let shown = path.display();
    let unreadable = |error| Failure::bad_input(format!("{shown}: cannot be read: {error}; give the path of a recording"));
    let file = std::fs::read(path).map_err(unreadable)?;
    match written_by(&file) {
        Some((version, schema)) => check_tool_version(version, schema)
            .map_err(|mismatch| Failure::bad_input(format!("{shown}: a recording of another version: {mismatch}")))?,
        // a damaged header is no reason not to look at the rest
        None if RecordReader::new(&mut file.clone()).any(|record| record.is_ok()) => {}
        None => return Err(Failure::bad_input(format!("{shown}: no recording: not one record of it can be read"))),
    }
    Ok(file)
}

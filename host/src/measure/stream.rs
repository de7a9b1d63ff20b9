//! A recording as a list of what to do with an engine, everything checked before the first tick.

use std::fs;
use std::path::Path;

use haptor_contact::Pose;
use haptor_engine::frames::{DeviceBase, Handle};
use haptor_engine::replay::{Follower, Gather};
use haptor_engine::{Bodies, Engine, Placed, Scene, Tuned};
use haptor_wire::{Record, RecordReader, TickRecord, Tuning, check_tool_version};

use super::Args;
use crate::error::HostError;

/// One thing to do. Ticks are nearly all of them: the rest is kept aside.
#[derive(Clone, Debug)]
pub enum Op {
    /// The core is put at rest.
    Rest,
    /// Other parameters hold from the next tick on.
    Tune(Box<Tuned>),
    /// The device stands elsewhere from the next tick on.
    Place(Box<Placed>),
    /// A tick.
    Tick {
        /// The handle's pose.
        x_dh: Pose<DeviceBase, Handle>,
        /// Time since the tick before \[s\].
        dt: f32,
    },
}

/// A recording, ready to run.
#[derive(Debug)]
pub struct Stream {
    scene: Scene,
    /// What to do, in order.
    pub ops: Vec<Op>,
}

/// What the command line puts in place of the recording's.
struct Instead<'a>(&'a Args);

impl Instead<'_> {
    fn tuning(&self, recorded: &Tuning) -> Tuning {
        Tuning {
            tier: self.0.tier.map_or(recorded.tier, Into::into),
            samples: self.0.samples.unwrap_or(recorded.samples),
            sweeps: self.0.sweeps.unwrap_or(recorded.sweeps),
            work: self.0.work.or(recorded.work),
            ..*recorded
        }
    }
}

impl Stream {
    /// Reads a whole recording: one scene, at least one tick's worth of nothing.
    ///
    /// # Errors
    /// [`HostError`] with the file and what is wrong with it.
    pub fn load(args: &Args) -> Result<Self, HostError> {
        let mut file = fs::read(&args.file).map_err(|reason| HostError::File {
            doing: "read the recording",
            path: args.file.clone(),
            reason,
        })?;
        Self::read(&mut file, args).map_err(|reason| HostError::Recording { path: args.file.clone(), reason })
    }

    fn read(file: &mut [u8], args: &Args) -> Result<Self, String> {
        let (mut gather, mut scene, mut ticks) = (None::<(Gather, Follower)>, None, Vec::new());
        for record in RecordReader::new(file) {
            match record.map_err(|damage| damage.to_string())? {
                Record::Header(_) if gather.is_some() => return Err("it holds more than one scene".into()),
                Record::Header(header) => {
                    check_tool_version(header.version, header.schema).map_err(|mismatch| mismatch.to_string())?;
                    gather = Some((Gather::new(&header), Follower::new(&header)));
                }
                Record::Scene(chunk) => {
                    if let Some((gather, _)) = &mut gather
                        && gather.push(&chunk)
                    {
                        scene = Some(gather.scene().map_err(|why| why.to_string())?);
                    }
                }
                // texts of the tables; what was done and went wrong is in the ticks
                Record::Schema(_) | Record::Event(_) | Record::Fault(_) | Record::End(_) => {}
                Record::Device(hello) => ticks.push(Record::Device(hello)),
                Record::Tuning(tuning) => ticks.push(Record::Tuning(tuning)),
                Record::Place(place) => ticks.push(Record::Place(place)),
                Record::Rest => ticks.push(Record::Rest),
                Record::Tick(tick) => ticks.push(Record::Tick(tick)),
                Record::Lost { count } => return Err(format!("{count} records are missing in it")),
            }
        }
        let Some((_, follower)) = gather else { return Err("it is no recording".into()) };
        let scene: Scene = scene.ok_or("its scene is not whole")?;
        let ops = ops(&scene, follower, &ticks, &Instead(args))?;
        Ok(Self { scene, ops })
    }

    /// The bodies that the engine borrows.
    ///
    /// # Errors
    /// As [`Scene::bodies`].
    pub fn bodies(&self, path: &Path) -> Result<Bodies<'_>, HostError> {
        self.scene.bodies().map_err(|reason| HostError::Scene { path: path.to_owned(), reason })
    }

    /// An engine at rest.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn engine<'a>(&self, path: &Path, bodies: &'a Bodies<'a>) -> Result<Engine<'a>, HostError> {
        Engine::new(self.scene.setup(), bodies)
            .map_err(|invalid| HostError::Scene { path: path.to_owned(), reason: invalid.into() })
    }
}

/// What to do at each record. A device is not fitted: the limits of the core's own hold, and they cost the same.
fn ops(scene: &Scene, mut follower: Follower, records: &[Record<'_>], instead: &Instead<'_>) -> Result<Vec<Op>, String> {
    let mut engine = scene.engine().map_err(|error| error.to_string())?;
    let tuned = |tuning: &Tuning| scene.tuned(&instead.tuning(tuning)).map_err(|error| error.to_string());
    let mut ops = vec![Op::Tune(Box::new(tuned(&Tuning::of(scene.setup().baked()))?))];
    for record in records {
        match record {
            Record::Tuning(tuning) => ops.push(Op::Tune(Box::new(tuned(tuning)?))),
            Record::Place(place) => ops.push(Op::Place(Box::new(Placed::new(place).map_err(|invalid| invalid.to_string())?))),
            Record::Rest => {
                engine.with(|engine| follower.take(engine, record));
                ops.push(Op::Rest);
            }
            Record::Tick(tick) => ops.extend(asked(&mut follower, tick)),
            _ => {}
        }
    }
    Ok(ops)
}

fn asked(follower: &mut Follower, tick: &TickRecord) -> Option<Op> {
    follower.asked(tick).map(|(x_dh, dt)| Op::Tick { x_dh, dt })
}

//! The thread for what takes long: scenes built from uploaded models, tunings checked, budgets measured, surfaces computed, old engines dropped.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};

use haptor_engine::{Limit, OwnedEngine, Scene, SceneError, Tuned};
use haptor_wire::{Denial, Tuning, WorkBudget, scene_file};

use super::surfaces::{Done, SurfaceJob, Surfaces};
use crate::rt::clock::Monotonic;
use crate::work;

/// Something to do.
#[derive(Debug)]
pub enum Job {
    /// Make an engine of a model.
    Build {
        /// Of the request.
        number: u64,
        /// That the scene will have.
        scene: u32,
        /// That the file was announced with.
        digest: u64,
        /// The model.
        file: Arc<[u8]>,
    },
    /// Check a tuning for the engines of a scene.
    Check {
        /// Of the request.
        number: u64,
        /// The scene it is meant for.
        scene: u32,
        /// The tuning.
        tuning: Box<Tuning>,
    },
    /// Find the budget of the scene that runs, and of those that are built from now on, by this rule.
    Limit {
        /// Of the request.
        number: u64,
        /// The scene that runs.
        scene: u32,
        /// The rule.
        rule: WorkBudget,
    },
    /// Compute the displacements of rest points.
    Surface(Box<SurfaceJob>),
    /// This viewer does not look at its surface any more.
    GiveUp(u64),
    /// Drop an engine.
    Drop(OwnedEngine),
    /// This scene runs now: those before it are not needed any more.
    Runs(u32),
    /// This scene will not run.
    Forget(u32),
}

/// Something done.
#[derive(Debug)]
pub enum Made {
    /// An engine, or why there is none.
    Built {
        /// Of the request.
        number: u64,
        /// Number of the scene.
        scene: u32,
        /// The engine, at rest.
        result: Result<OwnedEngine, (Denial, String)>,
    },
    /// A tuning, or why it is none.
    Checked {
        /// Of the request.
        number: u64,
        /// Number of the scene it was checked for.
        scene: u32,
        /// The tuning.
        result: Result<Box<Tuned>, (Denial, String)>,
    },
    /// A work budget, or why it is none.
    Limited {
        /// Of the request.
        number: u64,
        /// The budget.
        result: Result<Limit, (Denial, String)>,
    },
    /// A surface.
    Surface(Done),
}

/// A scene and an engine of it to compute surfaces with.
#[derive(Debug)]
struct Kept {
    scene: Scene,
    twin: Option<OwnedEngine>,
}

/// What the thread keeps.
#[derive(Debug)]
pub struct Workshop {
    scenes: BTreeMap<u32, Kept>,
    /// By which a scene gets its work budget.
    rule: WorkBudget,
    rate_hz: u32,
    surfaces: Surfaces,
    made: Sender<Made>,
}

impl Workshop {
    /// With the scene that runs first, number 0, and the rule by which scenes of a session at so many ticks a second get their work budget.
    #[must_use]
    pub fn new(first: Scene, rule: WorkBudget, rate_hz: u32, made: Sender<Made>) -> Self {
        Self {
            scenes: BTreeMap::from([(0, Kept { scene: first, twin: None })]),
            rule,
            rate_hz,
            surfaces: Surfaces::default(),
            made,
        }
    }

    /// Works until nobody can send jobs any more. What is asked goes before the next pass of a surface.
    pub fn run(mut self, jobs: &Receiver<Job>) {
        loop {
            let job = if self.surfaces.is_empty() { jobs.recv().map_err(TryRecvError::from) } else { jobs.try_recv() };
            let made = match job {
                Ok(job) => self.work(job),
                Err(TryRecvError::Empty) => self.surfaces.pass().map(Made::Surface),
                Err(TryRecvError::Disconnected) => return,
            };
            // a server that is gone needs nothing any more
            made.into_iter().for_each(|made| drop(self.made.send(made)));
        }
    }

    fn work(&mut self, job: Job) -> Option<Made> {
        match job {
            Job::Build { number, scene, digest, file } => {
                Some(Made::Built { number, scene, result: self.build(scene, digest, &file) })
            }
            Job::Check { number, scene, tuning } => Some(Made::Checked { number, scene, result: self.check(scene, &tuning) }),
            Job::Limit { number, scene, rule } => Some(Made::Limited { number, result: self.limit(scene, rule) }),
            Job::Surface(job) => self.surface(job),
            Job::GiveUp(viewer) => {
                self.surfaces.give_up(viewer);
                None
            }
            Job::Drop(engine) => {
                drop(engine);
                None
            }
            Job::Runs(scene) => {
                self.scenes.retain(|&number, _| number >= scene);
                None
            }
            Job::Forget(scene) => {
                self.scenes.remove(&scene);
                None
            }
        }
    }

    fn build(&mut self, number: u32, digest: u64, file: &[u8]) -> Result<OwnedEngine, (Denial, String)> {
        if scene_file::digest(file) != digest {
            return Err((Denial::Digest, String::new()));
        }
        let built = Scene::read(file).and_then(|scene| Ok((self.engine(&scene)?, scene)));
        let (engine, scene) = built.map_err(|error| (Denial::Scene, error.to_string()))?;
        self.scenes.insert(number, Kept { scene, twin: None });
        Ok(engine)
    }

    /// An engine at rest, with its budget.
    fn engine(&self, scene: &Scene) -> Result<OwnedEngine, SceneError> {
        let mut engine = scene.engine()?;
        engine.limit(work::find(self.rule, scene, self.rate_hz, &Monotonic)?.limit);
        Ok(engine)
    }

    /// A rule that is none for the scene that runs is none for others.
    fn limit(&mut self, scene: u32, rule: WorkBudget) -> Result<Limit, (Denial, String)> {
        // the scene that runs is always kept
        let kept = self.scenes.get(&scene).ok_or((Denial::Busy, String::new()))?;
        let found = work::find(rule, &kept.scene, self.rate_hz, &Monotonic);
        let found = found.map_err(|error| (Denial::Value, error.to_string()))?;
        self.rule = rule;
        Ok(found.limit)
    }

    fn check(&self, scene: u32, tuning: &Tuning) -> Result<Box<Tuned>, (Denial, String)> {
        // the scene that runs is always kept
        let kept = self.scenes.get(&scene).ok_or((Denial::Busy, String::new()))?;
        kept.scene.tuned(tuning).map(Box::new).map_err(|error| (Denial::Value, error.to_string()))
    }

    /// Takes a surface in. One whose scene is gone is done.
    fn surface(&mut self, job: Box<SurfaceJob>) -> Option<Made> {
        let kept = self.scenes.get_mut(&job.scene);
        let twin = kept.and_then(|kept| {
            kept.twin = kept.twin.take().or_else(|| kept.scene.engine().ok());
            kept.twin.as_ref()
        });
        let Some(twin) = twin else {
            return Some(Made::Surface(Done { viewer: job.viewer, tick: job.tick, frames: Vec::new(), points: 0, passes: 0 }));
        };
        self.surfaces.begin(job, twin.get());
        None
    }
}

//! The thread for what takes long: scenes built from uploaded models, tunings checked, surfaces computed, old engines dropped.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

use haptor_contact::{MAX_PARTS, Params, Patch, Vec3};
use haptor_engine::{OwnedEngine, Scene, Tuned};
use haptor_wire::viewer::POINTS_IN_MESSAGE;
use haptor_wire::{Denial, SurfaceBlock, ToViewer, Tuning, encode_stream, scene_file, stream_bound};

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
    /// Compute the displacements of rest points.
    Surface(Box<SurfaceJob>),
    /// Drop an engine.
    Drop(OwnedEngine),
    /// This scene runs now: those before it are not needed any more.
    Runs(u32),
    /// This scene will not run.
    Forget(u32),
}

/// A surface to compute.
#[derive(Debug)]
pub struct SurfaceJob {
    /// Serial number of the viewer.
    pub viewer: u64,
    /// The tick.
    pub tick: u64,
    /// Number of the scene.
    pub scene: u32,
    /// The patches in contact.
    pub patches: heapless::Vec<Patch, MAX_PARTS>,
    /// The parameters they were computed under.
    pub params: Params,
    /// Mass centre of the probe in `w`.
    pub p_wp: Vec3,
    /// With the motion of the whole body.
    pub body: bool,
    /// The points.
    pub rest: Arc<[Vec3]>,
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
    /// A surface as frames of the viewer link.
    Surface {
        /// Serial number of the viewer.
        viewer: u64,
        /// The frames.
        frames: Vec<u8>,
    },
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
    made: Sender<Made>,
}

impl Workshop {
    /// With the scene that runs first, number 0.
    #[must_use]
    pub fn new(first: Scene, made: Sender<Made>) -> Self {
        Self { scenes: BTreeMap::from([(0, Kept { scene: first, twin: None })]), made }
    }

    /// Works until nobody can send jobs any more.
    pub fn run(mut self, jobs: &Receiver<Job>) {
        while let Ok(job) = jobs.recv() {
            if let Some(made) = self.work(job) {
                // a server that is gone needs nothing any more
                let _ = self.made.send(made);
            }
        }
    }

    fn work(&mut self, job: Job) -> Option<Made> {
        match job {
            Job::Build { number, scene, digest, file } => {
                Some(Made::Built { number, scene, result: self.build(scene, digest, &file) })
            }
            Job::Check { number, scene, tuning } => Some(Made::Checked { number, scene, result: self.check(scene, &tuning) }),
            Job::Surface(job) => Some(Made::Surface { viewer: job.viewer, frames: self.surface(&job).unwrap_or_default() }),
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
        let built = Scene::read(file).and_then(|scene| Ok((scene.engine()?, scene)));
        let (engine, scene) = built.map_err(|error| (Denial::Scene, error.to_string()))?;
        self.scenes.insert(number, Kept { scene, twin: None });
        Ok(engine)
    }

    fn check(&self, scene: u32, tuning: &Tuning) -> Result<Box<Tuned>, (Denial, String)> {
        // the scene that runs is always kept
        let kept = self.scenes.get(&scene).ok_or((Denial::Busy, String::new()))?;
        kept.scene.tuned(tuning).map(Box::new).map_err(|error| (Denial::Value, error.to_string()))
    }

    /// The frames of a surface; `None` when its scene is gone.
    fn surface(&mut self, job: &SurfaceJob) -> Option<Vec<u8>> {
        let kept = self.scenes.get_mut(&job.scene)?;
        if kept.twin.is_none() {
            kept.twin = kept.scene.engine().ok();
        }
        let engine = kept.twin.as_ref()?.get();
        let mut moved = vec![Vec3::ZERO; job.rest.len()];
        engine.surface(&job.params, &job.patches, job.p_wp, job.body).update(&job.rest, &mut moved);
        Some(frames(job.tick, &moved))
    }
}

/// Displacements as frames.
fn frames(tick: u64, moved: &[Vec3]) -> Vec<u8> {
    let step = SurfaceBlock::step_for(moved.iter().map(|u| u.abs().max_element()).fold(0.0, f32::max));
    let mut frames = Vec::new();
    for (i, points) in moved.chunks(POINTS_IN_MESSAGE).enumerate() {
        let block = SurfaceBlock {
            tick,
            // at most REST_POINTS_MAX
            of: moved.len() as u32,
            offset: (i * POINTS_IN_MESSAGE) as u32,
            step,
            moved: points.iter().map(|u| SurfaceBlock::quantised(u.to_array(), step)).collect(),
        };
        let mut frame = [0; stream_bound(ToViewer::MAX_ENCODED)];
        // the buffer has the longest message's bound
        let length = encode_stream(&ToViewer::Surface(block), &mut frame).unwrap_or(0);
        frames.extend_from_slice(&frame[..length]);
    }
    frames
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_wire::StreamDecoder;

    #[test]
    fn a_surface_comes_back_from_its_frames() {
        let moved: Vec<Vec3> = (0..600).map(|i| Vec3::new(1.0e-6 * i as f32, -2.0e-3, 0.0)).collect();
        let (mut decoder, mut back) = (StreamDecoder::<{ stream_bound(ToViewer::MAX_ENCODED) }>::new(), Vec::new());
        decoder.feed(&frames(7, &moved), |message| {
            let ToViewer::Surface(block) = message else { panic!("{message:?}") };
            assert_eq!((block.tick, block.of, block.offset as usize), (7, 600, back.len()));
            back.extend(block.displacements().map(Vec3::from_array));
        });
        assert_eq!((back.len(), decoder.counts().rejected()), (600, 0));
        assert!(back.iter().zip(&moved).all(|(a, b)| (*a - *b).abs().max_element() <= 0.501 * 2.0e-3 / 32767.0));
    }
}

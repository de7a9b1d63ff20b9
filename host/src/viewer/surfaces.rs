//! Surfaces that viewers watch, computed in **passes**: each does so many points that it costs no more than a bound of work, and between two of them the workshop does what else
//! was asked of it. A surface is that of one tick, however many passes it takes.
//!
//! Work is counted as the core's budget counts it ([`haptor_contact::budget`]), in instructions. What a surface needs before its first point (the motion of the body, the fields
//! of the patches) is prepared once; its memory, 41 kB, goes from one surface to the next.

use std::collections::VecDeque;
use std::sync::Arc;

use haptor_contact::budget::of_vertex;
use haptor_contact::surface::Prepared;
use haptor_contact::{MAX_PARTS, Params, Patch, Vec3};
use haptor_engine::Engine;
use haptor_wire::viewer::POINTS_IN_MESSAGE;
use haptor_wire::{SurfaceBlock, ToViewer, encode_stream, stream_bound};

/// Work of a pass at most \[instructions\]: a millisecond or so, which nobody notices who waits for a scene or a tuning.
pub const PASS_WORK: u32 = 3_000_000;

/// Points of a pass at least: what the core computes side by side.
pub const PASS_POINTS_MIN: usize = 64;

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
    /// What a tick may spend \[instructions\]; a pass may spend no more.
    pub work: Option<u32>,
    /// Mass centre of the probe in `w`.
    pub p_wp: Vec3,
    /// With the motion of the whole body.
    pub body: bool,
    /// The points.
    pub rest: Arc<[Vec3]>,
}

impl SurfaceJob {
    /// Points that a pass does.
    fn points_in_pass(&self) -> usize {
        let work = self.work.map_or(PASS_WORK, |work| work.min(PASS_WORK));
        ((work / of_vertex(self.patches.len(), self.body)) as usize).max(PASS_POINTS_MIN)
    }
}

/// What a surface has come to.
#[derive(Debug)]
pub struct Done {
    /// Serial number of the viewer.
    pub viewer: u64,
    /// The tick.
    pub tick: u64,
    /// As frames of the viewer link; empty where its scene is gone.
    pub frames: Vec<u8>,
    /// Points computed.
    pub points: usize,
    /// Passes that they took.
    pub passes: u32,
}

/// A surface of which some points are done.
#[derive(Debug)]
struct UnderWay {
    job: Box<SurfaceJob>,
    prepared: Box<Prepared>,
    moved: Vec<Vec3>,
    /// Points done, from the first on.
    done: usize,
    passes: u32,
}

/// The surfaces that are being computed: one a viewer at most, by turns.
#[derive(Debug, Default)]
pub struct Surfaces {
    waiting: VecDeque<UnderWay>,
    /// Memory of surfaces that are done.
    spare: Vec<Box<Prepared>>,
}

impl Surfaces {
    /// Whether there is nothing to do.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Takes a surface in; `engine` is one of its scene.
    pub fn begin(&mut self, job: Box<SurfaceJob>, engine: &Engine<'_>) {
        let mut prepared = self.spare.pop().unwrap_or_default();
        prepared.prepare(&engine.surface(&job.params, &job.patches, job.p_wp, job.body));
        let moved = vec![Vec3::ZERO; job.rest.len()];
        self.waiting.push_back(UnderWay { job, prepared, moved, done: 0, passes: 0 });
    }

    /// One pass of the surface whose turn it is; yields it when it is whole.
    pub fn pass(&mut self) -> Option<Done> {
        let mut next = self.waiting.pop_front()?;
        next.pass();
        if next.done < next.moved.len() {
            self.waiting.push_back(next);
            return None;
        }
        let UnderWay { job, prepared, moved, passes, .. } = next;
        self.spare.push(prepared);
        Some(Done { viewer: job.viewer, tick: job.tick, frames: frames(job.tick, &moved), points: moved.len(), passes })
    }

    /// Gives up what a viewer does not look at any more.
    pub fn give_up(&mut self, viewer: u64) {
        self.waiting.retain(|surface| surface.job.viewer != viewer);
    }
}

impl UnderWay {
    fn pass(&mut self) {
        let points = self.done..(self.done + self.job.points_in_pass()).min(self.moved.len());
        self.done = points.end;
        self.passes += 1;
        self.prepared.update(&self.job.rest[points.clone()], &mut self.moved[points]);
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
    use haptor_contact::ParamsSpec;
    use haptor_engine::Scene;
    use haptor_wire::{BakedScene, ObjectShape, StreamDecoder};

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

    fn job(viewer: u64, work: Option<u32>, points: usize) -> Box<SurfaceJob> {
        Box::new(SurfaceJob {
            viewer,
            tick: 1,
            scene: 0,
            patches: heapless::Vec::new(),
            params: Params::new(&ParamsSpec::default()).unwrap(),
            work,
            p_wp: Vec3::ZERO,
            body: true,
            rest: vec![Vec3::Z; points].into(),
        })
    }

    #[test]
    fn a_pass_costs_no_more_than_its_bound_or_a_tick_and_surfaces_take_turns() {
        let scene = Scene::new(&BakedScene::ball_on(ObjectShape::Box { size: [0.1; 3] })).unwrap();
        let engine = scene.engine().unwrap();
        let (mut surfaces, each) = (Surfaces::default(), of_vertex(0, true) as usize);
        let points = 65_536;
        let jobs = [
            job(1, None, points),
            job(2, Some(1_000_000), points),
            job(3, Some(10_000), 130),
            job(4, None, 0),
            job(5, None, points),
        ];
        jobs.into_iter().for_each(|job| surfaces.begin(job, engine.get()));
        surfaces.give_up(5);
        let mut done = Vec::new();
        while !surfaces.is_empty() {
            done.extend(surfaces.pass());
        }
        let passes = |work: usize| points.div_ceil(work / each) as u32;
        let told: Vec<_> = done.iter().map(|done| (done.viewer, done.points, done.passes)).collect();
        // the smallest budget has room for one block at a time, and a surface without points is done as soon as it is looked at
        let expected = [(4, 0, 1), (3, 130, 3), (1, points, passes(PASS_WORK as usize)), (2, points, passes(1_000_000))];
        assert_eq!(told, expected);
    }
}

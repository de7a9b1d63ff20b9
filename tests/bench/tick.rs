//! What a tick costs. Scenes press and move, so that nothing is at rest; figures with machine, method and date go to `RESULTS.md`.
//!
//! `cargo bench -p haptor-tests --bench tick`. The share of detection is told by the frictionless scenes: they find contacts, follow regions
//! and press, but hold nothing; `point` differs from them by the curves, `bristle` by the samples.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{Quat, Vec3};
use haptor_contact::{
    Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Scratch, State, Tier, step,
};
use std::hint::black_box;

const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
const CUBE: ObjectShape<'static> = ObjectShape::Box { size: Vec3::splat(0.1) };
/// A table wide enough for ten legs 30 mm apart.
const TABLE: ObjectShape<'static> = ObjectShape::Box { size: Vec3::new(0.4, 0.4, 0.1) };

/// One ball of 20 mm.
fn ball() -> Vec<ProbePart<'static>> {
    vec![ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })]
}

/// Ten balls of 10 mm on a ring of 100 mm: ten regions.
fn ten() -> Vec<ProbePart<'static>> {
    (0..10)
        .map(|i| {
            let angle = std::f32::consts::TAU * i as f32 / 10.0;
            let position = Vec3::new(0.1 * angle.cos(), 0.1 * angle.sin(), -0.01);
            ProbePart { position, ..ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 }) }
        })
        .collect()
}

/// A hand's motion with period 256 ticks: depth 0.5 to 1.5 mm, shift and twist that stick and slip.
fn pose(height: f32, tick: u32) -> Pose<haptor_contact::World, haptor_contact::ProbeFrame> {
    let t = std::f32::consts::TAU * (tick % 256) as f32 / 256.0;
    let position = Vec3::new(1.0e-3 * t.sin(), 0.7e-3 * (2.0 * t).cos(), height - 1.0e-3 + 5.0e-4 * (3.0 * t).sin());
    Pose::new(position, Quat::from_rotation_z(0.1 * (t + 0.3).sin()))
}

/// Measures one tick of the moving scene; one round of the motion is run before, so that every region is born.
fn scene(
    bench: &mut Criterion,
    name: &str,
    object: ObjectShape<'static>,
    probe: &[ProbePart<'_>],
    regions: u8,
    params: &ParamsSpec,
) {
    let model = Model::new(&ModelSpec::new(object, RUBBER, probe)).expect("valid model");
    let params = Params::new(params).expect("valid parameters");
    let (mut state, mut scratch) = (Box::new(State::<16, 256, 256>::new()), Scratch::<16>::new());
    let poses: Vec<_> = (0..256).map(|tick| pose(object.height() + 0.02, tick)).collect();
    let mut tick = 0;
    let mut run = || {
        let input = Input { pose: poses[tick % 256], dt: 1.0e-3 };
        tick += 1;
        step(&model, &params, &mut state, &mut scratch, black_box(input))
    };
    let last = (0..256).map(|_| run()).last().expect("256 ticks");
    assert_eq!(last.report.regions, regions, "{name}");
    bench.bench_function(name, |b| b.iter(&mut run));
}

fn tier(tier: Tier, samples: usize) -> ParamsSpec {
    ParamsSpec { tier, samples, ..ParamsSpec::default() }
}

fn frictionless() -> ParamsSpec {
    ParamsSpec { friction_dynamic: 0.0, ..tier(Tier::Point, 64) }
}

fn one_region(bench: &mut Criterion) {
    scene(bench, "one/frictionless (detection, regions, press)", CUBE, &ball(), 1, &frictionless());
    scene(bench, "one/point", CUBE, &ball(), 1, &tier(Tier::Point, 64));
    scene(bench, "one/paper 64", CUBE, &ball(), 1, &tier(Tier::Paper, 64));
    for samples in [16, 64, 256] {
        scene(bench, &format!("one/bristle {samples}"), CUBE, &ball(), 1, &tier(Tier::Bristle, samples));
    }
    for cells in [52, 112] {
        scene(bench, &format!("one/influence {cells}"), CUBE, &ball(), 1, &tier(Tier::Influence, cells));
    }
}

fn ten_regions(bench: &mut Criterion) {
    scene(bench, "ten/frictionless (detection, regions, press)", TABLE, &ten(), 10, &frictionless());
    scene(bench, "ten/point", TABLE, &ten(), 10, &tier(Tier::Point, 64));
    scene(bench, "ten/paper 64", TABLE, &ten(), 10, &tier(Tier::Paper, 64));
    scene(bench, "ten/bristle 64", TABLE, &ten(), 10, &tier(Tier::Bristle, 64));
    scene(bench, "ten/influence 52", TABLE, &ten(), 10, &tier(Tier::Influence, 52));
}

fn nothing(bench: &mut Criterion) {
    let model_parts = ten();
    let model = Model::new(&ModelSpec::new(TABLE, RUBBER, &model_parts)).expect("valid model");
    let params = Params::new(&tier(Tier::Bristle, 64)).expect("valid parameters");
    let (mut state, mut scratch) = (Box::new(State::<16, 256, 256>::new()), Scratch::<16>::new());
    let mut tick = 0;
    bench.bench_function("ten parts, no contact", |b| {
        b.iter(|| {
            tick += 1;
            let input = Input { pose: pose(0.2, tick), dt: 1.0e-3 };
            step(&model, &params, &mut state, &mut scratch, black_box(input))
        });
    });
}

criterion_group!(ticks, one_region, ten_regions, nothing);
criterion_main!(ticks);

//! What the whole deformed surface costs: 4,096 vertices under 1 and 10 regions, and how it grows with either. Figures with machine,
//! method and date go to `RESULTS.md`.
//!
//! `cargo bench -p haptor-tests --bench surface`. Beside criterion's mean the fastest of many updates is printed, which is what the work takes
//! on a core that nothing else runs on. Instructions of one update: the same program under `valgrind --tool=callgrind
//! '--toggle-collect=*Prepared*update*' '--toggle-collect=*Prepared*prepare*'` with `--bench --test NAME`. The regions are pressed, dragged and twisted into partial slip, so that every part of
//! a field is at work. Vertices are the faces of the box in a regular grid, face by face.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Quat, Vec3};
use haptor_contact::surface::{Prepared, Surface};
use haptor_contact::{
    Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Patch, Pose, ProbePart, ProbeShape, Scratch, State, Tier,
    step,
};
use std::hint::black_box;
use std::time::{Duration, Instant};

const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.45, density: 1100.0 };
const CUBE: Vec3 = Vec3::splat(0.1);
/// Wide enough for ten legs 30 mm apart.
const TABLE: Vec3 = Vec3::new(0.4, 0.4, 0.1);

/// `legs` balls of 10 mm, one in the middle or all on a ring of 100 mm.
fn legs(legs: usize) -> Vec<ProbePart<'static>> {
    let ring = if legs == 1 { 0.0 } else { 0.1 };
    (0..legs)
        .map(|i| {
            let angle = std::f32::consts::TAU * i as f32 / legs as f32;
            let position = Vec3::new(ring * angle.cos(), ring * angle.sin(), -0.01);
            ProbePart { position, ..ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 }) }
        })
        .collect()
}

/// About `wanted` points on the four sides and the top of a box.
fn vertices(size: Vec3, wanted: usize) -> Vec<Vec3> {
    let area = size.x * size.y + 2.0 * (size.x + size.y) * size.z;
    let edge = (area / wanted as f32).sqrt();
    let mut points = Vec::new();
    let mut face = |corner: Vec3, u: Vec3, v: Vec3| {
        let (nu, nv) = ((u.length() / edge).ceil() as usize, (v.length() / edge).ceil() as usize);
        for (i, j) in (0..=nu).flat_map(|i| (0..=nv).map(move |j| (i, j))) {
            points.push(corner + u * (i as f32 / nu as f32) + v * (j as f32 / nv as f32));
        }
    };
    let half = size / 2.0;
    let corner = Vec3::new(-half.x, -half.y, 0.0);
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    face(corner + z, x, y);
    for (u, v, from) in [(x, z, corner), (y, z, corner), (x, z, corner + y), (y, z, corner + x)] {
        face(from, u, v);
    }
    points.truncate(wanted);
    assert!(points.len() == wanted, "{} points of {wanted}", points.len());
    points
}

/// Runs a motion that presses, drags and twists, and hands over what it leaves.
fn pressed(size: Vec3, parts: &[ProbePart<'_>], tier: Tier, look: impl FnOnce(&Surface<'_>)) {
    let model = Model::new(&ModelSpec::new(ObjectShape::Box { size }, RUBBER, parts)).expect("valid model");
    let params = Params::new(&ParamsSpec { tier, ..ParamsSpec::default() }).expect("valid parameters");
    let (mut state, mut scratch) = (Box::new(State::<16, 64>::new()), Scratch::<16>::new());
    let mut place = Vec3::ZERO;
    for i in 0..=20 {
        let share = i as f32 / 20.0;
        place = Vec3::new(3.0e-4 * share, 0.0, size.z + 0.019);
        let pose = Pose::new(place, Quat::from_rotation_z(0.004 * share));
        step(&model, &params, &mut state, &mut scratch, Input { pose, dt: 1.0e-3 });
    }
    let patches: Vec<Patch> = state.patches().to_vec();
    assert_eq!(patches.len(), parts.len());
    look(&Surface { model: &model, params: &params, patches: &patches, p_wp: place, body: true });
}

/// Updates of which the fastest counts.
const TRIES: usize = 5_000;

/// The fastest update; none when the program only shows that it runs.
fn fastest(mut update: impl FnMut()) -> Duration {
    let tries = if std::env::args().any(|arg| arg == "--test") { 0 } else { TRIES };
    let timed = (0..tries).map(|_| {
        let start = Instant::now();
        update();
        start.elapsed()
    });
    timed.min().unwrap_or_default()
}

fn whole(bench: &mut Criterion, name: &str, size: Vec3, regions: usize, count: usize, tier: Tier, body: bool) {
    let rest = vertices(size, count);
    let mut moved = vec![Vec3::ZERO; rest.len()];
    pressed(size, &legs(regions), tier, |surface| {
        let (surface, mut prepared) = (Surface { body, ..*surface }, Box::new(Prepared::new()));
        let mut update = || {
            prepared.prepare(&surface);
            prepared.update(black_box(&rest), black_box(&mut moved));
        };
        println!("{name}/{regions} regions/{count}: fastest {:?}", fastest(&mut update));
        let mut group = bench.benchmark_group(name);
        group.throughput(Throughput::Elements((count * regions) as u64));
        group.bench_function(BenchmarkId::new(format!("{regions} regions"), count), |b| {
            b.iter(&mut update);
        });
        group.finish();
    });
}

fn surfaces(bench: &mut Criterion) {
    whole(bench, "bristle", CUBE, 1, 4096, Tier::Bristle, true);
    whole(bench, "bristle, no body", CUBE, 1, 4096, Tier::Bristle, false);
    whole(bench, "paper", CUBE, 1, 4096, Tier::Paper, true);
    for regions in [2, 5, 10] {
        whole(bench, "bristle", TABLE, regions, 4096, Tier::Bristle, true);
    }
    whole(bench, "bristle, no body", TABLE, 10, 4096, Tier::Bristle, false);
    whole(bench, "paper", TABLE, 10, 4096, Tier::Paper, true);
    for count in [1024, 16_384] {
        whole(bench, "bristle", TABLE, 10, count, Tier::Bristle, true);
    }
}

criterion_group!(benches, surfaces);
criterion_main!(benches);

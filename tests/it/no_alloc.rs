//! `step` calls no allocator: not on any tier, not at a birth, a death, a refusal or a fault.

use glam::{Quat, Vec3};
use haptor_contact::{
    Input, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape, Scratch, State, Tier, step,
};

use crate::alloc::counted;

/// Twelve legs of four shapes on a ring of 60 mm, more than the regions that are kept.
fn probe() -> Vec<ProbePart<'static>> {
    (0..12)
        .map(|i| {
            let angle = std::f32::consts::TAU * i as f32 / 12.0;
            let shape = match i % 4 {
                0 => ProbeShape::Sphere { radius: 0.01 },
                1 => ProbeShape::Box { size: Vec3::splat(0.02) },
                2 => ProbeShape::Cone { radius: 0.01, height: 0.013 },
                _ => ProbeShape::Ellipsoid { semi_axes: Vec3::splat(0.01) },
            };
            ProbePart { position: Vec3::new(0.06 * angle.cos(), 0.06 * angle.sin(), 0.0), ..ProbePart::at_origin(shape) }
        })
        .collect()
}

#[test]
fn no_tick_allocates() {
    let parts = probe();
    let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1.1e3 };
    let objects = [ObjectShape::HalfSpace, ObjectShape::Box { size: Vec3::splat(0.2) }, ObjectShape::Sphere { radius: 50.0 }];
    for object in objects {
        let model = Model::new(&ModelSpec::new(object, material, &parts)).expect("valid");
        for tier in [Tier::Point, Tier::Paper, Tier::Bristle] {
            let params = Params::new(&ParamsSpec { tier, friction_static: Some(1.0), ..ParamsSpec::default() }).expect("valid");
            let (mut state, mut scratch) = (Box::new(State::<16, 64>::new()), Scratch::<16>::new());
            let mut regions = 0;
            for tick in 0..300 {
                let t = tick as f32 * 0.05;
                let mut position = Vec3::new(1.0e-3 * t.sin(), 0.0, object.height() + 0.01 - 1.0e-3 * (0.7 * t).sin());
                if tick == 150 {
                    position.x = f32::NAN;
                }
                let input = Input { pose: Pose::new(position, Quat::from_rotation_z(0.1 * t.sin())), dt: 1.0e-3 };
                let (output, calls) = counted(|| step(&model, &params, &mut state, &mut scratch, input));
                assert_eq!(calls, 0, "{object:?} {tier:?} tick {tick}");
                regions = regions.max(output.report.high_water);
            }
            assert!(regions >= 4, "{object:?} {tier:?}: {regions} regions were seen");
        }
    }
}

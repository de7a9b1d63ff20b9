//! Scenes that only a PC counts: features that few scenes have, budgets, tables, small surfaces, and every shape of a part on every shape of an object.
//!
//! Names, probes, meshes and tables are made as the list is; their memory is the program's until it ends.

use std::num::NonZeroUsize;

use haptor_contact::{MAX_WORK, ObjectShape, ParamsSpec, ProbePart, ProbeShape, Tier, Vec3};

use super::cases::{BALL, Case, Motion, Name, Shown, TABLE, TEN, WIDE, base};
use super::{meshes, table};

/// Every scene.
pub fn all() -> impl Iterator<Item = Case> {
    [features(), budgets(), tables(), blocks(), pairs()].into_iter().flatten()
}

/// A case with that name.
fn named(name: impl Into<String>, case: Case) -> Case {
    Case { name: Name([name.into().leak(), "", "", ""]), ..case }
}

/// Ten balls on the box.
fn many() -> Case {
    Case { probe: TEN, regions: 10, object: TABLE, ..base() }
}

/// Settings of a tier with so many samples.
fn tier(tier: Tier, samples: usize) -> ParamsSpec {
    ParamsSpec { tier, samples, ..ParamsSpec::default() }
}

/// Settings without friction.
fn smooth() -> ParamsSpec {
    ParamsSpec { friction_dynamic: 0.0, ..ParamsSpec::default() }
}

/// One feature more or less than a row of the list that a Cortex-M7 counts too.
fn features() -> Vec<Case> {
    let born = |name: &str, case: Case| named(name, Case { motion: Motion::Births, ..case });
    let params = ParamsSpec { sweeps: 1, ..tier(Tier::Influence, 52) };
    let ball = ObjectShape::Mesh(meshes::ball(0.05, 0.05, SAMPLES));
    vec![
        named("base, influence 52, one sweep", Case { params, ..base() }),
        born("no friction, half space, ten regions, births", Case { params: smooth(), object: ObjectShape::HalfSpace, ..many() }),
        born("no friction, box, ten regions, births", Case { params: smooth(), ..many() }),
        born("bristle 64, box, ten regions, births", many()),
        named(
            "bristle 64, half space, ten regions, held still",
            Case { motion: Motion::Still, object: ObjectShape::HalfSpace, ..many() },
        ),
        named("no contact, ten parts, mesh", Case { object: ball, probe: TEN, motion: Motion::Clear, regions: 0, ..base() }),
    ]
}

/// Work budgets: one that never bites, and such that ten regions do not get what they ask for.
fn budgets() -> Vec<Case> {
    let influence = tier(Tier::Influence, 52);
    let with = |work: u32| ParamsSpec { work: Some(work), ..influence };
    let of = |name: &str, params, case: Case| named(name, Case { params, ..case });
    let tipped = Case { probe: tips(), object: ObjectShape::Box { size: Vec3::splat(0.1) }, ..many() };
    let spare = ParamsSpec { work: Some(MAX_WORK), ..ParamsSpec::default() };
    vec![
        of("influence 52, cube, ten tips", influence, tipped),
        of("influence 52, cube, ten tips, work 1000000", with(1_000_000), tipped),
        of("bristle 64, cube, ten tips, work 300000", ParamsSpec { work: Some(300_000), ..ParamsSpec::default() }, tipped),
        of("bristle 64, cube, ten tips, work 150000", ParamsSpec { work: Some(150_000), ..ParamsSpec::default() }, tipped),
        of("base, work to spare", spare, base()),
        of("influence 52, box, ten regions, work 1000000", with(1_000_000), many()),
        of("influence 52, box, ten regions, work 400000", with(400_000), many()),
        of("influence 52, box, ten regions, work 200000", with(200_000), many()),
        of("influence 52, box, ten regions, births, work 400000", with(400_000), Case { motion: Motion::Births, ..many() }),
    ]
}

/// The box with a table of its own, as tier `green` has it; every tier reads it.
fn tables() -> Vec<Case> {
    let green = Some(table::of_a_box());
    let mut cases = Vec::new();
    for (friction, params) in [("no friction", smooth()), ("point", tier(Tier::Point, 64)), ("green 52", tier(Tier::Green, 52))] {
        for (count, case) in [("one region", Case { object: TABLE, ..base() }), ("ten regions", many())] {
            cases.push(named(format!("{friction}, box with a table, {count}"), Case { params, green, ..case }));
        }
    }
    cases
}

/// Vertices along a side of a block so small that what comes before the vertices is most of it.
const BLOCK: NonZeroUsize = NonZeroUsize::new(8).unwrap();

/// Updates of such a block: one patch and ten, with the motion of the body and without.
fn blocks() -> Vec<Case> {
    let shown = |body| Some(Shown { body, side: BLOCK });
    let mut cases = Vec::new();
    for (count, case) in [("one region", base()), ("ten regions", Case { probe: TEN, regions: 10, ..base() })] {
        cases.push(named(format!("surface of 64, local, {count}"), Case { surface: shown(false), ..case }));
        cases.push(named(format!("surface of 64, full, {count}, box"), Case { surface: shown(true), object: TABLE, ..case }));
    }
    cases
}

/// Ten round tips under a plate, as `tests/scenes/ten-regions.toml` has them.
fn tips() -> &'static [ProbePart<'static>] {
    let tip = ProbeShape::Capsule { radius: 0.006, height: 0.02 };
    let place = |i: usize| Vec3::new(0.016 * ((i % 5) as f32 - 2.0), 0.032 * ((i / 5) as f32 - 0.5), -0.004);
    let mut parts = vec![ProbePart {
        position: Vec3::Z * 0.013,
        ..ProbePart::at_origin(ProbeShape::Box { size: Vec3::new(0.08, 0.048, 0.006) })
    }];
    parts.extend((0..10).map(|i| ProbePart { position: place(i), ..ProbePart::at_origin(tip) }));
    parts.leak()
}

/// Samples of a mesh: more than any search asks for.
const SAMPLES: usize = 512;

/// Objects of [`pairs`].
fn objects() -> [(&'static str, ObjectShape<'static>); 8] {
    [
        ("half space", ObjectShape::HalfSpace),
        ("box", ObjectShape::Box { size: Vec3::splat(0.08) }),
        ("sphere", ObjectShape::Sphere { radius: 0.05 }),
        ("ellipsoid", ObjectShape::Ellipsoid { semi_axes: Vec3::new(0.06, 0.05, 0.04) }),
        ("cylinder", ObjectShape::Cylinder { radius: 0.04, height: 0.08 }),
        ("mesh", ObjectShape::Mesh(meshes::ball(0.05, 0.05, SAMPLES))),
        // no part comes near their edges
        ("wide box", ObjectShape::Box { size: WIDE }),
        ("wide cylinder", ObjectShape::Cylinder { radius: 0.5 * WIDE.x, height: WIDE.z }),
    ]
}

/// Shapes of [`pairs`].
fn shapes() -> [(&'static str, ProbeShape<'static>); 8] {
    let (radius, height) = (0.01, 0.03);
    [
        ("sphere", ProbeShape::Sphere { radius: 0.02 }),
        ("box", ProbeShape::Box { size: Vec3::new(0.03, 0.02, 0.025) }),
        ("ellipsoid", ProbeShape::Ellipsoid { semi_axes: Vec3::new(0.02, 0.03, 0.015) }),
        ("capsule", ProbeShape::Capsule { radius, height }),
        ("cylinder", ProbeShape::Cylinder { radius, height }),
        ("cone", ProbeShape::Cone { radius, height }),
        ("mesh", ProbeShape::Mesh(meshes::ball(0.02, 0.0, SAMPLES))),
        ("mesh of 32", ProbeShape::Mesh(meshes::ball(0.02, 0.0, 32))),
    ]
}

/// Every shape of a part on every shape of an object, without friction: what finding and pressing one contact costs.
fn pairs() -> Vec<Case> {
    let (objects, shapes) = (objects(), shapes());
    let mut cases = Vec::new();
    for (on, object) in objects {
        let tilted = Case { object, motion: Motion::Tilt, ..base() };
        cases.push(named(format!("point, sphere on {on}"), Case { probe: BALL, params: tier(Tier::Point, 64), ..tilted }));
        for (what, shape) in shapes {
            let probe = vec![ProbePart::at_origin(shape)].leak();
            cases.push(named(format!("{what} on {on}"), Case { probe, params: smooth(), ..tilted }));
        }
    }
    cases
}

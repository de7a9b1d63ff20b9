//! The work budget: estimates bound what is counted, ticks keep to the budget, the ladder goes down at once and up slowly, and what is felt has no step.

use std::cell::Cell;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;
use std::process::{Command, Stdio};

use haptor_contact::budget::{CALM_TICKS, of_surface};
use haptor_contact::{
    Flags, GuardSpec, Input, MAX_WORK, MIN_WORK, Model, ModelSpec, ObjectShape, Output, Params, ParamsSpec, Pose, ProbePart,
    ProbeShape, Quat, Rung, Scratch, State, Tier, Vec3, Wrench, step,
};
use haptor_wire::{Record, RecordReader};
use proptest::prelude::*;

use crate::alloc::counted;
use crate::cli::{built, haptor, root};
use crate::counts::counting;
use crate::served::{alone, patiently, signal};
use crate::support::drive::{CUBE, Drive, RUBBER};

#[path = "../counts/cases.rs"]
mod cases;
#[path = "../counts/cases_pc.rs"]
mod cases_pc;
#[path = "../counts/meshes.rs"]
mod meshes;
#[path = "../counts/table.rs"]
mod table;

use cases::{Case, Motion, ROUND};

/// How far an estimate may lie above the dearest counted tick.
const FACTOR: f64 = 1.5;

/// What a budget costs itself in a tick and for each part that is near: of estimates of rows that have none it is taken away.
const BUDGET: [u32; 2] = [1_250, 700];

/// Rows whose estimate lies further above, and why that is right.
const FARTHER: [(&str, f64, &str); 4] = [
    (
        "paper 64",
        4.0,
        "every patch's samples are counted, and a tick asks them only where the axis of the turn goes through the patch",
    ),
    (
        "point, ",
        2.0,
        "a patch that turns and slides at once, and has turned back before, costs twice what one does that only slides or turns",
    ),
    ("on ellipsoid", 2.6, "a part that lies a centimetre deep in an ellipsoid costs twice what the rows' millimetre does"),
    (
        "ten tips",
        2.6,
        "a plate that is near and never touches, and tips that an edge is near but does not cut, are most of a tick",
    ),
];

/// Largest estimate of the counted round, on the rung that the case asks for.
fn estimate(case: &Case) -> u32 {
    let work = case.params.work.or(Some(MAX_WORK));
    let spec = ModelSpec { mass: case.mass, green: case.green, ..ModelSpec::new(case.object, cases::RUBBER, case.probe) };
    let model = Model::new(&spec).expect("valid model");
    let params = Params::new(&ParamsSpec { work, ..case.params }).expect("valid parameters");
    let (mut state, mut scratch) = (Box::new(State::<16, 256, 256>::new()), Scratch::<16>::new());
    let mut most = 0;
    for tick in 0..2 * ROUND {
        let output = step(&model, &params, &mut state, &mut scratch, Input { pose: case.pose(tick), dt: 1.0e-3 });
        most = most.max(if tick < ROUND { 0 } else { output.report.work });
    }
    match case.surface {
        Some(shown) => of_surface(shown.side.get() * shown.side.get(), state.patches().len(), shown.body),
        None => most,
    }
}

/// The dearest tick of each row of the committed table.
fn counted_rows() -> Vec<(String, u32)> {
    let file = counting::table_file(Path::new(root()));
    let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let row = |line: &str| {
        let fields: Vec<_> = line.strip_prefix('|')?.strip_suffix('|')?.split('|').map(str::trim).collect();
        let [name, _, worst] = fields[..] else { return None };
        Some((name.to_owned(), worst.replace(' ', "").parse().ok()?))
    };
    text.lines().filter_map(row).collect()
}

#[test]
fn estimates_bound_the_counted_instructions_and_are_near_them() {
    let (rows, mut said, mut wrong) = (counted_rows(), String::new(), Vec::new());
    for case in cases::all().chain(cases_pc::all()) {
        let name = case.name.to_string();
        let Some(&(_, worst)) = rows.iter().find(|(row, _)| *row == name) else {
            wrong.push(format!("{name}: not in the table; cargo xtask counts"));
            continue;
        };
        let own = BUDGET[0] + BUDGET[1] * case.probe.len() as u32;
        let has_own = case.params.work.is_some() || case.regions == 0 || case.motion == Motion::Still || case.surface.is_some();
        let estimate = estimate(&case) - if has_own { 0 } else { own };
        let ratio = f64::from(estimate) / f64::from(worst);
        let allowed = FARTHER.iter().find(|(part, ..)| name.contains(part)).map_or(FACTOR, |&(_, allowed, _)| allowed);
        writeln!(
            said,
            "{name:55} counted {worst:8}  estimated {estimate:8}  {ratio:.2}  off {:+}",
            i64::from(estimate) - i64::from(worst)
        )
        .unwrap();
        if case.params.work.is_some_and(|work| worst > work) {
            wrong.push(format!("{name}: over its budget"));
        }
        if ratio < 1.0 || ratio > allowed {
            wrong.push(format!("{name}: {ratio:.2}, allowed is 1 to {allowed}"));
        }
    }
    println!("{said}");
    assert!(wrong.is_empty(), "unit costs are in core/contact/src/budget/costs.rs:\n{}\n{said}", wrong.join("\n"));
}

/// A scene whose settings change between ticks.
#[derive(Clone)]
struct Bench {
    model: Model<'static>,
    state: Box<State<16, 256, 256>>,
    scratch: Scratch<16>,
}

impl Bench {
    fn new(object: ObjectShape<'static>, parts: &[ProbePart<'static>]) -> Self {
        let model = Model::new(&ModelSpec::new(object, RUBBER, parts.to_vec().leak())).unwrap();
        Self { model, state: Box::new(State::new()), scratch: Scratch::new() }
    }

    fn tick(&mut self, params: &Params, pose: Pose<haptor_contact::World, haptor_contact::ProbeFrame>) -> Output {
        step(&self.model, params, &mut self.state, &mut self.scratch, Input { pose, dt: 1.0e-3 })
    }
}

impl Bench {
    /// A stretch of the slow motion.
    fn ticks(&mut self, params: &Params, ticks: Range<usize>) {
        for tick in ticks {
            self.tick(params, slow(tick));
        }
    }
}

/// Presses 1 mm, drags and turns so that part of the contact slides, 2 um and 0.2 mrad a tick.
fn slow(tick: usize) -> Pose<haptor_contact::World, haptor_contact::ProbeFrame> {
    let t = tick as f32;
    let place = Vec3::new(2.0e-6 * t, 0.0, 0.1 + 0.02 - 1.0e-3 * (t / 50.0).min(1.0));
    Pose::new(place, Quat::from_rotation_z(2.0e-4 * t))
}

const BALL: [ProbePart<'static>; 1] = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];

fn asking(work: u32) -> Params {
    Params::new(&ParamsSpec { tier: Tier::Influence, samples: 112, work: Some(work), ..ParamsSpec::default() }).unwrap()
}

/// Works at which one ball on the cube runs on each rung below the highest, first to last: each is what the rung is estimated at, taking over from the one above it too.
fn works() -> Vec<(Rung, u32)> {
    let top = Rung { tier: Tier::Influence, samples: 112, sweeps: 4 };
    let rungs: Vec<_> = std::iter::successors(Some(top), |rung| rung.lower()).collect();
    let params = |rung: Rung| {
        let (samples, sweeps) = (usize::from(rung.samples), usize::from(rung.sweeps));
        let spec = ParamsSpec { tier: rung.tier, samples, sweeps, work: Some(MAX_WORK), ..ParamsSpec::default() };
        Params::new(&spec).unwrap()
    };
    let of = |(above, rung): (&Rung, &Rung)| {
        let mut bench = Bench::new(CUBE, &BALL);
        bench.ticks(&params(*above), 0..100);
        let most = (100..200).map(|tick| bench.tick(&params(*rung), slow(tick)).report.work).max();
        (*rung, most.unwrap())
    };
    std::iter::once(&top).chain(&rungs).zip(&rungs).map(of).collect()
}

fn rung(output: &Output) -> Rung {
    let report = &output.report;
    Rung { tier: report.tier, samples: report.samples, sweeps: report.sweeps }
}

#[test]
fn down_at_once_and_up_one_rung_after_calm_ticks() {
    let works = works();
    assert!(works.is_sorted_by(|a, b| a.1 > b.1), "a lower rung costs less: {works:?}");
    let (plenty, mut bench, tick) = (asking(MAX_WORK), Bench::new(CUBE, &BALL), Cell::new(0));
    let next = |bench: &mut Bench, params: &Params| bench.tick(params, slow(tick.replace(tick.get() + 1)));
    (0..60).for_each(|_| assert_eq!(rung(&next(&mut bench, &plenty)), works[0].0));
    let last = works.len() - 1;
    let short = asking(works[last].1);
    let down = next(&mut bench, &short);
    assert_eq!((rung(&down), down.report.flags.contains(Flags::TIER_LOWERED)), (works[last].0, true), "all the way in one tick");
    for steps in (0..last).rev() {
        for calm in 1..=usize::from(CALM_TICKS) {
            let output = next(&mut bench, &plenty);
            let expected = if calm < usize::from(CALM_TICKS) { steps + 1 } else { steps };
            assert_eq!(rung(&output), works[expected].0, "{calm} calm ticks towards {:?}", works[steps].0);
            assert_eq!(output.report.flags.contains(Flags::TIER_LOWERED), expected > 0);
        }
    }
    // without room to spare it stays where it is
    let tight = asking(works[1].1 + works[1].1 / 20);
    assert_eq!(rung(&next(&mut bench, &asking(works[2].1))), works[2].0);
    (0..400).for_each(|_| assert_eq!(rung(&next(&mut bench, &tight)), works[2].0));
    // a probe that holds still goes up too, and then stays as it is, to the bit
    let held = slow(tick.get());
    let outputs: Vec<_> = (0..4 * usize::from(CALM_TICKS)).map(|_| bench.tick(&plenty, held)).collect();
    let (before, end) = (&outputs[outputs.len() - 2], &outputs[outputs.len() - 1]);
    assert_eq!((rung(end), before.contact), (works[0].0, end.contact));
    // and no limit is the highest rung at once
    let free = Params::new(&ParamsSpec { tier: Tier::Influence, samples: 112, ..ParamsSpec::default() }).unwrap();
    assert_eq!(rung(&next(&mut bench, &short)), works[last].0);
    let output = next(&mut bench, &free);
    let lowered = output.report.flags.contains(Flags::TIER_LOWERED);
    assert_eq!((rung(&output), output.report.work, lowered), (works[0].0, 0, false));
}

/// Most that a change of rung may move the contact's force, as a share of mu P, and its torque about the normal, as a share of mu P a. Measured 22 November 2026 by this
/// test, which prints them: 0.040 and 0.054 where nearly all of the contact slides, a tenth of that where most of it sticks. A hand tells 5 % to 10 % of a force.
const FORCE_STEP: f32 = 0.045;
const TORQUE_STEP: f32 = 0.06;

/// Force and torque by which two ticks from one state differ, as shares of mu P and mu P a.
fn apart(one: &Output, other: &Output) -> (f32, f32) {
    let budget = 0.75 * one.contact.force.z;
    let difference =
        Wrench::<haptor_contact::World>::new(one.contact.force - other.contact.force, one.contact.torque - other.contact.torque);
    (difference.force.length() / budget, difference.torque.z.abs() / (budget * one.report.radius))
}

#[test]
fn a_change_of_rung_is_no_step_in_the_hand() {
    let works = works();
    let (mut said, mut worst) = (String::new(), (0.0_f32, 0.0_f32));
    for pair in works.windows(2) {
        for at in [80, 160, 320, 640] {
            let [high, low] = [asking(pair[0].1), asking(pair[1].1)];
            let mut bench = Bench::new(CUBE, &BALL);
            bench.ticks(&high, 0..at);
            let mut other = bench.clone();
            let (stays, goes) = (bench.tick(&high, slow(at)), other.tick(&low, slow(at)));
            assert_eq!((rung(&stays), rung(&goes)), (pair[0].0, pair[1].0));
            let down = apart(&stays, &goes);
            // and up again: the last of the calm ticks
            let plenty = asking(MAX_WORK);
            let calm = usize::from(CALM_TICKS);
            other.ticks(&plenty, at + 1..at + calm);
            let mut stays = other.clone();
            let (stays, goes) = (stays.tick(&low, slow(at + calm)), other.tick(&plenty, slow(at + calm)));
            assert_eq!((rung(&stays), rung(&goes)), (pair[1].0, pair[0].0));
            let up = apart(&stays, &goes);
            writeln!(said, "{:?} to {:?} at {at}: down {down:.4?}, up {up:.4?}", pair[0].0, pair[1].0).unwrap();
            worst = (worst.0.max(down.0).max(up.0), worst.1.max(down.1).max(up.1));
        }
    }
    println!("{said}largest {worst:?}");
    assert!(worst.0 <= FORCE_STEP && worst.1 <= TORQUE_STEP, "{worst:?}\n{said}");
}

/// Ten round tips, each a little lower than the one before, so that their regions arrive one after the other.
fn tips() -> Vec<ProbePart<'static>> {
    let place = |i: usize| Vec3::new(0.016 * ((i % 5) as f32 - 2.0), 0.032 * ((i / 5) as f32 - 0.5), -1.0e-5 * i as f32);
    let tip = |i| ProbePart { position: place(i), ..ProbePart::at_origin(ProbeShape::Sphere { radius: 0.006 }) };
    (0..10).map(tip).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    /// Whatever the budget and the motion: where the lowest rung fits, the estimate does; nothing is allocated; the wrench is finite.
    #[test]
    fn a_tick_keeps_to_its_budget_where_the_lowest_rung_does(
        work in 20_000_u32..2_000_000, speed in 0.2_f32..4.0, tier in 0_usize..3, seed in 0.0_f32..6.0,
    ) {
        let (tier, samples) = [(Tier::Influence, 52), (Tier::Bristle, 256), (Tier::Influence, 112)][tier];
        let of = |tier, samples, work| Params::new(&ParamsSpec { tier, samples, work: Some(work), ..ParamsSpec::default() }).unwrap();
        let (asked, lowest) = (of(tier, samples, work), of(Tier::Point, 64, MAX_WORK));
        let (mut bench, mut least) = (Bench::new(CUBE, &tips()), Bench::new(CUBE, &tips()));
        for tick in 0..60 {
            let t = seed + speed * 0.05 * tick as f32;
            let place = Vec3::new(1.0e-3 * t.sin(), 2.0e-4 * t, 0.1 + 0.006 - 4.0e-4 * (1.3 * t).sin());
            let pose = Pose::new(place, Quat::from_rotation_z(0.05 * t.cos()));
            let (output, calls) = counted(|| bench.tick(&asked, pose));
            let floor = least.tick(&lowest, pose).report.work;
            prop_assert_eq!(calls, 0);
            prop_assert!(output.report.work <= work.max(floor), "{} of {} at tick {}", output.report.work, work, tick);
            prop_assert!(output.contact.force.is_finite() && output.contact.torque.is_finite());
            // looks and passes give way too, without another rung
            let lowered = rung(&output) != Rung { tier, samples: samples as u16, sweeps: 4 };
            prop_assert!(output.report.flags.contains(Flags::TIER_LOWERED) || !lowered);
        }
    }
}

#[test]
fn ten_regions_arriving_one_after_the_other_get_cheaper_tiers_and_no_step() {
    let spec = ParamsSpec { tier: Tier::Influence, samples: 52, work: Some(115_000), ..ParamsSpec::default() };
    let mut drive = Drive::new(CUBE, RUBBER, &tips(), &spec);
    let (mut seen, mut last) = (Vec::new(), None::<(Wrench, u8)>);
    for tick in 0..400 {
        let depth = 1.0e-6 * tick as f32;
        let output =
            drive.tick(Vec3::new(1.0e-6 * tick as f32, 0.0, 0.106 + 1.0e-4 - depth), Quat::from_rotation_z(5.0e-5 * tick as f32));
        let found = rung(&output);
        if seen.last() != Some(&found) {
            seen.push(found);
        }
        if let Some((before, regions)) = last {
            let step = (output.contact.force - before.force).length();
            // a birth in one of ten regions brings at most the force of its first 10 um
            let birth = if output.report.regions > regions { 0.02 } else { 0.0 };
            assert!(step <= 0.05 + birth + 0.02 * before.force.length(), "tick {tick}: {step} N on {before:?}");
        }
        last = Some((output.contact, output.report.regions));
    }
    assert_eq!(last.map(|(_, regions)| regions), Some(10));
    let tiers: Vec<_> = seen.iter().map(|rung| rung.tier).collect();
    assert!(
        tiers.starts_with(&[Tier::Influence]) && tiers.contains(&Tier::Bristle) && tiers.ends_with(&[Tier::Point]),
        "{seen:?}"
    );
}

/// Ten capsules under a plate, as in the ready scene.
fn capsules() -> Vec<ProbePart<'static>> {
    let plate =
        ProbePart { position: Vec3::Z * 0.0098, ..ProbePart::at_origin(ProbeShape::Box { size: Vec3::new(0.08, 0.048, 0.006) }) };
    let capsule = ProbeShape::Capsule { radius: 0.006, height: 0.02 };
    let tips = tips().into_iter().map(|tip| ProbePart { shape: capsule, position: tip.position - Vec3::Z * 0.0072, ..tip });
    std::iter::once(plate).chain(tips).collect()
}

/// Most that turns may change of the contact's force, as a share of its peak, while ten contacts are born and pressed by 5 um a tick, and afterwards while the probe is dragged and turned. Measured
/// 23 November 2026 by this test, which prints them: 0.021 and 0.0007.
const OFF_AT_BIRTHS: f32 = 0.03;
const OFF_AFTERWARDS: f32 = 0.0015;

/// The same tier with and without room for a look at every part in every tick: what waits for its turn is felt nearly as if it did not.
#[test]
fn parts_that_take_turns_are_felt_as_if_they_did_not() {
    let of =
        |work| Params::new(&ParamsSpec { tier: Tier::Point, work, guard: GuardSpec::OPEN, ..ParamsSpec::default() }).unwrap();
    let (free, short) = (of(None), of(Some(200_000)));
    let (mut all, mut turns) = (Bench::new(CUBE, &capsules()), Bench::new(CUBE, &capsules()));
    let (mut births, mut afterwards, mut peak, mut waited) = (0.0_f32, 0.0_f32, 0.0_f32, 0);
    for tick in 0..400 {
        let pressed = 5.0e-6 * tick.min(140) as f32;
        let moved = (tick - tick.min(180)) as f32;
        let place = Vec3::new(3.0e-6 * moved, 0.0, 0.1 + 0.0232 - pressed);
        let pose = Pose::new(place, Quat::from_rotation_z(1.0e-4 * moved));
        let (one, other) = (all.tick(&free, pose), turns.tick(&short, pose));
        assert!(other.report.work <= 200_000, "tick {tick}: {}", other.report.work);
        let off = (one.contact.force - other.contact.force).length();
        waited += usize::from(other.report.flags.contains(Flags::TIER_LOWERED));
        peak = peak.max(one.contact.force.length());
        *(if tick < 180 { &mut births } else { &mut afterwards }) =
            if tick < 180 { births.max(off) } else { afterwards.max(off) };
        assert!(tick < 180 || one.report.regions == 10 && other.report.regions == 10, "tick {tick}");
    }
    println!("peak {peak} N, off {} and {} of it, {waited} ticks waited", births / peak, afterwards / peak);
    assert!(waited > 200, "{waited} ticks in which a part waited");
    assert!(births <= OFF_AT_BIRTHS * peak && afterwards <= OFF_AFTERWARDS * peak, "{births} {afterwards} of {peak}");
}

/// Once a probe is held still every part gets its turn, and then nothing changes any more, to the bit.
#[test]
fn a_probe_that_is_held_comes_to_rest_although_its_parts_wait() {
    let params =
        Params::new(&ParamsSpec { tier: Tier::Point, work: Some(200_000), guard: GuardSpec::OPEN, ..ParamsSpec::default() })
            .unwrap();
    let mut bench = Bench::new(CUBE, &capsules());
    let held = Pose::new(Vec3::Z * (0.1 + 0.0232 - 7.0e-4), Quat::IDENTITY);
    let outputs: Vec<_> = (0..100).map(|_| bench.tick(&params, held)).collect();
    let last = &outputs[99];
    assert_eq!(last.report.regions, 10);
    assert!(outputs[50..].iter().all(|output| output.contact == last.contact));
    let mut all = Bench::new(CUBE, &capsules());
    let free = Params::new(&ParamsSpec { tier: Tier::Point, guard: GuardSpec::OPEN, ..ParamsSpec::default() }).unwrap();
    let outputs: Vec<_> = (0..100).map(|_| all.tick(&free, held)).collect();
    let off = (outputs[99].contact.force - last.contact.force).length();
    assert!(off <= 2.0e-3 * last.contact.force.length(), "{off}");
}

#[test]
fn a_surface_gives_way_before_the_grip() {
    use haptor_contact::surface::SurfaceState;
    use haptor_contact::{Look, deform};
    let rest: Vec<Vec3> = (0..500).map(|i| Vec3::new(1.0e-4 * i as f32, 0.0, 0.1)).collect();
    let mut bench = Bench::new(CUBE, &BALL);
    // 60 ticks of the slow motion: what a tick begins with is over
    bench.ticks(&Params::new(&ParamsSpec { guard: GuardSpec::OPEN, ..ParamsSpec::default() }).unwrap(), 0..60);
    let mut at = |work: Option<u32>| {
        let params = Params::new(&ParamsSpec { work, guard: GuardSpec::OPEN, ..ParamsSpec::default() }).unwrap();
        let report = bench.tick(&params, slow(60)).report;
        let look = Look { rest: &rest, body: true, vertices: usize::MAX };
        let updated = deform(&bench.model, &params, &bench.state, &slow(60), &look, &mut SurfaceState::<500>::new());
        (report, updated.count)
    };
    let (report, all) = at(Some(1_000_000));
    let grip = report.work;
    assert_eq!((all, at(None).1), (500, 500));
    for (spare, fewest, most) in [(0, 0, 0), (45_000, 0, 0), (100_000, 1, 400)] {
        let (report, count) = at(Some(grip + spare));
        assert_eq!((report.tier, report.flags), (Tier::Bristle, Flags::CLEAN), "the grip stays");
        assert!((fewest..=most).contains(&count), "{spare} instructions to spare: {count} vertices");
        let taken = of_surface(count, 1, true);
        assert!(report.work + taken <= grip + spare, "{spare}: {taken}");
    }
}

/// `tests/scenes/ten-regions.toml`, tier `influence`, with a budget.
fn scene_with(work: u32, folder: &Path) -> String {
    let text = std::fs::read_to_string(root().join("tests/scenes/ten-regions.toml")).unwrap();
    let (before, after) = text.split_once("[model]").expect("the scene has a model");
    let rest = after.split_once("\n[").map_or("", |(_, rest)| rest);
    assert!(rest.is_empty(), "[model] is last");
    let file = folder.join("s.toml");
    std::fs::write(&file, format!("{before}[model]\ntier = \"influence\"\nwork = {work}\n")).unwrap();
    file.to_str().unwrap().to_owned()
}

#[test]
fn eval_shows_what_the_budget_left_and_a_recording_of_it_is_verified() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_with(600_000, folder.path());
    let trajectory = root().join("tests/scenes/ten-regions.csv");
    let run = |args: &[&str]| {
        let output = haptor().args(args).output().unwrap();
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let table = run(&["eval", &scene, trajectory.to_str().unwrap()]);
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
    let lowered =
        |row: &&Vec<&str>| u32::from_str_radix(row[12].trim_start_matches("0x"), 16).unwrap() & Flags::TIER_LOWERED.0 != 0;
    let tiers: std::collections::BTreeSet<_> = rows.iter().map(|row| row[11]).collect();
    assert!(tiers.contains("influence") && tiers.contains("bristle"), "{tiers:?}");
    assert!(rows.iter().filter(|row| row[11] != "influence").all(|row| lowered(&row)) && rows.iter().any(|row| !lowered(&row)));
    let recording = folder.path().join("r.haptor");
    let file = recording.to_str().unwrap();
    run(&["record", &scene, "--trajectory", trajectory.to_str().unwrap(), "-o", file]);
    let verified: serde_json::Value = serde_json::from_str(&run(&["replay", file, "--verify", "--json"])).unwrap();
    assert_eq!((&verified["passed"], &verified["verified"]), (&true.into(), &rows.len().into()));
}

fn assert_verified(file: &str) {
    let verified = Command::new(built("haptor")).args(["replay", file, "--verify"]).output().unwrap();
    assert!(verified.status.success(), "{}", String::from_utf8_lossy(&verified.stderr));
}

/// A shell changes the budget of a session that runs; the recording says so and comes out again to the bit.
#[test]
fn tell_changes_the_budget_of_a_session_that_runs() {
    for program in ["haptor-host", "haptor-firmware-sim"] {
        built(program);
    }
    let (_alone, folder) = (alone(), tempfile::tempdir().unwrap());
    let (scene, file) = (root().join("tests/scenes/cube-twist.toml"), folder.path().join("r.haptor"));
    let (address, file) = (format!("unix:{}", folder.path().join("v").display()), file.to_str().unwrap());
    let mut session = Command::new(built("haptor"));
    session.arg("run").arg(scene).args(["--device", "sim", "--rt", "ignore", "--budget", "40000"]);
    // until told to stop: longer than any machine takes for what is asked below
    session.args(["--seconds", "60", "--viewer", &address, "--record", file]);
    let mut session = session.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let program = built("haptor");
    let tell = |budget: &str| Command::new(&program).args(["tell", &address, "budget", budget]).output().unwrap();
    let mut said = tell("20000");
    // the host is there in a moment, and says what a tick may spend once its device has answered
    patiently("the host has a session", || {
        said = tell("20000");
        said.status.success() && !said.stdout.is_empty()
    });
    assert_eq!(String::from_utf8_lossy(&said.stdout).trim(), "a tick may spend 20000 instructions");
    assert_eq!(String::from_utf8_lossy(&tell("off").stdout).trim(), "the work of a tick has no limit");
    assert_eq!(tell("9999").status.code(), Some(2));
    signal(session.id(), "INT");
    session.wait().unwrap();
    let (mut bytes, mut works) = (std::fs::read(file).unwrap(), Vec::new());
    for record in RecordReader::new(&mut bytes) {
        if let Record::Tuning(tuning) = record.unwrap() {
            works.push(tuning.work);
        }
    }
    assert!(works.ends_with(&[Some(20_000), None]), "{works:?}");
    assert_verified(file);
}

/// The host measures, says what it set, records it, and the recording comes out again to the bit without any clock.
#[test]
fn a_host_records_the_budget_it_measured() {
    for program in ["haptor-host", "haptor-firmware-sim"] {
        built(program);
    }
    let (_alone, folder) = (alone(), tempfile::tempdir().unwrap());
    let (scene, file) = (root().join("tests/scenes/cube-twist.toml"), folder.path().join("r.haptor"));
    let run = |args: &[&str]| Command::new(built("haptor")).args(args).output().unwrap();
    let [scene, file] = [&scene, &file].map(|path| path.to_str().unwrap());
    let session = ["--device", "sim", "--rt", "ignore", "--seconds", "1", "--budget", "auto", "--record", file];
    let output = run(&[&["run", scene], &session[..]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("instructions a tick, 60 % of the period at"), "{said}");
    let mut bytes = std::fs::read(file).unwrap();
    let (mut hello, mut set) = (Vec::new(), Vec::new());
    for record in RecordReader::new(&mut bytes) {
        match record.unwrap() {
            Record::Device(device) => hello.push(device.work),
            Record::Tuning(tuning) => set.push(tuning.work),
            _ => {}
        }
    }
    assert!(
        !set.is_empty() && set == hello && set.iter().all(|work| work.is_some_and(|work| (MIN_WORK..=MAX_WORK).contains(&work))),
        "{set:?}"
    );
    assert_verified(file);
    for (budget, part) in [("fast", "scene, auto, off"), ("9999", "10000 to 1000000000")] {
        let refused = run(&["run", scene, "--device", "sim", "--budget", budget]);
        assert_eq!(refused.status.code(), Some(2), "{budget}");
        assert!(String::from_utf8_lossy(&refused.stderr).contains(part), "{budget}");
    }
}

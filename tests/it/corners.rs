//! The short version of `cargo xtask extremes`: random corners of the box keep the laws, the kept worst cases are no worse, and what lies outside the box is refused or flagged by name.
//!
//! What the laws are and why their bounds are what they are stands in the document that the command writes.

use haptor_contact::{
    Flags, Input, MAX_TICK, MIN_TICK, Material, Model, ModelSpec, ObjectShape, Params, ParamsSpec, Pose, ProbePart, ProbeShape,
    Quat, Scratch, State, Tier, Vec3, step,
};
use haptor_tests::extremes::laws::{LAWS, Law, place_of};
use haptor_tests::extremes::run::{judge, some};

/// Seed of the short run: not that of the long one, whose cases are kept.
const SEED: u64 = 7;

/// Cases of the short run.
const CASES: u64 = 240;

/// Laws that hold to the bit or to rounding in every case.
const STRICT: [Law; 4] = [Law::Wander, Law::Coupled, Law::Times, Law::Hold];

/// Share of the measured cases of another law that may be above its bound: detection at edges, and slices of boxes below 20 um.
const ABOVE: f64 = 0.15;

#[test]
fn random_corners_keep_the_laws() {
    let tallies = some(SEED, CASES);
    assert_eq!(tallies.faulty, 0, "{:#?}", tallies.faults);
    for law in LAWS {
        let rows = &tallies.laws[place_of(law)];
        let (measured, above): (u64, u64) = rows.iter().fold((0, 0), |(m, a), row| (m + row.measured, a + row.above));
        println!("{}: {measured} measured, {above} above", law.name());
        let most = if STRICT.contains(&law) { 0.0 } else { (ABOVE * measured as f64).max(2.0) };
        assert!(above as f64 <= most, "{}: {above} of {measured} cases above the bound: {rows:#?}", law.name());
        assert!(measured > 0, "{} was never measured", law.name());
    }
}

#[test]
fn two_runs_are_the_same() {
    assert_eq!(some(SEED, 48).digest, some(SEED, 48).digest);
}

/// Worst cases of the long run by law, tier and seed, with their figures; and the document that was written with them.
const KEPT: &str = include_str!("../bench/extremes-cases.csv");
const DOCUMENT: &str = include_str!("../bench/EXTREMES.md");

/// Most that a kept figure above its bound may grow: the table has four digits, and a figure that a change of the core moves by more is to be looked at and kept anew.
const WORSE: f64 = 1.05;

/// A row of the kept cases.
struct Kept {
    law: Law,
    tier: Tier,
    seed: u64,
    figure: f64,
}

impl Kept {
    fn all() -> Vec<Self> {
        let mut reader = csv::Reader::from_reader(KEPT.as_bytes());
        let row = |(law, tier, seed, figure): (String, String, String, f64)| Self {
            law: LAWS.into_iter().find(|one| one.name() == law).expect("a law"),
            tier: Tier::ALL.into_iter().find(|one| one.name() == tier).expect("a tier"),
            seed: u64::from_str_radix(&seed, 16).expect("a seed"),
            figure,
        };
        reader.deserialize().map(|line| row(line.expect("the table parses"))).collect()
    }

    /// Largest figure that is no worse: the law's bound, or a little above the kept figure where that is above the bound or there is no bound.
    fn most(&self) -> f64 {
        let bound = self.law.bound(self.tier);
        let own = WORSE * self.figure;
        if bound.is_finite() { bound.max(own) } else { own }
    }

    /// What has become worse.
    fn complaint(&self) -> Option<String> {
        let (case, outcome) = judge(self.law, self.seed);
        let what = match (&outcome.seen.fault, outcome.refused, outcome.figure) {
            _ if case.twin.params.tier != self.tier => "the seed makes a case of another tier".to_owned(),
            (Some(fault), ..) => fault.clone(),
            (None, Some(invalid), _) => format!("refused: {invalid}"),
            (None, None, None) => "comes to measure nothing".to_owned(),
            (None, None, Some(figure)) if figure > self.most() => {
                format!("{figure:.3e}, kept is {:.3e}, allowed {:.3e}", self.figure, self.most())
            }
            (None, None, Some(_)) => return None,
        };
        Some(format!("{} {} {:016x}: {what}", self.law.name(), self.tier.name(), self.seed))
    }
}

/// Cases that once were far above their bounds, and what was wrong.
const MENDED: [(Law, u64); 11] = [
    // a normal taken from the few digits of a shallow point's slacks, under an edge of a box
    (Law::Turned, 0x72f7_8a3e_09da_218f),
    (Law::Turned, 0x9ea4_bfab_d2aa_6dc3),
    (Law::Turned, 0xe1d3_bed7_72e3_f7ea),
    (Law::Turned, 0x1039_2618_d20f_3a2a),
    // turns that nobody made: the product of a rotation and its inverse rounds
    (Law::Repeated, 0x8956_366a_4c48_9197),
    (Law::Repeated, 0xe8d0_b747_dccb_e05c),
    (Law::Repeated, 0xe84c_a417_51dd_8262),
    // a mark of slip in metres that was longer than the slips of a small contact
    (Law::Units, 0x92fc_8387_6649_378b),
    // two patches without area yet on one corner of a box, no distance apart
    (Law::Wander, 0x7335_4d7a_5e1d_15b8),
    // a contact that begins only at its full depth, whose load was divided by a fullness of nothing
    (Law::Coupled, 0x036f_5e13_1bb2_e7da),
    (Law::Coupled, 0xb06a_b588_9775_8705),
];

#[test]
fn mended_cases_stay_within_their_bounds() {
    for (law, seed) in MENDED {
        let (case, outcome) = judge(law, seed);
        assert_eq!(outcome.seen.fault, None, "{} {seed:016x}", law.name());
        let (figure, bound) = (outcome.figure.expect("measured"), law.bound(case.twin.params.tier));
        assert!(figure <= bound, "{} {seed:016x}: {figure:.3e}, bound {bound:.3e}", law.name());
    }
}

#[test]
fn the_document_names_the_cases_that_are_kept() {
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().replace('`', "")).collect::<Vec<_>>();
    let is_law = |row: &Vec<String>| row.len() == 12 && LAWS.iter().any(|law| law.name() == row[1]);
    let rows = DOCUMENT.lines().map(cells).filter(is_law).filter(|row| row[9] != "-");
    let told: Vec<_> = rows.map(|row| format!("{} {} {}", row[1], row[2], row[9])).collect();
    let kept = Kept::all();
    let held: Vec<_> = kept.iter().map(|one| format!("{} {} {:016x}", one.law.name(), one.tier.name(), one.seed)).collect();
    assert_eq!(told, held, "`cargo xtask extremes --accept` writes both");
    assert!(LAWS.iter().all(|&law| kept.iter().any(|one| one.law == law)), "a law without a case: {held:#?}");
}

/// Every kept case, none left out: nothing that must never break breaks, and no figure has become worse.
#[test]
fn kept_cases_are_no_worse() {
    let complaints: Vec<_> = Kept::all().iter().filter_map(Kept::complaint).collect();
    assert!(
        complaints.is_empty(),
        "{complaints:#?}\nwhere this is meant, `cargo xtask extremes --steps 5000000 --accept` keeps the worst cases anew"
    );
}

/// A ball on a half space for the drills below.
fn on_rubber(radius: f32, young_modulus: f32) -> impl FnMut(Vec3, f32) -> haptor_contact::Output {
    let parts: &'static [ProbePart<'static>] =
        Box::leak(vec![ProbePart::at_origin(ProbeShape::Sphere { radius })].into_boxed_slice());
    let material = Material { young_modulus, poisson_ratio: 0.5, density: 1.1e3 };
    let model = Model::new(&ModelSpec::new(ObjectShape::HalfSpace, material, parts)).expect("valid");
    let params = Params::new(&ParamsSpec::default()).expect("valid");
    let (mut state, mut scratch) = (Box::new(State::<16, 64>::new()), Scratch::<16>::new());
    move |at, dt| step(&model, &params, &mut state, &mut scratch, Input { pose: Pose::new(at, Quat::IDENTITY), dt })
}

#[test]
fn ticks_that_are_none_are_refused_and_count_no_time() {
    let mut tick = on_rubber(0.02, 3.0e6);
    let at = Vec3::Z * 0.019;
    tick(at, 1.0e-3);
    for dt in [0.5 * MIN_TICK, 2.0 * MAX_TICK, f32::MAX, 1.0e-40] {
        assert!(tick(at, dt).report.flags.contains(Flags::POSE_REFUSED), "{dt}");
    }
    for dt in [MIN_TICK, MAX_TICK] {
        assert!(!tick(at, dt).report.flags.contains(Flags::POSE_REFUSED), "{dt}");
    }
}

/// The same depth near the origin, far from it, and a depth that no pose near the origin can tell.
#[test]
fn depths_below_the_digits_of_the_pose_are_flagged() {
    let coarse = |at: Vec3| on_rubber(0.02, 3.0e6)(at, 1.0e-3).report.flags.contains(Flags::POSE_COARSE);
    assert!(!coarse(Vec3::Z * 0.019), "1 mm deep at the origin");
    assert!(coarse(Vec3::new(900.0, 0.0, 0.019)), "1 mm deep at 900 m");
    assert!(coarse(Vec3::Z * (0.02 - 1.0e-8)), "10 nm deep at the origin");
}

/// Friction whose shares among the samples would leave the range of an f32 is none, and the load stays.
#[test]
fn friction_below_its_range_is_none() {
    let mut tick = on_rubber(1.0e-6, 1.0e2);
    let (radius, depth) = (1.0e-6, 1.0e-10);
    tick(Vec3::Z * (radius - depth), 1.0e-3);
    let output = tick(Vec3::new(depth, 0.0, radius - depth), 1.0e-3);
    assert_eq!((output.contact.force.x, output.contact.force.y), (0.0, 0.0));
    assert!(output.contact.force.z > 0.0);
}

//! Runs ticks of named scenes, each call that counts in a marked function, for callgrind to count instructions in.
//!
//! Prints the scene's name for each call of a `measured_` function; callgrind writes one dump for each, in the same order. `--sizes` prints
//! the sizes of state and workspace instead. No clock, no argument that changes a count, no allocation while a
//! call is measured: the same program counts the same on every run.
#![forbid(unsafe_code)]

mod cases;
mod table;

use std::hint::black_box;

use haptor_contact::surface::Surface;
use haptor_contact::{Input, Model, ModelSpec, Output, Params, Patch, Scratch, State, Vec3, step};

use cases::{Case, ROUND, RUBBER, Shown};

/// Updates of a surface that are counted: every one costs the same but for the branches of its closed forms.
const UPDATES: usize = 2;

/// Capacities of the host: every probe, the finest samples.
type FullState = State<16, 256, 256>;

/// What a tick needs.
struct Bench<'a> {
    model: Model<'a>,
    params: Params,
    state: Box<FullState>,
    scratch: Box<Scratch<16>>,
}

fn main() {
    if std::env::args().nth(1).as_deref() == Some("--sizes") {
        return sizes();
    }
    let mut lines = String::new();
    for case in cases::all() {
        run(&case, &mut lines);
    }
    print!("{lines}");
}

/// One round to warm up, so that every region is born, and one that counts.
fn run(case: &Case, lines: &mut String) {
    let green = case.table.then(table::of_a_box);
    let spec = ModelSpec { mass: case.mass, green, ..ModelSpec::new(case.object, RUBBER, &case.probe) };
    let mut bench = Bench {
        model: Model::new(&spec).expect("valid model"),
        params: Params::new(&case.params).expect("valid parameters"),
        state: Box::new(State::new()),
        scratch: Box::new(Scratch::new()),
    };
    let input = |tick| Input { pose: case.pose(tick), dt: 1.0e-3 };
    let regions = warm_round(&mut bench, &input);
    assert_eq!(regions, case.regions, "{}", case.name);
    if let Some(shown) = case.surface {
        return update(&bench, case, shown, lines);
    }
    for tick in ROUND..2 * ROUND {
        measured_tick(&mut bench, black_box(&input(tick)));
        lines.push_str(&format!("{}\n", case.name));
    }
}

/// The first round, in no dump; yields the regions at its end.
#[inline(never)]
fn warm_round(bench: &mut Bench<'_>, input: &dyn Fn(usize) -> Input) -> u8 {
    let ticks = (0..ROUND).map(|tick| step(&bench.model, &bench.params, &mut bench.state, &mut bench.scratch, input(tick)));
    ticks.last().map_or(0, |output| output.report.regions)
}

/// Whole surfaces after the last tick.
fn update(bench: &Bench<'_>, case: &Case, shown: Shown, lines: &mut String) {
    let rest = case.surface_at_rest(shown.vertices);
    let mut moved = vec![Vec3::ZERO; rest.len()];
    let p_wp = case.pose(ROUND - 1).position;
    let surface = Surface { model: &bench.model, params: &bench.params, patches: bench.state.patches(), p_wp, body: shown.body };
    for _ in 0..UPDATES {
        measured_surface(&surface, &rest, black_box(&mut moved));
        lines.push_str(&format!("{}\n", case.name));
    }
}

/// One tick; the name is what callgrind is told.
#[inline(never)]
fn measured_tick(bench: &mut Bench<'_>, input: &Input) -> Output {
    black_box(step(&bench.model, &bench.params, &mut bench.state, &mut bench.scratch, *input))
}

/// One update of a whole surface.
#[inline(never)]
fn measured_surface(surface: &Surface<'_>, rest: &[Vec3], moved: &mut [Vec3]) {
    surface.update(rest, moved);
}

/// Sizes in bytes, a line each: what, bytes.
fn sizes() {
    let one = |what: &str, bytes: usize| println!("{what}\t{bytes}");
    one("`Model`", size_of::<Model<'_>>());
    one("`Params`", size_of::<Params>());
    one("`Patch`, in `State` once per part", size_of::<Patch>());
    one("`State<1, 0>`: one part, no friction or tiers `point` and `paper`: no samples", size_of::<State<1, 0, 0>>());
    one("`State<1, 64>`: one part, `bristle` 64", size_of::<State<1, 64, 0>>());
    one("`State<1, 80, 80>`: one part, `influence` 52", size_of::<State<1, 80, 80>>());
    one("`State<10, 0>`: ten parts, no samples", size_of::<State<10, 0, 0>>());
    one("`State<10, 64>`: ten parts, `bristle` 64", size_of::<State<10, 64, 0>>());
    one("`State<10, 80, 80>`: ten parts, `influence` 52", size_of::<State<10, 80, 80>>());
    one("`State<16, 64>`: every probe, `bristle` 64", size_of::<State<16, 64, 0>>());
    one("`State<16, 256, 256>`: every probe, every tier, the host's", size_of::<FullState>());
    one("`Scratch<1>`", size_of::<Scratch<1>>());
    one("`Scratch<10>`", size_of::<Scratch<10>>());
    one("`Scratch<16>`: the host's", size_of::<Scratch<16>>());
}

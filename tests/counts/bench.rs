//! Scenes stepped, each call that counts in a marked function, on a PC and on a Cortex-M7.
//!
//! No clock, no argument that changes a count, no allocation while a call is measured: the same program counts the same on every run. Needs nothing but
//! the core, so that the image for the Cortex-M7 can include this file.

use core::hint::black_box;
use core::num::NonZeroUsize;

use haptor_contact::surface::{Prepared, Surface};
use haptor_contact::{Input, Invalid, Model, ModelSpec, Output, Params, Scratch, State, Vec3, step};

use crate::cases::{Case, ROUND, RUBBER, SIDE, Shown};

/// Vertices of a whole surface.
const VERTICES: usize = SIDE.get() * SIDE.get();

/// Updates of a surface that are counted: every one costs the same but for the branches of its closed forms.
const UPDATES: usize = 2;

/// Capacities of the host: every probe, the finest samples.
pub type FullState = State<16, 256, 256>;

/// Counts calls.
pub trait Count {
    /// Makes a call and counts what it costs.
    fn count(&mut self, call: impl FnOnce());
}

/// What scenes need; one after the other uses it.
pub struct Room {
    state: FullState,
    scratch: Scratch<16>,
    rest: [Vec3; VERTICES],
    moved: [Vec3; VERTICES],
    prepared: Prepared,
}

impl Room {
    pub fn new() -> Self {
        let (rest, moved) = ([Vec3::ZERO; VERTICES], [Vec3::ZERO; VERTICES]);
        Self { state: State::new(), scratch: Scratch::new(), rest, moved, prepared: Prepared::new() }
    }

    /// As if no scene had used it.
    pub fn clear(&mut self) {
        self.state = State::new();
    }
}

/// What a tick needs.
struct Bench<'a> {
    model: Model<'a>,
    params: Params,
    state: &'a mut FullState,
    scratch: &'a mut Scratch<16>,
}

/// One round to warm up, so that every region is born, and one that counts; yields the regions at the end of the first.
///
/// # Errors
/// When the scene is refused.
#[inline(never)]
pub fn run(case: &Case, room: &mut Room, counter: &mut impl Count) -> Result<u8, Invalid> {
    // what the scene is made of the compiler must not know: a tick is compiled for every shape and tier
    let spec = black_box(ModelSpec { mass: case.mass, green: case.green, ..ModelSpec::new(case.object, RUBBER, case.probe) });
    let (model, params) = (Model::new(&spec)?, Params::new(&case.params)?);
    let mut bench = Bench { model, params, state: &mut room.state, scratch: &mut room.scratch };
    let input = |tick| Input { pose: case.pose(tick), dt: 1.0e-3 };
    let regions = warm_round(&mut bench, input);
    if let Some(shown) = case.surface {
        update(&bench, case, shown, (&mut room.rest, &mut room.moved, &mut room.prepared), counter);
        return Ok(regions);
    }
    for tick in ROUND..2 * ROUND {
        let input = input(tick);
        counter.count(|| {
            measured_tick(&mut bench, black_box(&input));
        });
    }
    Ok(regions)
}

/// The first round, not counted.
#[inline(never)]
fn warm_round(bench: &mut Bench<'_>, input: impl Fn(usize) -> Input) -> u8 {
    let ticks = (0..ROUND).map(|tick| step(&bench.model, &bench.params, bench.state, bench.scratch, input(tick)));
    ticks.last().map_or(0, |output| output.report.regions)
}

/// Surfaces after the last tick.
fn update(
    bench: &Bench<'_>,
    case: &Case,
    shown: Shown,
    (rest, moved, prepared): (&mut [Vec3], &mut [Vec3], &mut Prepared),
    counter: &mut impl Count,
) {
    let count = VERTICES.min(shown.side.get() * shown.side.get());
    let (Some(rest), Some(moved)) = (rest.get_mut(..count), moved.get_mut(..count)) else { return };
    rest.iter_mut().enumerate().for_each(|(k, vertex)| *vertex = vertex_at_rest(case, shown.side, k));
    let p_wp = case.pose(ROUND - 1).position;
    let surface = Surface { model: &bench.model, params: &bench.params, patches: bench.state.patches(), p_wp, body: shown.body };
    for _ in 0..UPDATES {
        counter.count(|| measured_surface(&surface, prepared, rest, black_box(moved)));
    }
}

/// A vertex of the undeformed surface around the contacts: of a square of 0.1 m on the object's top.
fn vertex_at_rest(case: &Case, side: NonZeroUsize, k: usize) -> Vec3 {
    let at = |k: usize| 0.1 * ((k as f32 + 0.5) / side.get() as f32 - 0.5);
    Vec3::new(at(k % side), at(k / side), case.object.height())
}

/// One tick; the name is what the counter of a PC and the bound of the stack are told.
#[inline(never)]
fn measured_tick(bench: &mut Bench<'_>, input: &Input) -> Output {
    black_box(step(&bench.model, &bench.params, bench.state, bench.scratch, *input))
}

/// One update of a whole surface.
#[inline(never)]
fn measured_surface(surface: &Surface<'_>, prepared: &mut Prepared, rest: &[Vec3], moved: &mut [Vec3]) {
    prepared.prepare(surface);
    prepared.update(rest, moved);
}

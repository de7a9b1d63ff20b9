//! The loops: the same ticks with a clock, with the fastest of several rounds, or bare.

use std::fs;
use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};

use haptor_contact::Pose;
use haptor_engine::frames::{DeviceBase, Handle};
use haptor_engine::{Engine, Felt};
use haptor_wire::RtReport;

use super::Op;
use crate::rt::clock::Clock;
use crate::rt::histogram::Durations;

/// Work between two breaths \[ns\].
const WORK_NS: u64 = 8_000_000;

/// A breath \[ns\]: a fifth of the time is left to others, so that the kernel's limit on real-time threads (95 %) never holds the loop.
const BREATH_NS: u64 = 2_000_000;

/// Pairs of looks at the clock, to learn what they take themselves.
const CLOCK_PAIRS: usize = 10_001;

/// What a timed run found.
#[derive(Debug)]
pub struct Timed {
    /// Times of ticks.
    pub durations: Durations,
    /// What two looks at the clock take with nothing between, the median \[ns\]: it is part of every time above.
    pub clock_ns: u64,
    /// How often the thread was put aside for another, in ticks or between.
    pub preempted: u64,
    /// What the real-time policy obtained.
    pub rt: RtReport,
}

impl Timed {
    /// Nothing yet, with all its memory.
    #[must_use]
    pub fn new() -> Self {
        Self { durations: Durations::new(), clock_ns: 0, preempted: 0, rt: RtReport::default() }
    }
}

impl Default for Timed {
    fn default() -> Self {
        Self::new()
    }
}

/// One tick; the name is what an instruction counter is told.
#[inline(never)]
pub fn measured_tick(engine: &mut Engine<'_>, x_dh: &Pose<DeviceBase, Handle>, dt: f32) -> Felt {
    black_box(engine.step(x_dh, dt))
}

/// Whatever is no tick.
fn between(engine: &mut Engine<'_>, op: &Op) {
    match op {
        Op::Rest => engine.rest(),
        Op::Tune(tuned) => engine.tune(tuned),
        Op::Place(placed) => engine.place(placed),
        Op::Tick { .. } => {}
    }
}

/// Every tick once, without a clock; yields what each was estimated at, 0 where there is no work budget.
pub fn count(engine: &mut Engine<'_>, ops: &[Op]) -> Vec<u32> {
    let mut works = Vec::new();
    for op in ops {
        if let Op::Tick { x_dh, dt } = op {
            works.push(measured_tick(engine, black_box(x_dh), *dt).work);
        }
        between(engine, op);
    }
    works
}

/// The least time of each tick over some rounds \[ns\]. Each round begins as the first did only where the stream puts the core at rest.
pub fn fastest(engine: &mut Engine<'_>, ops: &[Op], rounds: u32, clock: &impl Clock) -> Vec<u64> {
    let ticks = ops.iter().filter(|op| matches!(op, Op::Tick { .. })).count();
    let mut least = vec![u64::MAX; ticks];
    for _ in 0..rounds {
        let mut left = least.iter_mut();
        for op in ops {
            if let Op::Tick { x_dh, dt } = op {
                let before = clock.now_ns();
                measured_tick(engine, black_box(x_dh), *dt);
                let took = clock.now_ns() - before;
                if let Some(least) = left.next() {
                    *least = (*least).min(took);
                }
            }
            between(engine, op);
        }
    }
    least
}

/// How long a timed run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Length {
    /// Ticks.
    pub ticks: u64,
    /// Time after which fewer will do, breaths with it \[ns\].
    pub most_ns: u64,
}

/// The stream over and over; every tick into the histogram. A stream without ticks ends at once.
pub fn time(engine: &mut Engine<'_>, ops: &[Op], length: Length, clock: &impl Clock, done: &AtomicU64, timed: &mut Timed) {
    timed.clock_ns = clock_cost(clock);
    if !ops.iter().any(|op| matches!(op, Op::Tick { .. })) {
        return;
    }
    let put_aside = preemptions();
    let Length { ticks, most_ns } = length;
    let (mut left, mut began) = (ticks, clock.now_ns());
    let end = began.saturating_add(most_ns);
    for op in ops.iter().cycle() {
        if let Op::Tick { x_dh, dt } = op {
            let before = clock.now_ns();
            measured_tick(engine, black_box(x_dh), *dt);
            let after = clock.now_ns();
            timed.durations.record_ns(after - before);
            left -= 1;
            if left == 0 || after > end {
                break;
            }
            if after - began > WORK_NS {
                done.store(ticks - left, Ordering::Relaxed);
                clock.sleep_until_ns(after + BREATH_NS);
                began = clock.now_ns();
            }
        }
        between(engine, op);
    }
    timed.preempted = preemptions().saturating_sub(put_aside);
}

fn clock_cost(clock: &impl Clock) -> u64 {
    let mut pairs: Vec<u64> = (0..CLOCK_PAIRS)
        .map(|_| {
            let before = clock.now_ns();
            clock.now_ns() - before
        })
        .collect();
    pairs.sort_unstable();
    pairs[CLOCK_PAIRS / 2]
}

/// How often this thread was put aside without having asked for it; 0 where the system does not say.
fn preemptions() -> u64 {
    let status = fs::read_to_string("/proc/thread-self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("nonvoluntary_ctxt_switches:"));
    line.and_then(|count| count.trim().parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rt::clock::{Steady, Virtual};
    use haptor_contact::{Quat, Vec3};
    use haptor_engine::Scene;
    use haptor_wire::{BakedScene, ObjectShape};

    fn ball() -> Scene {
        Scene::new(&BakedScene::ball_on(ObjectShape::HalfSpace)).unwrap()
    }

    fn press() -> Vec<Op> {
        let tick = |k: usize| Op::Tick { x_dh: Pose::new(Vec3::new(0.0, 0.0, -1.0e-4 * k as f32), Quat::IDENTITY), dt: 1.0e-3 };
        std::iter::once(Op::Rest).chain((0..50).map(tick)).collect()
    }

    const fn of(ticks: u64) -> Length {
        Length { ticks, most_ns: u64::MAX }
    }

    #[test]
    fn a_run_ends_when_its_time_is_over() {
        let scene = ball();
        let (mut engine, mut timed) = (scene.engine().unwrap(), Timed::new());
        let (length, clock) = (Length { ticks: 1_000_000, most_ns: 1_000_000 }, Steady::new(1000));
        engine.with(|engine| time(engine, &press(), length, &clock, &AtomicU64::new(0), &mut timed));
        // two looks a tick
        assert!((490..=510).contains(&timed.durations.count()), "{}", timed.durations.count());
    }

    #[test]
    fn every_tick_is_run_and_no_more_are_timed_than_asked_for() {
        let scene = ball();
        let mut engine = scene.engine().unwrap();
        assert_eq!(engine.with(|engine| count(engine, &press()).len()), 50);
        let least = engine.with(|engine| fastest(engine, &press(), 2, &Virtual::default()));
        assert_eq!(least, [0; 50]);
        let (mut timed, done) = (Timed::new(), AtomicU64::new(0));
        engine.with(|engine| time(engine, &press(), of(120), &Virtual::default(), &done, &mut timed));
        assert_eq!(timed.durations.count(), 120);
    }

    #[test]
    fn a_stream_without_ticks_ends() {
        let scene = ball();
        let mut engine = scene.engine().unwrap();
        let mut timed = Timed::new();
        engine.with(|engine| time(engine, &[Op::Rest], of(5), &Virtual::default(), &AtomicU64::new(0), &mut timed));
        assert_eq!(timed.durations.count(), 0);
    }
}

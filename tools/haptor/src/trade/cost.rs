//! What a setting costs: time and instructions of a tick on the motion that turns and twists, time of a surface, bytes.
//!
//! Every repetition leads the probe through the same ticks, and the core is deterministic: whatever a tick takes longer in one repetition than in another was an interruption. The
//! **worst** time is that of the dearest tick, each tick taken at its fastest repetition; **max** is the longest there was, interruptions included.
//! Instructions are counted by valgrind's callgrind, which runs this program again (`haptor trade --count`); where it is not installed they are missing.

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use haptor_contact::tier::influence::Layout;
use haptor_contact::{MAX_PARTS, Scratch, State, Tier, Vec3};

use super::answers::Answers;
use super::motions::{MOTIONS, Motion, SAMPLES};
use super::settings::Setting;
use super::stage::{Stage, ticks_per_sample};
use super::truth::{Felt, Units};
use crate::bench::quantiles;
use crate::failure::Failure;
use crate::motion::Place;
use crate::simulation::Simulation;
use crate::table::Table;
use crate::timing::callgrind::{self, Job};

/// Rate at which the probe is led while time is taken; the work of a tick hardly depends on it \[Hz\].
const RATE: f64 = 1000.0;

/// Repetitions that the fastest of each tick is taken from, at least, however long they take.
const REPETITIONS: usize = 5;

/// Longest time spent on one setting \[s\]; fewer ticks than asked are told.
const SECONDS: f64 = 6.0;

/// Vertices of the surface that is timed.
pub const VERTICES: usize = 1024;

/// Updates of the surface.
const UPDATES: usize = 200;

/// Ticks that callgrind counts for a setting, spread over the motion.
const COUNTED: usize = 64;

/// The marked function.
const MARKED: &str = "haptor::trade::cost::measured_tick";

/// What says where tables of bodies are kept.
const CACHE: [&str; 2] = ["HOME", "XDG_CACHE_HOME"];

/// Samples of a patch that 52 and 112 cells need.
const COARSE: usize = Layout::COARSE.slots();
const FINE: usize = Layout::FINE.slots();

/// Cost of a setting.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    /// State and workspace with room for every part of a probe \[bytes\], without a body's table.
    pub bytes: usize,
    /// Instructions of the dearest counted tick.
    pub instructions: Option<u64>,
    /// Times on this machine, when they were taken.
    pub times: Option<Times>,
}

impl Cost {
    /// What is known without running anything.
    pub fn of(setting: &Setting) -> Self {
        Self { bytes: bytes(setting), instructions: None, times: None }
    }

    /// What settings are compared by: the dearest tick's time, and its instructions where no time was taken.
    pub fn price(&self) -> Option<f64> {
        self.times.map(|times| times.worst).or(self.instructions.map(|count| count as f64))
    }
}

/// Times of a setting.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    /// Ticks that were timed.
    pub ticks: usize,
    /// Median time of a tick \[us\].
    pub p50: f64,
    /// What 99 of 100 ticks stay within \[us\].
    pub p99: f64,
    /// The dearest tick without interruptions \[us\].
    pub worst: f64,
    /// The longest there was \[us\].
    pub max: f64,
    /// A surface of [`VERTICES`], surroundings only \[us\].
    pub surface_local: f64,
    /// The same with the body's motion \[us\].
    pub surface_full: f64,
}

/// The motion that costs are taken on: shift, turn and twist at once.
const MOTION: &Motion = &MOTIONS[2];

/// Takes the time of `ticks` ticks of a setting.
///
/// # Errors
/// When the core refuses the parameters.
pub fn time(
    stage: &Stage<'_>,
    answers: &Answers,
    setting: &Setting,
    table: Option<&Table>,
    ticks: usize,
) -> Result<Times, Failure> {
    let (started, params) = (Instant::now(), setting.params(stage));
    let round = ticks_per_sample(RATE) * SAMPLES;
    let (mut all, mut fastest) = (Vec::new(), vec![Duration::MAX; round]);
    let mut simulation = stage.simulate(&params, table)?;
    let enough = |done: usize| {
        done >= ticks.max(REPETITIONS * round) || (done >= REPETITIONS * round && started.elapsed().as_secs_f64() > SECONDS)
    };
    while !enough(all.len()) {
        simulation = stage.simulate(&params, table)?;
        let mut t = 0.0;
        stage.press(&mut simulation, RATE, &mut t);
        for (i, least) in fastest.iter_mut().enumerate() {
            let place = stage.led(MOTION, &answers.units, (i + 1) as f64 / round as f64);
            let row = stage.row(place, 1.0 / RATE, t);
            let start = Instant::now();
            black_box(simulation.tick(black_box(&row)));
            let took = start.elapsed();
            *least = took.min(*least);
            all.push(took);
        }
    }
    let worst = fastest.into_iter().max().map_or(0.0, |time| 1.0e6 * time.as_secs_f64());
    let [surface_local, surface_full] = [false, true].map(|body| surface(stage, &simulation, answers, body));
    let (ticks, [p50, p99, max]) = (all.len(), quantiles(all.into_iter()));
    Ok(Times { ticks, p50, p99, worst, max, surface_local, surface_full })
}

/// Median time of a surface after the last tick \[us\].
fn surface(stage: &Stage<'_>, simulation: &Simulation<'_>, answers: &Answers, body: bool) -> f64 {
    let rest: Vec<Vec3> = answers.places.iter().copied().cycle().take(VERTICES).collect();
    let mut moved = vec![Vec3::ZERO; VERTICES];
    let row = stage.row(stage.led(MOTION, &answers.units, 1.0), 1.0, 0.0);
    let mut times: Vec<f64> = (0..UPDATES)
        .map(|_| {
            let start = Instant::now();
            simulation.surface(&row, body).update(black_box(&rest), black_box(&mut moved));
            1.0e6 * start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[UPDATES / 2]
}

/// Bytes of the smallest state with room for the setting and every part of a probe, and of the workspace.
fn bytes(setting: &Setting) -> usize {
    let state = match (setting.tier, setting.samples) {
        (Tier::Point | Tier::Paper, _) => size_of::<State<MAX_PARTS, 0, 0>>(),
        (Tier::Bristle, ..=16) => size_of::<State<MAX_PARTS, 16, 0>>(),
        (Tier::Bristle, ..=32) => size_of::<State<MAX_PARTS, 32, 0>>(),
        (Tier::Bristle, ..=64) => size_of::<State<MAX_PARTS, 64, 0>>(),
        (Tier::Bristle, ..=128) => size_of::<State<MAX_PARTS, 128, 0>>(),
        (Tier::Bristle, _) => size_of::<State<MAX_PARTS, 256, 0>>(),
        (Tier::Influence | Tier::Green, ..=52) => size_of::<State<MAX_PARTS, COARSE, COARSE>>(),
        (Tier::Influence | Tier::Green, _) => size_of::<State<MAX_PARTS, FINE, FINE>>(),
    };
    state + size_of::<Scratch<MAX_PARTS>>()
}

/// Worst instructions by setting, from callgrind; `None` where it is not installed.
///
/// # Errors
/// When valgrind is there and does not do its work.
pub fn count(scene: &Path, stage: &Stage<'_>, units: &Units, settings: &[Setting]) -> Result<Option<Vec<u64>>, Failure> {
    if callgrind::version().is_none() {
        return Ok(None);
    }
    let failed = |what: &dyn std::fmt::Display| Failure::problem(format!("counting instructions: {what}"));
    let folder = tempfile::tempdir().map_err(|error| failed(&error))?;
    let program = std::env::current_exe().map_err(|error| failed(&error))?;
    let scene = std::path::absolute(scene).map_err(|error| failed(&error))?.display().to_string();
    let list = settings.iter().map(|s| format!("{} {} {}", s.tier.name(), s.samples, s.sweeps)).collect::<Vec<_>>().join(",");
    let order = format!("--count={} {} {},{list}", stage.depth, units.shift, units.angle);
    let args = &["trade", &scene, &order];
    let job = Job {
        program: &program,
        args,
        keep: &CACHE,
        pattern: "*measured_tick*",
        marked: &[MARKED],
        lines: false,
        folder: folder.path(),
    };
    let said = job.run().map_err(|what| failed(&what))?;
    let mut worst = vec![0; settings.len()];
    for (call, index) in said.lines().enumerate() {
        let total = callgrind::total(&job.dump(call).map_err(|what| failed(&what))?);
        let place = index.parse::<usize>().ok().and_then(|index| worst.get_mut(index));
        let (Some(total), Some(place)) = (total, place) else { return Err(failed(&"a dump without a total")) };
        *place = total.max(*place);
    }
    Ok(Some(worst))
}

/// The counted side: runs the ticks of every setting of `order` and prints the setting's number for each.
///
/// # Errors
/// When `order` is not what [`count`] writes.
pub fn counted(stage: &Stage<'_>, order: &Order, name: &str) -> Result<(), Failure> {
    for (index, setting) in order.settings.iter().enumerate() {
        let table = crate::table::of(stage.scene, setting.tier, name)?;
        let mut simulation = stage.simulate(&setting.params(stage), table.as_ref())?;
        let mut t = 0.0;
        stage.press(&mut simulation, 100.0, &mut t);
        for i in 1..=COUNTED {
            let place = stage.led(MOTION, &order.units, i as f64 / COUNTED as f64);
            black_box(measured_tick(stage, &mut simulation, place, &mut t));
            crate::output::say(index);
        }
    }
    Ok(())
}

/// One tick; the name is what callgrind is told.
#[inline(never)]
fn measured_tick(stage: &Stage<'_>, simulation: &mut Simulation<'_>, place: Place, t: &mut f64) -> Felt {
    stage.tick(simulation, place, 1.0 / RATE, t)
}

/// What the counted side is told: depth and units of the motion, and the settings.
#[derive(Clone, Debug)]
pub struct Order {
    /// Depth \[m\].
    pub depth: f64,
    units: Units,
    settings: Vec<Setting>,
}

impl std::str::FromStr for Order {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} was not written by this program");
        let mut items = text.split(',');
        let numbers: Vec<f64> = items.next().unwrap_or("").split(' ').filter_map(|number| number.parse().ok()).collect();
        let [depth, shift, angle] = numbers[..] else { return Err(wrong()) };
        let settings: Option<Vec<Setting>> = items.map(Setting::read).collect();
        let units = Units { shift, angle, ..Units::default() };
        Ok(Self { depth, units, settings: settings.ok_or_else(wrong)? })
    }
}

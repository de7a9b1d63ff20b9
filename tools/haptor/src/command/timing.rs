//! `haptor timing`: what a tick of a scene costs at worst.

use std::path::{Path, PathBuf};
use std::time::Duration;

use fastrand::Rng;
use haptor_contact::{MAX_WORK, MIN_WORK, Pose, Tier as CoreTier};
use haptor_engine::Scene as Baked;
use haptor_engine::settings::tier_to_wire;
use haptor_wire::{Coupling, Tuning, VirtualCoupling};

use super::bake::bake;
use super::eval::TierName;
use super::within;
use crate::doctor::cpus;
use crate::failure::{Failure, Outcome};
use crate::output::{Output, say, unwritten, write_file};
use crate::progress;
use crate::scene::{Extras, Scene};
use crate::timing::cover::Cover;
use crate::timing::history::History;
use crate::timing::judge::{Dearest, Judge, dearest};
use crate::timing::level::Level;
use crate::timing::measure::{Measure, Timed, Timing};
use crate::timing::report::{Found, Report, Row, Varied, stages};
use crate::timing::search::{Effort, Limits, search};
use crate::timing::start::{Pair, Start};
use crate::timing::{motions, picture, units};
use crate::trajectory;

/// Measures what a tick of a scene costs at worst: searches the dearest input, counts its instructions, times it.
///
/// For every tier: motions that are always measured, then a search for the dearest tick by hill climbing over poses and histories. Instructions are exact
/// (callgrind, when valgrind is installed); times are of the dearest input over and over under SCHED_FIFO on a CPU of its own, as far as the system grants
/// them. Runs `haptor-measure`, which lies beside this program.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: haptor timing tests/scenes/ten-regions.toml --tier bristle --search-seconds 60 --ticks 1000000 -o worst\n\
                        A motion of your own: haptor timing tests/scenes/mallet.toml --poses tests/scenes/mallet.csv --json"
)]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// One tier in place of all
    #[arg(long, value_name = "T")]
    tier: Option<TierName>,
    /// Samples per region of that tier
    #[arg(long, value_name = "N", requires = "tier", allow_negative_numbers = true, value_parser = samples)]
    samples: Option<u16>,
    /// Work that a tick may spend [instructions], in place of the scene's own
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = work)]
    work: Option<u32>,
    /// Ticks to time for each tier, 0 for none; 10000000 for p99.99 and max that mean something
    #[arg(long, value_name = "N", default_value_t = 200_000, allow_negative_numbers = true, value_parser = ticks)]
    ticks: u64,
    /// Longest time to spend on them for each tier [s]: then fewer are timed, and the report says how many
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time_seconds)]
    time_seconds: Option<u32>,
    /// Length of the search for each tier [s], 0 for none
    #[arg(long, value_name = "S", default_value_t = 20, allow_negative_numbers = true, value_parser = search_seconds)]
    search_seconds: u64,
    /// Generations of the search in place of seconds: the same seed then finds the same
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = generations)]
    generations: Option<u32>,
    /// Seed of the search
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = seed)]
    seed: u64,
    /// Folder with inputs that are known to be dear: SCENE-TIER-SAMPLES.csv, the scene's file without .toml. They are measured beside the motions, and the search begins with them too
    #[arg(long, value_name = "DIR")]
    known: Option<PathBuf>,
    /// Measure these poses (CSV, as `haptor eval` reads it) and search nothing
    #[arg(long, value_name = "CSV", conflicts_with_all = ["search_seconds", "generations", "seed", "known"])]
    poses: Option<PathBuf>,
    /// Ticks per second [Hz], 100 to 8000
    #[arg(long, value_name = "HZ", default_value_t = crate::config::RATE, allow_negative_numbers = true, value_parser = rate)]
    rate: u32,
    /// enforce: refuse to time without real-time rights, saying what to do; ignore: take what is granted and say so
    #[arg(long, value_parser = ["enforce", "ignore"], default_value = "ignore")]
    rt: String,
    /// CPU to time on; the last one that may be used when not given
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = cpu)]
    cpu: Option<usize>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Draw the histogram of the times (PNG)
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Save the dearest input of the last tier as a recording, which `haptor replay --verify` computes again
    #[arg(long, value_name = "FILE.haptor")]
    save: Option<PathBuf>,
    /// Folder for timing.json, timing.png, and of every tier the dearest input as a recording, and the dearest that is poses only as a trajectory
    #[arg(short, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let scene = Scene::load(&args.scene)?;
    check(args)?;
    let measure = Measure::find()?;
    let given = args.poses.as_deref().map(given).transpose()?;
    let baked = baked(&scene, args)?;
    let read = Baked::read(&baked).map_err(|error| refused(args, &error))?;
    let levels = levels(args, &read)?;
    let mut judge = Judge { scene: &baked, rate_hz: args.rate, measure: &measure, cover: Cover::default() };
    let mut rng = Rng::with_seed(args.seed);
    let pair = Pair { object: &scene.object.shape, parts: &scene.probe.parts };
    let starts = if given.is_some() { Vec::new() } else { pair.starts(&mut rng) };
    let below = pair.below();
    if given.is_none() && starts.is_empty() {
        return Err(Failure::bad_input(format!(
            "{}: the probe meets nothing on its way down; give poses with --poses",
            args.scene.display()
        )));
    }
    let base = Tuning::of(read.setup().baked());
    let mut bench = Bench { args, judge: &mut judge, starts: &starts, below: below.as_ref(), rng: &mut rng, base };
    let found: Vec<Found> = levels.iter().map(|level| bench.level(*level, &levels, given.as_ref())).collect::<Result<_, _>>()?;
    let other = if given.is_none() { Some(other_coupling(&scene, &mut judge, &starts, args)?) } else { None };
    let report = Report {
        scene: args.scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        rate_hz: args.rate,
        seed: args.seed,
        counter: measure.counter().map(str::to_owned),
        parts: starts.last().map_or(0, |start| start.parts),
        most_parts: scene.probe.parts.len(),
        levels: found,
        other,
        cover: judge.cover.clone(),
    };
    keep(args, &judge, &base, &report)?;
    let text = if args.json { format!("{:#}", report.json()) } else { report.text() };
    say(text.trim_end());
    Ok(())
}

fn samples(text: &str) -> Result<u16, String> {
    within(text, &(16..=1024), "16 to 1024; bristle at most 256, influence and green 52 or 112")
}

fn work(text: &str) -> Result<u32, String> {
    within(text, &(MIN_WORK..=MAX_WORK), "10000 to 1000000000 instructions")
}

fn ticks(text: &str) -> Result<u64, String> {
    within(text, &(0..=1_000_000_000_000), "0 to 1000000000000 ticks")
}

fn time_seconds(text: &str) -> Result<u32, String> {
    within(text, &(1..=1_000_000), "1 to 1000000 s")
}

fn search_seconds(text: &str) -> Result<u64, String> {
    within(text, &(0..=1_000_000), "0 to 1000000 s")
}

fn generations(text: &str) -> Result<u32, String> {
    within(text, &(0..=u32::MAX), "0 to 4294967295")
}

fn seed(text: &str) -> Result<u64, String> {
    within(text, &(0..=u64::MAX), "0 to 18446744073709551615")
}

fn rate(text: &str) -> Result<u32, String> {
    within(text, &(100..=8000), "100 to 8000 Hz")
}

fn cpu(text: &str) -> Result<usize, String> {
    let own = cpus::allowed();
    let name = |cpu: &usize| cpu.to_string();
    let refused =
        || format!("allowed are the CPUs that this process may use: {}", own.iter().map(name).collect::<Vec<_>>().join(", "));
    text.parse().ok().filter(|cpu| own.contains(cpu)).ok_or_else(refused)
}

/// Whether what comes out can be written, and whether what is known lies where it is said to: asked before minutes of work.
fn check(args: &Args) -> Outcome {
    let refused = |folder: &Path, what: &dyn std::fmt::Display| Failure::bad_input(format!("{}: {what}", folder.display()));
    if let Some(folder) = args.known.as_deref().filter(|folder| !folder.is_dir()) {
        return Err(refused(folder, &"no folder; --known takes one with files SCENE-TIER-SAMPLES.csv"));
    }
    args.save.iter().chain(&args.png).try_for_each(|file| Output::check(Some(file)))?;
    let Some(folder) = &args.output else { return Ok(()) };
    let made = std::fs::create_dir_all(folder);
    made.map_err(|error| refused(folder, &format_args!("cannot be made: {error}; -o takes a folder that can be written to")))?;
    Output::check(Some(&folder.join("timing.json")))
}

fn baked(scene: &Scene, args: &Args) -> Result<Vec<u8>, Failure> {
    let work = tempfile::tempdir().map_err(|error| unwritten(&error))?;
    let model = work.path().join("scene.model");
    bake(scene, &args.scene.display().to_string(), &model)?;
    std::fs::read(&model).map_err(|error| unwritten(&error))
}

/// The fixed motions on the other coupling, virtual where the scene's is direct, at the scene's own level: what no tuning brings about.
fn other_coupling(scene: &Scene, judge: &mut Judge<'_>, starts: &[Start], args: &Args) -> Result<Varied, Failure> {
    let coupling = match scene.extras.coupling {
        Coupling::Direct => Coupling::Virtual(VirtualCoupling::DEVICE_S_OWN),
        Coupling::Virtual(_) => Coupling::Direct,
    };
    let name = if coupling == Coupling::Direct { "direct coupling" } else { "virtual coupling" };
    let varied = Scene { extras: Extras { coupling, ..scene.extras }, ..scene.clone() };
    let file = baked(&varied, args)?;
    let read = Baked::read(&file).map_err(|error| refused(args, &error))?;
    let tuning = Tuning::of(read.setup().baked());
    let histories = motions::coupled(starts);
    let mut other = Judge { scene: &file, rate_hz: judge.rate_hz, measure: judge.measure, cover: Cover::default() };
    let bar = progress::bar(histories.len() as u64, "motions").with_message(name);
    let costs = other.costs(&tuning, &histories)?;
    bar.finish_and_clear();
    judge.cover.add(&other.cover);
    let level = Level { tier: tuning.tier, samples: tuning.samples, work: None };
    Ok(Varied { name, level, rows: histories.iter().zip(&costs).map(|(history, costs)| row(history, costs)).collect() })
}

fn row(history: &History, costs: &[u64]) -> Row {
    let mean = costs.iter().sum::<u64>() / (costs.len() as u64).max(1);
    Row { name: history.name.clone(), mean, worst: dearest(costs).1, plain: history.is_plain() }
}

fn refused(args: &Args, error: &haptor_engine::SceneError) -> Failure {
    Failure::bad_input(format!("{}: {error}", args.scene.display()))
}

/// The levels asked for; each is one that the scene takes.
fn levels(args: &Args, read: &Baked) -> Result<Vec<Level>, Failure> {
    let baked = read.setup().baked();
    let mut levels = Level::of(baked);
    if let Some(name) = args.tier {
        let tier = tier_to_wire(CoreTier::from(name));
        levels.retain(|level| level.tier == tier);
        if let Some(samples) = args.samples {
            levels = vec![Level { tier, samples, work: None }];
        }
        if levels.is_empty() {
            // the scene has no table: its own words say what to do
            levels.push(Level { tier, samples: 52, work: None });
        }
    }
    for level in &mut levels {
        level.work = args.work;
        let asked = |error| match args.samples {
            Some(samples) => Failure::bad_input(format!("--samples {samples}: {error}")),
            None => refused(args, &error),
        };
        read.tuned(&level.tuning(&Tuning::of(baked))).map_err(asked)?;
    }
    Ok(levels)
}

/// Poses of a trajectory file as a history.
fn given(path: &Path) -> Result<History, Failure> {
    let rows = trajectory::load(path)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(History { name, poses: rows.iter().map(|row| Pose::new(row.position, row.rotation)).collect(), tunings: Vec::new() })
}

/// Name of an input that was known before.
const KNOWN: &str = "known before";

/// Motions that are run before the bar moves on: two for each of a few CPUs.
const MOTIONS_AT_ONCE: usize = 4;

/// What the fixed motions cost.
#[derive(Default)]
struct Fixed {
    rows: Vec<Row>,
    /// The dearest tick of each.
    known: Vec<Dearest>,
    /// Regions and cost of every tick.
    ticks: Vec<(u8, u64)>,
}

/// What a level is measured with.
struct Bench<'a, 'b> {
    args: &'a Args,
    judge: &'a mut Judge<'b>,
    starts: &'a [Start],
    below: Option<&'a Start>,
    rng: &'a mut Rng,
    base: Tuning,
}

impl Bench<'_, '_> {
    fn level(&mut self, level: Level, all: &[Level], given: Option<&History>) -> Result<Found, Failure> {
        let tuning = level.tuning(&self.base);
        let others: Vec<_> = all.iter().filter(|other| **other != level).map(|other| other.tuning(&self.base)).collect();
        let fixed = match given {
            Some(history) => vec![history.clone()],
            None => {
                let mut fixed = motions::all(self.starts, self.below, &tuning, &others);
                fixed.extend(self.known(level)?);
                fixed
            }
        };
        let Fixed { rows, mut known, ticks } = self.fixed(level, &tuning, &fixed)?;
        known.sort_by_key(|dearest| std::cmp::Reverse(dearest.cost));
        let mut effort = None;
        if given.is_none() {
            let (found, tried) = self.search(level, &tuning, &known)?;
            effort = Some(tried);
            known.extend(found);
        }
        // the first of equals: a motion with a name goes before what the search made of it
        let best = |dearests: &mut dyn Iterator<Item = &Dearest>| {
            dearests.reduce(|best, other| if other.cost > best.cost { other } else { best }).cloned()
        };
        let plain = best(&mut known.iter().filter(|dearest| dearest.history.is_plain()));
        let dearest = best(&mut known.iter()).ok_or_else(|| Failure::problem("no tick was measured"))?;
        // what is tuned on the way would be taken for the price of a unit
        let of = plain.as_ref().filter(|_| !dearest.history.tunings.is_empty()).unwrap_or(&dearest).clone();
        let found = self.examine(level, &tuning, dearest, &of)?;
        Ok(Found { units: found.units.into_iter().chain(units::region(&ticks)).collect(), rows, effort, plain, ..found })
    }

    /// Costs of the fixed motions.
    fn fixed(&mut self, level: Level, tuning: &Tuning, histories: &[History]) -> Result<Fixed, Failure> {
        let bar = progress::bar(histories.len() as u64, "motions").with_message(level.name());
        let mut fixed = Fixed::default();
        for share in histories.chunks(MOTIONS_AT_ONCE) {
            for (history, costs) in share.iter().zip(self.judge.costs(tuning, share)?) {
                let (tick, cost) = dearest(&costs);
                let plain = history.is_plain();
                // what was found before is no fixed motion
                if history.name != KNOWN {
                    fixed.rows.push(row(history, &costs));
                }
                fixed.known.push(Dearest { history: history.clone(), tick, cost });
                // what is tuned on the way costs something else
                if plain {
                    fixed.ticks.extend(self.judge.regions(tuning, history)?.into_iter().zip(costs));
                }
            }
            bar.inc(share.len() as u64);
        }
        bar.finish_and_clear();
        Ok(fixed)
    }

    /// The input of this level that is known to be dear, if there is one.
    fn known(&self, level: Level) -> Result<Option<History>, Failure> {
        let Some(folder) = &self.args.known else { return Ok(None) };
        let scene = self.args.scene.file_stem().unwrap_or_default().to_string_lossy();
        let file = folder.join(format!("{scene}-{}.csv", level.slug()));
        let read = file.exists().then(|| given(&file)).transpose()?;
        Ok(read.map(|history| History { name: KNOWN.to_owned(), ..history }))
    }

    fn search(&mut self, level: Level, tuning: &Tuning, known: &[Dearest]) -> Result<(Option<Dearest>, Effort), Failure> {
        let limits = Limits { time: Duration::from_secs(self.args.search_seconds), generations: self.args.generations };
        let bar = progress::bar(1000 * self.args.search_seconds, "searching").with_message(level.name());
        let found = search(self.judge, tuning, self.starts, known, (limits, self.rng, &bar));
        bar.finish_and_clear();
        found
    }

    /// The dearest tick: its stages, stack, times; and the units of work at the tick that they are told `of`.
    fn examine(&mut self, level: Level, tuning: &Tuning, dearest: Dearest, of: &Dearest) -> Result<Found, Failure> {
        let history = std::slice::from_ref(&dearest.history);
        let (recording, _) = self.judge.recording(tuning, history)?;
        let by_stage = self.judge.measure.by_stage(&recording)?;
        let regions = self.judge.regions(tuning, &dearest.history)?.get(dearest.tick).copied().map_or(0, usize::from);
        let touching = self.judge.regions(tuning, &of.history)?.get(of.tick).copied().map_or(0, usize::from);
        let mut units = units::of(self.judge, tuning, of, touching)?;
        units.extend(units::vertex(self.judge, tuning, of, touching)?);
        Ok(Found {
            stages: by_stage.get(dearest.tick).copied().map(stages).unwrap_or_default(),
            stack: self.judge.measure.stack(&recording, &self.judge.empty(tuning)?)?,
            timed: self.time(level, &recording)?,
            units,
            level,
            dearest,
            regions,
            rows: Vec::new(),
            plain: None,
            effort: None,
        })
    }

    fn time(&self, level: Level, recording: &[u8]) -> Result<Option<Timed>, Failure> {
        let args = self.args;
        if args.ticks == 0 {
            return Ok(None);
        }
        let bar = progress::bar(args.ticks, "timing").with_message(level.name());
        let timing = Timing { ticks: args.ticks, rt: &args.rt, cpu: args.cpu, seconds: args.time_seconds };
        let timed = self.judge.measure.time(recording, &timing, |done| bar.set_position(done));
        bar.finish_and_clear();
        timed.map(Some)
    }
}

/// Writes what is to be kept.
fn keep(args: &Args, judge: &Judge<'_>, base: &Tuning, report: &Report) -> Outcome {
    let recorded = |found: &Found| {
        judge.recording(&found.level.tuning(base), std::slice::from_ref(&found.dearest.history)).map(|(recording, _)| recording)
    };
    if let (Some(file), Some(last)) = (&args.save, report.levels.last()) {
        write_file(file, &recorded(last)?)?;
    }
    if let Some(file) = &args.png {
        picture::draw(file, report).map_err(Failure::problem)?;
    }
    let Some(folder) = &args.output else { return Ok(()) };
    write_file(&folder.join("timing.json"), format!("{:#}\n", report.json()).as_bytes())?;
    if args.ticks > 0 {
        picture::draw(&folder.join("timing.png"), report).map_err(Failure::problem)?;
    }
    for found in &report.levels {
        let file = |kind: &str| folder.join(format!("{}.{kind}", found.level.slug()));
        write_file(&file("haptor"), &recorded(found)?)?;
        if let Some(plain) = &found.plain {
            write_file(&file("csv"), plain.history.csv(args.rate).as_bytes())?;
        }
    }
    Ok(())
}

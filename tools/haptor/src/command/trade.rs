//! `haptor trade`: speed against accuracy on a scene, measured; which setting to take.

use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use super::eval::TierName;
use super::within;
use crate::failure::{Failure, Outcome};
use crate::output::{Output, say, write_file};
use crate::progress;
use crate::scene::Scene;
use crate::table::{self, Table};
use crate::trade::advice::{self, Limits};
use crate::trade::answers::{self, Answers, Fineness};
use crate::trade::cost::{self, Cost, Order};
use crate::trade::errors::{self, Errors};
use crate::trade::picture;
use crate::trade::point::{Point, Trade};
use crate::trade::report::{self, Style};
use crate::trade::scene_file;
use crate::trade::settings::{ALL, QUICK, RATES, Setting};
use crate::trade::stage::Stage;

/// Ticks that are timed for each setting, and for a first look.
const TICKS: [usize; 2] = [50_000, 4_000];

/// Measures what each tier, number of samples and sweeps costs on a scene and how far it is from the truth; says which to take.
///
/// The probe is pressed by a twentieth of its own radius, twisted, turned back and led on paths that turn while they twist. Truth: the f64 reference on the half space with the scene's own
/// shapes, the body's compliance by finite elements (cube, ellipsoid 60:50:40) or the scene's own. Errors are shares of the force at full depth (normal), of the largest torque (twist, reversal), of that
/// or of mu P (mixed), of the largest displacement within three contact radii (surface).
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor trade tests/scenes/cube-twist.toml --quick")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Fewer settings, one rate, a coarser reference: a first look within seconds
    #[arg(long)]
    quick: bool,
    /// Ticks a second [Hz]
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, allow_negative_numbers = true, value_parser = rate)]
    rate: f64,
    /// Recommend the cheapest setting within this error [%], in place of the most accurate that fits
    #[arg(long, value_name = "PCT", allow_negative_numbers = true, value_parser = percent)]
    error: Option<f64>,
    /// Share of the tick's period that the dearest tick may take [%]
    #[arg(long, value_name = "PCT", default_value_t = 50.0, allow_negative_numbers = true, value_parser = percent)]
    share: f64,
    /// Depth of the press in place of a twentieth of the probe's radius [m]
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = depth)]
    depth: Option<f64>,
    /// Only this tier; may be repeated
    #[arg(long, value_name = "T")]
    tier: Vec<TierName>,
    /// Ticks to time for each setting [default: 50000, with --quick 4000]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = ticks)]
    ticks: Option<usize>,
    /// Errors only
    #[arg(long, conflicts_with_all = ["picture", "no_time"])]
    no_cost: bool,
    /// Errors and instructions, which are the same on every run, and no times
    #[arg(long, conflicts_with = "picture")]
    no_time: bool,
    /// One JSON object on standard output in place of the tables
    #[arg(long, conflicts_with = "markdown")]
    json: bool,
    /// The tables as Markdown
    #[arg(long)]
    markdown: bool,
    /// Draw error against time into this file
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// Put the recommended setting into the scene file; comments stay
    #[arg(long)]
    write: bool,
    /// The side of this command that runs under an instruction counter
    #[arg(long, hide = true, allow_hyphen_values = true)]
    count: Option<Order>,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let scene = Scene::load(&args.scene)?;
    let name = args.scene.display().to_string();
    if let Some(order) = &args.count {
        return cost::counted(&Stage::new(&scene, &name, Some(order.depth))?, order, &name);
    }
    let stage = Stage::new(&scene, &name, args.depth)?;
    // before minutes of work for nothing
    let changed = args.write.then_some(args.scene.as_path());
    args.picture.as_deref().into_iter().chain(changed).try_for_each(|file| Output::check(Some(file)))?;
    let trade = measured(args, &stage, &name)?;
    let limits = Limits { error: args.error, share: args.share };
    match (args.json, args.markdown) {
        (true, _) => say(report::json(&trade, &limits)),
        (false, true) => say(report::text(&trade, &limits, Style::Markdown).trim_end()),
        (false, false) => say(report::text(&trade, &limits, Style::Plain).trim_end()),
    }
    if let Some(file) = &args.picture {
        picture::draw(file, &trade, &limits)?;
    }
    if args.write { write(&args.scene, &trade, &limits) } else { Ok(()) }
}

/// Everything that is asked for.
fn measured(args: &Args, stage: &Stage<'_>, name: &str) -> Result<Trade, Failure> {
    let (settings, tables, notes) = settings(args, stage, name)?;
    let rates = rates(args);
    let bar = progress::bar(2 * answers::PROGRESS + (settings.len() * (rates.len() + 1)) as u64, "measuring");
    let (answers, own) = truth(args, stage, &bar)?;
    let mut points = Vec::new();
    for (setting, table) in settings.iter().zip(&tables) {
        bar.set_message(setting.name());
        let table = table.map(|index: usize| &notes.1[index]);
        let params = setting.params(stage);
        let mut cost = (!args.no_cost).then(|| Cost::of(setting));
        if let Some(cost) = cost.as_mut().filter(|_| !args.no_time) {
            cost.times = Some(cost::time(stage, &answers, setting, table, args.ticks.unwrap_or(TICKS[usize::from(args.quick)]))?);
        }
        bar.inc(1);
        for &rate in &rates {
            let (errors, surface) = errors::measure(stage, &answers, &params, table, rate)?;
            points.push(Point { setting: *setting, rate, errors, surface, cost });
            bar.inc(1);
        }
    }
    let mut notes = notes.0;
    if !args.no_cost {
        bar.set_message("counting instructions");
        counted(args, stage, &answers, &settings, &mut points, &mut notes)?;
    }
    bar.finish_and_clear();
    Ok(Trade {
        scene: scene_name(&args.scene),
        depth: stage.depth,
        contacts: answers.contacts,
        units: answers.units,
        source: answers.source,
        own,
        unconverged: answers.unconverged,
        rate: args.rate,
        points,
        notes,
    })
}

/// The truth, and what a coarser one differs by.
fn truth(args: &Args, stage: &Stage<'_>, bar: &ProgressBar) -> Result<(Answers, Option<Errors>), Failure> {
    bar.set_message("the reference");
    let step = &mut || bar.inc(1);
    if args.quick {
        return Ok((answers::solve(stage, Fineness::QUICK, None, step)?, None));
    }
    let answers = answers::solve(stage, Fineness::FULL, None, step)?;
    let coarse = answers::solve(stage, Fineness::QUICK, Some(answers.units), step)?;
    let own = errors::between(&answers, &coarse);
    Ok((answers, Some(own)))
}

/// Settings, the table that each reads, and why some were left out.
type Chosen = (Vec<Setting>, Vec<Option<usize>>, (Vec<String>, Vec<Table>));

fn settings(args: &Args, stage: &Stage<'_>, name: &str) -> Result<Chosen, Failure> {
    let all: &[Setting] = if args.quick { &QUICK } else { &ALL };
    let wanted = |setting: &&Setting| args.tier.is_empty() || args.tier.iter().any(|tier| setting.tier == (*tier).into());
    let (mut settings, mut reads, mut notes, mut tables) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for setting in all.iter().filter(wanted) {
        if setting.tier == haptor_contact::Tier::Green && tables.is_empty() {
            match table::of(stage.scene, setting.tier, name) {
                Ok(found) => tables.extend(found),
                Err(failure) => {
                    let note = format!("Left out: {:#}.", failure.error());
                    if !notes.contains(&note) {
                        notes.push(note);
                    }
                    continue;
                }
            }
        }
        settings.push(*setting);
        reads.push((setting.tier == haptor_contact::Tier::Green && !tables.is_empty()).then_some(0));
    }
    if settings.is_empty() {
        return Err(Failure::bad_input("--tier: no setting of that tier is tried here; leave out --quick or name another tier"));
    }
    Ok((settings, reads, (notes, tables)))
}

/// The rate that was asked for, and the others.
fn rates(args: &Args) -> Vec<f64> {
    let mut rates = vec![args.rate];
    if !args.quick {
        rates.extend(RATES.into_iter().filter(|rate| *rate != args.rate));
    }
    rates
}

/// Puts instructions into the points, or says why there are none.
fn counted(
    args: &Args,
    stage: &Stage<'_>,
    answers: &Answers,
    settings: &[Setting],
    points: &mut [Point],
    notes: &mut Vec<String>,
) -> Outcome {
    let Some(counts) = cost::count(&args.scene, stage, &answers.units, settings)? else {
        notes.push("Instructions are missing: valgrind is not installed (Debian's package valgrind).".to_owned());
        return Ok(());
    };
    for (setting, count) in settings.iter().zip(counts) {
        let of_setting = points.iter_mut().filter(|point| point.setting == *setting);
        of_setting.filter_map(|point| point.cost.as_mut()).for_each(|cost| cost.instructions = Some(count));
    }
    Ok(())
}

/// `cube-twist` of `tests/scenes/cube-twist.toml`.
fn scene_name(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

fn write(scene: &Path, trade: &Trade, limits: &Limits) -> Outcome {
    let shown = scene.display();
    let Some(point) = advice::choose(trade, limits) else {
        return Err(Failure::problem(format!("{shown}: not changed, because no setting meets the limits")));
    };
    let text = std::fs::read_to_string(scene).map_err(|error| Failure::bad_input(format!("{shown}: cannot be read: {error}")))?;
    let changed =
        scene_file::with(&text, &point.setting).map_err(|what| Failure::problem(format!("{shown}: not changed: {what}")))?;
    write_file(scene, changed.as_bytes())?;
    eprintln!("{shown}: now {}", point.setting.name());
    Ok(())
}

fn rate(text: &str) -> Result<f64, String> {
    within(text, &(100.0..=10_000.0), "100 to 10000 Hz")
}

fn percent(text: &str) -> Result<f64, String> {
    within(text, &(0.1..=1000.0), "0.1 to 1000 %")
}

fn depth(text: &str) -> Result<f64, String> {
    within(text, &(1.0e-9..=1.0), "1e-9 to 1 m")
}

fn ticks(text: &str) -> Result<usize, String> {
    within(text, &(1..=1_000_000_000), "1 to 1000000000 ticks")
}

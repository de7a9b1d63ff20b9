//! `cargo xtask timing`: what a tick of the ready scenes costs at worst, as `tests/bench/TIMING.md` and `WORST.md`, and the inputs that cost it.
//!
//! The search keeps its dearest inputs in `tests/bench/worst`; `--kept` counts those anew, which takes a minute where a search and ten million ticks a tier take
//! hours.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{ExitCode, Stdio};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::counting::stages::STAGES;
use crate::demo;
use crate::run::{self, ask, root, target};
use crate::scenes::SCENES;
use crate::worst::{self, Kept, rows};

/// Tiers of a ready scene.
const TIERS: usize = 4;

/// Levels with a work budget, whose searches show that it is kept: ten regions at the counts that a millisecond has room for.
const BUDGETS: [(&str, &str, &str, &str); 2] =
    [("ten-regions", "bristle", "64", "300000"), ("ten-regions", "influence", "52", "900000")];

/// A section of the document: a scene at all its levels, or at one with a budget.
struct Section {
    scene: &'static str,
    /// Heading, and folder of the results.
    title: String,
    /// How the tool is told the level.
    level: Vec<&'static str>,
}

impl Section {
    /// How many levels it has: those that are named, or all.
    const fn levels(&self) -> usize {
        if self.level.is_empty() { TIERS } else { 1 }
    }
}

/// All sections of a scene.
fn sections(scene: &'static str) -> impl Iterator<Item = Section> {
    let budgets = BUDGETS.into_iter().filter(move |budget| budget.0 == scene);
    let within = budgets.map(|(scene, tier, samples, work)| Section {
        scene,
        title: format!("{scene}, {tier} {samples} within {work}"),
        level: vec!["--tier", tier, "--samples", samples, "--work", work],
    });
    std::iter::once(Section { scene, title: scene.to_owned(), level: Vec::new() }).chain(within)
}

/// Time of a timed run over that of its ticks: the measuring program leaves a fifth to others.
const WITH_BREATHS: f64 = 1.25;

/// What is asked for.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Ticks to time for each tier
    #[arg(long, value_name = "N", default_value_t = 10_000_000)]
    ticks: u64,
    /// Length of the search for each tier [s]; it begins with what is kept
    #[arg(long, value_name = "S", default_value_t = 120)]
    search_seconds: u64,
    /// Longest time for the ticks of all tiers and scenes together [min]: cheap ones get all of them, dear ones what is left
    #[arg(long, value_name = "MIN", value_parser = clap::value_parser!(u32).range(1..))]
    minutes: Option<u32>,
    /// Count the kept inputs and the fixed motions anew; search and time nothing
    #[arg(long)]
    kept: bool,
    /// Scenes to measure, by name; the others' figures stay
    #[arg(value_parser = SCENES, conflicts_with = "kept")]
    scene: Vec<String>,
    /// Folder with the released programs, in place of building them
    #[arg(long, value_name = "DIR")]
    programs: Option<PathBuf>,
    /// Folder with results of `haptor timing -o DIR/SECTION`, in place of running it
    #[arg(long, value_name = "DIR", conflicts_with_all = ["kept", "programs"])]
    results: Option<PathBuf>,
}

/// Measures, and writes the documents.
pub fn run(args: &Args) -> Result<ExitCode> {
    let programs = || args.programs.clone().map_or_else(demo::build, Ok);
    if args.kept {
        let kept = again(&programs()?.join("haptor"))?;
        return written(&worst::table_file(root()), &worst_table(&kept)?);
    }
    let results = match &args.results {
        Some(folder) => folder.clone(),
        None => measure(args, &programs()?.join("haptor"))?,
    };
    let file = root().join("tests/bench/TIMING.md");
    // what is measured for the first time has no former text
    let former = fs::read_to_string(&file).unwrap_or_default();
    let formerly_kept = rows(&fs::read_to_string(worst::table_file(root())).unwrap_or_default());
    let (mut text, mut kept) = (head()?, Vec::new());
    for scene in SCENES {
        if !args.has(scene) {
            kept.extend(formerly_kept.iter().filter(|one| one.scene == scene).cloned());
        }
        for Section { title, .. } in sections(scene) {
            if args.has(scene) {
                let folder = results.join(&title);
                let report = report(&folder.join("timing.json"))?;
                scene_text(&mut text, &title, &report)?;
                kept.extend(keep(&folder, scene, &report)?);
            } else {
                text.push_str(former_text(&former, &title));
            }
        }
    }
    written(&worst::table_file(root()), &worst_table(&kept)?)?;
    written(&file, &text)
}

impl Args {
    /// Whether a scene is to be measured.
    fn has(&self, scene: &str) -> bool {
        self.scene.is_empty() || self.scene.iter().any(|name| name == scene)
    }
}

/// A section of the document as it was; empty when it had none.
fn former_text<'a>(document: &'a str, title: &str) -> &'a str {
    let Some(from) = document.find(&format!("\n## {title}\n")) else { return "" };
    let part = &document[from..];
    part[1..].find("\n## ").map_or(part, |end| &part[..=end])
}

fn written(file: &Path, text: &str) -> Result<ExitCode> {
    fs::write(file, text).with_context(|| format!("{}", file.display()))?;
    println!("{} written", file.display());
    Ok(ExitCode::SUCCESS)
}

/// Runs the tool on every scene; yields the folder with the results.
fn measure(args: &Args, haptor: &Path) -> Result<PathBuf> {
    let folder = target()?.join("timing");
    let sections: Vec<_> = SCENES.into_iter().filter(|scene| args.has(scene)).flat_map(sections).collect();
    let mut left = args.minutes.map(|minutes| f64::from(60 * minutes));
    let mut levels: usize = sections.iter().map(Section::levels).sum();
    for section @ Section { scene, title, level } in &sections {
        let mut command = run::program(haptor);
        command.args(["timing", &format!("tests/scenes/{scene}.toml"), "--ticks", &args.ticks.to_string()]).args(level);
        command.args(["--search-seconds", &args.search_seconds.to_string(), "--known", worst::FOLDER]);
        if let Some(left) = left {
            // what cheap tiers do not need is left to the dear ones: scenes come cheapest first
            let each = (left / levels as f64).max(1.0);
            command.args(["--time-seconds", &(each as u32).to_string()]);
        }
        run::run(command.arg("-o").arg(folder.join(title)))?;
        let spent: f64 = list(&report(&folder.join(title).join("timing.json"))?["levels"]).iter().map(seconds).sum();
        left = left.map(|left| left - spent);
        levels -= section.levels();
    }
    Ok(folder)
}

/// Time that the ticks of a level took, as far as the report tells: the mean of its histogram over all of them, breaths with it \[s\].
fn seconds(level: &Value) -> f64 {
    let bins = list(&level["time"]["bins"]).iter();
    let ns: f64 = bins.map(|bin| number(&bin[0]) as f64 * number(&bin[1]) as f64).sum();
    WITH_BREATHS * ns / 1.0e9
}

fn report(file: &Path) -> Result<Value> {
    let text = fs::read_to_string(file).with_context(|| format!("{}", file.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{}", file.display()))
}

/// Keeps the inputs of a scene.
fn keep(folder: &Path, scene: &str, report: &Value) -> Result<Vec<Kept>> {
    if report["cost_unit"] != "instructions" {
        bail!("{scene}: nothing counted instructions; install Debian's package valgrind");
    }
    let mut kept = Vec::new();
    for level in list(&report["levels"]) {
        let name = text(&level["name"]);
        let one =
            Kept { scene: scene.into(), level: name.clone(), worst: number(&level["dearest_plain"]), motions: motions(level) };
        let (from, to) = (folder.join(format!("{}.csv", name.replace(' ', "-"))), root().join(one.input()));
        fs::create_dir_all(to.parent().unwrap_or(root()))
            .and_then(|()| fs::copy(&from, &to))
            .with_context(|| format!("{}", from.display()))?;
        kept.push(one);
    }
    Ok(kept)
}

/// The dearest tick of the motions that are poses and nothing else.
fn motions(level: &Value) -> u64 {
    let plain = list(&level["motions"]).iter().filter(|motion| motion["plain"] == true);
    plain.map(|motion| number(&motion["worst"])).max().unwrap_or(0)
}

/// Counts what is kept, and the fixed motions, anew.
fn again(haptor: &Path) -> Result<Vec<Kept>> {
    let file = worst::table_file(root());
    let table = fs::read_to_string(&file).with_context(|| format!("{}", file.display()))?;
    let mut kept = rows(&table);
    for scene in SCENES {
        let mut fixed = counts(haptor, &format!("tests/scenes/{scene}.toml"), &["--search-seconds", "0"])?;
        for one in kept.iter_mut().filter(|one| one.scene == scene) {
            if one.work().is_some() {
                let level: Vec<String> = one.args().into_iter().chain(["--search-seconds".into(), "0".into()]).collect();
                let args: Vec<&str> = level.iter().map(String::as_str).collect();
                fixed = counts(haptor, &one.scene_file(), &args)?;
            }
            let level = list(&fixed["levels"]).iter().find(|level| level["name"] == one.level.as_str());
            one.motions = level.map(motions).with_context(|| format!("the scene has no level {}", one.level))?;
            let (input, level) = (one.input(), one.args());
            let args: Vec<&str> = level.iter().map(String::as_str).chain(["--poses", &input]).collect();
            one.worst = number(&counts(haptor, &one.scene_file(), &args)?["levels"][0]["dearest"]["cost"]);
        }
    }
    Ok(kept)
}

/// What the tool says of a scene without timing it.
fn counts(haptor: &Path, scene: &str, more: &[&str]) -> Result<Value> {
    eprintln!("$ haptor timing {scene} {}", more.join(" "));
    let mut command = run::program(haptor);
    let output = command.args(["timing", scene, "--ticks", "0", "--json"]).args(more).stderr(Stdio::inherit()).output();
    let output = output.with_context(|| format!("{} cannot be started", haptor.display()))?;
    serde_json::from_slice(&output.stdout).with_context(|| format!("{scene}: haptor timing ended with {}", output.status))
}

fn worst_table(kept: &[Kept]) -> Result<String> {
    let mut text = WORST_HEAD.to_owned();
    let versions = ["rustc", "valgrind"].map(|program| ask(program, &["--version"]).unwrap_or_default());
    writeln!(text, "Compiler: {}. Counter: {}, callgrind.\n", versions[0], versions[1])?;
    text += "| scene, tier | dearest tick | dearest of the fixed motions |\n|---|---:|---:|\n";
    for one in kept {
        writeln!(text, "| {} | {} | {} |", one.name(), one.worst, one.motions)?;
    }
    Ok(text)
}

/// Machine, date, compiler.
fn head() -> Result<String> {
    let cpu = run::processor();
    let say = |program: &str, args: &[&str]| ask(program, args).unwrap_or_default();
    let (date, kernel, cpus) = (say("date", &["+%-d %B %Y"]), say("uname", &["-sr"]), say("nproc", &[]));
    let mut text = TIMING_HEAD.to_owned();
    writeln!(
        text,
        "Measured {date} on {cpus} CPUs of {cpu}, {kernel}, {}, {}.",
        say("rustc", &["--version"]),
        say("valgrind", &["--version"])
    )?;
    Ok(text)
}

fn scene_text(into: &mut String, scene: &str, report: &Value) -> Result<()> {
    writeln!(into, "\n## {scene}\n\nUp to {} parts touch at once. Seed {}.\n", report["parts_touching"], report["seed"])?;
    *into += "| tier | instructions | regions | input | histories tried | ticks timed | p50 | p99.9 | p99.99 | max | max of 1 ms | FIFO | stack |\n";
    *into += "|---|---:|---:|---|---:|---:|---:|---:|---:|---:|---:|---|---:|\n";
    let levels = list(&report["levels"]);
    for level in levels {
        level_row(into, level)?;
    }
    stages(into, levels)?;
    let units = levels.iter().flat_map(|level| list(&level["units"]).iter().map(move |unit| (level, unit)));
    for (level, unit) in units {
        writeln!(
            into,
            "- {}: one {} more is {:.0} instructions ({})",
            text(&level["name"]),
            text(&unit["one_more"]),
            unit["cost"].as_f64().unwrap_or(0.0),
            text(&unit["how"])
        )?;
    }
    other_coupling(into, &report["other_coupling"])?;
    exercised(into, &report["exercised"])
}

fn level_row(into: &mut String, level: &Value) -> Result<()> {
    let (dearest, time) = (&level["dearest"], &level["time"]);
    let us = |name: &str| format!("{:.1} us", number(&time[name]) as f64 / 1000.0);
    writeln!(
        into,
        "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1} % | {} | {} |",
        text(&level["name"]),
        dearest["cost"],
        dearest["regions"],
        text(&dearest["input"]),
        level["search"]["histories"],
        time["ticks"],
        us("p50_ns"),
        us("p99_9_ns"),
        us("p99_99_ns"),
        us("max_ns"),
        100.0 * time["max_of_1_khz"].as_f64().unwrap_or(0.0),
        if time["fifo"] == true { "yes" } else { "refused" },
        level["stack_bytes"],
    )?;
    Ok(())
}

fn other_coupling(into: &mut String, other: &Value) -> Result<()> {
    let Some(dearest) = list(&other["motions"]).iter().max_by_key(|motion| number(&motion["worst"])) else { return Ok(()) };
    let (name, level, motion) = (text(&other["name"]), text(&other["level"]), text(&dearest["motion"]));
    writeln!(into, "- {name}, {level}: {} instructions at most in the fixed motions ({motion})", dearest["worst"])?;
    Ok(())
}

fn stages(into: &mut String, levels: &[Value]) -> Result<()> {
    let counted = levels.iter().any(|level| level["stages"].as_object().is_some_and(|stages| !stages.is_empty()));
    let names: Vec<&str> = STAGES.iter().map(|(name, _)| *name).chain(["rest"]).filter(|_| counted).collect();
    if names.is_empty() {
        return Ok(());
    }
    let joined = names.join(" | ");
    writeln!(into, "\nInstructions of the dearest tick by stage:\n\n| tier | {joined} |\n|---{}|", "|---:".repeat(names.len()))?;
    for level in levels {
        let counts = names.iter().map(|name| level["stages"][*name].to_string()).collect::<Vec<_>>().join(" | ");
        writeln!(into, "| {} | {counts} |", text(&level["name"]))?;
    }
    into.push('\n');
    Ok(())
}

fn exercised(into: &mut String, report: &Value) -> Result<()> {
    let reached: Vec<_> = list(&report["regions"])
        .iter()
        .enumerate()
        .filter(|(_, ticks)| number(ticks) > 0)
        .map(|(count, _)| count.to_string())
        .collect();
    let met = report["conditions"].as_object().into_iter().flatten().filter(|(_, ticks)| number(ticks) > 0);
    let met: Vec<_> = met.map(|(name, _)| name.as_str()).collect();
    writeln!(into, "\nExercised in {} ticks: {} regions; {}.", report["ticks"], reached.join(", "), met.join(", "))?;
    for (name, why) in report["not_met"].as_object().into_iter().flatten() {
        writeln!(into, "- Not met: {name}: {}.", text(why))?;
    }
    Ok(())
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or(0)
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

const WORST_HEAD: &str = "\
# The dearest ticks of the ready scenes, in instructions

Written by `cargo xtask timing`, counted anew by `cargo xtask timing --kept`; `tests/it/timing.rs` fails when a count grows by more than 2 %. Instructions of x86-64,
release profile of this workspace, exact, of the engine's step: the core's and some hundred for poses and report. The inputs lie in [worst](worst), a trajectory for each row, found by
the search of `haptor timing` or taken from its fixed motions where those are dearer. A search proves no bound: it shows a tick that costs as much.

";

const TIMING_HEAD: &str = "\
# What a tick of the ready scenes costs at worst

Written by `cargo xtask timing`, which runs `haptor timing` on each scene: for every tier fixed motions and a search for the dearest tick, its exact instructions (x86-64, callgrind), and the
time of that input over and over under SCHED_FIFO, pinned, with locked memory, where the system grants them. Counts are exact and the same on every run; far quantiles and max are the machine's:
interrupts, neighbours and the hypervisor count as well. Counts of an emulated Cortex-M7: `cargo xtask m7`, kept in `COUNTS-M7.md`. Columns of stages as in [COUNTS.md](COUNTS.md).

";

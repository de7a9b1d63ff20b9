//! The report of `haptor timing`: as text for people, as JSON for programs.

use std::fmt::Write;

use haptor_contact::{MAX_BRISTLES, MAX_PARTS, Model, Params, Scratch, State};
use serde_json::{Value, json};

use super::cover::Cover;
use super::judge::Dearest;
use super::level::Level;
use super::measure::Timed;
use super::search::Effort;
use super::stages::{ByStage, STAGES};
use super::units::Unit;

/// A period at 1 kHz \[ns\].
const PERIOD_1_KHZ_NS: f64 = 1.0e6;

/// Least width of the tables' first column.
const LEAST_WIDE: usize = 15;

/// A motion that was measured.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Mean cost of its ticks.
    pub mean: u64,
    /// Cost of the dearest.
    pub worst: u64,
    /// Poses and nothing else.
    pub plain: bool,
}

/// What was found at a level.
#[derive(Clone, Debug)]
pub struct Found {
    /// Tier and samples.
    pub level: Level,
    /// Fixed motions, or the poses that were given.
    pub rows: Vec<Row>,
    /// The dearest tick of all.
    pub dearest: Dearest,
    /// The dearest of histories that are poses and nothing else.
    pub plain: Option<Dearest>,
    /// Regions in that tick.
    pub regions: usize,
    /// How far the search came; `None` when poses were given.
    pub effort: Option<Effort>,
    /// Instructions of the dearest tick by stage; empty where nothing counts them.
    pub stages: Vec<(&'static str, u64)>,
    /// Cost per unit of work.
    pub units: Vec<Unit>,
    /// Stack of a tick \[bytes\].
    pub stack: Option<u64>,
    /// Times; `None` when none were asked for.
    pub timed: Option<Timed>,
}

/// Fixed motions on another coupling than the scene's.
#[derive(Clone, Debug)]
pub struct Varied {
    /// The coupling.
    pub name: &'static str,
    /// Tier and samples, the scene's own.
    pub level: Level,
    /// The motions.
    pub rows: Vec<Row>,
}

/// Everything about a scene.
#[derive(Debug)]
pub struct Report {
    /// Name of the scene's file.
    pub scene: String,
    /// Ticks a second.
    pub rate_hz: u32,
    /// Seed of the search.
    pub seed: u64,
    /// What counted instructions.
    pub counter: Option<String>,
    /// Most parts that were found to touch at once.
    pub parts: usize,
    /// Parts of the probe.
    pub most_parts: usize,
    /// Level by level.
    pub levels: Vec<Found>,
    /// On the other coupling; `None` when poses were given.
    pub other: Option<Varied>,
    /// What was exercised.
    pub cover: Cover,
}

/// Instructions by the stages' names, what is in none of them last.
pub fn stages((of, rest): (ByStage, u64)) -> Vec<(&'static str, u64)> {
    STAGES.iter().zip(of).map(|((name, _), count)| (*name, count)).chain([("rest", rest)]).collect()
}

/// What the core's memory takes: name, bytes.
pub fn sizes() -> [(&'static str, usize); 4] {
    [
        ("Model", size_of::<Model<'_>>()),
        ("Params", size_of::<Params>()),
        ("State, the host's", size_of::<State<MAX_PARTS, MAX_BRISTLES, MAX_BRISTLES>>()),
        ("Scratch, the host's", size_of::<Scratch<MAX_PARTS>>()),
    ]
}

fn rows_json(rows: &[Row]) -> Vec<Value> {
    rows.iter().map(|row| json!({ "motion": row.name, "mean": row.mean, "worst": row.worst, "plain": row.plain })).collect()
}

impl Report {
    /// What a cost is.
    pub const fn unit(&self) -> &'static str {
        if self.counter.is_some() { "instructions" } else { "ns" }
    }

    fn shares(&self, timed: &Timed) -> [f64; 2] {
        let max = timed.max as f64;
        [max / PERIOD_1_KHZ_NS, max * f64::from(self.rate_hz) / 1.0e9]
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut text = self.head();
        self.levels_table(&mut text);
        self.times_table(&mut text);
        self.stages_table(&mut text);
        self.units_table(&mut text);
        self.other_coupling(&mut text);
        self.memory(&mut text);
        self.exercised(&mut text);
        text
    }

    fn head(&self) -> String {
        let counted = match &self.counter {
            Some(version) => format!("instructions of x86-64, exact: {version}, callgrind"),
            None => "no instructions: valgrind is not installed (Debian: apt-get install valgrind); dearest = longest in the fastest of five rounds".to_owned(),
        };
        format!(
            "{}: what a tick costs at worst\n{counted}\nCortex-M7: no count here; `cargo xtask m7` counts on an emulated one, the table is tests/bench/COUNTS-M7.md\nup to {} parts touch at once; seed {}\n",
            self.scene, self.parts, self.seed
        )
    }

    /// Width of the first column: the longest name of a level, and what heads it.
    fn wide(&self) -> usize {
        self.levels.iter().map(|found| found.level.name().len()).fold(LEAST_WIDE, usize::max)
    }

    fn levels_table(&self, text: &mut String) {
        let wide = self.wide();
        // writing to a string cannot fail, here and below
        let _ = writeln!(
            text,
            "\n{:<wide$}{:>14}{:>9}  {:<34}{:>14}  search",
            "dearest tick",
            self.unit(),
            "regions",
            "input",
            "motions' worst"
        );
        for found in &self.levels {
            let motions = found.rows.iter().map(|row| row.worst).max().unwrap_or(0);
            let effort = found.effort.map_or("none, poses given".to_owned(), |effort| {
                format!("{} histories, {} generations, {} restarts", effort.histories, effort.generations, effort.restarts)
            });
            let input = format!("{}, tick {}", found.dearest.history.name, found.dearest.tick);
            let name = found.level.name();
            let _ =
                writeln!(text, "{name:<wide$}{:>14}{:>9}  {input:<34}{motions:>14}  {effort}", found.dearest.cost, found.regions);
        }
    }

    fn times_table(&self, text: &mut String) {
        let Some(timed) = self.levels.iter().find_map(|found| found.timed.as_ref()) else { return };
        let say = |granted| if granted { "yes" } else { "refused" };
        let _ = writeln!(
            text,
            "\ntimes of {} ticks of that input over and over; SCHED_FIFO {}, own CPU {}, locked memory {}; looking at the clock takes {} ns of each",
            timed.ticks,
            say(timed.fifo),
            say(timed.pinned),
            say(timed.locked),
            timed.clock_ns
        );
        let (rate, wide) = (format!("of {} Hz", self.rate_hz), self.wide());
        let columns = ["p50", "p99", "p99.9", "p99.99", "max"].map(|name| format!("{name:>10}")).concat();
        let _ = writeln!(text, "{:<wide$}{columns}{:>12}{rate:>12}  put aside", "[us]", "max/1 kHz");
        for (found, timed) in self.timed() {
            let us = |ns: u64| format!("{:>10.2}", ns as f64 / 1000.0);
            let columns = [timed.p50, timed.p99, timed.p999, timed.p9999, timed.max].map(us).concat();
            let shares = self.shares(timed).map(|share| format!("{:>10.2} %", 100.0 * share)).concat();
            let _ = writeln!(text, "{:<wide$}{columns}{shares}  {} times", found.level.name(), timed.preempted);
        }
        text.push_str("the far quantiles are this machine's: interrupts, neighbours and a hypervisor count as well\n");
    }

    fn timed(&self) -> impl Iterator<Item = (&Found, &Timed)> {
        self.levels.iter().filter_map(|found| Some((found, found.timed.as_ref()?)))
    }

    fn stages_table(&self, text: &mut String) {
        let Some(first) = self.levels.iter().find(|found| !found.stages.is_empty()) else { return };
        let wide = self.wide();
        let names: String = first.stages.iter().map(|(name, _)| format!("{name:>11}")).collect();
        let _ = writeln!(text, "\n{:<wide$}{names}", "by stage");
        for found in &self.levels {
            let counts: String = found.stages.iter().map(|(_, count)| format!("{count:>11}")).collect();
            let _ = writeln!(text, "{:<wide$}{counts}", found.level.name());
        }
        text.push_str("each with all that it calls; body: the body's compliance, whichever stage asked; rest: the list of calls, checks, report\n");
    }

    fn units_table(&self, text: &mut String) {
        if self.levels.iter().all(|found| found.units.is_empty()) {
            return;
        }
        let wide = self.wide();
        let _ = writeln!(text, "\n{:<wide$}{:>22}{:>14}  how", "per unit", "one more", self.unit());
        for (found, unit) in self.levels.iter().flat_map(|found| found.units.iter().map(move |unit| (found, unit))) {
            let _ = writeln!(text, "{:<wide$}{:>22}{:>14.0}  {}", found.level.name(), unit.what, unit.cost, unit.how);
        }
        text.push_str("a vertex of the surface is no part of a tick: whoever looks on pays for it\n");
    }

    fn other_coupling(&self, text: &mut String) {
        let Some(Varied { name, level, rows }) = &self.other else { return };
        let Some(dearest) = rows.iter().max_by_key(|row| row.worst) else { return };
        let _ = writeln!(text, "\n{name}, {}: {} {}, {}", level.name(), dearest.worst, self.unit(), dearest.name);
    }

    fn memory(&self, text: &mut String) {
        let sizes = sizes().map(|(name, bytes)| format!("{name} {bytes}")).join(", ");
        let _ = writeln!(text, "\nbytes: {sizes}; nothing is allocated");
        let stacks = self.levels.iter().filter_map(|found| Some(format!("{} {}", found.level.name(), found.stack?)));
        let stacks = stacks.collect::<Vec<_>>().join(", ");
        if !stacks.is_empty() {
            let _ = writeln!(text, "bytes of stack of a tick (valgrind's drd): {stacks}");
        }
    }

    fn exercised(&self, text: &mut String) {
        let _ = writeln!(text, "\nexercised, of {} ticks:", self.cover.ticks());
        let regions: Vec<_> = self.cover.regions().iter().enumerate().map(|(count, ticks)| format!("{count}: {ticks}")).collect();
        let _ = writeln!(text, "  regions   {}", regions.join(", "));
        let met = self.cover.conditions().filter(|(_, ticks)| *ticks > 0);
        let met: Vec<_> = met.map(|(name, ticks)| format!("{name} {ticks}")).collect();
        let _ = writeln!(text, "  met       {}", met.join(", "));
        for (name, why) in self.cover.unmet(self.most_parts) {
            let _ = writeln!(text, "  not met   {name}: {why}");
        }
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let sizes: serde_json::Map<_, _> = sizes().into_iter().map(|(name, bytes)| (name.to_owned(), bytes.into())).collect();
        let conditions: serde_json::Map<_, _> =
            self.cover.conditions().map(|(name, ticks)| (name.to_owned(), ticks.into())).collect();
        let unmet: serde_json::Map<_, _> =
            self.cover.unmet(self.most_parts).map(|(name, why)| (name.to_owned(), why.into())).collect();
        json!({
            "scene": self.scene,
            "rate_hz": self.rate_hz,
            "seed": self.seed,
            "cost_unit": self.unit(),
            "counter": self.counter,
            "parts_touching": self.parts,
            "levels": self.levels.iter().map(|found| self.level_json(found)).collect::<Vec<_>>(),
            "other_coupling": self.other.as_ref().map(|other| json!({
                "name": other.name,
                "level": other.level.name(),
                "motions": rows_json(&other.rows),
            })),
            "bytes": sizes,
            "exercised": { "ticks": self.cover.ticks(), "regions": self.cover.regions(), "conditions": conditions, "not_met": unmet },
        })
    }

    fn level_json(&self, found: &Found) -> Value {
        let stages: serde_json::Map<_, _> =
            found.stages.iter().map(|(name, count)| ((*name).to_owned(), (*count).into())).collect();
        let units = found.units.iter().map(|unit| json!({ "one_more": unit.what, "cost": unit.cost, "how": unit.how }));
        json!({
            "tier": found.level.tier.name(),
            "samples": found.level.samples,
            "name": found.level.name(),
            "dearest": { "cost": found.dearest.cost, "input": found.dearest.history.name, "tick": found.dearest.tick, "regions": found.regions },
            "dearest_plain": found.plain.as_ref().map(|dearest| dearest.cost),
            "motions": rows_json(&found.rows),
            "search": found.effort.map(|effort| json!({
                "histories": effort.histories, "generations": effort.generations, "restarts": effort.restarts,
            })),
            "stages": stages,
            "units": units.collect::<Vec<_>>(),
            "stack_bytes": found.stack,
            "time": found.timed.as_ref().map(|timed| self.time_json(timed)),
        })
    }

    fn time_json(&self, timed: &Timed) -> Value {
        let [khz, rate] = self.shares(timed);
        json!({
            "ticks": timed.ticks, "clock_ns": timed.clock_ns, "put_aside": timed.preempted,
            "fifo": timed.fifo, "pinned": timed.pinned, "locked": timed.locked,
            "p50_ns": timed.p50, "p99_ns": timed.p99, "p99_9_ns": timed.p999, "p99_99_ns": timed.p9999, "max_ns": timed.max,
            "max_of_1_khz": khz, "max_of_rate": rate, "bins": timed.bins,
        })
    }
}

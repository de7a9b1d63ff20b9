//! Instructions by stage of the pipeline, each with all that it calls: a root or a sine counts for the stage that asked.
//!
//! A dump of callgrind says of a function what its own lines cost, inlined or not, and what each of its calls cost with all below. What the list of calls in `step.rs` spends on a
//! stage is therefore the stage's; where one stage asks another, the asked one has it. Needs nothing but the standard library, as `callgrind.rs`.

use std::collections::HashMap;

use super::callgrind::{cost, short};

/// Stages in pipeline order: name, starts of paths in the core's `src`. What is in none serves the stage that calls it.
pub const STAGES: [(&str, &[&str]); 11] = [
    ("coupling", &["coupling/"]),
    ("budget", &["budget/"]),
    ("detect", &["stage/detect", "stage/carry"]),
    ("regions", &["stage/regions"]),
    ("force", &["stage/force"]),
    ("torque", &["stage/torque", "tier/"]),
    ("deform", &["stage/deform", "stage/ground"]),
    ("body", &["body"]),
    ("wrench", &["stage/wrench"]),
    ("guard", &["guard"]),
    ("surface", &["surface/"]),
];

/// Stage of those who look at the surface; what a tick asks of it is the asking stage's.
const SURFACE: usize = 10;

/// Instructions of each of [`STAGES`].
pub type ByStage = [u64; STAGES.len()];

/// Names that a run has told so far: they are written once as `(number) name`, then as `(number)`, in dump after dump.
#[derive(Debug, Default)]
pub struct Names {
    files: HashMap<String, String>,
    functions: HashMap<String, Place>,
}

/// The stage that a path in the core belongs to.
fn of_path(path: &str) -> Option<usize> {
    STAGES.iter().position(|(_, starts)| starts.iter().any(|start| path.starts_with(start)))
}

/// Instructions of a dump by stage, what is in none of them last. `names` keeps what the dumps of one run have named.
pub fn by_stage(dump: &str, names: &mut Names) -> (ByStage, u64) {
    names.learn(dump);
    let mut tally = Tally::default();
    let (mut file, mut within, mut callee, mut is_call) = (String::new(), Place::Below, None, false);
    for line in dump.lines() {
        match line.split_once('=') {
            Some(("fl" | "fi" | "fe", name)) => file = names.file(name),
            Some(("fn", name)) => within = names.place(name),
            Some(("cfn", name)) => callee = names.place(name).stage(),
            Some(("calls", _)) => is_call = true,
            Some(_) => {}
            None => {
                if let Some(cost) = cost(line) {
                    let called = std::mem::take(&mut is_call);
                    tally.take(within, of_path(&file), called.then_some(callee), cost);
                }
            }
        }
    }
    tally.shares()
}

/// Where a function stands among the stages. Its name says so: the file of its first line may be that of something inlined there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// It calls stages: the list of calls, and whoever calls that.
    Above,
    /// It is a stage's, by its place in [`STAGES`].
    Stage(usize),
    /// It serves whoever calls it.
    Below,
}

impl Place {
    fn of(function: &str) -> Self {
        let name = function.trim_start_matches('<');
        let Some(path) = name.strip_prefix("haptor_contact::").map(|path| path.replace("::", "/")) else {
            return if name.starts_with("haptor_") { Self::Above } else { Self::Below };
        };
        let aside = if path.starts_with("step/") { Self::Above } else { Self::Below };
        of_path(&path).map_or(aside, Self::Stage)
    }

    const fn stage(self) -> Option<usize> {
        if let Self::Stage(stage) = self { Some(stage) } else { None }
    }
}

/// Sums while a dump is read. A stage that gives to another may be below nothing until its own callers have been read.
#[derive(Debug, Default)]
struct Tally {
    stages: [i64; STAGES.len()],
    total: i64,
}

impl Tally {
    /// Takes a line of a function: its own instructions, or those of a call with all below it, `called` then, with the callee's stage if it has one. `at` is the stage of the
    /// line's file, which is another than the function's where code of it is inlined.
    fn take(&mut self, within: Place, at: Option<usize>, called: Option<Option<usize>>, cost: u64) {
        let cost = i64::try_from(cost).unwrap_or(i64::MAX);
        if called.is_none() {
            self.total += cost;
        }
        let asked = called.flatten().or(at);
        match (within, asked) {
            (Place::Above, Some(to)) => self.stages[to] += cost,
            (Place::Stage(from), Some(to)) if to != from && to != SURFACE => {
                self.stages[to] += cost;
                self.stages[from] -= cost;
            }
            _ => {}
        }
    }

    fn shares(self) -> (ByStage, u64) {
        let rest = self.total - self.stages.iter().sum::<i64>();
        let count = |count: i64| u64::try_from(count).unwrap_or(0);
        (self.stages.map(count), count(rest))
    }
}

impl Names {
    /// Reads the names in a dump.
    pub fn learn(&mut self, dump: &str) {
        for (key, name) in dump.lines().filter_map(|line| line.split_once('=')) {
            let (number, name) = parts(name);
            match key {
                "fl" | "fi" | "fe" | "cfi" | "cfl" if !name.is_empty() => drop(self.files.insert(number.to_owned(), short(name))),
                "fn" | "cfn" if !name.is_empty() => drop(self.functions.insert(number.to_owned(), Place::of(name))),
                _ => {}
            }
        }
    }

    /// The file of this number, or of this number and name.
    pub fn file(&self, name: &str) -> String {
        self.files.get(parts(name).0).cloned().unwrap_or_default()
    }

    fn place(&self, name: &str) -> Place {
        self.functions.get(parts(name).0).copied().unwrap_or(Place::Below)
    }
}

/// Number and name.
fn parts(name: &str) -> (&str, &str) {
    name.split_once(' ').unwrap_or((name, ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The engine asks `step` (60 of its own, 10 of the guard inlined), that asks detection, which asks a root and a look at geometry; force asks the body.
    const DUMP: &str = "\
fl=(1) /x/core/engine/src/engine.rs
fn=(1) haptor_engine::engine::Engine::step
5 7
cfi=(2) /x/core/contact/src/step.rs
cfn=(2) haptor_contact::step::step
calls=1 9
+3 300

fl=(2)
fn=(2)
9 60
fi=(3) /x/core/contact/src/guard.rs
4 10
fe=(2)
cfn=(3) haptor_contact::stage::detect::detect
calls=1 9
* 130
cfn=(4) haptor_contact::stage::force::press
calls=1 9
* 100

fl=(4) /rust/core/src/ops/arith.rs
fn=(3)
2 30
cfn=(5) haptor_contact::geometry::deepest::deepest
calls=1 9
* 100

fn=(5)
+1 100

fn=(4)
3 80
cfn=(6) haptor_contact::body::compliance
calls=2 9
* 20

fn=(6)
3 20

totals: 307
";

    #[test]
    fn a_stage_has_what_it_calls_and_not_what_it_asks_of_others() {
        let (of, rest) = by_stage(DUMP, &mut Names::default());
        let named: Vec<_> =
            STAGES.iter().zip(of).filter(|(_, count)| *count > 0).map(|((name, _), count)| (*name, count)).collect();
        assert_eq!((named, rest), (vec![("detect", 130), ("force", 80), ("body", 20), ("guard", 10)], 67));
    }
}

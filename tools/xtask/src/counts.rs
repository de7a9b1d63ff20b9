//! `cargo xtask counts`: what a tick costs in instructions, scene by scene, as `tests/bench/COUNTS.md`.
//!
//! Counts are exact and the same on every run of the same program; they change with the code and with the compiler.

use std::fmt::Write;
use std::fs;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow};

use crate::counting::callgrind::VALGRIND;
use crate::counting::stages::STAGES;
use crate::counting::{self, Counted};
use crate::run::{self, ask, cargo, root, target};

/// Scenes of the second table.
const SHOWN: [&str; 11] = [
    "no contact, ten parts",
    "no friction, half space, one region, twist",
    "no friction, box, ten regions, twist",
    "point, half space, one region, twist",
    "paper 64, half space, one region, twist",
    "bristle 64, half space, one region, twist",
    "bristle 64, box, one region, twist",
    "bristle 64, box, ten regions, twist",
    "influence 52, half space, one region, twist",
    "base, virtual coupling",
    "surface of 4096, full, one region, box",
];

/// Counts and writes the table.
pub fn run() -> Result<ExitCode> {
    let target = target()?;
    run::run(cargo().args(["build", "--release", "-p", counting::PROGRAM, "--target-dir"]).arg(&target))?;
    if ask(VALGRIND, &["--version"]).is_none() {
        run::install(&[VALGRIND])?;
    }
    let program = target.join("release").join(counting::PROGRAM);
    let folder = target.join("counts");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
    let counted = counting::count(&program, &folder).map_err(|said| anyhow!(said));
    fs::remove_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
    let file = counting::table_file(root());
    fs::write(&file, table(&counted?)?).with_context(|| format!("{}", file.display()))?;
    println!("{} written", file.display());
    Ok(ExitCode::SUCCESS)
}

fn table(counted: &[Counted]) -> Result<String> {
    let mut text = HEAD.to_owned();
    let versions = ["rustc", VALGRIND].map(|program| ask(program, &["--version"]).unwrap_or_default());
    writeln!(text, "Compiler: {}. Counter: {}, callgrind.\n", versions[0], versions[1])?;
    text += "## Instructions of a tick\n\n| scene | mean | worst |\n|---|---:|---:|\n";
    for case in counted {
        writeln!(text, "| {} | {} | {} |", case.name, case.mean(), case.worst)?;
    }
    text += PARTS_HEAD;
    writeln!(text, "| scene | {} | rest |", STAGES.map(|(name, _)| name).join(" | "))?;
    writeln!(text, "|---{}", "|---:".repeat(STAGES.len() + 1) + "|")?;
    for case in counted.iter().filter(|case| SHOWN.contains(&case.name.as_str())) {
        let share = |count: u64| (count + case.calls / 2) / case.calls;
        let fields = case.stages.map(|count| share(count).to_string()).join(" | ");
        writeln!(text, "| {} | {fields} |", case.name)?;
    }
    Ok(text)
}

const HEAD: &str = "\
# What a tick costs, in instructions

Written by `cargo xtask counts`; `tests/it/counts.rs` fails when a count grows by more than 2 %. Instructions of x86-64, release profile of this workspace, exact: the same
program counts the same on every run. A count is no time: a division counts as one, and so does a load that misses every cache; times are in [RESULTS.md](RESULTS.md).

A tick is the whole of `step`. One region: a ball of 20 mm; ten regions: ten balls of 10 mm, 30 mm apart; rubber of 3 MPa. 48 ticks of one round of a motion that presses 0.6 to
1.4 mm, slides and, where the row says twist, turns, so that contacts stick and slip; a round runs before without being counted. `base` is one ball on the half space, twisted, tier
`bristle` with 64 samples; the rows below it change what they name. A surface is one update of 4096 vertices. State and workspace are the host's;
their sizes are in [MEMORY.md](MEMORY.md), a Cortex-M7's instructions in [COUNTS-M7.md](COUNTS-M7.md).

";

const PARTS_HEAD: &str = "
## Where they are

Mean instructions of each stage with all that it calls. Where one stage asks another, the asked one has them: *deform* is what force and torque ask of the ground between patches,
*body* the body's compliance, whoever asks. *rest*: the list of calls itself, checks of the pose, report.

";

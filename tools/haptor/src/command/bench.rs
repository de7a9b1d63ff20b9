//! `haptor bench`: what a tick costs on this machine.

use std::time::Duration;

use crate::bench::cases::{self, Setting, Stand};
use crate::bench::{self, Line};
use crate::failure::{Failure, Outcome};
use crate::output::say;
use crate::progress;
use crate::table;

/// Measures what a tick costs on this machine: the shipped scenes in every tier, a ball on a cube, one to ten regions.
///
/// Ticks of the core in contact, one thread, no device, each timed by itself: wall time, and CPU time of the thread, which other work on the machine does not lengthen.
/// Reading the clocks is taken off. Tier green, whose table takes seconds to compute, is measured when --case names it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor bench --case ten-regions --seconds 1\n\
                        One line of JSON per case: haptor bench --json > haptor.jsonl")]
pub struct Args {
    /// Only cases in whose name, `SCENE, SETTING`, this occurs; may be repeated
    #[arg(long = "case", value_name = "TEXT")]
    cases: Vec<String>,
    /// Time for each case [s]
    #[arg(long, value_name = "S", default_value_t = 0.2, value_parser = seconds)]
    seconds: f64,
    /// For programs: one line of JSON per case
    #[arg(long)]
    json: bool,
}

/// Longest time for one case \[s\]: an hour for all of them.
const MAX_SECONDS: f64 = 60.0;

fn seconds(text: &str) -> Result<f64, String> {
    let allowed = || format!("allowed is 0 to {MAX_SECONDS} s");
    text.parse().ok().filter(|seconds| (0.0..=MAX_SECONDS).contains(seconds)).ok_or_else(allowed)
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let stands = cases::stands()?;
    let all = || stands.iter().flat_map(|stand| stand.settings().map(move |setting| (stand, setting)));
    let chosen: Vec<_> = all().filter(|(stand, setting)| is_asked(args, stand, setting)).collect();
    if chosen.is_empty() {
        let names: Vec<_> = all().map(|(stand, setting)| stand.case(setting)).collect();
        return Err(Failure::bad_input(format!("--case {:?}: in no name; there are:\n{}", args.cases, names.join("\n"))));
    }
    if !args.json {
        say(HEAD);
    }
    let bar = progress::bar(chosen.len() as u64, "measuring");
    for (index, (stand, setting)) in chosen.into_iter().enumerate() {
        bar.set_position(index as u64);
        let table = table::of(&stand.scene, setting.tier, &stand.name)?;
        let line = bench::measure(stand, setting, table.as_ref(), Duration::from_secs_f64(args.seconds));
        let line = line.map_err(|invalid| Failure::problem(format!("{}: {invalid}", stand.case(setting))))?;
        bar.suspend(|| tell(&line, args.json));
    }
    bar.finish_and_clear();
    Ok(())
}

fn is_asked(args: &Args, stand: &Stand, setting: &Setting) -> bool {
    let name = stand.case(setting);
    if args.cases.is_empty() {
        return !setting.only_named;
    }
    args.cases.iter().any(|text| name.contains(text.as_str()) && (!setting.only_named || text.contains(setting.tier.name())))
}

const HEAD: &str = "\
                                                            us on the wall             us on a core
scene          setting                               n   median      p99      max   median      p99      max";

fn tell(line: &Line, json: bool) {
    if json {
        // plain numbers and words: nothing that JSON cannot hold
        say(serde_json::to_string(line).unwrap_or_default());
        return;
    }
    let Line { scene, case, n, median_us, p99_us, max_us, cpu_median_us, cpu_p99_us, cpu_max_us, .. } = line;
    say(format_args!(
        "{scene:<15}{case:<30}{n:>9}{median_us:>9.2}{p99_us:>9.2}{max_us:>9.1}{cpu_median_us:>9.2}{cpu_p99_us:>9.2}{cpu_max_us:>9.1}"
    ));
}

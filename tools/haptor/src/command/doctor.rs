//! `haptor doctor`: is this machine good enough, and what to change.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::bake::bake;
use super::run::device;
use crate::doctor::{self, Finding, Mark, cpus, system};
use crate::failure::{Failure, Outcome};
use crate::output::{say, unwritten};
use crate::programs;
use crate::scene;
use crate::trial::{gains, rates, soak};

/// Tells whether this machine is good enough for 1 kHz and what to change.
///
/// Every line is ok, warn or FAIL with what to do. The timer test runs at normal priority: what the host gets under SCHED_FIFO is
/// better. Exit 1 when something fails.
///
/// With --soak, --rates or --gains the real host runs and is measured instead. A share of 95 % of the ticks in time is wanted, below 90 %
/// the machine will not do (exit 1).
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor doctor --json\n\
                        The host's loop beside cyclictest: haptor doctor --soak 10\n\
                        The highest rate for a scene: haptor doctor --rates tests/scenes/mallet.toml")]
pub struct Args {
    /// Run the host's loop beside cyclictest (rt-tests) for so long [min]: with nothing else, under load (stress-ng), with a viewer
    #[arg(long, value_name = "MIN", group = "trial", value_parser = minutes)]
    soak: Option<f64>,
    /// Try 1, 2, 4 and 8 kHz on a scene with the simulated device: which holds, and what limits it
    #[arg(long, value_name = "SCENE", group = "trial")]
    rates: Option<PathBuf>,
    /// Measure under load (stress-ng) what each right of the real-time policy buys
    #[arg(long, group = "trial")]
    gains: bool,
    /// Length of a session of --rates, or of each way of --gains [s]
    #[arg(long, value_name = "S", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=3600))]
    seconds: u64,
    /// Soak with this device in place of the simulated one
    #[arg(long, value_parser = device, requires = "soak")]
    device: Option<String>,
    /// Draw the latencies of --soak
    #[arg(long, value_name = "FILE.png", requires = "soak")]
    plot: Option<PathBuf>,
    /// The two CPUs of --soak; the last two that may be used when not given
    #[arg(long, value_name = "A,B", value_parser = two_cpus, requires = "soak")]
    cpus: Option<[usize; 2]>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    match (args.soak, &args.rates) {
        (Some(minutes), _) => run_soak(args, minutes),
        (None, Some(scene)) => run_rates(args, scene),
        (None, None) if args.gains => run_gains(args),
        (None, None) => examine(args),
    }
}

fn examine(args: &Args) -> Outcome {
    let findings = doctor::examine();
    if args.json {
        let lines: Vec<_> = findings.iter().map(json).collect();
        say(format_args!("{:#}", json!({ "checks": lines, "good": !findings.iter().any(is_fail) })));
    } else {
        findings.iter().for_each(print);
    }
    match findings.iter().filter(|finding| is_fail(finding)).count() {
        0 => Ok(()),
        count => Err(Failure::problem(format!("{count} of {} checks failed", findings.len()))),
    }
}

/// A folder of a trial with a baked scene in it; gone with the value.
struct Work {
    folder: tempfile::TempDir,
    model: PathBuf,
    /// The scene and its tier.
    name: String,
}

impl Work {
    fn new(path: Option<&Path>) -> Result<Self, Failure> {
        let scene = scene::load_or_default(path)?;
        let name = path.map_or("cube-twist".into(), Path::to_string_lossy);
        let folder = tempfile::tempdir().map_err(|error| unwritten(&error))?;
        let model = folder.path().join("scene.model");
        bake(&scene, &name, &model)?;
        Ok(Self { folder, model, name: format!("{name}, tier {}", scene.params.tier.name()) })
    }
}

fn run_soak(args: &Args, minutes: f64) -> Outcome {
    let work = Work::new(None)?;
    let stop = programs::note_interrupts()?;
    let allowed = cpus::allowed();
    let cpus = match (args.cpus, &allowed[..]) {
        (Some(cpus), _) => cpus,
        (None, [.., a, b]) => [*b, *a],
        _ => {
            return Err(Failure::problem(
                "--soak needs two CPUs, one for the host and one for cyclictest; this process may use one",
            ));
        }
    };
    let plan = soak::Plan {
        model: &work.model,
        work: work.folder.path(),
        device: args.device.as_deref().filter(|device| *device != "sim"),
        seconds: (60.0 * minutes) as u64,
        cpus,
        load_on: allowed.len(),
    };
    let soak = soak::soak(&plan, system::has_rights(), &stop)?;
    if let Some(path) = &args.plot {
        soak.draw(path)?;
    }
    conclude(args, &soak.table(), &soak.value(), soak.problem())
}

fn run_rates(args: &Args, scene: &Path) -> Outcome {
    let work = Work::new(Some(scene))?;
    let stop = programs::note_interrupts()?;
    let rates = rates::rates(work.name.clone(), &work.model, work.folder.path(), args.seconds, &stop)?;
    conclude(args, &rates.table(), &rates.value(), rates.problem())
}

fn run_gains(args: &Args) -> Outcome {
    let work = Work::new(None)?;
    let stop = programs::note_interrupts()?;
    let gains = gains::gains(&work.model, work.folder.path(), cpus::allowed().len(), args.seconds, &stop)?;
    conclude(args, &gains.table(), &gains.value(), None)
}

/// Prints a trial and says what is wrong with the machine.
fn conclude(args: &Args, table: &str, value: &Value, problem: Option<String>) -> Outcome {
    if args.json {
        say(format_args!("{value:#}"));
    } else {
        say(table.trim_end());
    }
    problem.map_or(Ok(()), |problem| Err(Failure::problem(problem)))
}

fn is_fail(finding: &Finding) -> bool {
    finding.mark == Mark::Fail
}

fn print(finding: &Finding) {
    say(format_args!("{:<5}{:<22}{}", finding.mark.name(), finding.what, finding.found));
    if let Some(advice) = &finding.advice {
        say(format_args!("{:27}-> {advice}", ""));
    }
}

fn json(finding: &Finding) -> Value {
    let mark = finding.mark.name().to_ascii_lowercase();
    json!({ "check": finding.what, "mark": mark, "found": finding.found, "advice": finding.advice })
}

/// Longest soak \[min\]: a week.
const MINUTES_MAX: f64 = 10_080.0;

fn minutes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.2..=MINUTES_MAX).contains(&value) => Ok(value),
        _ => Err(format!("allowed is a number of minutes, 0.2 to {MINUTES_MAX}")),
    }
}

fn two_cpus(text: &str) -> Result<[usize; 2], String> {
    let cpus = cpus::list(text);
    match cpus[..] {
        [a, b] if a != b => Ok([a, b]),
        _ => Err("allowed are the numbers of two CPUs, as in 2,3".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cpus_and_minutes_are_checked() {
        assert_eq!(two_cpus("2,3"), Ok([2, 3]));
        for bad in ["2", "2,2", "1,2,3", "a,b", ""] {
            assert!(two_cpus(bad).unwrap_err().contains("two CPUs"), "{bad}");
        }
        assert_eq!(minutes("0.5"), Ok(0.5));
        for bad in ["0", "-1", "nan", "10081"] {
            assert!(minutes(bad).unwrap_err().contains("0.2 to"), "{bad}");
        }
    }
}

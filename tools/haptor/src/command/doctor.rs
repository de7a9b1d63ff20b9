//! `haptor doctor`: is this machine good enough, and what to change.

use serde_json::json;

use crate::doctor::{self, Finding, Mark};
use crate::failure::{Failure, Outcome};
use crate::output::say;

/// Tells whether this machine is good enough for 1 kHz and what to change.
///
/// Every line is ok, warn or FAIL with what to do. The timer test runs at normal priority: what the host gets under SCHED_FIFO is
/// better. Exit 1 when something fails.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor doctor --json")]
pub struct Args {
    /// Length of the timer test [min]; two seconds when not given
    #[arg(long, value_name = "MIN", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    soak: Option<u32>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let findings = doctor::examine(args.soak);
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

fn is_fail(finding: &Finding) -> bool {
    finding.mark == Mark::Fail
}

fn print(finding: &Finding) {
    say(format_args!("{:<5}{:<20}{}", finding.mark.name(), finding.what, finding.found));
    if let Some(advice) = &finding.advice {
        say(format_args!("{:25}-> {advice}", ""));
    }
}

fn json(finding: &Finding) -> serde_json::Value {
    let mark = finding.mark.name().to_ascii_lowercase();
    json!({ "check": finding.what, "mark": mark, "found": finding.found, "advice": finding.advice })
}

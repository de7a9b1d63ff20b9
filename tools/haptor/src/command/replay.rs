//! `haptor replay`: what a recording holds, and whether the contact comes out again.

use std::path::PathBuf;

use haptor_engine::replay::{Verdict, verify};
use serde_json::{Value, json};

use crate::failure::{Failure, Outcome};
use crate::output::say;
use crate::progress;
use crate::session::describe;
use crate::session::recording::{self, Recording};

/// Shows what a recording holds; with --verify computes its contact again and compares every bit.
///
/// A recording carries its scene, so no other file is needed. With --verify: exit 0 when every tick that can be computed again comes out equal to the bit; exit 1
/// when one differs (its tick and field are named, with both values) or when there is none to compute. Damage is no difference: what is whole is verified, and what was
/// lost is said. After a damaged place ticks cannot be verified until the next `Rest` in the file, because what the core remembered there is unknown.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor replay session.haptor --verify")]
pub struct Args {
    /// The recording
    file: PathBuf,
    /// Compute every tick again and compare to the bit
    #[arg(long)]
    verify: bool,
    /// For programs: JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Bytes between two moves of the progress bar.
const PROGRESS_EVERY: usize = 1 << 18;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    if args.verify {
        return check(args);
    }
    let recording = Recording::open(&args.file)?;
    if args.json {
        say(describe::value(&recording));
    } else {
        say(describe::table(&recording).trim_end());
    }
    Ok(())
}

fn check(args: &Args) -> Outcome {
    let shown = args.file.display();
    let mut file = recording::load(&args.file)?;
    let bar = progress::bar(file.len() as u64, "computing again");
    let mut told = 0;
    let verdict = verify(&mut file, |at| {
        if at - told >= PROGRESS_EVERY {
            told = at;
            bar.set_position(at as u64);
        }
    });
    bar.finish_and_clear();
    let verdict =
        verdict.map_err(|mismatch| Failure::bad_input(format!("{shown}: a recording of another version: {mismatch}")))?;
    if args.json {
        say(value(&verdict));
    } else {
        tell(&verdict);
    }
    match refusal(&verdict) {
        Some(why) => Err(Failure::problem(format!("{shown}: {why}"))),
        None => Ok(()),
    }
}

fn tell(verdict: &Verdict) {
    let counts = &verdict.counts;
    say(format_args!(
        "verified      {} of {} ticks, equal to the bit; {} more had no pose",
        counts.verified, counts.ticks, counts.idle
    ));
    if counts.unverifiable > 0 {
        let why = why(verdict).map_or(String::new(), |why| format!(": {why}"));
        say(format_args!("not verified  {} ticks{why}", counts.unverifiable));
    }
    if let Some(first) = &verdict.first_damage {
        say(format_args!("damage        {} places, {} bytes; the first at {first}", verdict.damaged, verdict.damaged_bytes));
    }
    say(format_args!("digest        {:016x} of the contact wrenches", verdict.digest.value()));
}

/// Why ticks could not be verified.
fn why(verdict: &Verdict) -> Option<String> {
    verdict.no_scene.as_ref().map(ToString::to_string).or(verdict.unsure.map(|why| why.to_string()))
}

/// Why the recording does not pass.
fn refusal(verdict: &Verdict) -> Option<String> {
    let counts = &verdict.counts;
    if let Some(first) = verdict.first {
        return Some(format!("{first}; {} of {} ticks differ", counts.different, counts.ticks));
    }
    (counts.verified == 0).then(|| {
        let why = why(verdict).unwrap_or_else(|| "there is no tick with a pose".to_owned());
        format!("nothing in it can be verified: {why}")
    })
}

fn value(verdict: &Verdict) -> Value {
    let counts = &verdict.counts;
    let first = verdict.first.map(|first| {
        json!({ "tick": first.tick, "field": first.field, "recorded": first.recorded.to_string(), "computed": first.computed.to_string() })
    });
    json!({
        "passed": refusal(verdict).is_none(), "ticks": counts.ticks, "verified": counts.verified, "different": counts.different,
        "without_pose": counts.idle, "unverifiable": counts.unverifiable, "why": why(verdict), "first_difference": first,
        "damaged_places": verdict.damaged, "damaged_bytes": verdict.damaged_bytes,
        "digest": format!("{:016x}", verdict.digest.value()),
    })
}

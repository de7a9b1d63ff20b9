//! `haptor replay`: what a recording holds, and whether the contact comes out again.

use std::path::PathBuf;

use haptor_engine::replay::{Verdict, verify};
use serde_json::{Value, json};

use crate::failure::{Failure, Outcome};
use crate::looks::playback::Replay;
use crate::output::say;
use crate::progress;
use crate::session::describe;
use crate::session::recording::{self, Recording};
use crate::session::replay::Player;
use crate::window;

/// Shows what a recording holds; with --verify computes its contact again and compares every bit.
///
/// A recording carries its scene, so no other file is needed. With --verify: exit 0 when every tick that can be computed again comes out equal to the bit; exit 1
/// when one differs (its tick and field are named, with both values) or when there is none to compute. Damage is no difference: what is whole is verified, and what was
/// lost is said. After a damaged place ticks cannot be verified until the next `Rest` in the file, because what the core remembered there is unknown.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor replay session.haptor --verify\n\
                        In the window: haptor replay session.haptor --view")]
pub struct Args {
    /// The recording
    file: PathBuf,
    /// Compute every tick again and compare to the bit
    #[arg(long)]
    verify: bool,
    /// Show the contact at this time of the session [s], computed again: every region with its wrench
    #[arg(long, value_name = "T_S", conflicts_with = "verify")]
    at: Option<f64>,
    /// Look at it in the window: play it, hold it, wind it
    #[arg(long, conflicts_with_all = ["verify", "at", "json"])]
    view: bool,
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
    if args.view {
        return look(args);
    }
    let recording = Recording::open(&args.file)?;
    if let Some(at) = args.at {
        return show(args, recording, at);
    }
    if args.json {
        say(describe::value(&recording));
    } else {
        say(describe::table(&recording).trim_end());
    }
    Ok(())
}

/// The recording in the window.
fn look(args: &Args) -> Outcome {
    window::check()?;
    let name = args.file.display().to_string();
    let recording = Recording::open(&args.file)?;
    let bar = progress::bar(recording.ticks.len() as u64, "computing again");
    let replay = Replay::new(recording, &name, |ticks| bar.set_position(ticks as u64));
    bar.finish_and_clear();
    window::show(Box::new(replay?), &name)
}

/// The contact at a time.
fn show(args: &Args, recording: Recording, at_s: f64) -> Outcome {
    let shown = args.file.display();
    let (Some(first), Some(last)) = (recording.ticks.first(), recording.ticks.last()) else {
        return Err(Failure::bad_input(format!("{shown}: no ticks in it")));
    };
    let (from, to) = (first.t_us as f64 * 1.0e-6, last.t_us as f64 * 1.0e-6);
    if !(from..=to).contains(&at_s) {
        return Err(Failure::bad_input(format!("--at {at_s}: the recording has {from} to {to} s")));
    }
    let index = recording.ticks.partition_point(|tick| (tick.t_us as f64) < 1.0e6 * at_s);
    let bar = progress::bar(recording.ticks.len() as u64, "computing again");
    let mut player = Player::new(recording, |ticks| bar.set_position(ticks as u64));
    bar.finish_and_clear();
    let moment =
        player.at(index).ok_or_else(|| Failure::problem(format!("{shown}: there is no contact to compute at {at_s} s")))?;
    if args.json {
        say(moment.value());
    } else {
        say(moment.table().trim_end());
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

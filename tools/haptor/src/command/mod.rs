//! The commands, one per file: its arguments, what it does, its messages.

pub mod bake;
mod bench;
mod completions;
mod config;
mod demo;
mod devices;
mod doctor;
mod eval;
mod export;
mod mesh;
mod plot;
mod record;
mod replay;
mod run;
mod tell;
mod timing;
mod trade;
mod trajectory;
mod view;
mod watch;

pub use eval::HEADER as EVAL_HEADER;
pub use run::device as device_kind;

use std::ops::RangeInclusive;
use std::str::FromStr;

use crate::failure::Outcome;

/// A number within a range, or what is allowed.
fn within<T: FromStr + PartialOrd>(text: &str, range: &RangeInclusive<T>, allowed: &str) -> Result<T, String> {
    text.parse().ok().filter(|value| range.contains(value)).ok_or_else(|| format!("allowed is {allowed}"))
}

/// What the tool can do.
#[derive(Debug, clap::Subcommand)]
pub enum Command {
    Eval(eval::Args),
    Demo(demo::Args),
    Bake(bake::Args),
    Run(run::Args),
    Record(record::Args),
    Replay(replay::Args),
    Export(export::Args),
    View(view::Args),
    Tell(tell::Args),
    Timing(timing::Args),
    Plot(plot::Args),
    Trade(trade::Args),
    Trajectory(trajectory::Args),
    Mesh(mesh::Args),
    Devices(devices::Args),
    Doctor(doctor::Args),
    Bench(bench::Args),
    Config(config::Args),
    Completions(completions::Args),
}

/// Runs one command.
pub fn run(command: Command) -> Outcome {
    match command {
        Command::Eval(args) => eval::run(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Bake(args) => bake::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Record(args) => record::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Export(args) => export::run(&args),
        Command::View(args) => view::run(&args),
        Command::Tell(args) => tell::run(&args),
        Command::Timing(args) => timing::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Trade(args) => trade::run(&args),
        Command::Trajectory(args) => trajectory::run(&args),
        Command::Mesh(args) => mesh::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Config(args) => config::run(&args),
        Command::Completions(args) => completions::run(&args),
    }
}

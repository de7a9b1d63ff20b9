//! `haptor-host`: arguments in, exit code out.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use haptor_host::config::{Args, Config};
use haptor_host::error::HostError;
use haptor_host::session::{self, Outcome};

/// A fault, or a device or machine that does not do.
const EXIT_PROBLEM: u8 = 1;

/// Bad usage or bad input; clap exits with the same.
const EXIT_BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    match Config::new(Args::parse()).and_then(|config| session::run(&config)) {
        Ok(outcome) => report(&outcome),
        Err(error) => refuse(&error),
    }
}

fn report(outcome: &Outcome) -> ExitCode {
    if let Some(mismatch) = &outcome.mismatch {
        say(format_args!("device refused: {mismatch}"));
    }
    if let Some(error) = &outcome.written.error {
        say(format_args!("{error}; {} records not written", outcome.written.unwritten));
    }
    if outcome.written.dumps_left_out > 0 {
        say(format_args!(
            "{} black boxes not written: too many faults, too soon one after another, or no file named with --blackbox",
            outcome.written.dumps_left_out
        ));
    }
    if outcome.is_good() { ExitCode::SUCCESS } else { ExitCode::from(EXIT_PROBLEM) }
}

fn refuse(error: &HostError) -> ExitCode {
    say(format_args!("{error}"));
    ExitCode::from(if error.is_bad_input() { EXIT_BAD_INPUT } else { EXIT_PROBLEM })
}

/// Tells whoever is left to hear it.
fn say(what: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "haptor-host: {what}");
}

//! `haptor-measure`: arguments in, exit code out.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use haptor_host::measure::{self, Args};

/// Bad usage or bad input; clap exits with the same.
const EXIT_BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    match measure::run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // nobody may be left to hear it
            let _ = writeln!(std::io::stderr(), "haptor-measure: {error}");
            if error.is_bad_input() { ExitCode::from(EXIT_BAD_INPUT) } else { ExitCode::FAILURE }
        }
    }
}

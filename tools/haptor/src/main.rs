//! `haptor`: the front door of the project. One command per file in [`command`]; each says what it did, on standard error how
//! far it is, and ends with 0 (good), 1 (found a problem) or 2 (bad input, nothing written).
//!
//! The tool never runs a real-time loop: `demo` and `run` start the programs `haptor-firmware-sim` and `haptor-host` that lie
//! beside it and talk to them over the tool link (`haptor_wire::status`); `timing` has ticks run by `haptor-measure` in the same way.

#![allow(rustdoc::broken_intra_doc_links, rustdoc::invalid_html_tags, reason = "help texts carry units and choices in brackets")]
#![forbid(unsafe_code)]

mod bench;
mod client;
mod command;
mod config;
mod doctor;
mod failure;
mod looks;
mod motion;
mod output;
mod plot;
mod programs;
mod progress;
mod scene;
mod session;
mod simulation;
mod skins;
mod surface;
mod table;
mod text;
mod timing;
mod trajectory;
mod trial;
mod usb;
mod window;

use std::process::ExitCode;

use clap::Parser;

/// What a hand feels when a rigid body presses, slides and twists on an elastic one.
#[derive(Debug, Parser)]
#[command(name = "haptor", version, arg_required_else_help = true)]
#[command(after_help = "Exit codes: 0 good, 1 a problem was found, 2 bad usage or bad input (nothing was written).\n\
                        Example: haptor demo --seconds 5")]
struct Cli {
    #[command(subcommand)]
    command: command::Command,
}

fn main() -> ExitCode {
    match command::run(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {:#}", failure.error());
            ExitCode::from(failure.exit_code())
        }
    }
}

//! Developer commands, one per file: what a laptop runs is what the server runs.
#![allow(rustdoc::broken_intra_doc_links, rustdoc::invalid_html_tags, reason = "help texts carry units and choices in brackets")]
#![forbid(unsafe_code)]

mod arithmetic;
mod bits;
mod calls;
mod ci;
#[path = "../../../tests/support/counts.rs"]
mod counting;
mod counts;
mod demo;
mod docs;
mod extremes;
mod fuzz;
mod golden;
#[path = "../../../tests/support/growth.rs"]
mod growth;
mod guest;
mod m7;
mod m7_counts;
mod m7_device;
mod m7_image;
mod m7_memory;
mod peers;
mod pictures;
mod real_time_loop;
mod recordings;
mod run;
#[path = "../../../tests/support/golden.rs"]
mod scenes;
mod timing;
mod trade;
#[path = "../../../tests/support/worst.rs"]
mod worst;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

/// Developer commands of haptor.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", arg_required_else_help = true, after_help = "Example: cargo xtask demo --seconds 5")]
enum Cli {
    /// Builds the three programs in release and runs `haptor demo` with the arguments that follow
    #[command(after_help = "Example: cargo xtask demo --seconds 5 -o my-demo")]
    Demo {
        /// Arguments of `haptor demo`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<String>,
    },
    /// Format, lints with warnings denied, tests, API documentation, documents
    #[command(after_help = "Example: cargo xtask ci")]
    Ci,
    /// Builds core, wire and engine for a Cortex-M7 without an operating system, looks for an allocator, runs a session, a recording and the simulated device on an
    /// emulated one, compares the bits with those of a debug and a release build, and instructions, stack and sizes with the kept tables
    #[command(
        after_help = "Example: cargo xtask m7\n         cargo xtask m7 device --rate 250\n         cargo xtask m7 costs --accept"
    )]
    M7 {
        #[command(subcommand)]
        only: Option<M7>,
    },
    /// Computes recordings again in a debug build, a release and one for this very processor, compares the digest of every tick, and looks for fused multiply-adds and
    /// the platform's mathematics in the image
    #[command(after_help = "Example: cargo xtask bits")]
    Bits,
    /// Counts the instructions of a tick, scene by scene, and writes tests/bench/COUNTS.md
    #[command(after_help = "Example: cargo xtask counts")]
    Counts,
    /// Searches the dearest ticks of the ready scenes, times them, and writes tests/bench/TIMING.md, WORST.md and the inputs
    #[command(after_help = "Example: cargo xtask timing --kept")]
    Timing(timing::Args),
    /// Feeds what reads bytes from outside with bytes nobody would send, by libFuzzer
    #[command(
        after_help = "Example: cargo xtask fuzz --seconds 60\n         cargo xtask fuzz mesh_ply --seconds 3600 --keep\n         cargo xtask fuzz mesh_ply --input crash-1f"
    )]
    Fuzz(fuzz::Args),
    /// Runs host and simulated device over USB on a real-time kernel in an emulator; with the drills, unplugs, halts and damages
    #[command(after_help = "Example: cargo xtask guest --drills --seconds 3\n         cargo xtask guest --latency --seconds 20")]
    Guest {
        /// Length of the first session, in the guest's time
        #[arg(long, default_value_t = 60.0, value_name = "S")]
        seconds: f64,
        /// Run the drills as well
        #[arg(long, conflicts_with = "latency")]
        drills: bool,
        /// In place of sessions, run the host's loop beside cyclictest and trace its system calls
        #[arg(long)]
        latency: bool,
        /// Keep the tables in tests/guest/DRILLS.md or LATENCY.md
        #[arg(long)]
        accept: bool,
    },
    /// Walks the ends of the ranges, runs random cases against the laws, and writes EXTREMES.md with its map
    #[command(after_help = "Example: cargo xtask extremes --steps 100000000 --accept")]
    Extremes(extremes::Args),
    /// Measures the loop on this machine: beside cyclictest, at rates up to 8 kHz, with rights left out; tests/bench/LOOP.md
    #[command(after_help = "Example: cargo xtask loop --minutes 10 --seconds 30 --accept")]
    Loop(real_time_loop::Args),
    /// Compares the curves of the ready scenes in every tier with those that are kept
    #[command(after_help = "Example: cargo xtask golden --accept")]
    Golden {
        /// Keep the present curves from now on
        #[arg(long)]
        accept: bool,
    },
    /// Runs the comparison with other programs (Python's packages in the target folder, some minutes) and writes tests/bench/PEERS.md
    #[command(after_help = "Example: cargo xtask peers --seconds 0.05 --rounds 1")]
    Peers {
        /// Times that every program runs, in turn
        #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
        rounds: u32,
        /// Time for each case in each round
        #[arg(long, default_value_t = 0.3, value_name = "S")]
        seconds: f64,
        /// Only write the table, from the lines of the last run
        #[arg(long)]
        table: bool,
    },
    /// Draws the pictures of the ready scenes anew: moments, force and torque over time
    #[command(after_help = "Example: cargo xtask pictures")]
    Pictures,
    /// Measures speed against accuracy on the ready scenes and writes tests/bench/TRADE.md, its pictures and trade.json
    #[command(after_help = "Example: cargo xtask trade\n         cargo xtask trade --errors")]
    Trade {
        /// Ticks to time for each setting in place of 50000
        #[arg(long, value_name = "N")]
        ticks: Option<usize>,
        /// A first look: fewer settings, one rate, a coarser reference
        #[arg(long)]
        quick: bool,
        /// Only trade.json, errors and instructions of a first look, which the tests watch
        #[arg(long)]
        errors: bool,
    },
    /// Checks that the documents tell the truth
    #[command(after_help = "Example: cargo xtask docs --check\n         cargo xtask docs --run README.md")]
    Docs {
        /// Commands and options exist, pictures are there, links lead somewhere
        #[arg(long, required_unless_present = "run", conflicts_with = "run")]
        check: bool,
        /// Run the shell examples with released programs, each document in a folder of its own
        #[arg(long)]
        run: bool,
        /// Documents to run; all when none is named
        #[arg(requires = "run")]
        documents: Vec<PathBuf>,
    },
}

/// A part alone.
#[derive(Debug, clap::Subcommand)]
enum M7 {
    /// The simulated device as firmware, and a session of the real host on it
    Device(m7_device::Args),
    /// What a tick costs: compares instructions, stack and sizes with tests/bench/COUNTS-M7.md and MEMORY.md
    Costs {
        /// Keep the present ones from now on
        #[arg(long)]
        accept: bool,
    },
}

fn main() -> ExitCode {
    let done = match Cli::parse() {
        Cli::Demo { args } => demo::run(&args),
        Cli::Ci => ci::run(),
        Cli::M7 { only: None } => m7::run(),
        Cli::M7 { only: Some(M7::Device(args)) } => m7::device(&args),
        Cli::M7 { only: Some(M7::Costs { accept }) } => m7::costs(accept),
        Cli::Bits => bits::run(),
        Cli::Counts => counts::run(),
        Cli::Timing(args) => timing::run(&args),
        Cli::Fuzz(args) => fuzz::run(&args),
        Cli::Guest { seconds, latency: true, accept, .. } => guest::run(seconds, guest::What::Latency, accept),
        Cli::Guest { seconds, drills: true, accept, .. } => guest::run(seconds, guest::What::Drills, accept),
        Cli::Guest { seconds, accept, .. } => guest::run(seconds, guest::What::Sessions, accept),
        Cli::Extremes(args) => extremes::run(&args),
        Cli::Loop(args) => real_time_loop::run(&args),
        Cli::Golden { accept } => golden::run(accept),
        Cli::Peers { rounds, seconds, table } => peers::run(rounds, seconds, table),
        Cli::Pictures => pictures::run(),
        Cli::Trade { ticks, quick, errors } => trade::run(ticks, quick, errors),
        Cli::Docs { run: true, documents, .. } => docs::run_examples(&documents),
        Cli::Docs { .. } => docs::check(),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

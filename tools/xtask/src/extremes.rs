//! `cargo xtask extremes`: the ends of the ranges and random corners of the box, in release, as `tests/bench/EXTREMES.md` with its map and tables.

use std::process::ExitCode;

use anyhow::{Context, Result};

use crate::run::{self, cargo, program, root, target};

/// Arguments.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Ticks of random cases; the five hundred million along the axes come beside them
    #[arg(long, default_value_t = 1_000_000, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000_000))]
    steps: u64,
    /// Seed of the cases
    #[arg(long, default_value_t = 1, value_name = "S")]
    seed: u64,
    /// Keep what was found in tests/bench
    #[arg(long)]
    accept: bool,
}

/// Builds the program, runs it, and keeps its results in `tests/bench` or leaves them in the folder of the build.
pub fn run(args: &Args) -> Result<ExitCode> {
    let target = target()?;
    run::run(
        cargo().args(["build", "--quiet", "--release", "-p", "haptor-tests", "--bin", "extremes", "--target-dir"]).arg(&target),
    )?;
    let folder = if args.accept { root().join("tests/bench") } else { target.join("extremes") };
    std::fs::create_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
    let status = program(&target.join("release/extremes"))
        .args(["--steps", &args.steps.to_string(), "--seed", &args.seed.to_string(), "--machine", &run::machine(), "-o"])
        .arg(&folder)
        .status()
        .context("the program cannot be started")?;
    if !status.success() {
        // the program has said why
        return Ok(ExitCode::FAILURE);
    }
    println!("{} written", folder.join("EXTREMES.md").display());
    Ok(ExitCode::SUCCESS)
}

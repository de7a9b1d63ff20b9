//! `cargo xtask peers`: the comparison with other programs, from their installation to `tests/bench/PEERS.md`.
//!
//! Python's packages go into a virtual environment in cargo's target folder, in the versions that `requirements.txt` says; nothing else is installed.

use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};

use crate::run::{self, cargo, root, target};

/// Where everything lies.
const FOLDER: &str = "tests/bench/peers";

/// Runs every program, or writes the table from the lines that a run has left.
pub fn run(rounds: u32, seconds: f64, table_only: bool) -> Result<ExitCode> {
    let target = target()?;
    let programs = target.join("release");
    run::run(cargo().args(["build", "--quiet", "--release", "-p", "haptor-peers", "--target-dir"]).arg(&target))?;
    if !table_only {
        let haptor = run::release_tool()?;
        let python = target.join("peers-python");
        install(&python)?;
        let mut compare = Command::new(python.join("bin/python"));
        compare.current_dir(root()).arg(format!("{FOLDER}/run.py"));
        compare.arg("--haptor").arg(haptor).arg("--parry").arg(programs.join("parry-peer"));
        // what Python compiles stays out of the sources
        compare.env("PYTHONPYCACHEPREFIX", python.join("compiled")).env("NUMBA_CACHE_DIR", python.join("compiled"));
        run::run(compare.args(["--rounds", &rounds.to_string(), "--seconds", &seconds.to_string()]))?;
    }
    write(&programs.join("peers-table"))
}

/// Makes the virtual environment, if it is not there, and brings its packages to the versions asked for.
fn install(python: &Path) -> Result<()> {
    if !python.join("bin/python").is_file() {
        run::run(Command::new("python3").args(["-m", "venv"]).arg(python))
            .context("Python 3.11 or later with its module venv is needed")?;
    }
    let requirements = root().join(FOLDER).join("requirements.txt");
    run::run(Command::new(python.join("bin/python")).args(["-m", "pip", "install", "--quiet", "-r"]).arg(requirements))
}

fn write(program: &Path) -> Result<ExitCode> {
    let lines = root().join(FOLDER).join("results.jsonl");
    let table = Command::new(program).arg(&lines).output().with_context(|| format!("{}", program.display()))?;
    anyhow::ensure!(table.status.success(), "{}: {}", lines.display(), String::from_utf8_lossy(&table.stderr).trim());
    let file = root().join("tests/bench/PEERS.md");
    fs::write(&file, table.stdout).with_context(|| format!("{}", file.display()))?;
    println!("{} written", file.display());
    Ok(ExitCode::SUCCESS)
}

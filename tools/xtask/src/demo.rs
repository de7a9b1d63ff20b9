//! `cargo xtask demo`: `cargo run` builds only the program that it runs, the demonstration starts three.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};

use crate::run::{self, cargo, target};

/// Builds the three programs in release and yields the folder in which they lie.
///
/// # Errors
/// When they do not build.
pub fn build() -> Result<PathBuf> {
    build_with(&[])
}

/// As [`build`], with more arguments for cargo.
fn build_with(more: &[&str]) -> Result<PathBuf> {
    let target = target()?;
    run::run(
        cargo()
            .args(["build", "--release", "-p", "haptor", "-p", "haptor-host", "-p", "haptor-firmware-sim", "--target-dir"])
            .arg(&target)
            .args(more),
    )?;
    Ok(target.join("release"))
}

/// Builds the three programs in release and runs the demonstration, whose exit code this passes on.
pub fn run(args: &[String]) -> Result<ExitCode> {
    // the window takes minutes to build: only for who looks through it
    let more: &[&str] = if args.iter().any(|arg| arg == "--view") { &["--features", "haptor/window"] } else { &[] };
    let haptor = build_with(more)?.join("haptor");
    let status = Command::new(&haptor).arg("demo").args(args).status();
    let status = status.with_context(|| format!("{} cannot be started", haptor.display()))?;
    // 255 for an end by a signal, which has no code
    Ok(ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(255)))
}

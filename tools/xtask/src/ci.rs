//! `cargo xtask ci`: every gate that needs nothing but Rust and a C compiler, cheapest first.

use std::process::ExitCode;

use anyhow::Result;

use crate::docs;
use crate::run::{self, cargo};

/// Runs the gates; the first that fails ends it.
pub fn run() -> Result<ExitCode> {
    run::run(cargo().args(["fmt", "--all", "--", "--check"]))?;
    run::run(cargo().args(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    docs::check()?;
    run::run(cargo().args(["test", "--workspace"]))?;
    run::run(cargo().args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))?;
    Ok(ExitCode::SUCCESS)
}

//! `cargo xtask docs`: do the documents still tell the truth? What can be known without running anything is checked ([`mod@check`]); the
//! shell examples are run ([`examples`]).

mod check;
mod examples;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};

pub use check::check;
pub use examples::run as run_examples;

use crate::run::{ask, root};

/// Every Markdown file of the repository.
fn documents() -> Result<Vec<PathBuf>> {
    let listed = ask("git", &["ls-files", "--cached", "--others", "--exclude-standard", "*.md"]);
    let listed = listed.context("git cannot list the documents")?;
    let paths: Vec<_> = listed.lines().map(|line| root().join(line)).filter(|path| path.is_file()).collect();
    if paths.is_empty() { bail!("there are no documents") } else { Ok(paths) }
}

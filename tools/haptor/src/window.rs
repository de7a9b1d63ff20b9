//! The window, where this build has one.

use std::process::Command;

use anyhow::Context;
use haptor_viewer::feed::Source;

use crate::failure::{Failure, Outcome};
use crate::programs::Child;

/// What builds without a window say.
#[cfg(not(feature = "window"))]
const NO_WINDOW: &str = "this build has no window: `cargo build --release -p haptor --features window` builds one (some minutes), and \
                         `haptor view --shot FILE.png` draws pictures without";

/// Fails at once in a build without a window, before anything is computed for it.
///
/// # Errors
/// [`Failure::BadInput`] with the command that builds one.
pub fn check() -> Outcome {
    #[cfg(not(feature = "window"))]
    return Err(Failure::bad_input(NO_WINDOW));
    #[cfg(feature = "window")]
    Ok(())
}

/// Starts a window called `title` on the host at `address`, in a program of its own: what happens to it does not touch the session. It closes when dropped.
///
/// # Errors
/// As [`check`], or when the program cannot be started.
pub fn beside(address: &str, title: &str) -> Result<Child, Failure> {
    check()?;
    let this = std::env::current_exe().context("the path of this program is unknown")?;
    Ok(Child::attached(Command::new(this).args(["view", address, "--title", title, "--wait", PATIENCE_S]))?)
}

/// How long the window waits for a host that has just been started \[s\].
const PATIENCE_S: &str = "10";

/// Shows a source in a window called `title`, until it is closed.
///
/// # Errors
/// [`Failure::Problem`] when there is no display to open it on.
#[cfg(feature = "window")]
pub fn show(source: Box<dyn Source>, title: &str) -> Outcome {
    let options = haptor_viewer::window::Options { title: format!("haptor - {title}"), ..Default::default() };
    haptor_viewer::window::open(source, &options).map_err(Failure::problem)
}

/// See [`check`].
#[cfg(not(feature = "window"))]
pub fn show(_source: Box<dyn Source>, _title: &str) -> Outcome {
    check()
}

//! The window, where this build has one.

use haptor_viewer::feed::Source;

use crate::failure::{Failure, Outcome};

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
#[expect(clippy::needless_pass_by_value, reason = "as the window takes it")]
pub fn show(_source: Box<dyn Source>, _title: &str) -> Outcome {
    check()
}

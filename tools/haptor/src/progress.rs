//! A bar on standard error for work that takes a while; nothing when standard error is no terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `total` steps of what `doing` says, e.g. `evaluating`.
pub fn bar(total: u64, doing: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix} [{bar:32}] {percent:>3} % {msg}");
    let bar = ProgressBar::new(total).with_prefix(doing);
    match style {
        Ok(style) => bar.with_style(style.progress_chars("=> ")),
        Err(_) => bar,
    }
}

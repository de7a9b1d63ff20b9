//! One target run for a while: what it reached, and what it found.

use std::fmt;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::Folders;

/// A target that has run.
#[derive(Debug)]
pub struct Session {
    /// Its name.
    pub name: String,
    /// Time it was given \[s\].
    seconds: u32,
    said: Said,
    /// What it found.
    pub found: Option<Found>,
}

/// What libFuzzer says of a run.
#[derive(Debug, Default, PartialEq, Eq)]
struct Said {
    /// Inputs tried.
    tried: u64,
    /// Edges of the code reached.
    edges: u64,
    /// Inputs that reach them.
    inputs: u64,
}

/// An input that should not have done what it did.
#[derive(Debug)]
pub struct Found {
    name: String,
    what: String,
    input: PathBuf,
    log: PathBuf,
}

impl fmt::Display for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Said { tried, edges, inputs } = self.said;
        write!(f, "| {} | {} | {tried} | {edges} | {inputs} |", self.name, self.seconds)
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, what, input, log } = self;
        let (input, log) = (input.display(), log.display());
        writeln!(f, "{name}: {what}")?;
        writeln!(f, "  all it said: {log}")?;
        writeln!(f, "  again: cargo xtask fuzz {name} --input {input}")?;
        write!(
            f,
            "  once mended: keep the input as tests/fuzz/cases/{name}/WHAT-IT-IS, and `cargo test -p haptor-tests --test it fuzz_cases` runs it"
        )
    }
}

/// Runs a target for so long, from the inputs found before, those that are kept, and the good ones.
///
/// # Errors
/// When it cannot be started, or its folders not be made.
pub fn run(folders: &Folders, name: &str, seconds: u32) -> Result<Session> {
    let (found, log) = (folders.found(name), folders.work.join(format!("{name}.log")));
    let bad = folders.work.join("bad").join(name);
    for folder in [&found, &bad] {
        fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    }
    let file = File::create(&log).with_context(|| format!("{} cannot be written", log.display()))?;
    let mut command = folders.program(name, &found);
    command.arg(folders.work.join("seeds").join(name)).args(kept_inputs(name));
    command.arg(format!("-max_total_time={seconds}")).args(["-print_final_stats=1"]);
    command.arg(format!("-artifact_prefix={}/", bad.display())).stdout(file.try_clone()?).stderr(file);
    let status = command.status().with_context(|| format!("target {name} cannot be started"))?;
    let text = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
    let found = (!status.success()).then(|| Found {
        name: name.to_owned(),
        what: what(&text).unwrap_or_else(|| format!("it ended with {status}")),
        input: written(&text, &bad).unwrap_or(bad),
        log,
    });
    Ok(Session { name: name.to_owned(), seconds, said: said(&text), found })
}

/// Folders of inputs that are kept: a target may have none of a kind.
fn kept_inputs(name: &str) -> impl Iterator<Item = PathBuf> {
    [Folders::kept(name), Folders::cases(name)].into_iter().filter(|folder| folder.is_dir())
}

/// What went wrong, in one line.
fn what(text: &str) -> Option<String> {
    let panicked = text.lines().skip_while(|line| !line.contains("panicked at")).take(2).collect::<Vec<_>>().join(" ");
    let summary = || text.lines().find(|line| line.starts_with("SUMMARY:")).map(str::to_owned);
    if panicked.is_empty() { summary() } else { Some(panicked) }
}

/// The file that the input was written to.
fn written(text: &str, bad: &Path) -> Option<PathBuf> {
    let line = text.lines().find_map(|line| line.split_once("Test unit written to "))?.1;
    Some(bad.join(Path::new(line.trim()).file_name()?))
}

/// Figures of the last line that has them, and of those at the end.
fn said(text: &str) -> Said {
    let after = |line: &str, mark: &str| {
        let digits = line.split_once(mark)?.1.trim_start();
        digits.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
    };
    let last = text.lines().rfind(|line| line.starts_with('#') && line.contains(" cov: ")).unwrap_or_default();
    Said {
        tried: text.lines().find_map(|line| after(line, "stat::number_of_executed_units:")).unwrap_or_default(),
        edges: after(last, " cov: ").unwrap_or_default(),
        inputs: after(last, " corp: ").unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "#2\tINITED cov: 5 ft: 7 corp: 1/1b exec/s: 0 rss: 40Mb\n\
        thread '<unnamed>' (1) panicked at src/targets/x.rs:15:13:\nindex out of bounds\nstack backtrace:\n\
        #1249\tNEW    cov: 3436 ft: 9869 corp: 494/591Kb lim: 2845 exec/s: 393\n    #0 0x5641 in start\n\
        SUMMARY: libFuzzer: deadly signal\nartifact_prefix='bad/x/'; Test unit written to bad/x/crash-a2e7\n\
        stat::number_of_executed_units: 1249\n";

    #[test]
    fn what_libfuzzer_says_is_understood() {
        assert_eq!(said(TEXT), Said { tried: 1249, edges: 3436, inputs: 494 });
        assert_eq!(what(TEXT).unwrap(), "thread '<unnamed>' (1) panicked at src/targets/x.rs:15:13: index out of bounds");
        assert_eq!(written(TEXT, Path::new("/w/bad/x")), Some(PathBuf::from("/w/bad/x/crash-a2e7")));
        assert_eq!(what("SUMMARY: libFuzzer: timeout\n").unwrap(), "SUMMARY: libFuzzer: timeout");
        assert_eq!((said(""), what(""), written("", Path::new("bad"))), (Said::default(), None, None));
    }
}

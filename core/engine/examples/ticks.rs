//! Computes recordings again and prints the digest after every tick, so that two builds can be held against each other: `ticks FILE...`.
//!
//! A line a tick: the file's name, the tick's number, the digest of all contact wrenches so far. It ends badly when a tick cannot be computed again, or differs from its
//! record in any bit that the core has to do with.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use haptor_engine::replay::Verifier;
use haptor_wire::{Record, RecordReader};

fn main() -> ExitCode {
    for file in std::env::args_os().skip(1).map(PathBuf::from) {
        match ticks(&file) {
            Ok(lines) => print!("{lines}"),
            Err(why) => {
                eprintln!("{}: {why}", file.display());
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

/// The lines of a recording.
fn ticks(path: &Path) -> Result<String, String> {
    let mut file = std::fs::read(path).map_err(|error| error.to_string())?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let (mut verifier, mut lines) = (Verifier::default(), String::new());
    for record in RecordReader::new(&mut file) {
        verifier.take(&record).map_err(|error| error.to_string())?;
        if let Ok(Record::Tick(tick)) = record {
            let digest = verifier.so_far().digest.value();
            writeln!(lines, "{name} {} {digest:016x}", tick.tick).map_err(|error| error.to_string())?;
        }
    }
    let verdict = verifier.verdict();
    match verdict.first {
        Some(difference) => Err(difference.to_string()),
        None if verdict.counts.verified == 0 || verdict.counts.verified != verdict.counts.ticks => Err(format!("{verdict:?}")),
        None => Ok(lines),
    }
}

//! `haptor export`: a recording for other programs.

use std::io;
use std::path::PathBuf;

use ::mcap::McapError;
use clap::ValueEnum;

use crate::failure::Outcome;
use crate::output::{Output, unwritten};
use crate::progress;
use crate::session::recording::Recording;
use crate::session::{mcap, table};

/// Writes a recording for other programs: CSV for spreadsheets and scripts, MCAP for Foxglove and PlotJuggler.
///
/// CSV has the columns of wrench.csv of `haptor demo`, then the handle's pose in the device's frame and what happened before the tick. MCAP is the container that
/// robotics tools share: indexed, described by itself, with readers in C++, Python, Go, Rust and TypeScript; it is chosen because two field tools open it as it is. Its
/// messages are JSON: /tick (haptor.Tick), /handle (foxglove.PoseInFrame), /tf (foxglove.FrameTransform) and /log (foxglove.Log). What is damaged in the recording is
/// left out and said.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor export session.haptor --to mcap -o session.mcap\n\
                        For a spreadsheet: haptor export session.haptor --to csv -o session.csv")]
pub struct Args {
    /// The recording
    file: PathBuf,
    /// Format
    #[arg(long, value_enum)]
    to: Format,
    /// File to write; standard output when not given
    #[arg(short, value_name = "OUT")]
    output: Option<PathBuf>,
}

/// `--to`.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// One row a tick
    Csv,
    /// For Foxglove and PlotJuggler
    Mcap,
}

/// Ticks between two moves of the progress bar.
const PROGRESS_EVERY: usize = 4096;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let recording = Recording::open(&args.file)?;
    let mut output = Output::create(args.output.as_deref())?;
    let bar = progress::bar(recording.ticks.len() as u64, "exporting");
    let at = |index: usize| {
        if index.is_multiple_of(PROGRESS_EVERY) {
            bar.set_position(index as u64);
        }
    };
    let written = match args.to {
        Format::Csv => table::write_recording(&recording, &mut output, at),
        Format::Mcap => mcap::write(&recording, &mut output, at).map_err(reason),
    };
    bar.finish_and_clear();
    match written {
        // a reader of standard output that has left is no failure
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
        written => written.map_err(|error| unwritten(&error))?,
    }
    output.finish()?;
    if recording.damaged > 0 {
        eprintln!("{}: {} damaged places were left out; the rest is written", args.file.display(), recording.damaged);
    }
    Ok(())
}

fn reason(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

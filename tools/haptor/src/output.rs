//! Where a command writes: standard output, or a file that appears complete or not at all.
//!
//! A file is written beside its target under a temporary name and renamed when it is whole; a failure on the way leaves whatever
//! was there before. A target that is no regular file (a pipe, a terminal, `/dev/null`) is written in place.

use std::fmt::Display;
use std::fs::{self, OpenOptions, Permissions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::{Failure, Outcome};

/// Permissions asked for a new file; the user's mask is taken off.
const MODE: u32 = 0o666;

/// Something to write to.
pub struct Output {
    writer: Box<dyn Write>,
    replace: Option<(NamedTempFile, PathBuf)>,
}

impl Output {
    /// Standard output for `None`, else the file.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when nothing can be written there.
    pub fn create(path: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = path else {
            return Ok(Self { writer: Box::new(BufWriter::new(io::stdout().lock())), replace: None });
        };
        Self::open(path).map_err(|error| Failure::bad_input(format!("{}: cannot be written: {error}", path.display())))
    }

    /// Whether something could be written there: asked before what takes long.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn check(path: Option<&Path>) -> Outcome {
        Self::create(path).map(drop)
    }

    fn open(path: &Path) -> io::Result<Self> {
        if fs::metadata(path).is_ok_and(|info| !info.is_file() && !info.is_dir()) {
            let file = OpenOptions::new().write(true).open(path)?;
            return Ok(Self { writer: Box::new(BufWriter::new(file)), replace: None });
        }
        // through a symbolic link to what it names: the link stays
        let target = fs::canonicalize(path).unwrap_or(path.to_owned());
        if target.is_dir() {
            return Err(io::Error::new(ErrorKind::IsADirectory, "it is a directory"));
        }
        let folder = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            return Err(io::Error::new(ErrorKind::NotFound, format!("there is no folder {}", folder.display())));
        }
        let temporary =
            tempfile::Builder::new().prefix(".haptor-").permissions(Permissions::from_mode(MODE)).tempfile_in(folder)?;
        let writer = BufWriter::new(temporary.reopen()?);
        Ok(Self { writer: Box::new(writer), replace: Some((temporary, target)) })
    }

    /// Everything is written: makes the file appear. A reader of standard output that has left is no failure.
    ///
    /// # Errors
    /// [`Failure::Problem`] when the last bytes or the name could not be written.
    pub fn finish(mut self) -> Outcome {
        match self.writer.flush() {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => return Err(unwritten(&error)),
            _ => {}
        }
        let Some((temporary, target)) = self.replace else { return Ok(()) };
        temporary.persist(&target).map(drop).map_err(|error| unwritten(&error.error))
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Writes a whole file so that it appears complete or not at all.
///
/// # Errors
/// As [`Output::create`] and [`Output::finish`].
pub fn write_file(path: &Path, bytes: &[u8]) -> Outcome {
    let mut output = Output::create(Some(path))?;
    output.write_all(bytes).map_err(|error| unwritten(&error))?;
    output.finish()
}

/// Prints a line on standard output; a reader that has left is no failure.
pub fn say(line: impl Display) {
    let _ = writeln!(io::stdout(), "{line}");
}

/// The failure of a write that began well.
pub fn unwritten(error: &io::Error) -> Failure {
    Failure::problem(format!("the output could not be written: {error}; is the disk full?"))
}

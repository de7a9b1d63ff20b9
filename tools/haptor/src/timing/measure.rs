//! The program that runs ticks, `haptor-measure`: under callgrind, under the real-time policy, or for the fastest of some rounds.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;
use tempfile::TempDir;

use super::callgrind::{self, Job, VALGRIND};
use super::stages::{ByStage, Names, by_stage};
use crate::failure::Failure;
use crate::output::unwritten;
use crate::programs::{self, Child};

/// The program beside this one.
const PROGRAM: &str = "haptor-measure";

/// Its marked functions: ticks, then the surface where it is asked for.
const MARKED: [&str; 2] = ["haptor_host::measure::run::measured_tick", "haptor_host::measure::surface::measured_surface"];

/// Rounds of which the fastest counts: with five a neighbour on the machine has to come back at the same tick every time.
const ROUNDS: &str = "5";

/// What a timed run said.
#[derive(Clone, Debug, Deserialize)]
pub struct Timed {
    /// Ticks.
    pub ticks: u64,
    /// What looking at the clock takes, within every time \[ns\].
    pub clock_ns: u64,
    /// How often the thread was put aside.
    pub preempted: u64,
    /// It ran under `SCHED_FIFO`.
    pub fifo: bool,
    /// Its memory was locked.
    pub locked: bool,
    /// It had one CPU.
    pub pinned: bool,
    /// Half of the ticks took no longer \[ns\].
    pub p50: u64,
    /// 99 in 100 \[ns\].
    pub p99: u64,
    /// 999 in 1,000 \[ns\].
    pub p999: u64,
    /// 9,999 in 10,000 \[ns\].
    pub p9999: u64,
    /// Longest \[ns\].
    pub max: u64,
    /// Upper edges \[ns\] and counts.
    pub bins: Vec<(u64, u64)>,
}

/// How a timed run is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Timing<'a> {
    /// Ticks.
    pub ticks: u64,
    /// `enforce` or `ignore`.
    pub rt: &'a str,
    /// CPU.
    pub cpu: Option<usize>,
    /// Longest run \[s\].
    pub seconds: Option<u32>,
}

/// The program, a folder for its files, and the counter.
#[derive(Debug)]
pub struct Measure {
    program: PathBuf,
    folder: TempDir,
    counter: Option<String>,
}

impl Measure {
    /// Finds the program, and valgrind where there is one.
    ///
    /// # Errors
    /// [`Failure::Problem`] when the program is missing.
    pub fn find() -> Result<Self, Failure> {
        let folder = tempfile::tempdir().map_err(|error| unwritten(&error))?;
        Ok(Self { program: programs::find(PROGRAM)?, folder, counter: callgrind::version() })
    }

    /// Name and version of what counts instructions; `None` when nothing does.
    pub fn counter(&self) -> Option<&str> {
        self.counter.as_deref()
    }

    /// Cost of each tick of a recording: instructions, or nanoseconds where nothing counts them. `slot` keeps runs at the same time apart.
    ///
    /// # Errors
    /// [`Failure::Problem`] with what the program said.
    pub fn costs(&self, recording: &[u8], slot: usize) -> Result<Vec<u64>, Failure> {
        if self.counter.is_none() {
            return self.fastest(recording, slot);
        }
        let place = self.place(recording, slot)?;
        place.ticks(&self.program, false, |dump| callgrind::total(dump).unwrap_or(0))
    }

    /// Instructions of an update of the surface, so many points of it, after the last tick of a recording; `None` where nothing counts them.
    ///
    /// # Errors
    /// As [`Self::costs`].
    pub fn surface(&self, recording: &[u8], points: u16) -> Result<Option<u64>, Failure> {
        if self.counter.is_none() {
            return Ok(None);
        }
        let place = self.place(recording, 0)?;
        let points = points.to_string();
        place.counted(&self.program, false, &["--surface", &points], |job, ticks| Ok(callgrind::total(&job.dump(ticks)?)))
    }

    /// Instructions of each tick by stage, and what is in none; nothing where nothing counts them.
    ///
    /// # Errors
    /// As [`Self::costs`].
    pub fn by_stage(&self, recording: &[u8]) -> Result<Vec<(ByStage, u64)>, Failure> {
        if self.counter.is_none() {
            return Ok(Vec::new());
        }
        let (place, mut names) = (self.place(recording, 0)?, Names::default());
        place.ticks(&self.program, true, |dump| by_stage(dump, &mut names))
    }

    /// Stack that the ticks of a recording use \[bytes\], beyond that of `empty`, the same without a tick: valgrind's drd says of each thread how far its stack
    /// reached. `None` without valgrind.
    ///
    /// # Errors
    /// As [`Self::costs`].
    pub fn stack(&self, recording: &[u8], empty: &[u8]) -> Result<Option<u64>, Failure> {
        if self.counter.is_none() {
            return Ok(None);
        }
        let used = |recording: &[u8]| -> Result<Option<u64>, Failure> {
            let place = self.place(recording, 0)?;
            let mut command = Command::new(VALGRIND);
            command.args(["--tool=drd", "--show-stack-usage=yes"]).arg(&self.program).arg(&place.file).arg("count");
            let output = command.output().map_err(|error| Failure::problem(callgrind::missing(&error)))?;
            Ok(stack_used(&String::from_utf8_lossy(&output.stderr)))
        };
        let (with, without) = (used(recording)?, used(empty)?);
        Ok(with.zip(without).map(|(with, without)| with.saturating_sub(without)))
    }

    /// Times the ticks of a recording, over and over; `at` hears how far it is.
    ///
    /// # Errors
    /// [`Failure::Problem`] with what the program said.
    pub fn time(&self, recording: &[u8], timing: &Timing<'_>, mut at: impl FnMut(u64)) -> Result<Timed, Failure> {
        let place = self.place(recording, 0)?;
        let mut command = Command::new(&self.program);
        command.arg(&place.file).args(["time", "--ticks", &timing.ticks.to_string(), "--rt", timing.rt]);
        if let Some(cpu) = timing.cpu {
            command.args(["--cpu", &cpu.to_string()]);
        }
        if let Some(seconds) = timing.seconds {
            command.args(["--seconds", &seconds.to_string()]);
        }
        self.listen(&mut command, |line| match line {
            Said::Done { done } => {
                at(done);
                None
            }
            Said::Timed(timed) => Some(*timed),
            Said::Least { .. } => None,
        })
    }

    fn fastest(&self, recording: &[u8], slot: usize) -> Result<Vec<u64>, Failure> {
        let place = self.place(recording, slot)?;
        let mut command = Command::new(&self.program);
        command.arg(&place.file).args(["fastest", "--rounds", ROUNDS]);
        self.listen(&mut command, |line| if let Said::Least { least_ns } = line { Some(least_ns) } else { None })
    }

    /// Runs it and takes the line that matters.
    fn listen<T>(&self, command: &mut Command, mut wanted: impl FnMut(Said) -> Option<T>) -> Result<T, Failure> {
        let mut child = Child::start(command)?;
        let output = child.stdout().map(BufReader::new);
        let lines = output.into_iter().flat_map(BufRead::lines).map_while(Result::ok);
        let found = lines.filter_map(|line| serde_json::from_str(&line).ok()).filter_map(&mut wanted).last();
        let ended = child.wait(END_WITHIN);
        found
            .filter(|_| ended.is_some_and(|status| status.success()))
            .ok_or_else(|| Failure::problem(format!("{} failed:{}", self.program.display(), child.last_words())))
    }

    fn place(&self, recording: &[u8], slot: usize) -> Result<Place, Failure> {
        let folder = self.folder.path().join(slot.to_string());
        let fresh = || -> std::io::Result<()> {
            if folder.exists() {
                fs::remove_dir_all(&folder)?;
            }
            fs::create_dir_all(&folder)?;
            fs::write(folder.join(FILE), recording)
        };
        fresh().map_err(|error| unwritten(&error))?;
        Ok(Place { file: folder.join(FILE), folder })
    }
}

/// How long a program that has said everything may take to end.
const END_WITHIN: std::time::Duration = std::time::Duration::from_secs(10);

/// The recording in a slot's folder.
const FILE: &str = "ticks.haptor";

/// A slot's folder with a recording.
struct Place {
    folder: PathBuf,
    file: PathBuf,
}

impl Place {
    /// Runs the recording under callgrind and reads the dump of every tick.
    fn ticks<T>(&self, program: &Path, lines: bool, mut read: impl FnMut(&str) -> T) -> Result<Vec<T>, Failure> {
        self.counted(program, lines, &[], |job, ticks| (0..ticks).map(|call| job.dump(call).map(|dump| read(&dump))).collect())
    }

    /// Runs the recording under callgrind; `read` is told the number of ticks.
    fn counted<T>(
        &self,
        program: &Path,
        lines: bool,
        more: &[&str],
        read: impl FnOnce(&Job<'_>, usize) -> Result<T, String>,
    ) -> Result<T, Failure> {
        let file = self.file.to_string_lossy();
        let args = &[&[&*file, "count"], more].concat();
        let job = Job { program, args, keep: &[], pattern: "*measured_*", marked: &MARKED, lines, folder: &self.folder };
        let said = job.run().map_err(Failure::problem)?;
        let counted: Counted =
            serde_json::from_str(said.trim()).map_err(|error| Failure::problem(format!("{PROGRAM}: {error}")))?;
        read(&job, counted.ticks).map_err(Failure::problem)
    }
}

/// A counted run.
#[derive(Deserialize)]
struct Counted {
    ticks: usize,
}

/// A line of the other runs.
#[derive(Deserialize)]
#[serde(untagged)]
enum Said {
    Done { done: u64 },
    Least { least_ns: Vec<u64> },
    Timed(Box<Timed>),
}

/// Bytes of stack of the thread that steps, the second of the program, as drd tells them.
fn stack_used(said: &str) -> Option<u64> {
    let line = said.lines().find(|line| line.contains("thread 2 finished and used"))?;
    line.split("used ").nth(1)?.split(' ').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_programs_say_is_read() {
        assert_eq!(callgrind::total("fn=(1) x\n5 17\n\ntotals: 34248\n"), Some(34_248));
        let drd = "==7== thread 2 finished and used 10039 bytes out of 1044480 on its stack. Margin: 1034441 bytes.";
        assert_eq!(stack_used(drd), Some(10_039));
        assert!(matches!(serde_json::from_str(r#"{"least_ns":[3,4]}"#), Ok(Said::Least { least_ns }) if least_ns == [3, 4]));
        let timed = r#"{"ticks":2,"clock_ns":20,"preempted":0,"fifo":true,"locked":true,"pinned":false,"dma_latency":true,
            "p50":1,"p99":2,"p999":2,"p9999":2,"max":2,"bins":[[1,1],[2,1]]}"#;
        assert!(matches!(serde_json::from_str(timed), Ok(Said::Timed(timed)) if timed.bins == [(1, 1), (2, 1)]));
    }
}

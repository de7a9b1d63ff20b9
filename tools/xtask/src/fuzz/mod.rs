//! `cargo xtask fuzz`: builds the targets of `tests/fuzz` for libFuzzer and runs them, from good inputs and those that are kept.
//!
//! The pinned compiler does it: what instruments code for libFuzzer are options of LLVM, and the address sanitizer, an unstable option, comes with every toolchain
//! (`RUSTC_BOOTSTRAP` lets it through). So there is no second toolchain and no `cargo-fuzz` to install, which knows its way about `tests/fuzz` all the same.
//! The sanitizer is there for what dependencies do that is `unsafe`, and for the size of single allocations.

mod keep;
mod session;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::Mutex;
use std::thread;

use anyhow::{Context, Result, bail};

use crate::run::{self, ask, cargo, root, target};
use session::{Found, Session};

/// Which targets, and for how long.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Targets; all when none is named
    targets: Vec<String>,
    /// Time for each
    #[arg(long, default_value_t = 60, value_name = "S", value_parser = clap::value_parser!(u32).range(1..))]
    seconds: u32,
    /// Targets that run at the same time
    #[arg(long, default_value_t = 2, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=64))]
    jobs: u8,
    /// Give this file to the one target that is named, and nothing else
    #[arg(long, value_name = "FILE", conflicts_with_all = ["keep", "seconds"])]
    input: Option<PathBuf>,
    /// Keep the fewest inputs that reach what was reached, in tests/fuzz/corpus
    #[arg(long)]
    keep: bool,
}

/// What makes a build one for libFuzzer: counters and tables of places, comparisons traced, branches not folded, all checked for wrong addresses.
const INSTRUMENTED: [&str; 9] = [
    "--cfg=fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "-Cllvm-args=-simplifycfg-branch-fold-threshold=0",
    "-Ccodegen-units=1",
    "-Zsanitizer=address",
];

/// Builds and runs.
///
/// # Errors
/// When a target finds something, or cannot be built.
pub fn run(args: &Args) -> Result<ExitCode> {
    let names = chosen(&args.targets)?;
    let one = args.input.as_ref().map(|input| one(&names, input)).transpose()?;
    let folders = Folders::new()?;
    folders.build(&names)?;
    if let Some((name, input)) = one {
        std::fs::create_dir_all(&folders.work).with_context(|| format!("{} cannot be made", folders.work.display()))?;
        run::run(&mut folders.program(name, &input))?;
        return Ok(ExitCode::SUCCESS);
    }
    run::run(Command::new(folders.programs.join("seeds")).arg(folders.work.join("seeds")))?;
    let sessions = sessions(&folders, &names, args)?;
    println!("| target | time, s | inputs tried | edges | inputs that reach them |\n|---|---|---|---|---|");
    sessions.iter().for_each(|session| println!("{session}"));
    let found: Vec<&Found> = sessions.iter().filter_map(|session| session.found.as_ref()).collect();
    if !found.is_empty() {
        bail!("{}", found.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"));
    }
    if args.keep {
        names.iter().try_for_each(|name| keep::keep(&folders, name))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The one target that an input is for, and the input's path from anywhere: targets run in a folder of their own.
fn one<'a>(names: &'a [String], input: &Path) -> Result<(&'a str, PathBuf)> {
    let [name] = names else { bail!("--input is for one target: name one of {}", names.join(", ")) };
    let shown = input.display();
    if !input.is_file() {
        bail!("--input: {shown} is no file; give one that the target {name} is to read");
    }
    Ok((name, std::path::absolute(input).with_context(|| format!("{shown} has no absolute path"))?))
}

/// The targets that are named, or all.
fn chosen(named: &[String]) -> Result<Vec<String>> {
    let folder = root().join("tests/fuzz/fuzz_targets");
    let entries = std::fs::read_dir(&folder).with_context(|| format!("{} cannot be read", folder.display()))?;
    let stem = |path: PathBuf| Some(path.file_stem()?.to_str()?.to_owned());
    let mut all: Vec<String> = entries.flatten().filter_map(|entry| stem(entry.path())).collect();
    all.sort();
    if let Some(unknown) = named.iter().find(|name| !all.contains(name)) {
        bail!("there is no target {unknown}; there are {}", all.join(", "));
    }
    Ok(if named.is_empty() { all } else { named.to_vec() })
}

/// Where things lie.
struct Folders {
    /// Cargo's.
    build: PathBuf,
    /// The targets, built.
    programs: PathBuf,
    /// What the targets read and write.
    work: PathBuf,
    /// Which machine it is, as compilers call it.
    machine: String,
}

impl Folders {
    fn new() -> Result<Self> {
        let said = ask("rustc", &["-vV"]).context("rustc does not say for which machine it builds")?;
        let machine = said.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc names no host")?.to_owned();
        let build = target()?.join("fuzz");
        Ok(Self { programs: build.join(&machine).join("release"), work: build.join("work"), build, machine })
    }

    /// Builds the targets and what writes their first inputs.
    fn build(&self, names: &[String]) -> Result<()> {
        let mut command = cargo();
        command.args(["build", "--quiet", "--release", "--locked", "--manifest-path", "tests/fuzz/Cargo.toml", "--target"]);
        command.arg(&self.machine).arg("--target-dir").arg(&self.build).args(["--bin", "seeds"]);
        command.args(names.iter().flat_map(|name| ["--bin", name]));
        run::run(command.env("RUSTC_BOOTSTRAP", "1").env("CARGO_ENCODED_RUSTFLAGS", INSTRUMENTED.join("\x1f")))
    }

    /// Inputs that a target has found on this machine.
    fn found(&self, name: &str) -> PathBuf {
        self.work.join("found").join(name)
    }

    /// Inputs that are kept with the source.
    fn kept(name: &str) -> PathBuf {
        root().join("tests/fuzz/corpus").join(name)
    }

    /// Inputs that once found something.
    fn cases(name: &str) -> PathBuf {
        root().join("tests/fuzz/cases").join(name)
    }

    /// A target, with the limits that hold for every one of its inputs; `input` is a file or a folder of them.
    fn program(&self, name: &str, input: &Path) -> Command {
        let mut command = Command::new(self.programs.join(name));
        command.args(LIMITS).arg(input).current_dir(&self.work).env("ASAN_OPTIONS", "detect_leaks=0");
        // scenes that name a mesh look into the cache folder
        command.env("XDG_CACHE_HOME", self.work.join("cache"));
        command
    }
}

/// What an input may take. 64 MB at once and 1 GB in all, the sanitizer's own share and the inputs included: a thousand times an input's length. 25 s: a hundred times what
/// the slowest input takes that is known, so that a busy machine reports nothing.
const LIMITS: [&str; 4] = ["-malloc_limit_mb=64", "-rss_limit_mb=1024", "-timeout=25", "-max_len=32768"];

/// Runs the targets, so many at a time.
fn sessions(folders: &Folders, names: &[String], args: &Args) -> Result<Vec<Session>> {
    let (waiting, done) = (Mutex::new(names.iter().rev().collect::<Vec<_>>()), Mutex::new(Vec::new()));
    let next = || waiting.lock().ok().and_then(|mut waiting| waiting.pop());
    thread::scope(|scope| {
        for _ in 0..args.jobs {
            scope.spawn(|| {
                while let Some(name) = next() {
                    let session = session::run(folders, name, args.seconds);
                    done.lock().map(|mut done| done.push(session)).ok();
                }
            });
        }
    });
    let done: Result<Vec<Session>> = done.into_inner().unwrap_or_default().into_iter().collect();
    let mut done = done?;
    done.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(done)
}

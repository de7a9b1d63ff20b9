//! `cargo xtask loop`: what the real-time loop does on this machine, as `tests/bench/LOOP.md`: `haptor doctor` with its trials, one after the other, and what each
//! printed.

use std::fmt::Write;
use std::fs;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use crate::demo;
use crate::run::{self, ask, root};

/// Where the tables are kept.
const TABLES: &str = "tests/bench/LOOP.md";

/// Programs of others, and Debian's packages of them.
const TOOLS: [(&str, &str); 2] = [("cyclictest", "rt-tests"), ("stress-ng", "stress-ng")];

/// Scenes whose rates are tried: an ordinary one and the hardest.
const SCENES: [&str; 2] = ["tests/scenes/cube-twist.toml", "tests/scenes/ten-regions.toml"];

/// How it is run.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Length of the soak [min]
    #[arg(long, default_value_t = 0.5, value_name = "MIN")]
    minutes: f64,
    /// Length of a session at each rate, and of each way of running with rights left out [s]
    #[arg(long, default_value_t = 5, value_name = "S")]
    seconds: u64,
    /// Keep the tables in tests/bench/LOOP.md
    #[arg(long)]
    accept: bool,
}

/// Runs the trials and prints or keeps their tables.
pub fn run(args: &Args) -> Result<ExitCode> {
    for (tool, package) in TOOLS {
        if ask(tool, &["--help"]).is_none() {
            run::install(&[package])?;
        }
    }
    let programs = demo::build()?;
    let mut text = head(args)?;
    for (title, words) in sections(args) {
        let words: Vec<_> = words.iter().map(String::as_str).collect();
        let output = Command::new(programs.join("haptor")).args(&words).current_dir(root()).output()?;
        // 1: the machine is not good enough, which is a result
        if !matches!(output.status.code(), Some(0 | 1)) || output.stdout.is_empty() {
            bail!("haptor {}: {}", words.join(" "), String::from_utf8_lossy(&output.stderr));
        }
        // where this machine keeps its programs is nobody's business
        let table = String::from_utf8_lossy(&output.stdout).replace(&format!("{}/", programs.display()), "");
        eprintln!("{table}");
        writeln!(text, "\n## {title}\n\n`haptor {}`\n\n```text\n{}\n```", words.join(" "), table.trim_end())?;
    }
    if args.accept {
        let file = root().join(TABLES);
        fs::write(&file, &text).with_context(|| format!("{}", file.display()))?;
        println!("{} written", file.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// Titles and what the tool is asked.
fn sections(args: &Args) -> Vec<(String, Vec<String>)> {
    let doctor = |more: &[&str]| ["doctor"].iter().chain(more).map(|&word| word.to_owned()).collect::<Vec<_>>();
    let (minutes, seconds) = (args.minutes.to_string(), args.seconds.to_string());
    let mut all = vec![
        ("What `haptor doctor` finds".to_owned(), doctor(&[])),
        ("Beside cyclictest".to_owned(), doctor(&["--soak", &minutes])),
    ];
    all.extend(SCENES.map(|scene| (format!("Rates: {scene}"), doctor(&["--rates", scene, "--seconds", &seconds]))));
    all.push(("What each right buys".to_owned(), doctor(&["--gains", "--seconds", &seconds])));
    all
}

/// Method and machine.
fn head(args: &Args) -> Result<String> {
    let told = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let info = told("/proc/cpuinfo");
    let model = run::processor();
    let cpus = info.lines().filter(|line| line.starts_with("processor")).count();
    let kind = if info.contains(" hypervisor") { "of a virtual machine " } else { "" };
    let (load, date) = (told("/proc/loadavg"), ask("date", &["-u", "+%-d %B %Y"]).context("`date` (coreutils)")?);
    let (kernel, load) = (told("/proc/sys/kernel/osrelease"), load.split(' ').next().unwrap_or_default());
    Ok(format!(
        "# The real-time loop on one machine\n\n\
         Written by `cargo xtask loop --minutes {} --seconds {} --accept` on {date}: {cpus} CPUs {kind}({model}), kernel {}, load average {load}\n\
         when it began, without a device. Every table is what the tool printed; times are upper edges of bins. On a shared machine the worst cases are its\n\
         other users'; the ratios within a table met the same machine at the same time.\n",
        args.minutes,
        args.seconds,
        kernel.trim(),
    ))
}

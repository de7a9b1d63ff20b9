//! `extremes`: walks the axes of the box and runs random cases against the laws. Prints the document, or writes it, the map and the kept cases into a folder.
//!
//! `cargo xtask extremes --accept`

use std::path::Path;
use std::process::ExitCode;

use haptor_tests::extremes::laws::{LAWS, Law};
use haptor_tests::extremes::{axes, plot, run, words};

/// What is asked for.
struct Asked {
    steps: u64,
    seed: u64,
    machine: String,
    folder: Option<String>,
    law: Option<Law>,
    case: Option<u64>,
}

const USAGE: &str = "\
usage: extremes [--steps N] [--seed S] [--machine WORDS] [-o FOLDER]   writes EXTREMES.md, extremes.csv, extremes-cases.csv and extremes.png; without -o prints the document
       extremes --law NAME --case SEED   runs one case and prints it";

fn main() -> ExitCode {
    let Some(asked) = asked(std::env::args().skip(1)) else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    if let (Some(law), Some(seed)) = (asked.law, asked.case) {
        let (case, outcome) = run::judge(law, seed);
        println!("{case:#?}\n{outcome:#?}");
        return ExitCode::SUCCESS;
    }
    everything(&asked)
}

/// Axes, then cases.
fn everything(asked: &Asked) -> ExitCode {
    let (map, axis_steps, tallies) = std::thread::scope(|scope| {
        let axes = scope.spawn(along_axes);
        let tallies = random_cases(asked);
        let (map, steps) = axes.join().expect("an axis does not panic");
        (map, steps, tallies)
    });
    let about = words::About { seed: asked.seed, asked: asked.steps, axis_steps, machine: asked.machine.clone() };
    let document = words::document(&map, &tallies, &about);
    let sound = tallies.faulty == 0;
    let done = match &asked.folder {
        None => {
            print!("{document}");
            Ok(())
        }
        Some(folder) => write(Path::new(folder), &document, &map, &tallies),
    };
    match done {
        Ok(()) if sound => ExitCode::SUCCESS,
        Ok(()) => {
            eprintln!("{} cases broke what must never break", tallies.faulty);
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// What was found on every axis, and the ticks that took.
fn along_axes() -> (Vec<Vec<[axes::Found; 5]>>, u64) {
    let mut steps = 0;
    let walked = axes::AXES.iter().map(|axis| {
        let (found, more) = axes::walk(axis);
        eprintln!("{}: {more} ticks", axis.name);
        steps += more;
        found
    });
    (walked.collect(), steps)
}

fn random_cases(asked: &Asked) -> run::Tallies {
    let mut told = 0;
    run::all(asked.seed, asked.steps, |ticks| {
        if ticks / PROGRESS > told {
            told = ticks / PROGRESS;
            eprintln!("{ticks} ticks of {}", asked.steps);
        }
    })
}

/// Ticks between two words of progress.
const PROGRESS: u64 = 5_000_000;

fn asked(mut args: impl Iterator<Item = String>) -> Option<Asked> {
    let mut asked = Asked {
        steps: 1_000_000,
        seed: 1,
        machine: "a machine that was not named".to_owned(),
        folder: None,
        law: None,
        case: None,
    };
    while let Some(name) = args.next() {
        let value = args.next()?;
        match name.as_str() {
            "--steps" => asked.steps = value.parse().ok()?,
            "--seed" => asked.seed = value.parse().ok()?,
            "--machine" => asked.machine = value,
            "--law" => asked.law = Some(LAWS.into_iter().find(|law| law.name() == value)?),
            "--case" => asked.case = Some(u64::from_str_radix(&value, 16).ok()?),
            "-o" => asked.folder = Some(value),
            _ => return None,
        }
    }
    Some(asked)
}

fn write(
    folder: &Path,
    document: &str,
    map: &[Vec<[axes::Found; 5]>],
    tallies: &run::Tallies,
) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::write(folder.join("EXTREMES.md"), document)?;
    std::fs::write(folder.join("extremes.csv"), words::map_csv(map))?;
    std::fs::write(folder.join("extremes-cases.csv"), words::cases_csv(tallies))?;
    plot::draw(&folder.join("extremes.png"), map)
}

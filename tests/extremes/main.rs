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
    let asked = match asked(std::env::args().skip(1)) {
        Ok(asked) => asked,
        Err(wrong) => {
            eprintln!("{wrong}\n{USAGE}");
            return ExitCode::from(2);
        }
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

/// What is asked for, or what is wrong with it.
fn asked(mut args: impl Iterator<Item = String>) -> Result<Asked, String> {
    let mut asked = Asked {
        steps: 1_000_000,
        seed: 1,
        machine: "a machine that was not named".to_owned(),
        folder: None,
        law: None,
        case: None,
    };
    while let Some(name) = args.next() {
        let value = args.next().ok_or_else(|| format!("{name}: its value is missing"))?;
        let not = |allowed: &str| format!("{name} is {value}, allowed is {allowed}");
        match name.as_str() {
            "--steps" => {
                asked.steps = value.parse().ok().filter(|&steps| steps > 0).ok_or_else(|| not("a number of ticks, 1 or more"))?;
            }
            "--seed" => asked.seed = value.parse().map_err(|_| not("0 to 18446744073709551615"))?,
            "--machine" => asked.machine = value,
            "--law" => asked.law = Some(law(&value).ok_or_else(|| not(&LAWS.map(Law::name).join(", ")))?),
            "--case" => {
                asked.case = Some(u64::from_str_radix(&value, 16).map_err(|_| not("a seed of up to 16 hexadecimal digits"))?);
            }
            "-o" => asked.folder = Some(writable(value)?),
            _ => return Err(format!("{name}: there is no such option")),
        }
    }
    match (asked.law, asked.case) {
        (Some(_), None) => Err("--law: name the case too, --case SEED".to_owned()),
        (None, Some(_)) => Err("--case: name the law too, --law NAME".to_owned()),
        _ => Ok(asked),
    }
}

fn law(name: &str) -> Option<Law> {
    LAWS.into_iter().find(|law| law.name() == name)
}

/// A folder that can be written to: asked before minutes of work.
fn writable(folder: String) -> Result<String, String> {
    let tried = tempfile::tempfile_in(&folder);
    tried.map_err(|error| {
        format!("-o is {folder}, nothing can be written there: {error}; give a folder that can be written to")
    })?;
    Ok(folder)
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

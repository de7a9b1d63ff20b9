//! `reference`: writes the tables of reference answers.
//!
//! `cargo run --release -p haptor-reference -- turning -o tests/truth/turning_paths.json`
//! writes the turning paths; `straight` and `all` the others; `pressed` the histories whose load changes. `--profile` sets the pressure, `--across N` cells over the diameter,
//! `--rows N` the rows per path.

use haptor_reference::paths::{PATHS, Path};
use haptor_reference::pressed;
use haptor_reference::profile::Profile;
use haptor_reference::table;
use std::process::ExitCode;

/// Cells over the diameter: 448 cells, within 0.5 % of 1020 cells on every path.
const ACROSS: usize = 24;
/// Rows per path, each of several steps.
const ROWS: usize = 240;
const USAGE: &str = "usage: reference straight|turning|all|pressed -o FILE [--profile hertz|cone|punch] [--across N] [--rows N]";

struct Request {
    profile: Profile,
    paths: Vec<Path>,
    across: usize,
    rows: usize,
    out: String,
}

fn main() -> ExitCode {
    match parse(&std::env::args().skip(1).collect::<Vec<_>>()).and_then(|r| write(&r)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn parse(args: &[String]) -> Result<Request, String> {
    let kind = args.first().map_or("", String::as_str);
    let paths: Vec<Path> = match kind {
        "straight" => PATHS.iter().filter(|p| !p.turning).copied().collect(),
        "turning" => PATHS.iter().filter(|p| p.turning).copied().collect(),
        "all" => PATHS.to_vec(),
        "pressed" => Vec::new(),
        _ => return Err(USAGE.into()),
    };
    let mut request = Request { paths, profile: Profile::Hertz, across: ACROSS, rows: ROWS, out: String::new() };
    for pair in args[1..].chunks(2) {
        let [key, value] = pair else {
            return Err(USAGE.into());
        };
        let number = || value.parse::<usize>().map_err(|_| format!("{key} {value}: not a whole number"));
        match key.as_str() {
            "-o" => request.out.clone_from(value),
            "--profile" => {
                request.profile = *Profile::ALL.iter().find(|p| p.name() == value).ok_or(USAGE)?;
            }
            "--across" => request.across = number()?.clamp(4, 80),
            "--rows" => request.rows = number()?.clamp(1, 100_000),
            _ => return Err(USAGE.into()),
        }
    }
    if request.out.is_empty() { Err(USAGE.into()) } else { Ok(request) }
}

fn write(request: &Request) -> Result<(), String> {
    let progress = &mut |line: &str| eprintln!("{line}");
    let text = if request.paths.is_empty() {
        serde_json::to_string(&pressed::run(request.across, request.rows, progress))
    } else {
        serde_json::to_string(&table::run(&request.paths, request.profile, request.across, request.rows, progress))
    };
    let text = text.map_err(|e| e.to_string())?;
    std::fs::write(&request.out, text + "\n").map_err(|e| format!("{}: {e}", request.out))
}

//! `stability`: maps which closed loops hold still. Prints the document, or writes it and the picture beside it.
//!
//! `cargo run --release -p haptor-tests --bin stability -- -o tests/bench/STABILITY.md`

use std::path::Path;
use std::process::ExitCode;

use haptor_tests::stability::{map::map, plot, words};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args.as_slice() {
        [] => print!("{}", words::document(&map())),
        ["-o", file] => return write(Path::new(file)),
        _ => {
            eprintln!("usage: stability [-o FILE]   writes FILE and stability.png beside it; without -o prints the tables");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

fn write(file: &Path) -> ExitCode {
    let map = map();
    let picture = file.with_file_name("stability.png");
    if let Err(error) = std::fs::write(file, words::document(&map)) {
        eprintln!("{}: {error}", file.display());
        return ExitCode::FAILURE;
    }
    if let Err(error) = plot::draw(&picture, &map) {
        eprintln!("{}: {error}", picture.display());
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

//! `accuracy`: measures the deformed surface against finite elements and prints the table, or writes it.
//!
//! `cargo run --release -p haptor-tests --bin accuracy -- -o tests/bench/ACCURACY.md`

use std::process::ExitCode;

use haptor_tests::accuracy;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args.as_slice() {
        [] => print!("{}", accuracy::document()),
        ["-o", file] => {
            if let Err(error) = std::fs::write(file, accuracy::document()) {
                eprintln!("{file}: {error}");
                return ExitCode::FAILURE;
            }
        }
        _ => {
            eprintln!("usage: accuracy [-o FILE]");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

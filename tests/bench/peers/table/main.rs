//! `tests/bench/PEERS.md` from the lines of JSON that a run of the comparison left: every number of the table is one of a line, or a ratio of two.
//!
//! `peers-table LINES.jsonl > PEERS.md`; `cargo xtask peers` runs everything before it.
#![forbid(unsafe_code)]

mod accuracy;
mod lines;
mod speed;
mod words;

use std::error::Error;
use std::fs;

use lines::Lines;

/// The programs' own words in a table: names are their cases'.
const OURS: &str = "haptor";

/// The setting of ours that ratios are taken to: the default of a scene.
const DEFAULT: &str = "bristle 64";

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: peers-table LINES.jsonl > PEERS.md")?;
    print!("{}", document(&Lines::parse(&fs::read_to_string(path)?)?));
    Ok(())
}

/// The whole document.
fn document(lines: &Lines) -> String {
    [
        words::head(lines),
        accuracy::table(lines),
        accuracy::drag(lines),
        speed::one_region(lines),
        speed::regions(lines),
        speed::shipped(lines),
        words::better(lines),
        words::cannot(lines),
        words::how(lines),
    ]
    .join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_table_is_that_of_the_committed_lines() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let read = |path: &str| fs::read_to_string(folder.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
        let (lines, table) = (Lines::parse(&read("results.jsonl")).unwrap(), read("../PEERS.md"));
        let made = document(&lines);
        for (number, (made, committed)) in made.lines().zip(table.lines()).enumerate() {
            assert_eq!(made, committed, "tests/bench/PEERS.md:{}; write it anew: cargo xtask peers --table", number + 1);
        }
        assert_eq!(made.len(), table.len(), "tests/bench/PEERS.md: write it anew: cargo xtask peers --table");
    }
}

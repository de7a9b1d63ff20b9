//! The documents tell the truth: every command has help with an example, the worked example's figures are the tool's own, and what
//! the documents name exists.

use std::fs;
use std::process::Command;

use crate::cli::{built, haptor, root};

#[test]
fn every_command_has_help_with_an_example() {
    let commands: &[&[&str]] = &[
        &[],
        &["eval"],
        &["demo"],
        &["bake"],
        &["run"],
        &["view"],
        &["plot"],
        &["trade"],
        &["trajectory"],
        &["trajectory", "press-twist-slide"],
        &["trajectory", "moves"],
        &["mesh"],
        &["mesh", "info"],
        &["mesh", "check"],
        &["mesh", "repair"],
        &["mesh", "reduce"],
        &["mesh", "bake"],
        &["mesh", "make"],
        &["devices"],
        &["doctor"],
        &["bench"],
    ];
    for words in commands {
        let output = haptor().args(*words).arg("--help").output().unwrap();
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success(), "{words:?}");
        assert!(help.contains("Example: haptor "), "{words:?}: {help}");
    }
}

/// The README shows rows of a result; each of them must be in it.
#[test]
fn the_worked_example_shows_what_the_tool_prints() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let printed = haptor().args(["eval", "tests/scenes/cube-twist.toml", "tests/scenes/cube-twist.csv"]).output().unwrap();
    let printed = String::from_utf8(printed.stdout).unwrap();
    let shown: Vec<_> = readme.lines().filter(|line| line.contains(",bristle,")).collect();
    assert!(!shown.is_empty(), "the README shows no row");
    for row in shown {
        assert!(printed.lines().any(|line| line == row), "the tool does not print {row}");
    }
}

/// The README's table beside other programs takes its figures from the long one: a row's first cell names program and case, the others are cells of their rows there.
#[test]
fn the_readme_compares_as_the_comparison_does() {
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let text = |path: &str| fs::read_to_string(root().join(path)).unwrap();
    let (readme, peers) = (text("README.md"), text("tests/bench/PEERS.md"));
    let rows: Vec<_> = peers.lines().filter(|line| line.starts_with('|')).map(cells).collect();
    let (_, section) = readme.split_once("## Beside other programs").expect("the section");
    let table = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1).take_while(|line| line.starts_with('|'));
    let mut compared = 0;
    for row in table.map(cells) {
        let (program, case) = row[0].split_once(", ").expect("program, case");
        let own = |columns: usize| rows.iter().find(|one| one.len() == columns && one[0] == program && one[1] == case);
        let (time, physics) = (own(9).map(|one| &one[2]), own(7));
        assert_eq!(Some(&row[1]), time, "time of {}", row[0]);
        let (force, torque) = physics.map_or((String::new(), String::new()), |one| (one[2].clone(), one[5].clone()));
        assert_eq!((&row[2], &row[3]), (&force, &torque), "force and torque of {}", row[0]);
        compared += 1;
    }
    assert!(compared > 5, "{compared} rows");
}

#[test]
fn links_pictures_and_commands_of_the_documents_exist() {
    let output = Command::new(built("xtask")).args(["docs", "--check"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

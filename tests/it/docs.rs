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

#[test]
fn links_pictures_and_commands_of_the_documents_exist() {
    let output = Command::new(built("xtask")).args(["docs", "--check"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

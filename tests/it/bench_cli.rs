//! `haptor bench` as the comparison uses it: one line of JSON per case, with the fields that every program of the comparison prints.

use std::fs;

use serde_json::Value;

use crate::cli::{haptor, root};

const WORDS: [&str; 4] = ["peer", "version", "scene", "case"];
const NUMBERS: [&str; 7] = ["n", "median_us", "p99_us", "max_us", "cpu_median_us", "cpu_p99_us", "cpu_max_us"];

/// What the tool prints for some cases, as short as it measures.
fn lines(cases: &[&str]) -> Vec<Value> {
    let asked = cases.iter().flat_map(|case| ["--case", case]);
    let output = haptor().args(["bench", "--json", "--seconds", "0"]).args(asked).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn a_line_of_json_per_case_with_the_agreed_fields() {
    let lines = lines(&["mallet, point", "box-k10, no friction", "ball-on-cube, bristle 16"]);
    let cases: Vec<_> = lines.iter().map(|line| format!("{} {}", line["scene"], line["case"])).collect();
    assert_eq!(cases, ["\"mallet\" \"point\"", "\"ball-on-cube\" \"bristle 16\"", "\"box-k10\" \"no friction\""]);
    for line in &lines {
        assert_eq!(line["peer"], "haptor");
        assert_eq!(line.as_object().unwrap().len(), WORDS.len() + NUMBERS.len(), "{line}");
        assert!(WORDS.iter().all(|name| line[name].as_str().is_some_and(|word| !word.is_empty())), "{line}");
        let [n, median, p99, max, cpu_median, cpu_p99, cpu_max] = NUMBERS.map(|name| line[name].as_f64().unwrap());
        assert!(n >= 100.0 && median > 0.0 && cpu_median > 0.0, "{line}");
        assert!(median <= p99 && p99 <= max && cpu_median <= cpu_p99 && cpu_p99 <= cpu_max, "{line}");
    }
}

#[test]
fn a_case_that_is_not_there_is_told_with_those_that_are() {
    let output = haptor().args(["bench", "--case", "cube-of-jelly"]).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(told.contains("cube-of-jelly") && told.contains("ten-regions, influence 52"), "{told}");
}

/// Every program's lines of time have the same fields, with the round behind them.
#[test]
fn the_committed_lines_of_every_program_have_the_same_fields() {
    let text = fs::read_to_string(root().join("tests/bench/peers/results.jsonl")).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let times: Vec<_> = lines.iter().filter(|line| line.get("round").is_some()).collect();
    for peer in ["haptor", "MuJoCo", "Drake hydroelastic", "coal", "parry3d-f64", "condensed FE + Coulomb sweeps"] {
        assert!(times.iter().any(|line| line["peer"] == peer), "{peer} is in no line");
    }
    for line in times {
        assert!(WORDS.iter().all(|name| line[name].is_string()) && NUMBERS.iter().all(|name| line[name].is_number()), "{line}");
    }
}

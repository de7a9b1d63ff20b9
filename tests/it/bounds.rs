//! Every loop of the core stands in `core/contact/src/bounds.md` with what bounds it.
//!
//! A scanner of lines, no parser: a loop is a line that begins with `for`, `while` or `loop`, a label apart, above the tests of its file; what a call drives is told by the
//! call's name. A loop hidden in a macro or behind a name of its own would escape it; the core has neither.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::cli::root;

/// Calls that run an iterator or a slice to its end, or until they know enough.
const DRIVERS: [&str; 14] = [
    "for_each",
    "try_for_each",
    "fold",
    "sum",
    "all",
    "any",
    "find",
    "max_by",
    "min_by",
    "retain",
    "count",
    "fill",
    "position",
    "rposition",
];

fn sources() -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![root().join("core/contact/src")]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = entry.file_name().unwrap().to_str().unwrap();
            if entry.is_dir() {
                folders.push(entry);
            } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
                found.push(entry);
            }
        }
    }
    found
}

/// The lines of a file above its tests, without comments.
fn lines(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let code = text.split("#[cfg(test)]").next().unwrap_or("");
    code.lines().map(|line| line.split("//").next().unwrap_or("").trim().to_owned()).collect()
}

/// The loop that a line begins, without its brace.
fn loop_of(line: &str) -> Option<String> {
    let body = match line.split_once(": ") {
        Some((label, rest)) if label.starts_with('\'') => rest,
        _ => line,
    };
    let is_loop = (body.starts_with("for ") && body.contains(" in ")) || body.starts_with("while ") || body.starts_with("loop");
    is_loop.then(|| body.trim_end_matches('{').trim().replace('|', "\u{a6}"))
}

/// Loops that are no `for`, whose bound can be read off, and have no word about theirs on the line above.
fn unbounded(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let code: Vec<&str> = text.split("#[cfg(test)]").next().unwrap_or("").lines().map(str::trim).collect();
    let begins = |line: &str| loop_of(line).is_some_and(|code| !code.starts_with("for "));
    code.windows(2).filter(|pair| begins(pair[1]) && !pair[0].starts_with("// bound: ")).map(|pair| pair[1].to_owned()).collect()
}

/// How many calls of a line drive an iterator.
fn drivers_of(line: &str) -> usize {
    let after = line.split('.').skip(1);
    let name = |call: &str| {
        call.find(|c: char| !c.is_alphanumeric() && c != '_').map(|end| (call[..end].to_owned(), call[end..].to_owned()))
    };
    after
        .filter_map(name)
        .filter(|(name, rest)| DRIVERS.contains(&name.as_str()) && (rest.starts_with('(') || rest.starts_with("::<")))
        .count()
}

/// Rows of the document's tables: the loops of a file, and the calls.
fn table() -> (BTreeMap<String, Vec<String>>, BTreeMap<String, usize>) {
    let text = fs::read_to_string(root().join("core/contact/src/bounds.md")).unwrap();
    let (mut loops, mut calls) = (BTreeMap::<String, Vec<String>>::new(), BTreeMap::new());
    for line in text.lines() {
        let fields: Vec<&str> = line.trim_matches('|').split('|').map(|field| field.trim().trim_matches('`')).collect();
        match fields[..] {
            [file, code, bound, _] if file.ends_with(".rs") => {
                assert!(!bound.is_empty(), "{file}: {code} has no bound");
                loops.entry(file.to_owned()).or_default().push(code.to_owned());
            }
            [file, number] if file.ends_with(".rs") => drop(calls.insert(file.to_owned(), number.parse().unwrap())),
            _ => {}
        }
    }
    (loops, calls)
}

#[test]
fn every_loop_of_the_core_is_in_the_table_of_bounds_and_none_waits_for_convergence() {
    let (mut table, calls) = table();
    let (mut wrong, mut seen, base) = (Vec::new(), 0, root().join("core/contact/src"));
    for file in sources() {
        let name = file.strip_prefix(&base).unwrap().to_str().unwrap().to_owned();
        let lines = lines(&file);
        let mut listed = table.remove(&name).unwrap_or_default();
        for code in lines.iter().filter_map(|line| loop_of(line)) {
            seen += 1;
            match listed.iter().position(|row| *row == code) {
                Some(row) => drop(listed.remove(row)),
                None => wrong.push(format!("{name}: not in the table: | `{name}` | `{code}` | BOUND | UNIT COST |")),
            }
        }
        wrong.extend(listed.into_iter().map(|code| format!("{name}: in the table, not in the file: {code}")));
        wrong.extend(unbounded(&file).into_iter().map(|code| format!("{name}: {code}: say on the line above: // bound: ...")));
        let driven: usize = lines.iter().map(|line| drivers_of(line)).sum();
        if calls.get(&name).copied().unwrap_or(0) != driven {
            wrong.push(format!("{name}: calls that drive an iterator: | `{name}` | {driven} |"));
        }
    }
    wrong.extend(table.into_keys().map(|file| format!("{file} is in the table and has no loop, or is no file")));
    assert!(seen > 100, "the scanner sees {seen} loops");
    assert!(wrong.is_empty(), "core/contact/src/bounds.md:\n{}", wrong.join("\n"));
}

//! What can be known of the documents without running anything: relative links and pictures lead to files, every `haptor ...` command exists with the options shown, every `cargo xtask ...`
//! command exists.

use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use super::documents;
use crate::run::{root, tool};

/// Checks every document; all that is wrong is said before it fails.
pub fn check() -> Result<ExitCode> {
    let haptor = tool()?;
    let documents = documents()?;
    let mut wrong = Vec::new();
    for path in &documents {
        let text = fs::read_to_string(path).with_context(|| format!("{} cannot be read", path.display()))?;
        wrong.extend(check_text(path, &text, &haptor));
    }
    if wrong.is_empty() {
        println!("{} documents checked", documents.len());
        return Ok(ExitCode::SUCCESS);
    }
    bail!("the documents are wrong in {} places:\n{}", wrong.len(), wrong.join("\n"))
}

/// What is wrong with a document. Inside a fence only the commands of shell examples count, outside it links and spans.
fn check_text(path: &Path, text: &str, haptor: &Path) -> Vec<String> {
    let folder = path.parent().unwrap_or(root());
    let mut fence: Option<&str> = None;
    let mut wrong = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            fence = if fence.is_some() { None } else { Some(language.split_whitespace().next().unwrap_or("")) };
            continue;
        }
        let (links, commands) = match fence {
            Some("sh") => (Vec::new(), shell_command(line).into_iter().collect()),
            Some(_) => continue,
            None => (links(line), spans(line)),
        };
        let missing = links.iter().filter(|link| !folder.join(link).exists());
        let found = missing.map(|link| format!("link to {link}, which is not there"));
        let found = found.chain(commands.iter().filter_map(|words| check_command(words, haptor)));
        wrong.extend(found.map(|what| format!("{}:{}: {what}", path.display(), index + 1)));
    }
    wrong
}

/// Targets of the line's links and pictures within the repository, without their anchors.
pub fn links(line: &str) -> Vec<&str> {
    let ends = line.match_indices("](").map(|(at, _)| &line[at + 2..]);
    let targets = ends.filter_map(|rest| rest.split(')').next());
    let outside = |target: &&str| !(target.contains("://") || target.starts_with('#') || target.is_empty());
    targets.filter(outside).filter_map(|target| target.split('#').next()).collect()
}

/// A command of ours on a line of a shell example.
fn shell_command(line: &str) -> Option<Vec<&str>> {
    let line = line.trim_start().trim_start_matches("$ ").trim_start_matches("target/release/");
    let line = line.split(" #").next().unwrap_or(line);
    let is_ours = ["haptor ", "cargo xtask "].iter().any(|start| line.starts_with(start));
    is_ours.then(|| line.split_whitespace().collect())
}

/// Commands of ours between backquotes.
fn spans(line: &str) -> Vec<Vec<&str>> {
    line.split('`').skip(1).step_by(2).filter_map(shell_command).collect()
}

/// What is wrong with a command; nothing is run but `--help`.
fn check_command(words: &[&str], haptor: &Path) -> Option<String> {
    let shown = words.join(" ");
    let (program, rest) = match words {
        ["cargo", "xtask", rest @ ..] => (std::env::current_exe().ok()?, rest),
        [_, rest @ ..] => (haptor.to_owned(), rest),
        [] => return None,
    };
    let is_name = |word: &&&str| {
        word.starts_with(|c: char| c.is_ascii_lowercase())
            && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
    };
    // `mesh info` and `trajectory press-twist-slide` have two words, the others one
    let depth = if matches!(rest.first(), Some(&("mesh" | "trajectory"))) { 2 } else { 1 };
    let names: Vec<_> = rest.iter().take(depth).take_while(is_name).collect();
    if names.is_empty() {
        return None;
    }
    let output = Command::new(program).args(&names).arg("--help").output().ok()?;
    if !output.status.success() {
        return Some(format!("`{shown}`: no such command"));
    }
    let help = String::from_utf8_lossy(&output.stdout).into_owned();
    // what follows `cargo xtask demo` belongs to `haptor demo`
    if words.first() == Some(&"cargo") && rest.first() == Some(&"demo") {
        return check_command(&[&["haptor"], rest].concat(), haptor);
    }
    let options = rest.iter().filter_map(|word| word.strip_prefix("--")).map(|word| word.split('=').next().unwrap_or(word));
    options
        .filter(|option| !help.contains(&format!("--{option}")))
        .map(|option| format!("`{shown}`: no option --{option}"))
        .next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_within_the_repository_are_found() {
        let line = "see [a](core/a.md#part), [b](https://example.org/b), ![c](tests/c.png) and [d](#here)";
        assert_eq!(links(line), ["core/a.md", "tests/c.png"]);
    }

    #[test]
    fn commands_are_found_in_examples_and_in_text() {
        assert_eq!(shell_command("$ haptor eval a b -o c  # says nothing").unwrap(), ["haptor", "eval", "a", "b", "-o", "c"]);
        assert_eq!(shell_command("cd haptor"), None);
        assert_eq!(spans("run `cargo xtask ci` and `haptor doctor`"), [vec!["cargo", "xtask", "ci"], vec!["haptor", "doctor"]]);
        assert!(spans("haptor `-o` its `heart`").is_empty());
    }
}

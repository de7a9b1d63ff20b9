//! The shell examples of the documents, run as a reader would: each document in an empty folder of its own in which `tests` leads to the
//! repository's, one block after the other, with the released programs in the path. A block that needs a device, a window or minutes says so in its
//! fence (```` ```sh no-run ````) and is only checked for commands and options that exist. A picture that a document shows and its commands draw
//! under the same name must come out the same, byte for byte.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use super::check::links;
use super::documents;
use crate::demo;
use crate::run::{root, target};

/// A block of shell commands.
#[derive(Debug, PartialEq, Eq)]
struct Block<'a> {
    /// Its first line in the document, from 1.
    line: usize,
    /// The commands.
    commands: &'a str,
}

/// Runs the examples of the named documents, or of all; all that fails is said before it fails.
pub fn run(named: &[PathBuf]) -> Result<ExitCode> {
    let programs = demo::build()?;
    let scratch = target()?.join("tmp/docs");
    let (mut ran, mut wrong) = (0, Vec::new());
    let all = if named.is_empty() { documents()? } else { named.to_vec() };
    for (number, path) in all.iter().enumerate() {
        let text = fs::read_to_string(path).with_context(|| format!("{} cannot be read", path.display()))?;
        let blocks = blocks(&text);
        if blocks.is_empty() {
            continue;
        }
        let folder = fresh(&scratch.join(number.to_string()))?;
        for block in blocks {
            eprintln!("$ {}:{}", path.display(), block.line);
            ran += 1;
            wrong.extend(fault(&block, &folder, &programs)?.map(|what| format!("{}:{}: {what}", path.display(), block.line)));
        }
        let other = other_pictures(path, &text, &folder);
        wrong.extend(other.map(|picture| format!("{}: {picture} is not what its commands draw", path.display())));
    }
    if ran == 0 {
        bail!("there is no example to run");
    }
    if !wrong.is_empty() {
        bail!("{} of {ran} examples fail:\n{}", wrong.len(), wrong.join("\n"));
    }
    println!("{ran} examples ran");
    Ok(ExitCode::SUCCESS)
}

/// An empty folder in which `tests` is the repository's.
fn fresh(folder: &Path) -> Result<PathBuf> {
    let make = || {
        if folder.exists() {
            fs::remove_dir_all(folder)?;
        }
        fs::create_dir_all(folder)?;
        symlink(root().join("tests"), folder.join("tests"))
    };
    make().with_context(|| format!("{} cannot be made", folder.display()))?;
    Ok(folder.to_owned())
}

/// How a block fails, if it does; its last words.
fn fault(block: &Block<'_>, folder: &Path, programs: &Path) -> Result<Option<String>> {
    let path = std::env::join_paths(
        std::iter::once(programs.to_owned()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )?;
    let output = Command::new("bash")
        .args(["-euo", "pipefail", "-c", block.commands])
        .current_dir(folder)
        .env("PATH", path)
        // what a reader has configured must not change what the documents say
        .env("XDG_CONFIG_HOME", folder.join("config"))
        .output()
        .context("bash cannot be started")?;
    if output.status.success() {
        return Ok(None);
    }
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let last: Vec<_> = said.lines().rev().take(5).collect();
    Ok(Some(format!("{}: {}", output.status, last.into_iter().rev().collect::<Vec<_>>().join(" | "))))
}

/// Pictures that the document shows and that its commands have drawn otherwise.
fn other_pictures<'t>(path: &'t Path, text: &'t str, drawn: &'t Path) -> impl Iterator<Item = &'t str> {
    let folder = path.parent().unwrap_or(root());
    text.lines().flat_map(links).filter(|link| link.ends_with(".png")).filter(move |link| {
        let shown = folder.join(link);
        let drawn = shown.file_name().and_then(|name| fs::read(drawn.join(name)).ok());
        drawn.is_some_and(|drawn| fs::read(&shown).ok() != Some(drawn))
    })
}

/// The blocks of a document that are to be run. What is cargo's is run elsewhere and left out line by line.
fn blocks(text: &str) -> Vec<Block<'_>> {
    let mut found = Vec::new();
    let mut open: Option<(&str, usize, usize)> = None;
    let mut offset = 0;
    for (index, line) in text.split_inclusive('\n').enumerate() {
        if let Some(info) = line.trim().strip_prefix("```") {
            match open.take() {
                None => open = Some((info.trim(), index + 2, offset + line.len())),
                Some(("sh", first, from)) => found.push(Block { line: first, commands: &text[from..offset] }),
                Some(_) => {}
            }
        }
        offset += line.len();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_those_of_the_shell_that_may_run() {
        let text = "a\n```sh\none\ntwo\n```\n```rust\nlet x;\n```\n```sh no-run\nthree\n```\n```sh\nfour\n```\n";
        let expected = [Block { line: 3, commands: "one\ntwo\n" }, Block { line: 13, commands: "four\n" }];
        assert_eq!(blocks(text), expected);
    }

    #[test]
    fn a_picture_that_comes_out_otherwise_is_told() {
        let folder = std::env::temp_dir().join(format!("haptor-docs-{}", std::process::id()));
        let (shown, drawn) = (folder.join("shown"), folder.join("drawn"));
        for (path, bytes) in [(&shown, "ab"), (&drawn, "ac")] {
            fs::create_dir_all(path).unwrap();
            ["a.png", "b.png"]
                .iter()
                .zip(bytes.chars())
                .for_each(|(name, byte)| fs::write(path.join(name), byte.to_string()).unwrap());
        }
        let document = folder.join("page.md");
        let text = "![A](shown/a.png) and [b](shown/b.png), ![c](shown/c.png)";
        assert_eq!(other_pictures(&document, text, &drawn).collect::<Vec<_>>(), ["shown/b.png"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_command_that_fails_is_told_with_its_last_words() {
        let folder = std::env::temp_dir();
        let run = |commands| fault(&Block { line: 1, commands }, &folder, Path::new("/")).unwrap();
        assert_eq!(run("true\n"), None);
        let said = run("echo lost >&2\nfalse\necho more\n").unwrap();
        assert!(said.contains("exit status: 1: lost") && !said.contains("more"), "{said}");
    }
}

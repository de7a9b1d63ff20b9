//! What a tick costs on an emulated Cortex-M7: instructions of every scene, and their table `tests/bench/COUNTS-M7.md`.
//!
//! Counts are exact and the same on every run of the same image; they change with the code and with the compiler.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::growth::{self, Row};
use crate::m7_image;
use crate::run::{ask, root};

/// The table.
const TABLE: &str = "tests/bench/COUNTS-M7.md";

/// Command that writes it.
const COMMAND: &str = "cargo xtask m7 costs --accept";

/// Its columns that may not grow.
const UNITS: [&str; 3] = ["mean", "worst", "bytes of stack"];

/// What the image says.
pub struct Counted {
    /// What the memory of a tick takes \[bytes\].
    pub sizes: Vec<(String, u64)>,
    /// Every scene, in order.
    pub scenes: Vec<Scene>,
}

/// A scene.
pub struct Scene {
    /// Its name.
    pub name: String,
    calls: u64,
    total: u64,
    worst: u64,
    worst_call: u64,
    /// Bytes of stack from the function that steps a scene downwards, measured.
    pub stack: u64,
}

impl Scene {
    fn row(&self) -> Row {
        (self.name.clone(), vec![(self.total + self.calls / 2) / self.calls.max(1), self.worst, self.stack])
    }
}

/// Runs the image.
///
/// # Errors
/// When a scene does not come to its end as it must, or the image says something else.
pub fn count(triple: &str, folder: &Path) -> Result<Counted> {
    let said = m7_image::counts(triple, folder)?;
    let counted = read(&said)?;
    if counted.scenes.is_empty() || counted.sizes.is_empty() {
        bail!("the image counted nothing: `{said}`")
    }
    Ok(counted)
}

fn read(said: &str) -> Result<Counted> {
    let (mut sizes, mut scenes) = (Vec::new(), Vec::new());
    for line in said.lines() {
        let mut fields = line.split('\t');
        let name = fields.next().unwrap_or_default().to_owned();
        let numbers = fields.map(str::parse).collect::<Result<Vec<u64>, _>>().with_context(|| line.to_owned())?;
        match numbers[..] {
            [bytes] => sizes.push((name, bytes)),
            [calls, total, worst, worst_call, stack] => scenes.push(Scene { name, calls, total, worst, worst_call, stack }),
            _ => bail!("the counting image says `{line}`, which is no line of its table"),
        }
    }
    Ok(Counted { sizes, scenes })
}

/// Whether no count grew beyond the table; says so in a line.
///
/// # Errors
/// Names the scenes that grew, or that only the table or only the image has.
pub fn check(counted: &Counted, compiler: &str) -> Result<String> {
    let text = fs::read_to_string(root().join(TABLE)).with_context(|| format!("{TABLE}; make it: {COMMAND}"))?;
    let found: Vec<_> = counted.scenes.iter().map(Scene::row).collect();
    let said = growth::complaints(&growth::rows(&text, UNITS.len()), &found, &UNITS);
    if !said.is_empty() {
        let table = text.lines().find(|line| line.starts_with("Compiler:")).unwrap_or_default();
        bail!(
            "{}\n{TABLE} was made with: {table}\nthis is {compiler}. If this is the price of something: {COMMAND}",
            said.join("\n")
        );
    }
    Ok(format!("{} scenes cost no more instructions and stack than {TABLE} says", found.len()))
}

/// Writes the table.
///
/// # Errors
/// When it cannot be written.
pub fn write(counted: &Counted, compiler: &str) -> Result<()> {
    let emulator = ask(m7_image::EMULATOR, &["--version"]).unwrap_or_default();
    let emulator = emulator.lines().next().unwrap_or_default();
    let mut text = HEAD.to_owned();
    writeln!(text, "Compiler: {compiler}. Counter: {emulator}, mps2-an500, `-icount shift=8`.\n")?;
    text += "| scene | mean | worst | stack [bytes] | the worst is |\n|---|---:|---:|---:|---|\n";
    for scene in &counted.scenes {
        let (name, numbers) = scene.row();
        let [mean, worst, stack] = numbers[..] else { continue };
        writeln!(text, "| {name} | {mean} | {worst} | {stack} | call {} of {} |", scene.worst_call, scene.calls)?;
    }
    fs::write(root().join(TABLE), text).with_context(|| TABLE.to_owned())?;
    println!("{TABLE} written");
    Ok(())
}

const HEAD: &str = "\
# What a tick costs on a Cortex-M7, in instructions

Written by `cargo xtask m7 costs --accept`; `cargo xtask m7` fails when a number grows by more than 2 %. Instructions of an emulated Cortex-M7 with a floating-point unit of single precision,
release profile of `firmware-sim/cortex-m`, exact: the same image counts the same on every run. A count is no time: the emulator knows no pipeline, no cache and no wait states. At
480 MHz and one instruction a cycle, 1 kHz leaves 480,000 instructions.

The scenes are those of [COUNTS.md](COUNTS.md), with the host's capacities; call 0 is the first of the counted round. *stack*: bytes that were used, measured by painting, from the function that
makes the model, the parameters and the ticks downwards; the bound from the image itself is in [MEMORY.md](MEMORY.md).

";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_image_are_sizes_and_scenes() {
        let counted = read("`Model`\t208\na, b\t48\t4801\t150\t7\t8000\n").unwrap();
        assert_eq!(counted.sizes, [("`Model`".to_owned(), 208)]);
        assert_eq!(counted.scenes.iter().map(Scene::row).collect::<Vec<_>>(), [("a, b".to_owned(), vec![100, 150, 8000])]);
        assert!(read("a, b: refused, or not with 10 regions\n").is_err());
    }
}

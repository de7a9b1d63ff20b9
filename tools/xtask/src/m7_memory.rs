//! The memory that a tick and the images take: stack by a bound from the linked images, sizes of the types, flash and RAM; and their table `tests/bench/MEMORY.md`.
//!
//! The counting image is linked for a Cortex-M7 and for x86-64. Linking it proves that nothing in it can panic; here is looked for an allocator, for functions that call
//! themselves, for calls whose target is not known, for functions without a known frame, and, on the Cortex-M7, for whoever computes in f64, which is software there.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::calls::{Below, Image, imports};
use crate::growth::{self, Row};
use crate::m7::no_allocator;
use crate::m7_counts::Counted;
use crate::run::{ask, root};

/// The table.
const TABLE: &str = "tests/bench/MEMORY.md";

/// Command that writes it.
const COMMAND: &str = "cargo xtask m7 costs --accept";

/// Functions below which stack is bounded: what they are, which image, their name in it.
const ROOTS: [(&str, usize, &str); 8] = [
    (TICK[0], 0, "haptor_m7_counts::bench::measured_tick"),
    (TICK[1], 0, "haptor_m7_counts::bench::measured_surface"),
    (RUN, 0, "haptor_m7_counts::bench::run::<haptor_m7_counts::emulated::Counter>"),
    ("a turn of the simulated device: `Device::step`", 1, "device::turn"),
    (DEVICE, 1, "device::__cortex_m_rt_main"),
    ("x86-64: a tick, every tier and shape: `step`", 2, "haptor_m7_counts::bench::measured_tick"),
    ("x86-64: a whole surface: `Prepared::prepare`, `Prepared::update`", 2, "haptor_m7_counts::bench::measured_surface"),
    ("x86-64: a scene made and stepped", 2, "haptor_m7_counts::bench::run::<haptor_m7_counts::hosted::Calls>"),
];

/// What is done in every tick, on a Cortex-M7.
const TICK: [&str; 2] = ["a tick, every tier and shape: `step`", "a whole surface: `Prepared::prepare`, `Prepared::update`"];

/// What is measured as well, by painting.
const RUN: &str = "a scene made and stepped: `Model::new`, `Params::new`, ticks, surfaces";

const DEVICE: &str = "the whole image of the device: `main`";

/// Functions that the compiler did not make, their frames \[bytes\], and what they are.
const BY_HAND: [(&str, u64, &str); 3] = [
    ("__aeabi_uldivmod", 24, "compiler-builtins' assembly: saves two registers, makes room for four words"),
    ("__aeabi_ldivmod", 24, "as __aeabi_uldivmod"),
    (
        ".plt",
        0,
        "x86-64's table of what comes from outside, which is only what OUTSIDE names: calls nothing, keeps nothing on the stack",
    ),
];

/// What the image for x86-64 may take from outside: the C library's copies, and what starts a program.
const OUTSIDE: [&str; 6] = ["memcpy", "memmove", "memset", "bcmp", "__libc_start_main", "__gmon_start__"];

/// Functions that call themselves, and why that ends.
const ONCE: [(&str, &str); 5] = [
    ("haptor_contact::footprint::widest_disc", STAND_IN),
    ("haptor_contact::surface::section::is_round", STAND_IN),
    ("<haptor_contact::surface::section::Section>::of", STAND_IN),
    ("<haptor_contact::model::ObjectShape>::default_fixed_below", STAND_IN),
    ("<haptor_contact::coupling::inertia::Solid>::of", STAND_IN),
];
const STAND_IN: &str = "a mesh asks its stand-in, which is no mesh: once";

/// What the names of functions that compute in f64 by software begin with, on Arm.
const F64: [&str; 7] = ["__aeabi_d", "__aeabi_cd", "__aeabi_f2d", "__aeabi_i2d", "__aeabi_ui2d", "__aeabi_l2d", "__aeabi_ul2d"];

/// The images, in the order of [`ROOTS`].
pub struct Images {
    /// Counts, device, counts for x86-64.
    pub paths: [PathBuf; 3],
}

/// What was found.
pub struct Memory {
    stack: Vec<Row>,
    types: Vec<Row>,
    images: Vec<Row>,
    deepest: Vec<(String, u64)>,
    /// Stack that the deepest scene took \[bytes\].
    measured: u64,
    /// Who computes in f64 in a tick on the Cortex-M7, and by what.
    f64_users: BTreeMap<String, BTreeSet<String>>,
}

/// Looks at the images. `pc` are sizes of types on x86-64.
///
/// # Errors
/// When something in an image is unbounded, allocates, or takes more stack on the Cortex-M7 than its bound.
pub fn look(images: &Images, counted: &Counted, pc: &[(String, u64)]) -> Result<Memory> {
    no_allocator(&images.paths)?;
    images.paths.iter().try_for_each(|path| alone(path))?;
    let known = || BY_HAND.map(|(name, bytes, _)| (name, bytes));
    let read = images.paths.iter().map(|path| Image::read(path, known())).collect::<Result<Vec<_>>>()?;
    let (mut stack, mut f64_users, mut deepest) = (Vec::new(), BTreeMap::<_, BTreeSet<_>>::new(), Vec::new());
    for (what, image, name) in ROOTS {
        let below = read[image].below(name)?;
        bounded(what, &below)?;
        stack.push((what.to_owned(), vec![below.bytes]));
        if TICK.contains(&what) {
            for (of, by) in below.calls.iter().filter(|(of, by)| is_f64(of) && !is_f64(by)) {
                f64_users.entry(by.clone()).or_default().insert(of.clone());
            }
        }
        if deepest.is_empty() {
            deepest = below.path;
        }
    }
    let measured = counted.scenes.iter().map(|scene| scene.stack).max().unwrap_or_default();
    within(&stack, RUN, measured)?;
    let types = counted.sizes.iter().map(|(what, bytes)| {
        let on_pc = pc.iter().find(|row| row.0 == *what).map_or(0, |row| row.1);
        (what.clone(), vec![*bytes, on_pc])
    });
    let images = images.paths.iter().take(2).map(|path| sections(path)).collect::<Result<_>>()?;
    Ok(Memory { stack, types: types.collect(), images, deepest, measured, f64_users })
}

/// A measured stack lies within its bound, or the bound is none.
fn within(stack: &[Row], what: &str, measured: u64) -> Result<()> {
    let bound = stack.iter().find(|row| row.0 == what).map_or(0, |row| row.1[0]);
    if measured > bound {
        bail!("{what}: {measured} bytes of stack were used, more than the {bound} that the image should allow");
    }
    Ok(())
}

/// An image takes nothing from outside but what is allowed: no allocator of C either.
fn alone(path: &Path) -> Result<()> {
    let imports = imports(path)?;
    let stray: Vec<_> = imports.iter().filter(|name| !OUTSIDE.contains(&name.as_str())).collect();
    if stray.is_empty() { Ok(()) } else { bail!("{} takes from outside: {stray:?}", path.display()) }
}

/// Nothing below may be without bound.
fn bounded(what: &str, below: &Below) -> Result<()> {
    let again: Vec<_> = below.recursive.iter().filter(|name| ONCE.iter().all(|known| known.0 != *name)).collect();
    if !again.is_empty() {
        bail!("{what}: these call themselves: {again:?}");
    }
    if !below.unknown.is_empty() {
        bail!("{what}: calls whose target is not known: {:?}", below.unknown);
    }
    if !below.unsized_functions.is_empty() {
        bail!("{what}: the frames of these are not known: {:?}", below.unsized_functions);
    }
    Ok(())
}

fn is_f64(name: &str) -> bool {
    F64.iter().any(|start| name.starts_with(start))
}

/// Flash and RAM of an image: code, constants, data with a value, data without.
fn sections(image: &Path) -> Result<Row> {
    let said = ask("llvm-size", &["-A", &image.display().to_string()]).context("llvm-size says nothing")?;
    let size = |name: &str| {
        let fields =
            said.lines().map(|line| line.split_whitespace().collect::<Vec<_>>()).find(|fields| fields.first() == Some(&name));
        fields.and_then(|fields| fields.get(1)?.parse::<u64>().ok()).unwrap_or(0)
    };
    let name = image.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((name, vec![size(".vector_table") + size(".text"), size(".rodata"), size(".data"), size(".bss")]))
}

/// Whether nothing grew beyond the table; says so in a line.
///
/// # Errors
/// Names what grew, or who computes in f64 and did not before.
pub fn check(memory: &Memory, compiler: &str) -> Result<String> {
    let text = fs::read_to_string(root().join(TABLE)).with_context(|| format!("{TABLE}; make it: {COMMAND}"))?;
    let said = memory.complaints(&text);
    if !said.is_empty() {
        let table = text.lines().find(|line| line.starts_with("Compiler")).unwrap_or_default();
        bail!(
            "{}\n{TABLE} was made with: {table}\nthis is {compiler}. If this is the price of something: {COMMAND}",
            said.join("\n")
        );
    }
    let tick = memory.stack.first().map_or(0, |row| row.1[0]);
    Ok(format!(
        "a tick takes at most {tick} bytes of stack; no recursion, no unknown call, no allocator, no panic path, nothing larger than {TABLE} says"
    ))
}

impl Memory {
    /// What is more than the table of this text allows, a line each.
    fn complaints(&self, text: &str) -> Vec<String> {
        let grown =
            |(found, units): (&[Row], &[&'static str])| growth::complaints(&growth::rows(text, units.len()), found, units);
        let mut said: Vec<_> = self.tables().into_iter().flat_map(grown).collect();
        let new = self.f64_users.iter().filter(|(by, _)| !text.contains(&f64_row(by)));
        said.extend(new.map(|(by, of)| format!("{by} computes in f64, which is software on a Cortex-M7: it calls {of:?}")));
        said
    }

    /// Rows and the names of their numbers.
    fn tables(&self) -> [(&[Row], &[&'static str]); 3] {
        [
            (&self.stack, &["bytes of stack"]),
            (&self.types, &["bytes on a Cortex-M7", "bytes on x86-64"]),
            (&self.images, &["code", "constants", "data", "zeroed"]),
        ]
    }

    /// Whether the stack that the device used in its session lies within the image's bound.
    ///
    /// # Errors
    /// When it does not.
    pub fn check_device(&self, used: usize) -> Result<()> {
        within(&self.stack, DEVICE, used as u64)
    }

    /// Writes the table.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, compiler: &str) -> Result<()> {
        fs::write(root().join(TABLE), self.text(compiler)?).with_context(|| TABLE.to_owned())?;
        println!("{TABLE} written");
        Ok(())
    }

    fn text(&self, compiler: &str) -> Result<String> {
        let mut text = HEAD.to_owned();
        writeln!(text, "Compiler: {compiler}.\n")?;
        text += STACK_HEAD;
        self.stack.iter().try_for_each(|(what, bytes)| writeln!(text, "| {what} | {} |", bytes[0]))?;
        writeln!(text, "\nMeasured by painting, on the emulated Cortex-M7: the deepest scene used {} bytes.", self.measured)?;
        text += "\nThe deepest path of a tick, with each function's frame:\n\n";
        self.deepest.iter().try_for_each(|(name, bytes)| writeln!(text, "- `{name}`: {bytes}"))?;
        text += TYPES_HEAD;
        self.types.iter().try_for_each(|(what, bytes)| writeln!(text, "| {what} | {} | {} |", bytes[0], bytes[1]))?;
        text += IMAGES_HEAD;
        self.images.iter().try_for_each(|(what, b)| writeln!(text, "| {what} | {} | {} | {} | {} |", b[0], b[1], b[2], b[3]))?;
        text += F64_HEAD;
        for (by, of) in &self.f64_users {
            writeln!(text, "{} {} |", f64_row(by), of.iter().map(String::as_str).collect::<Vec<_>>().join(", "))?;
        }
        Ok(text)
    }
}

/// How the row of a function that computes in f64 begins.
fn f64_row(by: &str) -> String {
    format!("| `{by}` |")
}

const HEAD: &str = "\
# The memory of a tick and of the images

Written by `cargo xtask m7 costs --accept`; `cargo xtask m7` fails when a number grows by more than 2 %, and whatever the table says when something below a tick calls itself, calls what is not
known, allocates or can panic. Some functions ask themselves once more for the primitive that stands in for a mesh, and count twice. Release profile of `firmware-sim/cortex-m`.

";

const STACK_HEAD: &str = "\
## Stack

A bound, not a measurement: the deepest sum of frames along the calls of the linked image. Frames are the compiler's, calls are read from the disassembly. An interrupt of a Cortex-M7 with
its floating-point unit adds 104 bytes for each level; these images take none. Rows without a target are the Cortex-M7's. What the device used of its bound `cargo xtask m7 device` tells.

| below | bytes |
|---|---:|
";

const TYPES_HEAD: &str = "
## Types

Nothing is allocated: these are all the memory that a tick knows.

| what | Cortex-M7 [bytes] | x86-64 [bytes] |
|---|---:|---:|
";

const IMAGES_HEAD: &str = "
## Images for the Cortex-M7

Code and constants lie in flash; data with a value in flash and RAM; zeroed data in RAM. *haptor-m7-counts* holds the whole core, every tier, shape and table, and a room of the host's
capacities with two surfaces of 4096 vertices; *device* the simulated device.

| image | code [bytes] | constants [bytes] | data [bytes] | zeroed [bytes] |
|---|---:|---:|---:|---:|
";

const F64_HEAD: &str = "
## f64 in software

The Cortex-M7 meant here computes f32 in hardware and f64 by software, at some hundred instructions an operation. Who does that below a tick or a surface; a function that is not here fails the gate.

| function | calls |
|---|---|
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_bound_fails() {
        let set = |name: &str| BTreeSet::from([name.to_owned()]);
        let told = |below: Below| bounded("a tick", &below).map_err(|error| error.to_string());
        assert_eq!(told(Below::default()), Ok(()));
        assert_eq!(told(Below { recursive: set(ONCE[0].0), ..Below::default() }), Ok(()));
        let unknown = BTreeSet::from([("of".to_owned(), "blx r0".to_owned())]);
        for (below, word) in [
            (Below { unsized_functions: set("by_hand"), ..Below::default() }, "by_hand"),
            (Below { recursive: set("again"), ..Below::default() }, "again"),
            (Below { unknown, ..Below::default() }, "blx r0"),
        ] {
            assert!(told(below).is_err_and(|said| said.contains(word)), "{word}");
        }
    }

    fn memory() -> Memory {
        let row = |name: &str, numbers: &[u64]| vec![(name.to_owned(), numbers.to_vec())];
        Memory {
            stack: row("a tick", &[1000]),
            types: row("a type", &[100, 200]),
            images: row("an image", &[4000, 300, 20, 10]),
            deepest: vec![("tick".to_owned(), 1000)],
            measured: 900,
            f64_users: BTreeMap::from([("math::slow".to_owned(), BTreeSet::from(["__aeabi_dadd".to_owned()]))]),
        }
    }

    #[test]
    fn what_grew_beyond_the_table_is_said_and_what_fell_is_not() {
        let table = memory().text("a compiler").unwrap();
        assert_eq!(memory().complaints(&table), Vec::<String>::new());
        let changed = |change: fn(&mut Memory)| {
            let mut memory = memory();
            change(&mut memory);
            memory.complaints(&table).join("\n")
        };
        assert_eq!(changed(|m| m.stack[0].1[0] = 500), "");
        assert_eq!(changed(|m| m.f64_users.clear()), "");
        for (said, words) in [
            (changed(|m| m.stack[0].1[0] = 1021), "a tick: bytes of stack 1021"),
            (changed(|m| m.types[0].1[1] = 205), "a type: bytes on x86-64 205"),
            (changed(|m| m.images[0].1[3] = 11), "an image: zeroed 11"),
            (changed(|m| m.stack[0].0.push('s')), "a ticks: not in the table"),
            (changed(|m| drop(m.f64_users.insert("math::new".to_owned(), BTreeSet::new()))), "math::new computes in f64"),
        ] {
            assert!(said.contains(words), "{words}: {said}");
        }
        assert!(within(&memory().stack, "a tick", 1000).is_ok() && within(&memory().stack, "a tick", 1001).is_err());
    }
}

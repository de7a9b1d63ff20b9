//! The functions of a linked image: the frame of each, and whom it calls. From that the deepest stack below a function, whether anything calls itself, and where a call's
//! target is not known.
//!
//! Frames are the compiler's own figures (`-Z emit-stack-sizes`), calls are read from the disassembly, so what is judged is what runs. Tools: LLVM's nm, readelf, objdump
//! and cxxfilt, for an Arm Cortex-M and for x86-64.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::run;

/// Debian's package of the tools.
const PACKAGE: &str = "llvm";

/// What comes before a frame on x86-64: the return address \[bytes\]. On Arm it is in a register, and saved as part of the frame.
const RETURN_ADDRESS: u64 = 8;

/// Whom a branch leads to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    /// A function of the image, by its address.
    Function(u64),
    /// A function outside, by its name.
    Outside(String),
    /// What a register or memory holds: the instruction.
    Unknown(String),
}

/// A function of an image.
#[derive(Clone, Debug)]
struct Function {
    name: String,
    end: u64,
    /// Bytes of stack; `None` for one that the compiler did not make.
    frame: Option<u64>,
    calls: BTreeSet<Target>,
}

/// A linked image.
#[derive(Debug)]
pub struct Image {
    functions: BTreeMap<u64, Function>,
    /// Bytes on the stack that each call takes beside frames.
    per_call: u64,
    /// Functions that the compiler did not make, and their frames \[bytes\].
    known: HashMap<String, u64>,
}

/// What can happen below a function.
#[derive(Debug, Default)]
pub struct Below {
    /// Most bytes of stack, its own frame included. A function that calls itself counts twice, one without a frame not at all.
    pub bytes: u64,
    /// The calls that take them, outermost first, each with its frame.
    pub path: Vec<(String, u64)>,
    /// Functions that call themselves, directly or not.
    pub recursive: BTreeSet<String>,
    /// Calls whose target is not known: function and instruction.
    pub unknown: BTreeSet<(String, String)>,
    /// Functions without a frame, in the image or outside.
    pub unsized_functions: BTreeSet<String>,
    /// Every call: whom, and by whom.
    pub calls: BTreeSet<(String, String)>,
}

impl Image {
    /// Reads an image. `known` are the frames of functions that the compiler did not make.
    ///
    /// # Errors
    /// When a tool is missing, or the image was built without frames.
    pub fn read(path: &Path, known: impl IntoIterator<Item = (&'static str, u64)>) -> Result<Self> {
        let frames = frames(&tool("readelf", &["--stack-sizes"], path)?);
        if frames.is_empty() {
            bail!("{} says no stack sizes: was it built with -Z emit-stack-sizes?", path.display());
        }
        let mut functions = functions(&tool("nm", &["--defined-only", "--print-size"], path)?, &frames);
        let text = tool("objdump", &["--disassemble", "--no-show-raw-insn"], path)?;
        add_calls(&mut functions, &text);
        demangle(&mut functions)?;
        let per_call = if text.contains("file format elf64-x86-64") { RETURN_ADDRESS } else { 0 };
        let known: HashMap<_, _> = known.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect();
        for function in functions.values_mut() {
            function.frame = function.frame.or_else(|| known.get(&function.name).copied());
        }
        Ok(Self { functions, per_call, known })
    }

    /// What can happen below the function of this name.
    ///
    /// # Errors
    /// When the image has no such function.
    pub fn below(&self, name: &str) -> Result<Below> {
        let root = self.functions.iter().find(|(_, function)| function.name == name).map(|(&address, _)| address);
        let root = root.with_context(|| format!("the image has no function {name}: has it been inlined?"))?;
        let (mut below, mut walk) = (Below::default(), Walk::default());
        below.bytes = self.depth(root, &mut walk, &mut below);
        let mut next = Some(root);
        while let Some(address) = next {
            let function = &self.functions[&address];
            below.path.push((function.name.clone(), function.frame.unwrap_or(0)));
            next = walk.deepest.get(&address).and_then(|&(_, next)| next);
        }
        Ok(below)
    }

    /// Bytes below a function, depth first; a call back into the path is recursion and counts nothing.
    fn depth(&self, address: u64, walk: &mut Walk, below: &mut Below) -> u64 {
        if let Some(&(bytes, _)) = walk.deepest.get(&address) {
            return bytes;
        }
        let function = &self.functions[&address];
        walk.path.push(address);
        let (mut deepest, mut times) = ((0, None), 1);
        for call in &function.calls {
            match call {
                Target::Function(to) => {
                    below.calls.insert((self.functions[to].name.clone(), function.name.clone()));
                    if let Some(from) = walk.path.iter().position(|on| on == to) {
                        below.recursive.extend(walk.path[from..].iter().map(|on| self.functions[on].name.clone()));
                        times = 2;
                        continue;
                    }
                    let bytes = self.depth(*to, walk, below);
                    deepest = deepest.max((bytes, Some(*to)));
                }
                Target::Outside(name) => {
                    below.calls.insert((name.clone(), function.name.clone()));
                    let Some(bytes) = self.known.get(name) else {
                        below.unsized_functions.insert(name.clone());
                        continue;
                    };
                    deepest = deepest.max((bytes + self.per_call, None));
                }
                Target::Unknown(instruction) => {
                    below.unknown.insert((function.name.clone(), instruction.clone()));
                }
            }
        }
        if function.frame.is_none() {
            below.unsized_functions.insert(function.name.clone());
        }
        walk.path.pop();
        let bytes = deepest.0 + times * (function.frame.unwrap_or(0) + self.per_call);
        walk.deepest.insert(address, (bytes, deepest.1));
        bytes
    }
}

/// Names of what an image takes from outside.
///
/// # Errors
/// When the tool is missing.
pub fn imports(path: &Path) -> Result<BTreeSet<String>> {
    let text = tool("nm", &["--undefined-only", "--just-symbol-name"], path)?;
    Ok(text.lines().map(|line| line.split('@').next().unwrap_or_default().trim().to_owned()).collect())
}

/// Where a walk is, and what it knows.
#[derive(Default)]
struct Walk {
    path: Vec<u64>,
    /// Bytes below a function, and which of its calls takes them.
    deepest: HashMap<u64, (u64, Option<u64>)>,
}

/// Runs one of LLVM's tools on an image; installs them where they are missing and that is possible.
///
/// # Errors
/// When the tool is missing, or does not end well.
pub fn tool(name: &str, options: &[&str], image: &Path) -> Result<String> {
    let program = format!("llvm-{name}");
    if run::ask(&program, &["--version"]).is_none() {
        run::install(&[PACKAGE])?;
    }
    let output = Command::new(&program).args(options).arg(image).output();
    let output = output.with_context(|| format!("{program} cannot be started: install Debian's package {PACKAGE}"))?;
    if !output.status.success() {
        bail!("{program} {}: {}", image.display(), String::from_utf8_lossy(&output.stderr));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Frames by mangled name, from lines `bytes  name, name`.
fn frames(text: &str) -> HashMap<String, u64> {
    let row = |line: &str| {
        let (bytes, names) = line.trim().split_once(char::is_whitespace)?;
        let bytes: u64 = bytes.parse().ok()?;
        Some(names.trim().split(", ").map(move |name| (name.to_owned(), bytes)).collect::<Vec<_>>())
    };
    text.lines().filter_map(row).flatten().collect()
}

/// Functions by address, still with mangled names, from lines `address size kind name`. Of several names for one place the one with a frame stays.
fn functions(text: &str, frames: &HashMap<String, u64>) -> BTreeMap<u64, Function> {
    let mut functions: BTreeMap<u64, Function> = BTreeMap::new();
    for line in text.lines() {
        let fields: Vec<_> = line.split_whitespace().collect();
        let [address, size, "t" | "T" | "w" | "W", name] = fields[..] else { continue };
        let (Ok(address), Ok(size)) = (u64::from_str_radix(address, 16), u64::from_str_radix(size, 16)) else { continue };
        // an address of Thumb code has its lowest bit set; no function begins at an odd one
        let (address, frame) = (address & !1, frames.get(name).copied());
        if frame.is_some() || !functions.contains_key(&address) {
            let function = Function { name: name.to_owned(), end: address + size, frame, calls: BTreeSet::new() };
            functions.insert(address, function);
        }
    }
    functions
}

/// Adds the calls that lines `address: instruction` make.
fn add_calls(functions: &mut BTreeMap<u64, Function>, text: &str) {
    for line in text.lines() {
        let Some((address, instruction)) = line.trim_start().split_once(":") else { continue };
        let Ok(address) = u64::from_str_radix(address, 16) else { continue };
        let Some((&start, function)) = functions.range(..=address).next_back() else { continue };
        if address >= function.end.max(start + 1) {
            continue;
        }
        let target = match leads(instruction.trim()) {
            Leads::On => continue,
            Leads::To(place, is_call, label) => {
                let inside = (start..function.end).contains(&place) && !(is_call && place == start);
                match functions.range(..=place).next_back() {
                    _ if inside => continue,
                    Some((&to, found)) if place < found.end => Target::Function(to),
                    _ => Target::Outside(label),
                }
            }
            Leads::Anywhere => Target::Unknown(instruction.trim().replace('\t', " ")),
        };
        if let Some(function) = functions.get_mut(&start) {
            function.calls.insert(target);
        }
    }
}

/// Where an instruction leads.
#[derive(Debug, PartialEq)]
enum Leads {
    /// To the next one, back to the caller, or about the function by a table.
    On,
    /// To a place, as a call or not; and what the disassembler calls the place.
    To(u64, bool, String),
    /// To where a register or memory says.
    Anywhere,
}

/// Reads an instruction of Arm's Thumb or of x86-64, mnemonic and operands between tabs or blanks.
fn leads(instruction: &str) -> Leads {
    let (mnemonic, operands) = instruction.split_once(char::is_whitespace).unwrap_or((instruction, ""));
    let (mnemonic, operands) = (mnemonic.split('.').next().unwrap_or_default(), operands.trim());
    let is_x86 = mnemonic.starts_with("call") || mnemonic.starts_with('j');
    // blt, ble, bls, blo are branches on a condition
    let is_call = mnemonic.starts_with("call") || mnemonic == "bl" || (mnemonic.len() == 4 && mnemonic.starts_with("bl"));
    let is_branch = is_call
        || is_x86
        || mnemonic == "b"
        || (mnemonic.len() == 3 && CONDITIONS.contains(&mnemonic.get(1..).unwrap_or_default()) && mnemonic.starts_with('b'));
    let place = operands.strip_prefix("0x").and_then(|rest| u64::from_str_radix(rest.split([' ', '\t']).next()?, 16).ok());
    let label =
        || operands.split_once('<').and_then(|(_, rest)| rest.split(['>', '+', '@']).next()).unwrap_or(operands).to_owned();
    let writes_pc = matches!(mnemonic, "mov" | "ldr") && operands.starts_with("pc,") && !operands.contains("[sp]");
    match (is_branch, place) {
        (true, Some(place)) => Leads::To(place, is_call, label()),
        (true, None) => Leads::Anywhere,
        _ if mnemonic.starts_with("blx") || writes_pc => Leads::Anywhere,
        _ if mnemonic.starts_with("bx") && operands != "lr" => Leads::Anywhere,
        _ => Leads::On,
    }
}

/// Conditions of Arm's branches.
const CONDITIONS: [&str; 16] = ["eq", "ne", "hs", "lo", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le"];

/// Names as people write them.
fn demangle(functions: &mut BTreeMap<u64, Function>) -> Result<()> {
    let program = "llvm-cxxfilt";
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().context(program)?;
    let names: Vec<_> = functions.values().map(|function| function.name.clone()).collect();
    let mut stdin = child.stdin.take().context("it was given a pipe")?;
    // it answers while it is still asked: who asks must not be who listens
    let asking = std::thread::spawn(move || std::io::Write::write_all(&mut stdin, names.join("\n").as_bytes()));
    let output = child.wait_with_output()?;
    asking.join().map_err(|_| anyhow::anyhow!("{program} could not be asked"))??;
    for (function, name) in functions.values_mut().zip(String::from_utf8_lossy(&output.stdout).lines()) {
        function.name = name.to_owned();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_of_both_machines_are_read() {
        let to = |place, is_call, label: &str| Leads::To(place, is_call, label.to_owned());
        for (instruction, expected) in [
            ("bl\t0x3b660 <sqrtf> @ imm = #241618", to(0x3b660, true, "sqrtf")),
            ("ble\t0x694 <tick+0x23c> @ imm = #12", to(0x694, false, "tick")),
            ("blo.w\t0x3d8bc <memcpy> @ imm = #-5482", to(0x3d8bc, false, "memcpy")),
            ("bllo\t0x10 <f>", to(0x10, true, "f")),
            ("b\t0x698 <tick+0x240>", to(0x698, false, "tick")),
            ("blx\tr3", Leads::Anywhere),
            ("bx\tr0", Leads::Anywhere),
            ("bx\tlr", Leads::On),
            ("bic\tr0, r1, #0x4", Leads::On),
            ("bfi\tr0, r1, #4, #8", Leads::On),
            ("mov\tpc, r2", Leads::Anywhere),
            ("ldr\tpc, [sp], #4", Leads::On),
            ("pop.w\t{r4, pc}", Leads::On),
            ("callq\t0x2016b0 <memcpy@plt>", to(0x2016b0, true, "memcpy")),
            ("callq\t*%r12", Leads::Anywhere),
            ("jmp\t0x20 <f+0x4>", to(0x20, false, "f")),
            ("jae\t0x20 <f+0x4>", to(0x20, false, "f")),
            ("jmpq\t*%rax", Leads::Anywhere),
            ("retq", Leads::On),
        ] {
            assert_eq!(leads(instruction), expected, "{instruction}");
        }
    }

    const NAMES: &str = "00000100 00000010 t root\n00000110 00000010 t middle\n00000120 00000010 t leaf\n00000130 00000010 t by_hand\n00000140 00000010 t turns\n";
    const FRAMES: &str = "Stack Sizes:\n         Size     Functions\n           40     root\n           16     middle\n          100     leaf\n            8     turns\n";
    const CODE: &str = " 100:\tbl\t0x110 <middle>\n 104:\tbl\t0x130 <by_hand>\n 106:\tb\t0x100 <root>\n 110:\tb.w\t0x120 <leaf>\n 120:\tblx\tr0\n 140:\tbl\t0x140 <turns>\n 144:\tbl\t0x900 <memcpy@plt>\n";

    fn image() -> Image {
        let mut functions = functions(NAMES, &frames(FRAMES));
        add_calls(&mut functions, CODE);
        Image { functions, per_call: 0, known: HashMap::from([("memcpy".to_owned(), 12)]) }
    }

    #[test]
    fn the_deepest_path_and_what_has_no_bound_are_found() {
        let below = image().below("root").unwrap();
        assert_eq!(below.bytes, 156);
        assert_eq!(below.path.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["root", "middle", "leaf"]);
        assert!(below.recursive.is_empty());
        assert_eq!(below.unsized_functions.into_iter().collect::<Vec<_>>(), ["by_hand"]);
        assert_eq!(below.unknown.into_iter().collect::<Vec<_>>(), [("leaf".to_owned(), "blx r0".to_owned())]);
        let below = image().below("turns").unwrap();
        assert_eq!(below.recursive.into_iter().collect::<Vec<_>>(), ["turns"]);
        assert_eq!(below.bytes, 2 * 8 + 12);
        assert!(below.unsized_functions.is_empty());
        assert!(image().below("gone").is_err());
    }
}

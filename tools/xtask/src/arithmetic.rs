//! What a linked image computes with. Two builds give the same bits only if every sum and product is rounded by itself, and if every function of mathematics is the one that
//! comes with the source: so no image may hold a fused multiply-add, an estimate of a reciprocal, or a call of the platform's mathematics library.
//!
//! Read from the disassembly, for x86-64 and for an Arm Cortex-M: what is judged is what runs.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use anyhow::{Result, bail};

use crate::calls::{imports, tool};

/// How instructions begin that round once where two roundings are written: x86-64, Arm with single and double precision, Arm with vectors.
const FUSED: [&str; 12] =
    ["vfmadd", "vfmsub", "vfnmadd", "vfnmsub", "vfma", "vfms", "vfnma", "vfnms", "fmadd", "fmsub", "fnmadd", "fnmsub"];

/// How instructions begin whose results are estimates, of as many bits as the maker of the processor likes.
const ESTIMATES: [&str; 6] = ["rcp", "vrcp", "rsqrt", "vrsqrt", "vrecpe", "frecpe"];

/// The platform's functions of mathematics, without the letter that says the precision. Those that any library must get right to the bit are among them: one way for all.
const MATHEMATICS: [&str; 38] = [
    "acos",
    "acosh",
    "asin",
    "asinh",
    "atan",
    "atan2",
    "atanh",
    "cbrt",
    "ceil",
    "cos",
    "cosh",
    "erf",
    "exp",
    "exp10",
    "exp2",
    "expm1",
    "fdim",
    "floor",
    "fma",
    "fmod",
    "hypot",
    "log",
    "log10",
    "log1p",
    "log2",
    "nearbyint",
    "pow",
    "remainder",
    "rint",
    "round",
    "sin",
    "sincos",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "tgamma",
    "trunc",
];

/// Instructions of an image at least: fewer are no image, but a disassembly in another form than is read here.
const FEWEST: usize = 100;

/// What should not be in an image.
#[derive(Debug, Default, PartialEq, Eq)]
struct Slips {
    /// An instruction, and the function that it is in.
    instructions: BTreeSet<(String, String)>,
    /// Functions of the platform's.
    functions: BTreeSet<String>,
    /// Instructions looked at.
    looked_at: usize,
}

/// Looks at an image; yields how many instructions it has.
///
/// # Errors
/// When there is something in it that should not be, by function and instruction; when a tool is missing.
pub fn check(image: &Path) -> Result<usize> {
    let mut slips = slips(&tool("objdump", &["--disassemble", "--no-show-raw-insn", "--demangle"], image)?);
    slips.functions.extend(imports(image)?.into_iter().filter(|name| is_mathematics(name)));
    if slips.instructions.is_empty() && slips.functions.is_empty() && slips.looked_at >= FEWEST {
        return Ok(slips.looked_at);
    }
    let mut said = format!("{}: {} instructions looked at", image.display(), slips.looked_at);
    for (function, instruction) in &slips.instructions {
        write!(said, "\n  {instruction} in {function}")?;
    }
    for function in &slips.functions {
        write!(said, "\n  calls the platform's {function}")?;
    }
    bail!(
        "{said}\n  two roundings must stay two, and mathematics come from core/contact/src/math.rs: write it out, or leave it to libm's functions there"
    );
}

/// What a disassembly holds: lines `address <function>:` and `address: instruction`.
fn slips(text: &str) -> Slips {
    let (mut slips, mut function) = (Slips::default(), "");
    for line in text.lines() {
        if let Some(name) = line.strip_suffix(">:").and_then(|line| Some(line.split_once(" <")?.1)) {
            function = name;
            continue;
        }
        let Some((address, instruction)) = line.trim_start().split_once(':') else { continue };
        if u64::from_str_radix(address, 16).is_err() {
            continue;
        }
        let instruction = instruction.trim();
        let mnemonic = instruction.split_whitespace().next().unwrap_or_default();
        slips.looked_at += 1;
        if FUSED.iter().chain(&ESTIMATES).any(|begin| mnemonic.starts_with(begin)) {
            slips.instructions.insert((function.to_owned(), instruction.replace('\t', " ")));
        }
        // a call by a bare name: of the platform's, or of what a compiler puts in its place
        if let Some((_, name)) = instruction.split(" @ ").next().and_then(|call| call.strip_suffix('>')?.split_once('<'))
            && is_mathematics(name.strip_suffix("@plt").unwrap_or(name))
        {
            slips.functions.insert(name.to_owned());
        }
    }
    slips
}

/// `sinf`, `sin`, `sinl`, `__sinf_finite`.
fn is_mathematics(name: &str) -> bool {
    let plain = name.trim_start_matches('_');
    let plain = plain.strip_suffix("_finite").unwrap_or(plain);
    let is = |name: &str| MATHEMATICS.contains(&name);
    is(plain) || plain.strip_suffix(['f', 'l']).is_some_and(is)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_slips_into_an_image_is_found() {
        let text = "\nDisassembly of section .text:\n\n0000000000001100 <core::fine>:\n    1100:      \tmulss\t%xmm1, %xmm0\n    1104:\taddss\t%xmm2, %xmm0\n    1108:\tsqrtss\t%xmm0, %xmm0\n\
            0000000000001110 <core::fused>:\n    1110:\tvfmadd213ss\t%xmm2, %xmm1, %xmm0\n    1115:\tcallq\t0x1030 <sinf@plt>\n    1119:\tcallq\t0x1040 <memcpy@plt>\n\
            08000200 <core::thumb>:\n 8000200:\tvmla.f32\ts0, s1, s2\n 8000204:\tvfma.f32\ts0, s1, s2\n 8000208:\tvrsqrte.f32\td0, d1\n 800020c:\tbl\t0x8000300 <fmaf> @ imm = #240\n";
        let found = slips(text);
        let instructions: Vec<_> = found.instructions.iter().map(|(f, i)| (f.as_str(), i.as_str())).collect();
        let expected = [
            ("core::fused", "vfmadd213ss %xmm2, %xmm1, %xmm0"),
            ("core::thumb", "vfma.f32 s0, s1, s2"),
            ("core::thumb", "vrsqrte.f32 d0, d1"),
        ];
        assert_eq!(instructions, expected);
        assert_eq!(
            (found.functions.into_iter().collect::<Vec<_>>(), found.looked_at),
            (vec!["fmaf".to_owned(), "sinf@plt".to_owned()], 10)
        );
    }

    #[test]
    fn the_platform_s_mathematics_is_known_by_every_name() {
        for name in ["sin", "sinf", "__sinf", "__expf_finite", "fmaf", "sqrtl", "fmodf", "round", "floorf"] {
            assert!(is_mathematics(name), "{name}");
        }
        for name in ["memcpy", "signal", "exit", "expand", "__cxa_finalize", "libm", "write", "f", ""] {
            assert!(!is_mathematics(name), "{name}");
        }
    }
}

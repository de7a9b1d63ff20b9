//! `cargo xtask bits`: recordings of every ready scene in every tier, on the dearest inputs that are known, computed again by a debug build, a release and a release for this
//! very processor with all it can do. After every tick the three must have the same digest. The image for this processor is then looked at ([`arithmetic`]): what it may use
//! and does not is what keeps the bits. That the look would find something is shown each time on a piece of code with a fused multiply-add and a sine.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use crate::arithmetic;
use crate::recordings::known_inputs;
use crate::run::{self, ask, cargo, program, target};

/// Has the compiler use everything that this processor has.
const NATIVE: &str = "-Ctarget-cpu=native";

/// The program that computes recordings again.
const PROGRAM: &str = "ticks";

/// What the look at an image must find.
const SLIPS: &str =
    "#[unsafe(no_mangle)]\npub extern \"C\" fn slip(a: f32, b: f32, c: f32) -> f32 {\n    a.mul_add(b, c) + a.sin()\n}\n";

/// A build, and the flags that make it another.
struct Build {
    name: &'static str,
    profile: &'static str,
    flags: Option<&'static str>,
}

const BUILDS: [Build; 3] = [
    Build { name: "debug", profile: "debug", flags: None },
    Build { name: "release", profile: "release", flags: None },
    Build { name: "native", profile: "release", flags: Some(NATIVE) },
];

/// Records, computes again, compares, looks.
///
/// # Errors
/// When two builds differ, by recording and tick; when the image holds what it should not.
pub fn run() -> Result<ExitCode> {
    let folder = target()?.join("bits");
    let recordings = known_inputs(&run::release_tool()?, &folder)?;
    let programs: Result<Vec<PathBuf>> = BUILDS.iter().map(Build::make).collect();
    let programs = programs?;
    let mut said = Vec::new();
    for (build, path) in BUILDS.iter().zip(&programs) {
        said.push((build.name, ticks(path, &recordings)?));
    }
    let ticks = compare(&said)?;
    let features = features()?;
    println!(
        "{} recordings, {ticks} ticks: the same digest after every tick in {}",
        recordings.len(),
        BUILDS.map(|b| b.name).join(", ")
    );
    let [.., native] = programs.as_slice() else { bail!("no builds") };
    let looked_at = arithmetic::check(native)?;
    println!(
        "this processor has {features}; of {looked_at} instructions built for it none is fused or an estimate, nothing calls the platform's mathematics"
    );
    finds_slips(&folder)?;
    println!("a fused multiply-add and a sine of the platform's are found where they are");
    Ok(ExitCode::SUCCESS)
}

impl Build {
    /// Builds the program; yields its path.
    fn make(&self) -> Result<PathBuf> {
        let folder = if self.flags.is_some() { target()?.join(self.name) } else { target()? };
        let mut command = cargo();
        command.args(["build", "--quiet", "-p", "haptor-engine", "--example", PROGRAM, "--target-dir"]).arg(&folder);
        command.args((self.profile == "release").then_some("--release"));
        if let Some(flags) = self.flags {
            command.env("RUSTFLAGS", flags);
        }
        run::run(&mut command)?;
        Ok(folder.join(self.profile).join("examples").join(PROGRAM))
    }
}

/// What a build says of the recordings.
fn ticks(path: &Path, recordings: &[PathBuf]) -> Result<String> {
    let output = program(path).args(recordings).output().with_context(|| format!("{}", path.display()))?;
    if !output.status.success() {
        bail!("{}: {}", path.display(), String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(String::from_utf8(output.stdout)?)
}

/// All say the same; how many ticks that is.
fn compare(said: &[(&str, String)]) -> Result<usize> {
    let Some(((first, expected), others)) = said.split_first() else { bail!("no builds") };
    for (name, found) in others {
        if let Some((a, b)) = expected.lines().zip(found.lines()).find(|(a, b)| a != b) {
            bail!("{first} says `{a}`, {name} says `{b}` (recording, tick, digest)");
        }
        if expected.lines().count() != found.lines().count() {
            bail!("{first} and {name} do not say the same number of ticks");
        }
    }
    match expected.lines().count() {
        0 => bail!("no ticks"),
        ticks => Ok(ticks),
    }
}

/// What this processor has beyond the least of its kind, as far as numbers are concerned.
fn features() -> Result<String> {
    let cfg = ask("rustc", &[NATIVE, "--print", "cfg"]).context("rustc does not say what this processor has")?;
    let feature = |line: &str| Some(line.strip_prefix("target_feature=\"")?.strip_suffix('"')?.to_owned());
    let of_numbers = |name: &String| ["fma", "avx", "sse4", "neon"].iter().any(|begin| name.starts_with(begin));
    let features: Vec<String> = cfg.lines().filter_map(feature).filter(of_numbers).collect();
    Ok(if features.is_empty() { "nothing beyond the least of its kind".to_owned() } else { features.join(", ") })
}

/// The look finds what it looks for.
fn finds_slips(folder: &Path) -> Result<()> {
    let (source, image) = (folder.join("slips.rs"), folder.join("slips.so"));
    fs::write(&source, SLIPS).with_context(|| format!("{}", source.display()))?;
    run::run(
        Command::new("rustc").args(["--edition", "2024", "--crate-type", "cdylib", "-O", NATIVE, "-o"]).arg(&image).arg(&source),
    )?;
    let Err(found) = arithmetic::check(&image) else { bail!("{}: a fused multiply-add and a sine went unseen", image.display()) };
    let found = found.to_string();
    // an instruction of it, or without one a function of the platform's
    if !found.contains("fma") || !found.contains("sinf") {
        bail!("{}: not all was seen: {found}", image.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_tick_that_differs_is_named() {
        let said = |last: &str| format!("a 0 11\na 1 {last}\n");
        assert_eq!(compare(&[("debug", said("22")), ("native", said("22"))]).unwrap(), 2);
        let error = compare(&[("debug", said("22")), ("native", said("23"))]).unwrap_err().to_string();
        assert!(error.contains("native says `a 1 23`"), "{error}");
        let short = said("22").lines().next().map(|line| format!("{line}\n")).unwrap();
        assert!(compare(&[("debug", said("22")), ("native", short)]).is_err());
        assert!(compare(&[("debug", String::new()), ("native", String::new())]).is_err());
    }
}

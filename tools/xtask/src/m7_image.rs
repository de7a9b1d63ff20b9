//! The images for the emulated Cortex-M7: builds them, runs them in QEMU.
//!
//! Three are run to their end. One runs the session of `tests/support/bits.rs` and ends with success only if its digest is the one every PC gives. The other computes a recording again and ends with
//! success only if every bit came out as recorded; its standard output is a recording of its own. The third
//! counts what the scenes of `tests/counts/cases.rs` cost; it is linked for a PC as well.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use anyhow::{Context, Result, bail};

use crate::m7_device;
use crate::m7_memory::Images;
use crate::run::{self, ask, root};

/// Folder of the image's own workspace.
const FOLDER: &str = "firmware-sim/cortex-m";

/// Names of the images.
const SESSION: &str = "haptor-m7";
const REPLAY: &str = "haptor-m7-replay";
const COUNTS: &str = "haptor-m7-counts";

/// The PC that the counting image is linked for as well.
const PC: &str = "x86_64-unknown-linux-gnu";

/// An instruction takes 2^8 ns of the emulated board's time.
const EXACT: [&str; 2] = ["-icount", "shift=8"];

/// The emulator, and Debian's package of it.
pub const EMULATOR: &str = "qemu-system-arm";

/// Cargo's command for the images, with a `recording` also the one that computes it again; their workspace, their target folder and their linker are their own.
pub fn build(target: &str, folder: &Path, recording: Option<&Path>) -> Result<Command> {
    let prefix = format!("CARGO_TARGET_{}", target.to_uppercase().replace('-', "_"));
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.current_dir(root().join(FOLDER));
    command.args(["build", "--release", "--locked", "--target", target]).arg("--target-dir").arg(folder);
    if let Some(recording) = recording {
        command.args(["--features", "replay"]).env("HAPTOR_RECORDING", recording);
    }
    command.env(format!("{prefix}_LINKER"), linker()?);
    command.env(format!("{prefix}_RUSTFLAGS"), "-C link-arg=-Tlink.x -Z emit-stack-sizes").env(NIGHTLY, "1");
    Ok(command)
}

/// Has a released compiler take the option that writes each function's frame into the image.
const NIGHTLY: &str = "RUSTC_BOOTSTRAP";

/// Cargo's command for the counting image on a PC, to be looked at: every call of a known function by its name, no tables of jumps, which look like calls of unknown ones.
pub fn build_for_pc(folder: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.current_dir(root().join(FOLDER));
    command.args(["build", "--release", "--locked", "--target", PC, "--bin", COUNTS, "--target-dir"]).arg(folder);
    let flags = "-Z emit-stack-sizes -Z plt=yes -C relocation-model=static -C jump-tables=no -C link-arg=-lc";
    command.env("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS", flags).env(NIGHTLY, "1");
    command
}

/// The images whose memory is looked at.
pub fn looked_at(target: &str, folder: &Path) -> Images {
    Images { paths: [image(target, folder, COUNTS), image(target, folder, m7_device::IMAGE), image(PC, folder, COUNTS)] }
}

/// The images that hold the core, on the Cortex-M7 and on a PC.
pub fn with_core(target: &str, folder: &Path) -> [PathBuf; 3] {
    [image(target, folder, SESSION), image(target, folder, REPLAY), image(PC, folder, COUNTS)]
}

/// Runs the counting image and yields what it says.
///
/// # Errors
/// When a scene does not come to its end as it must.
pub fn counts(target: &str, folder: &Path) -> Result<String> {
    let (output, _) = emulate(&image(target, folder, COUNTS), &EXACT)?;
    let said = words(&output.stdout);
    if !output.status.success() {
        bail!("the scenes do not come to their end on the emulated Cortex-M7: {said}");
    }
    Ok(said)
}

/// The linker that comes with the host's own toolchain.
fn linker() -> Result<PathBuf> {
    let sysroot = ask("rustc", &["--print", "sysroot"]).context("rustc does not say where it lies")?;
    let host = ask("rustc", &["--print", "host-tuple"]).context("rustc does not say what it runs on")?;
    let linker = Path::new(&sysroot).join("lib/rustlib").join(host).join("bin/rust-lld");
    if linker.is_file() { Ok(linker) } else { bail!("{} is missing: is the toolchain rustup's?", linker.display()) }
}

/// Installs the emulator where it is missing and that is possible.
pub fn have_emulator() -> Result<()> {
    if ask(EMULATOR, &["--version"]).is_none() {
        run::install(&[EMULATOR])?;
    }
    Ok(())
}

/// Runs the session and yields what it says.
///
/// # Errors
/// When its digest is not the expected one.
pub fn session(target: &str, folder: &Path) -> Result<String> {
    let (output, size) = emulate(&image(target, folder, SESSION), &[])?;
    let said = words(&output.stdout) + &words(&output.stderr);
    if !output.status.success() {
        bail!("the image on the emulated Cortex-M7 says `{said}`, which is not the digest in tests/support/bits.rs");
    }
    Ok(format!("{said}, image with symbols {} kB", size / 1024))
}

/// Computes the recording again and yields what the image says, and the recording that it writes.
///
/// # Errors
/// When a tick differs.
pub fn replay(target: &str, folder: &Path) -> Result<(String, Vec<u8>)> {
    let (output, _) = emulate(&image(target, folder, REPLAY), &[])?;
    let said = words(&output.stderr);
    if !output.status.success() {
        bail!("the recording comes out otherwise on the emulated Cortex-M7: {said}");
    }
    Ok((said, output.stdout))
}

fn image(target: &str, folder: &Path, name: &str) -> PathBuf {
    folder.join(target).join("release").join(name)
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().to_owned()
}

/// Runs an image to its end; its size too \[bytes\].
fn emulate(image: &Path, options: &[&str]) -> Result<(Output, u64)> {
    let size = fs::metadata(image).with_context(|| format!("{} was not built", image.display()))?.len();
    have_emulator()?;
    let mut command = Command::new(EMULATOR);
    command.args(["-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial", "none"]).args(options);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(image);
    let output =
        command.output().with_context(|| format!("{EMULATOR} cannot be started: install Debian's package {EMULATOR}"))?;
    Ok((output, size))
}

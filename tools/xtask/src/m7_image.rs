//! The image for the emulated Cortex-M7: builds it, looks that it is free of an allocator, runs it in QEMU.
//!
//! The image runs the session of `tests/support/bits.rs` and ends with success only if its digest is the one every PC gives.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::run::{self, ask, root};

/// Folder of the image's own workspace.
const FOLDER: &str = "firmware-sim/cortex-m";

/// Name of the image.
const IMAGE: &str = "haptor-m7";

/// The emulator, and Debian's package of it.
pub const EMULATOR: &str = "qemu-system-arm";

/// Cargo's command for the image; its workspace, its target folder and its linker are its own.
pub fn build(target: &str, folder: &Path) -> Result<Command> {
    let prefix = format!("CARGO_TARGET_{}", target.to_uppercase().replace('-', "_"));
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.current_dir(root().join(FOLDER));
    command.args(["build", "--release", "--locked", "--target", target]).arg("--target-dir").arg(folder);
    command.env(format!("{prefix}_LINKER"), linker()?);
    command.env(format!("{prefix}_RUSTFLAGS"), "-C link-arg=-Tlink.x");
    Ok(command)
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

/// Runs the image and yields what it says.
pub fn emulate(target: &str, folder: &Path) -> Result<String> {
    let image = folder.join(target).join("release").join(IMAGE);
    let size = fs::metadata(&image).with_context(|| format!("{} was not built", image.display()))?.len();
    have_emulator()?;
    let mut command = Command::new(EMULATOR);
    command.args(["-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial", "none"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(&image);
    let output =
        command.output().with_context(|| format!("{EMULATOR} cannot be started: install Debian's package {EMULATOR}"))?;
    let said = String::from_utf8_lossy(&output.stdout).trim().to_owned() + String::from_utf8_lossy(&output.stderr).trim();
    if !output.status.success() {
        bail!("the image on the emulated Cortex-M7 says `{said}`, which is not the digest in tests/support/bits.rs");
    }
    Ok(format!("{said}, image with symbols {} kB", size / 1024))
}

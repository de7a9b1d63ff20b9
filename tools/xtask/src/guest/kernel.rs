//! Debian's PREEMPT_RT kernel: downloaded by `apt-get`, unpacked, not installed. Kept in the target folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::run::{self, ask};

/// The package that names the newest.
const NEWEST: &str = "linux-image-rt-amd64";

/// Modules of virtual USB, in the order in which they are loaded.
pub const MODULES: [&str; 4] = ["usb-common", "usbcore", "usbip-core", "vhci-hcd"];

/// A kernel to boot.
#[derive(Debug)]
pub struct Kernel {
    /// Its release, as `6.1.0-56-rt-amd64`.
    pub version: String,
    /// What QEMU boots.
    pub image: PathBuf,
    /// Folder that holds its [`MODULES`] somewhere below.
    pub modules: PathBuf,
}

/// The kernel in `folder`, downloaded if it is not there.
pub fn fetch(folder: &Path) -> Result<Kernel> {
    let unpacked = folder.join("kernel");
    if let Some(kernel) = found(&unpacked) {
        return Ok(kernel);
    }
    let package = download(folder).or_else(|_| {
        // lists that are missing, or name a kernel that Debian has replaced since
        run::run(Command::new("apt-get").arg("update"))?;
        download(folder)
    })?;
    let file = deb(folder, &package)?;
    unpack(&file, &unpacked)?;
    fs::remove_file(&file).with_context(|| format!("{}", file.display()))?;
    found(&unpacked).with_context(|| format!("{package} holds no kernel with virtual USB"))
}

/// Downloads the package into `folder`; its name.
fn download(folder: &Path) -> Result<String> {
    let answer = ask("apt-cache", &["depends", NEWEST]).context("apt-cache is missing: this needs Debian or one of its kind")?;
    let package = answer.lines().find_map(|line| line.trim().strip_prefix("Depends: "));
    let package = package.with_context(|| format!("apt-cache knows no {NEWEST}"))?;
    // the sandbox of apt may not write here; what it says of that is no error
    run::run(Command::new("apt-get").args(["download", "-o", "APT::Sandbox::User=root", package]).current_dir(folder))?;
    Ok(package.to_owned())
}

fn deb(folder: &Path, package: &str) -> Result<PathBuf> {
    let files = fs::read_dir(folder)?.flatten().map(|entry| entry.path());
    let is_it = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.starts_with(&format!("{package}_")) && name.ends_with(".deb")
    };
    files.into_iter().find(is_it).with_context(|| format!("{package} was not downloaded"))
}

/// Takes out of the package only what is booted: it has thousands of modules.
fn unpack(file: &Path, into: &Path) -> Result<()> {
    fs::create_dir_all(into)?;
    let mut package = Command::new("dpkg-deb").arg("--fsys-tarfile").arg(file).stdout(Stdio::piped()).spawn()?;
    let contents = package.stdout.take().context("the package's contents")?;
    let wanted = MODULES.map(|name| format!("*/{name}.ko"));
    let mut tar = Command::new("tar");
    tar.args(["-x", "--wildcards", "-C"]).arg(into).arg("./boot/vmlinuz-*").args(wanted).stdin(contents);
    run::run(&mut tar)?;
    if !package.wait()?.success() {
        bail!("{} does not unpack", file.display());
    }
    Ok(())
}

fn found(unpacked: &Path) -> Option<Kernel> {
    let boot = fs::read_dir(unpacked.join("boot")).ok()?;
    boot.flatten().find_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let version = name.strip_prefix("vmlinuz-")?.to_owned();
        let modules = unpacked.join("lib/modules").join(&version);
        modules.is_dir().then(|| Kernel { version, image: entry.path(), modules })
    })
}

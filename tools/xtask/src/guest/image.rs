//! The guest's whole file system, as the kernel unpacks it into memory: a shell, four modules, our programs and the libraries they name.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use super::kernel::{Kernel, MODULES};
use super::{PROGRAMS, What};
use crate::run::{self, ask, root};

/// The shell; statically linked, or it would need libraries before there are any.
const SHELL: &str = "/bin/busybox";

/// Debian's package of it.
const SHELL_PACKAGE: &str = "busybox-static";

/// Folders that exist before anything is mounted.
const FOLDERS: [&str; 7] = ["bin", "lib", "modules", "dev", "proc", "sys", "tmp"];

/// Builds the image; yields its path.
pub fn build(folder: &Path, kernel: &Kernel, programs: &Path, seconds: f64, what: What) -> Result<PathBuf> {
    if !Path::new(SHELL).is_file() {
        run::install(&[SHELL_PACKAGE])?;
    }
    let tree = folder.join("root");
    let _ = fs::remove_dir_all(&tree);
    for name in FOLDERS {
        fs::create_dir_all(tree.join(name))?;
    }
    copy(Path::new(SHELL), &tree.join("bin/busybox")).with_context(|| format!("as root, apt-get install {SHELL_PACKAGE}"))?;
    for name in MODULES {
        copy(&module(&kernel.modules, name)?, &tree.join("modules").join(name))?;
    }
    let ours = PROGRAMS.iter().map(|name| Ok(programs.join(name)));
    let theirs = what.tools().iter().map(|name| in_path(name));
    for program in ours.chain(theirs) {
        with_libraries(&program?, &tree)?;
    }
    counter(&tree.join("lib/malloc_count.so"))?;
    let init = tree.join("init");
    fs::write(&init, script(seconds, what))?;
    fs::set_permissions(&init, fs::Permissions::from_mode(0o755))?;
    pack(&tree, &folder.join("guest.cpio"))
}

/// Builds the library that counts what libusb allocates.
fn counter(into: &Path) -> Result<()> {
    let mut cc = Command::new(std::env::var_os("CC").unwrap_or("cc".into()));
    cc.args(["-O2", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-o"])
        .arg(into)
        .arg(root().join("tests/guest/malloc_count.c"));
    run::run(&mut cc)
}

/// What the kernel starts.
fn script(seconds: f64, what: What) -> String {
    let modules = MODULES.map(|name| format!("insmod /modules/{name}\n")).concat();
    let what = what.argument();
    format!(
        "#!/bin/busybox sh\n\
         /bin/busybox --install -s /bin\n\
         export PATH=/bin\n\
         mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev; mount -t tmpfs tmp /tmp\n\
         {modules}\
         [ \"$(cat /sys/kernel/realtime)\" = 1 ] || echo '@failed|the kernel is not of the real-time kind'\n\
         haptor-guest {seconds} {what} || echo '@failed|haptor-guest ended badly'\n\
         poweroff -f\n"
    )
}

/// A program of this machine.
fn in_path(name: &str) -> Result<PathBuf> {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&folders).map(|folder| folder.join(name)).find(|path| path.is_file());
    found.with_context(|| format!("{name} is not in the path"))
}

/// Copies a program and the libraries that it names.
fn with_libraries(program: &Path, tree: &Path) -> Result<()> {
    let name = program.file_name().context("a program has a name")?;
    copy(program, &tree.join("bin").join(name))?;
    for library in libraries(program)? {
        copy(&library, &tree.join(library.strip_prefix("/")?))?;
    }
    Ok(())
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    let folder = to.parent().context("a file lies in a folder")?;
    fs::create_dir_all(folder)?;
    fs::copy(from, to).with_context(|| format!("cannot copy {}", from.display())).map(drop)
}

fn module(folder: &Path, name: &str) -> Result<PathBuf> {
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder)?.flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_stem().is_some_and(|stem| stem == name) {
                return Ok(path);
            }
        }
    }
    bail!("{} holds no module {name}", folder.display())
}

/// The libraries that a program names, by path: `libc.so.6 => /lib/x86_64-linux-gnu/libc.so.6 (0x...)`.
fn libraries(program: &Path) -> Result<BTreeSet<PathBuf>> {
    let said = ask("ldd", &[&program.to_string_lossy()]).context("ldd cannot tell the libraries (Debian's package libc-bin)")?;
    Ok(said.split_whitespace().filter(|word| word.starts_with('/')).map(PathBuf::from).collect())
}

/// Packs a folder as the kernel wants it, by `cpio`.
fn pack(tree: &Path, into: &Path) -> Result<PathBuf> {
    let mut names = Vec::new();
    list(tree, Path::new("."), &mut names)?;
    let mut cpio = Command::new("cpio");
    cpio.args(["--quiet", "-o", "-H", "newc"]).current_dir(tree).stdin(Stdio::piped()).stdout(File::create(into)?);
    let mut child = cpio.spawn().context("cpio cannot be started")?;
    child.stdin.take().context("cpio's input")?.write_all(names.join("\n").as_bytes())?;
    if !child.wait()?.success() {
        bail!("cpio failed");
    }
    Ok(into.to_owned())
}

fn list(tree: &Path, folder: &Path, names: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(tree.join(folder))?.flatten() {
        let name = folder.join(entry.file_name());
        names.push(name.to_string_lossy().into_owned());
        if entry.path().is_dir() {
            list(tree, &name, names)?;
        }
    }
    Ok(())
}

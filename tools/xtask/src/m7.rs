//! `cargo xtask m7`: core, wire and engine for a Cortex-M7 without an operating system, the proof that nothing in them allocates, on an emulated one a
//! session of the core and a recording computed again, whose bits must be those of a PC; the simulated device on it, with the real host; and what ticks cost there in
//! instructions, stack and size.
//!
//! Two toolchains can do it. Where rustup's target is installed it is used. Where rustup cannot fetch it, Debian's second Rust
//! (packages rustc-web and rust-web-src) builds `core` from source. Which one was used is said.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use crate::arithmetic;
use crate::counting;
use crate::m7_counts::{self, Counted};
use crate::m7_device;
use crate::m7_image;
use crate::m7_memory::{self, Memory};
use crate::recordings::Recordings;
use crate::run::{self, ask, cargo, target};

/// A Cortex-M7 with a floating-point unit of single precision.
const TARGET: &str = "thumbv7em-none-eabihf";

/// What must build for it.
const CRATES: [&str; 3] = ["haptor-contact", "haptor-wire", "haptor-engine"];

/// Debian's packages for a machine whose rustup has no network.
const PACKAGES: [&str; 2] = ["rustc-web", "rust-web-src"];

/// Where Debian puts that compiler.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// What every symbol of Rust's allocator has in its name.
const ALLOCATOR: &[u8] = b"__rust_alloc";

/// How `core` for the target is come by.
enum Toolchain {
    /// rustup's target, ready made.
    Rustup,
    /// Debian's compiler, `core` from its source.
    Debian,
}

/// Builds and looks.
pub fn run() -> Result<ExitCode> {
    let (folder, image) = (target()?.join("m7"), target()?.join("m7-image"));
    let toolchain = toolchain()?;
    match toolchain {
        Toolchain::Rustup => println!("toolchain: rustup's target {TARGET}"),
        Toolchain::Debian => println!("toolchain: {}, core from source", toolchain.compiler()),
    }
    run::run(toolchain.take(&mut build(&folder)))?;
    let libraries = libraries(&folder.join(TARGET).join("release/deps"))?;
    no_allocator(&libraries)?;
    println!("{} libraries for {TARGET}, no allocator in any of them", libraries.len());

    let recordings = Recordings::make(&target()?.join("recordings"))?;
    run::run(toolchain.take(&mut m7_image::build(TARGET, &image, Some(recordings.first()))?))?;
    println!("emulated Cortex-M7: {}, as on a PC", m7_image::session(TARGET, &image)?);
    let (said, written) = m7_image::replay(TARGET, &image)?;
    println!("emulated Cortex-M7: {said}");
    println!("debug, release, Cortex-M7: {}", recordings.check(&written)?);
    let looked = Looked::at(&toolchain, &image)?;
    looked.check()?;
    let instructions = arithmetic_of(&m7_image::with_core(TARGET, &image))?;
    println!(
        "of {instructions} instructions of images with the core none is fused or an estimate, nothing calls a platform's mathematics"
    );
    let used = m7_device::session(TARGET, &image, &m7_device::Args::default())?;
    looked.memory.check_device(used)?;
    Ok(ExitCode::SUCCESS)
}

/// Instructions of the images, none of which may cost bits.
fn arithmetic_of(images: &[PathBuf]) -> Result<usize> {
    images.iter().map(|image| arithmetic::check(image)).sum()
}

/// Only what ticks cost: compared with the tables, or kept in them.
pub fn costs(accept: bool) -> Result<ExitCode> {
    let image = target()?.join("m7-image");
    let toolchain = toolchain()?;
    run::run(toolchain.take(&mut m7_image::build(TARGET, &image, None)?))?;
    let looked = Looked::at(&toolchain, &image)?;
    if !accept {
        looked.check()?;
        return Ok(ExitCode::SUCCESS);
    }
    m7_counts::write(&looked.counted, &looked.compiler)?;
    looked.memory.write(&looked.compiler)?;
    Ok(ExitCode::SUCCESS)
}

/// What the built images cost.
struct Looked {
    counted: Counted,
    memory: Memory,
    compiler: String,
}

impl Looked {
    /// Counts on the emulated Cortex-M7, links the counting image for a PC too, and looks at both and at the device's.
    fn at(toolchain: &Toolchain, image: &Path) -> Result<Self> {
        let counted = m7_counts::count(TARGET, image)?;
        run::run(toolchain.take_source(&mut m7_image::build_for_pc(image))?)?;
        let memory = m7_memory::look(&m7_image::looked_at(TARGET, image), &counted, &sizes_on_pc()?)?;
        Ok(Self { counted, memory, compiler: toolchain.compiler() })
    }

    /// Whether nothing grew beyond the tables; says so.
    fn check(&self) -> Result<()> {
        println!("emulated Cortex-M7: {}", m7_counts::check(&self.counted, &self.compiler)?);
        println!("Cortex-M7 and x86-64: {}", m7_memory::check(&self.memory, &self.compiler)?);
        Ok(())
    }
}

/// Sizes of the types on this PC.
fn sizes_on_pc() -> Result<Vec<(String, u64)>> {
    let target = target()?;
    run::run(cargo().args(["build", "--quiet", "--release", "-p", counting::PROGRAM, "--target-dir"]).arg(&target))?;
    let program = target.join("release").join(counting::PROGRAM);
    let said = ask(&program, &["--sizes"]).with_context(|| format!("{} tells no sizes", program.display()))?;
    let row = |line: &str| line.split_once('\t').and_then(|(what, bytes)| Some((what.to_owned(), bytes.parse().ok()?)));
    Ok(said.lines().filter_map(row).collect())
}

/// Only the device: its image, and a session of the real host on it.
pub fn device(args: &m7_device::Args) -> Result<ExitCode> {
    let image = target()?.join("m7-image");
    run::run(toolchain()?.take(&mut m7_image::build(TARGET, &image, None)?))?;
    m7_image::have_emulator()?;
    m7_device::session(TARGET, &image, args)?;
    Ok(ExitCode::SUCCESS)
}

impl Toolchain {
    /// Has `command` build with this toolchain.
    fn take<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        match self {
            Self::Rustup => command,
            Self::Debian => command.env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1").arg("-Zbuild-std=core"),
        }
    }

    /// Has `command` build for the PC with `core` from its source, so that the options of the build hold for that too.
    fn take_source<'c>(&self, command: &'c mut Command) -> Result<&'c mut Command> {
        match self {
            Self::Rustup if !has_source("rustc") => bail!("no source of core: run `rustup component add rust-src`"),
            Self::Rustup => Ok(command.arg("-Zbuild-std=core")),
            Self::Debian => Ok(self.take(command)),
        }
    }

    /// Which compiler it is.
    fn compiler(&self) -> String {
        let rustc = match self {
            Self::Rustup => "rustc",
            Self::Debian => DEBIAN_RUSTC,
        };
        ask(rustc, &["--version"]).unwrap_or_default()
    }
}

/// The build; its own folder, so that it never disturbs the host's.
fn build(folder: &Path) -> Command {
    let mut command = cargo();
    command.args(["build", "--release", "--lib", "--no-default-features", "--target", TARGET]);
    command.args(CRATES.iter().flat_map(|name| ["-p", *name])).arg("--target-dir").arg(folder);
    command
}

fn toolchain() -> Result<Toolchain> {
    if has_core(Path::new("rustc")) {
        return Ok(Toolchain::Rustup);
    }
    if !has_source(DEBIAN_RUSTC) {
        run::install(&PACKAGES)?;
    }
    if has_source(DEBIAN_RUSTC) {
        return Ok(Toolchain::Debian);
    }
    bail!("no compiler for {TARGET}: run `rustup target add {TARGET}`, or as root `apt-get install {}`", PACKAGES.join(" "))
}

/// Has this compiler a ready-made `core` for the target?
fn has_core(rustc: &Path) -> bool {
    let folder = ask(rustc, &["--print", "target-libdir", "--target", TARGET]);
    folder.is_some_and(|folder| fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()))
}

/// Has this compiler the source of `core` beside it?
fn has_source(rustc: &str) -> bool {
    let sysroot = ask(rustc, &["--print", "sysroot"]);
    sysroot.is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib/src/rust/library/core").is_dir())
}

/// The libraries of a build, `core` and its helpers left out: they define what is looked for.
fn libraries(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("{} cannot be read", folder.display()))?;
    let is_ours = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let of_rust = ["libcore-", "libcompiler_builtins-", "librustc_std_workspace"].iter().any(|start| name.starts_with(start));
        name.ends_with(".rlib") && !of_rust
    };
    let libraries: Vec<_> = entries.flatten().map(|entry| entry.path()).filter(is_ours).collect();
    for name in CRATES {
        let file = format!("lib{}-", name.replace('-', "_"));
        if !libraries.iter().any(|path| path.file_name().is_some_and(|found| found.to_string_lossy().starts_with(&file))) {
            bail!("{} holds no library of {name}", folder.display());
        }
    }
    Ok(libraries)
}

/// Symbol names stand in a library as they are, so looking for the bytes needs no tool.
pub fn no_allocator(libraries: &[PathBuf]) -> Result<()> {
    for path in libraries {
        let bytes = fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        if bytes.windows(ALLOCATOR.len()).any(|window| window == ALLOCATOR) {
            bail!("{} allocates: it names {}", path.display(), String::from_utf8_lossy(ALLOCATOR));
        }
    }
    Ok(())
}

//! `cargo xtask guest`: the real host and the simulated device on a real kernel's USB, in real time, then the drills.
//!
//! ```text
//!  Debian's PREEMPT_RT kernel in QEMU ── vhci: a USB port that is a socket ── haptor-firmware-sim
//!        └─ /dev/bus/usb ── libusb ── haptor-host --rt enforce          haptor-guest starts both and judges what is recorded
//! ```
//! No hardware, no installation of the kernel, no right beyond that to run QEMU. The emulator counts instructions and makes time of them (2 ns each,
//! `-icount`), so a busy machine makes it slow and changes nothing in what it measures: a figure in microseconds is a count of instructions. That
//! makes figures good for comparing and useless as a claim about hardware.

mod image;
mod kernel;
mod report;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result, bail};

use crate::run::{self, ask, cargo, root, target};
use report::Report;

/// What the guest runs.
pub const PROGRAMS: [&str; 3] = ["haptor-host", "haptor-firmware-sim", "haptor-guest"];

/// Tools and Debian's packages of them.
const TOOLS: [(&str, &str, &str); 6] = [
    ("qemu-system-x86_64", "--version", "qemu-system-x86"),
    ("cpio", "--version", "cpio"),
    ("dpkg-deb", "--version", "dpkg"),
    ("tar", "--version", "tar"),
    ("cyclictest", "--help", "rt-tests"),
    ("strace", "--version", "strace"),
];

/// Those of them that are only needed where they run in the guest.
const GUEST_TOOLS: [&str; 2] = ["cyclictest", "strace"];

/// Wall time after which the emulator counts as hung; a loaded machine needs a sixth of it.
const PATIENCE: &str = "3600";

/// What is run in the guest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Sessions over USB.
    Sessions,
    /// The same and the drills.
    Drills,
    /// The host beside cyclictest, and its system calls.
    Latency,
}

impl What {
    /// The guest's argument.
    const fn argument(self) -> &'static str {
        match self {
            Self::Sessions => "",
            Self::Drills => "drills",
            Self::Latency => "latency",
        }
    }

    /// Programs of this machine that it needs in the guest, by their names and Debian's packages.
    const fn tools(self) -> &'static [&'static str] {
        match self {
            Self::Sessions | Self::Drills => &[],
            Self::Latency => &["cyclictest", "strace"],
        }
    }

    /// Where its tables are kept.
    const fn tables(self) -> &'static str {
        match self {
            Self::Sessions | Self::Drills => "tests/guest/DRILLS.md",
            Self::Latency => "tests/guest/LATENCY.md",
        }
    }
}

/// Builds, boots, judges; with `accept` keeps the tables.
pub fn run(seconds: f64, what: What, accept: bool) -> Result<ExitCode> {
    check_tools(what)?;
    let target = target()?;
    let folder = target.join("guest");
    fs::create_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
    let kernel = kernel::fetch(&folder)?;
    let packages = PROGRAMS.iter().flat_map(|name| ["-p", *name]);
    run::run(cargo().args(["build", "--release"]).args(packages).arg("--target-dir").arg(&target))?;
    let image = image::build(&folder, &kernel, &target.join("release"), seconds, what)?;
    let report = boot(&kernel.image, &image)?;
    print!("{}", report.tables());
    if !report.is_good() {
        bail!("{}", report.failures());
    }
    if accept {
        let file = root().join(what.tables());
        fs::write(&file, report.document(what, &kernel.version, seconds)).with_context(|| format!("{}", file.display()))?;
        println!("{} written", file.display());
    }
    Ok(ExitCode::SUCCESS)
}

fn check_tools(what: What) -> Result<()> {
    let wanted = |(tool, _, _): &&(&str, &str, &str)| !GUEST_TOOLS.contains(tool) || what.tools().contains(tool);
    for &(tool, question, package) in TOOLS.iter().filter(wanted) {
        if ask(tool, &[question]).is_none() {
            run::install(&[package])?;
        }
        if ask(tool, &[question]).is_none() {
            bail!("{tool} is missing: as root, apt-get install {package}");
        }
    }
    Ok(())
}

/// Boots the guest and gathers what it tells.
fn boot(kernel: &Path, image: &Path) -> Result<Report> {
    let mut command = Command::new("timeout");
    command.args([PATIENCE, "qemu-system-x86_64", "-M", "q35", "-accel", "tcg,thread=single", "-icount", "shift=1,sleep=off"]);
    command.args(["-cpu", "max", "-smp", "1", "-m", "1G", "-nographic", "-no-reboot", "-net", "none"]);
    command.arg("-kernel").arg(kernel).arg("-initrd").arg(image).args(["-append", "console=ttyS0 quiet panic=-1"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped());
    let mut child = command.spawn().context("`timeout` (Debian's package coreutils) cannot be started")?;
    let console = BufReader::new(child.stdout.take().context("the guest's console")?);
    let mut report = Report::default();
    for line in console.split(b'\n') {
        let line = String::from_utf8_lossy(&line?).trim().to_owned();
        eprintln!("{line}");
        report.take(&line);
    }
    child.wait()?;
    Ok(report)
}

//! The simulated device on an emulated Cortex-M7, its UART a pseudo-terminal, and the real host on the other end.
//!
//! What is judged is counted, not timed: the device says hello and is armed, poses come, the contact is felt, nothing is damaged on the line, and no
//! fault latches but of lateness. How much was in time is told: an emulated UART takes a byte at a time through three threads, some 20 to 60 us
//! each, and a command is some 35 bytes, so at 1 kHz a machine that does anything else falls behind.
//!
//! That the image cannot panic its linking has proved; that it has no allocator is looked for; how deep its stack went is read from the emulator's
//! memory, which the image has painted.

use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::m7_image::EMULATOR;
use crate::run::{self, cargo, root, target};

/// Name of the image.
pub const IMAGE: &str = "device";

/// The scene, and what is changed in it: rubber so soft that the hand is not shaken by a loop of tens of milliseconds.
const SCENE: &str = "tests/scenes/cube-twist.toml";
const SOFTER: [&str; 2] = ["young_modulus = 3.0e6", "young_modulus = 1.0e5"];

/// What a late machine may bring about, in the host's words.
const LATENESS: [&str; 5] = ["none", "pose stale", "too many ticks late", "device watchdog ran out", "device restarted"];

/// Force that only a contact gives \[N\].
const FELT: f64 = 0.3;

/// Where the image's memory begins and ends: `memory.x`.
const RAM: std::ops::Range<u64> = 0x2000_0000..0x2040_0000;

/// What the image paints its stack with, and how much of it: `src/bin/device.rs`.
const PAINT: [u8; 4] = 0xA5A5_5A5A_u32.to_le_bytes();
const PAINTED_BYTES: usize = 32 * 1024;

/// A flag of open(2): a terminal that is opened does not become this program's own.
const O_NOCTTY: i32 = 0o400;

/// Session of the gate.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Args {
    /// Ticks a second that the host asks for
    #[arg(long, default_value_t = 1000)]
    rate: u32,
    /// Length of the session [s]
    #[arg(long, default_value_t = 10)]
    seconds: u32,
}

impl Default for Args {
    fn default() -> Self {
        Self { rate: 1000, seconds: 10 }
    }
}

/// Runs a session on the image that was built into `folder`; yields the bytes of stack that the image used.
pub fn session(triple: &str, folder: &Path, args: &Args) -> Result<usize> {
    let image = folder.join(triple).join("release").join(IMAGE);
    crate::m7::no_allocator(std::slice::from_ref(&image))?;
    let work = folder.join("device-session");
    fs::create_dir_all(&work)?;
    let model = baked(&work)?;
    let host = host()?;
    let mut emulator = Emulator::start(&image)?;
    let port = emulator.port.display().to_string();
    let mut command = Command::new(host);
    // patient: what is looked for is not whether this machine is quick
    command.arg(model).args(["--device", &format!("serial:{port}"), "--rt", "ignore", "--pace", "device", "--hold", "100"]);
    command.args(["--fade", "100", "--rate", &args.rate.to_string(), "--seconds", &args.seconds.to_string()]);
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output().context("haptor-host cannot be started")?;
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    print!("{said}");
    judge(&said)?;
    let stack = emulator.stack(&work.join("ram"))?;
    println!("device on an emulated Cortex-M7: {stack} bytes of stack, no allocator, no panic path, image {}", size(&image)?);
    Ok(stack)
}

/// The softer scene, baked.
fn baked(work: &Path) -> Result<PathBuf> {
    let text = fs::read_to_string(root().join(SCENE)).with_context(|| format!("{SCENE} cannot be read"))?;
    if !text.contains(SOFTER[0]) {
        bail!("{SCENE} has no line `{}` any more", SOFTER[0]);
    }
    let (scene, model) = (work.join("soft.toml"), work.join("soft.model"));
    fs::write(&scene, text.replace(SOFTER[0], SOFTER[1]))?;
    run::run(Command::new(run::tool()?).arg("bake").arg(&scene).arg("-o").arg(&model))?;
    Ok(model)
}

/// The real host, in release: the emulator needs the processor more than a debug build does.
fn host() -> Result<PathBuf> {
    let target = target()?;
    run::run(cargo().args(["build", "--quiet", "--release", "-p", "haptor-host", "--target-dir"]).arg(&target))?;
    Ok(target.join("release/haptor-host"))
}

/// Median round trip above which the emulator does not keep up with the session's clock \[us\]: a hundred ticks at 1 kHz.
const BEHIND_US: f64 = 100_000.0;

/// The host's word for a device that takes nothing.
const DEAF: &str = "link lost";

/// The host's table, row by row.
fn judge(said: &str) -> Result<()> {
    let row = |name: &str| said.lines().find_map(|line| line.strip_prefix(name)).map(str::trim).unwrap_or_default();
    let first = |text: &str| text.split([' ', ',']).find_map(|word| word.parse::<f64>().ok()).unwrap_or_default();
    let (fault, peak) = (row("fault"), first(row("peak contact")));
    // an emulator that is behind takes nothing for a while: then the host finds it deaf
    let behind = first(row("round trip [us]")) > BEHIND_US;
    if !(LATENESS.contains(&fault) || behind && fault == DEAF) {
        bail!("the session on the emulated device ended with `{fault}`, which lateness does not explain");
    }
    if first(row("session")) <= 0.0 || peak < FELT {
        bail!("no contact was felt: the emulated device said no hello, was not armed, or sent no poses");
    }
    if !row("poses").ends_with("0 frames rejected") {
        bail!("frames were damaged on a line that damages none: {}", row("poses"));
    }
    Ok(())
}

fn size(image: &Path) -> Result<String> {
    Ok(format!("with symbols {} kB", fs::metadata(image)?.len() / 1024))
}

/// The emulator at work; ended with this value.
struct Emulator {
    child: Child,
    port: PathBuf,
    /// The port's far side, held open: the emulator looks for a peer only about once a second.
    _held: File,
}

impl Emulator {
    /// Starts it and reads where its UART is. It asks to run before other programs, which it may as root: it stands for hardware.
    fn start(image: &Path) -> Result<Self> {
        let mut command = Command::new("nice");
        command.args(["-n", "-20", EMULATOR, "-M", "mps2-an500", "-display", "none", "-monitor", "stdio", "-serial", "pty"]);
        command.arg("-kernel").arg(image).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().with_context(|| format!("{EMULATOR} cannot be started"))?;
        let said = child.stdout.take().context("it was given a pipe")?;
        let place = BufReader::new(said).lines().map_while(Result::ok).find_map(|line| {
            let at = line.find("/dev/pts/")?;
            line[at..].split(' ').next().map(PathBuf::from)
        });
        let Some(port) = place else {
            let _ = child.kill();
            bail!("{EMULATOR} did not say where its UART is");
        };
        let held = OpenOptions::new().read(true).write(true).custom_flags(O_NOCTTY).open(&port)?;
        Ok(Self { child, port, _held: held })
    }

    /// Ends it; yields the bytes of stack that the image has used so far.
    fn stack(&mut self, dump: &Path) -> Result<usize> {
        let orders = format!("pmemsave {:#x} {:#x} \"{}\"\nquit\n", RAM.start, RAM.end - RAM.start, dump.display());
        self.child.stdin.take().context("it was given a pipe")?.write_all(orders.as_bytes())?;
        self.child.wait()?;
        let ram = fs::read(dump).context("the emulator did not write its memory down")?;
        let from = ram.len() - PAINTED_BYTES;
        // what the image itself used above the paint shifts it down by less than this
        let words: Vec<&[u8]> = ram[from..].chunks_exact(4).collect();
        let painted = words.iter().take_while(|word| **word == PAINT).count();
        if painted == 0 {
            bail!("the image has used more than the {PAINTED_BYTES} bytes of stack that it paints");
        }
        Ok(PAINTED_BYTES - 4 * painted)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(ticks: &str, poses: &str, peak: &str, fault: &str) -> String {
        format!("session          {ticks}\nposes            {poses}\npeak contact     {peak}\nfault            {fault}\n")
    }

    #[test]
    fn lateness_passes_and_nothing_else_does() {
        let (ticks, poses) = ("10.000 s, 10000 ticks at 1000 Hz", "3 lost, 0 out of order, 0 frames rejected");
        for (said, good) in [
            (table(ticks, poses, "4.462 N, 0.0416 N m", "none"), true),
            (table(ticks, poses, "4.462 N, 0.0416 N m", "too many ticks late"), true),
            (table(ticks, poses, "4.462 N, 0.0416 N m", "device over-speed"), false),
            (table(ticks, poses, "0.000 N, 0.0000 N m", "none"), false),
            (table("0.000 s, 0 ticks at 1000 Hz", poses, "4.462 N, 0.0416 N m", "pose stale"), false),
            (table(ticks, "3 lost, 0 out of order, 1 frames rejected", "4.462 N, 0.0416 N m", "none"), false),
            (String::new(), false),
        ] {
            assert_eq!(judge(&said).is_ok(), good, "{said}");
        }
    }
}

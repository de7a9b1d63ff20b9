//! The two programs at the ends of the cable.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::{FromHost, StreamDecoder, Summary, stream_bound};

use crate::Failure;
use crate::ball::ball_on_cube;
use crate::relay::Dice;

/// Mean time between two restarts of the device \[s\].
const RESTART_EVERY_S: u64 = 20;

/// What the device says of itself at its end.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeviceBooks {
    /// Times that its time stood still because the machine was late.
    pub stood_still: u64,
    /// Messages understood.
    pub messages: u64,
    /// Frames not understood.
    pub rejected: u64,
    /// Frames that a restart cut in two.
    pub cut: u64,
    /// Frames sent.
    pub sent: u64,
    /// Frames that nobody took.
    pub dropped: u64,
}

/// Both programs; killed with this value.
#[derive(Debug)]
pub struct Programs {
    folder: PathBuf,
    device: Child,
    host: Option<Child>,
    said_by_host: Option<JoinHandle<Vec<FromHost>>>,
    /// Restarts planned.
    pub restarts: u64,
}

impl Programs {
    /// Builds what is missing, starts the device with its restarts planned, and yields where it is.
    pub fn device(seed: u64, length: Duration) -> Result<(Self, PathBuf), Failure> {
        let folder = std::env::temp_dir().join(format!("haptor-soak-{}", std::process::id()));
        fs::create_dir_all(&folder)?;
        let plan = restarts(seed, length);
        let mut command = Command::new(program("haptor-firmware-sim")?);
        // the watchdog is longer than a stall, shorter than a restart's silence: on a busy machine it would else be all that happens
        command.args(["--script", "press-twist-slide", "--watchdog-ms", "100"]);
        for at in &plan {
            command.args(["--fault", &format!("restart@{at}")]);
        }
        let mut device = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let mut line = String::new();
        BufReader::new(device.stdout.take().ok_or("a pipe")?).read_line(&mut line)?;
        let path = line.trim().strip_prefix("serving pty ").ok_or("the device does not say where it is")?.into();
        Ok((Self { folder, device, host: None, said_by_host: None, restarts: plan.len() as u64 }, path))
    }

    /// Starts the host on the relay's end.
    pub fn start_host(&mut self, port: &Path) -> Result<(), Failure> {
        let model = self.folder.join("ball-on-cube.model");
        let mut file = vec![0; FILE_MAX];
        let n = encode_file(&ball_on_cube(), &mut file)?;
        fs::write(&model, &file[..n])?;
        let mut command = Command::new(program("haptor-host")?);
        command.arg(model).args(["--device", &format!("serial:{}", port.display()), "--rt", "ignore", "--status", "frames"]);
        // the recorder works, its file takes no room
        command.args(["--pace", "device", "--record", "/dev/null", "--blackbox"]).arg(self.folder.join("blackbox"));
        let mut host = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let said = host.stdout.take().ok_or("a pipe")?;
        self.said_by_host = Some(std::thread::spawn(move || listen(said)));
        self.host = Some(host);
        Ok(())
    }

    pub fn host_id(&self) -> Result<u32, Failure> {
        Ok(self.host.as_ref().ok_or("the host has not been started")?.id())
    }

    pub fn device_id(&self) -> u32 {
        self.device.id()
    }

    /// Neither has ended.
    pub fn both_run(&mut self) -> Result<(), Failure> {
        let host = self.host.as_mut().ok_or("the host has not been started")?;
        if let Some(status) = host.try_wait()? {
            return Err(format!("the host has ended by itself: {status}").into());
        }
        match self.device.try_wait()? {
            None => Ok(()),
            Some(status) => Err(format!("the device has ended by itself: {status}").into()),
        }
    }

    /// Asks the host to end.
    pub fn stop_host(&mut self) -> Result<(), Failure> {
        terminate(self.host_id()?)
    }

    /// Waits for the host's end; its last word.
    pub fn host_summary(&mut self) -> Result<Summary, Failure> {
        self.host.as_mut().ok_or("the host has not been started")?.wait()?;
        let said = self.said_by_host.take().ok_or("the host has not been started")?.join().map_err(|_| "the listener failed")?;
        match said.last() {
            Some(FromHost::Summary(summary)) => Ok(*summary),
            last => Err(format!("the host ended without a summary; its last word is {last:?}").into()),
        }
    }

    /// Ends the device; its books.
    pub fn end_device(&mut self) -> Result<DeviceBooks, Failure> {
        terminate(self.device.id())?;
        let mut said = String::new();
        self.device.stderr.take().ok_or("a pipe")?.read_to_string(&mut said)?;
        self.device.wait()?;
        let number = |words: &str| -> Result<u64, Failure> {
            let before = said.split(words).next().filter(|before| before.len() < said.len());
            let word = before.and_then(|before| before.trim_end().rsplit([' ', '\n']).next());
            word.and_then(|word| word.parse().ok())
                .ok_or_else(|| format!("the device does not say how many {words}: {said}").into())
        };
        Ok(DeviceBooks {
            stood_still: number("times stood still")?,
            messages: number("messages")?,
            rejected: number("frames rejected")?,
            cut: number("cut by restarts")?,
            sent: number("frames sent")?,
            dropped: number("frames dropped")?,
        })
    }
}

impl Drop for Programs {
    fn drop(&mut self) {
        for child in self.host.iter_mut().chain([&mut self.device]) {
            let _ = child.kill();
            let _ = child.wait();
        }
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Times of the restarts, by the seed [s after forces are first armed].
fn restarts(seed: u64, length: Duration) -> Vec<String> {
    let (mut dice, mut at_ms, mut plan) = (Dice::new(!seed), 0, Vec::new());
    loop {
        at_ms += 1_000 + dice.below(2_000 * (RESTART_EVERY_S - 1));
        if u128::from(at_ms) >= length.as_millis() {
            return plan;
        }
        plan.push(format!("{}.{:03}", at_ms / 1_000, at_ms % 1_000));
    }
}

/// All that the host says, but for its progress.
fn listen(mut from: ChildStdout) -> Vec<FromHost> {
    let (mut said, mut decoder) = (Vec::new(), StreamDecoder::<{ stream_bound(FromHost::MAX_ENCODED) }>::new());
    let mut bytes = [0; 4096];
    while let Ok(n) = from.read(&mut bytes) {
        if n == 0 {
            break;
        }
        decoder.feed(&bytes[..n], |message| match message {
            FromHost::Progress(_) => {}
            // an hour of faults is many; the last word is what counts
            other => said = vec![other],
        });
    }
    said
}

fn terminate(id: u32) -> Result<(), Failure> {
    let status = Command::new("sh").args(["-c", &format!("kill -TERM {id}")]).status()?;
    status.success().then_some(()).ok_or_else(|| format!("process {id} cannot be ended").into())
}

/// Builds a program beside this one, in the same profile.
fn program(package: &str) -> Result<PathBuf, Failure> {
    let here = std::env::current_exe()?;
    let profile = here.parent().ok_or("this program lies nowhere")?;
    let target = profile.parent().ok_or("this program does not lie in a folder of cargo's")?;
    eprintln!("building {package}");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.current_dir(env!("CARGO_MANIFEST_DIR")).args(["build", "--quiet", "--package", package, "--target-dir"]).arg(target);
    if profile.ends_with("release") {
        cargo.arg("--release");
    }
    let built = cargo.status()?.success();
    std::io::stderr().flush()?;
    built.then(|| profile.join(package)).ok_or_else(|| format!("{package} does not build").into())
}

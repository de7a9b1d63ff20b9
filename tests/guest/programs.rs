//! The two programs under test as processes: started, watched, ended.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

/// After this a program counts as hanging: sessions say how long they last.
const PATIENCE: Duration = Duration::from_secs(10);

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(10);

/// Nanoseconds of an instruction in the guest: `-icount shift=1`.
const NS_PER_INSTRUCTION: u64 = 2;

/// Instructions run in so much of the guest's time.
pub const fn instructions(ran_ns: u64) -> u64 {
    ran_ns / NS_PER_INSTRUCTION
}

/// The simulated device, plugged in and seen by the kernel.
pub struct Sim {
    child: Child,
    stdin: Option<ChildStdin>,
    serial: &'static str,
}

impl Sim {
    /// Plugs it in under the serial number `G1`.
    pub fn start(args: &[&str]) -> Result<Self> {
        Self::start_as("G1", args)
    }

    /// The same under another number.
    pub fn start_as(serial: &'static str, args: &[&str]) -> Result<Self> {
        let mut command = Command::new("/bin/haptor-firmware-sim");
        command.args(["--serve", "vhci", "--serial", serial, "--until-stdin-closes"]).args(args);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let mut line = String::new();
        BufReader::new(child.stdout.take().context("its standard output")?).read_line(&mut line)?;
        let stdin = child.stdin.take();
        let sim = Self { child, stdin, serial };
        until("the kernel sees the device", || Ok(is_plugged_in(serial)))?;
        Ok(sim)
    }

    /// Open files of the process.
    pub fn files(&self) -> Result<usize> {
        files(self.child.id())
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        drop(self.stdin.take());
        let gone = until("the device ends", || Ok(self.child.try_wait()?.is_some()));
        if gone.is_err() {
            println!("@failed|the simulated device hangs");
            let _ = self.child.kill();
        }
        let _ = until("the kernel lets go of the device", || Ok(!is_plugged_in(self.serial)));
    }
}

/// Whether the kernel shows a device of this serial number with its strings and its interface.
fn is_plugged_in(serial: &str) -> bool {
    let Ok(entries) = fs::read_dir("/sys/bus/usb/devices") else { return false };
    let told = |path: PathBuf| fs::read_to_string(path.join("serial")).unwrap_or_default();
    entries.flatten().any(|entry| told(entry.path()).trim() == serial && entry.path().join("bConfigurationValue").exists())
}

/// What a process has used and holds.
#[derive(Clone, Copy, Debug)]
pub struct Account {
    /// Time that its real-time thread ran, in user and kernel mode \[ns\].
    pub ran_ns: u64,
    /// Open files.
    pub files: usize,
    /// Memory held \[kB\].
    pub memory_kb: u64,
    /// Time since boot \[s\].
    pub uptime_s: f64,
}

/// A user without rights.
pub const NOBODY: u32 = 65_534;

/// How a host is started.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options<'a> {
    /// A library loaded before all others.
    pub preload: Option<&'a str>,
    /// As which user.
    pub user: Option<u32>,
}

/// The host.
pub struct Host {
    child: Child,
    seconds: f64,
}

impl Host {
    /// Starts a session; `device` may be followed by further arguments.
    pub fn start(model: &Path, device: &str, seconds: f64, record: &Path) -> Result<Self> {
        Self::start_with(model, device, seconds, record, Options::default())
    }

    /// The same with options.
    pub fn start_with(model: &Path, device: &str, seconds: f64, record: &Path, options: Options<'_>) -> Result<Self> {
        let _ = fs::remove_file(record);
        let _ = fs::remove_file(black_box(record));
        let said = File::create(record.with_extension("said"))?;
        let mut command = Command::new("/bin/haptor-host");
        // who has no right to a device has none to real time either
        let rt = if options.user.is_some() { "ignore" } else { "enforce" };
        command.arg(model).arg("--device").args(device.split(' ')).args(["--rt", rt, "--seconds", &seconds.to_string()]);
        if let Some(library) = options.preload {
            command.env("LD_PRELOAD", library);
        }
        if let Some(user) = options.user {
            command.uid(user).gid(user);
        }
        let child = command.arg("--record").arg(record).stdin(Stdio::null()).stdout(Stdio::null()).stderr(said).spawn()?;
        Ok(Self { child, seconds })
    }

    /// Lets time pass; an error when the host ends meanwhile.
    pub fn run_for(&mut self, seconds: f64) -> Result<()> {
        thread::sleep(Duration::from_secs_f64(seconds.max(0.0)));
        match self.child.try_wait()? {
            Some(status) => bail!("the host has ended early: {status}"),
            None => Ok(()),
        }
    }

    /// Number of the process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Ends it at once.
    pub fn kill(mut self) -> Result<()> {
        self.child.kill()?;
        self.child.wait()?;
        Ok(())
    }

    /// What it has used so far.
    pub fn account(&self) -> Result<Account> {
        let id = self.child.id();
        let status = fs::read_to_string(format!("/proc/{id}/status"))?;
        let memory = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).and_then(|rest| rest.split_whitespace().next());
        let uptime = fs::read_to_string("/proc/uptime")?;
        Ok(Account {
            ran_ns: ran_ns(id)?,
            files: files(id)?,
            memory_kb: memory.context("VmRSS")?.parse()?,
            uptime_s: uptime.split(' ').next().context("uptime")?.parse()?,
        })
    }

    /// Waits for its end; an error when it hangs.
    pub fn end(mut self) -> Result<i32> {
        let begin = Instant::now();
        let patience = Duration::from_secs_f64(self.seconds) + PATIENCE;
        loop {
            if let Some(status) = self.child.try_wait()? {
                return status.code().context("the host was killed");
            }
            if begin.elapsed() > patience {
                self.child.kill()?;
                bail!("the host hangs");
            }
            thread::sleep(LOOK);
        }
    }
}

/// Where the black box of a recording lies.
pub fn black_box(record: &Path) -> PathBuf {
    let mut name = record.as_os_str().to_owned();
    name.push(".blackbox");
    name.into()
}

/// What a host said on standard error.
pub fn said(record: &Path) -> String {
    fs::read_to_string(record.with_extension("said")).unwrap_or_default()
}

fn files(id: u32) -> Result<usize> {
    Ok(fs::read_dir(format!("/proc/{id}/fd"))?.count())
}

fn ran_ns(id: u32) -> Result<u64> {
    let mut text = String::new();
    File::open(task(id, "real-time")?.join("schedstat"))?.read_to_string(&mut text)?;
    Ok(text.split(' ').next().context("schedstat")?.parse()?)
}

/// The kernel's folder of a thread of a process.
pub fn task(id: u32, name: &str) -> Result<PathBuf> {
    for entry in fs::read_dir(format!("/proc/{id}/task"))?.flatten() {
        if fs::read_to_string(entry.path().join("comm"))?.trim() == name {
            return Ok(entry.path());
        }
    }
    bail!("no thread {name}")
}

fn until(what: &str, mut done: impl FnMut() -> Result<bool>) -> Result<()> {
    let begin = Instant::now();
    while !done()? {
        if begin.elapsed() > PATIENCE {
            bail!("waited in vain until {what}");
        }
        thread::sleep(LOOK);
    }
    Ok(())
}

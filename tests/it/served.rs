//! Programs at the two ends of a device link: one that serves a pseudo-terminal, and the host.
//!
//! Time is no part of what is judged: [`PATIENCE`] only ends a test that hangs.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use haptor_host::link::serial::SerialLink;
use haptor_host::link::{AnyLink, Messages, Port, Received};
use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::{FaultRecord, FromDevice, FromHost, Summary, ToDevice};
use haptor_wire::{PoseReport, StreamDecoder, stream_bound};

use crate::cli::built;
use crate::host_rig::ball_on_cube;

/// After this a program counts as hanging and the test fails: many times what a session of some seconds takes.
pub const PATIENCE: Duration = Duration::from_secs(90);

/// Sessions in real time, one after the other.
pub fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until `done`, looking often.
pub fn patiently(what: &str, mut done: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !done() {
        assert!(begin.elapsed() < PATIENCE, "waited in vain until {what}");
        thread::sleep(Duration::from_millis(5));
    }
}

/// Sends a signal, by its name without SIG.
pub fn signal(id: u32, name: &str) {
    assert!(Command::new("sh").args(["-c", &format!("kill -{name} {id}")]).status().unwrap().success());
}

/// A program that serves a device on a pseudo-terminal and says where in its first line; killed when the test ends.
pub struct Served {
    child: Child,
    path: String,
    said: Arc<Mutex<Vec<String>>>,
}

impl Served {
    /// Starts it and reads where it serves.
    pub fn start(command: &mut Command) -> Self {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let said = Arc::new(Mutex::new(Vec::new()));
        for pipe in [listen(child.stdout.take().unwrap()), listen(child.stderr.take().unwrap())] {
            let said = Arc::clone(&said);
            thread::spawn(move || pipe.for_each(|line| said.lock().unwrap().push(line)));
        }
        let place = |line: &String| line.strip_prefix("serving pty ").map(str::to_owned);
        let mut path = None;
        patiently("it says where it serves", || {
            path = said.lock().unwrap().iter().find_map(place);
            path.is_some()
        });
        Self { child, path: path.unwrap(), said }
    }

    /// The device as the host's command line names it.
    pub fn address(&self) -> String {
        format!("serial:{}", self.path)
    }

    /// Opens the port as the host does.
    pub fn connect(&self) -> Peer {
        Peer(Messages::new(Box::new(SerialLink::open(&Port::from(self.path.as_str())).unwrap())))
    }

    /// What it has said so far.
    pub fn said(&self) -> Vec<String> {
        self.said.lock().unwrap().clone()
    }

    /// Asks it to end; yields all it said.
    pub fn end(mut self) -> Vec<String> {
        signal(self.child.id(), "TERM");
        patiently("it ends", || self.child.try_wait().unwrap().is_some());
        // the pipes may lag behind the end
        patiently("its last words", || self.said().iter().any(|line| line.contains("messages")));
        self.said()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn listen(pipe: impl std::io::Read + Send + 'static) -> Box<dyn Iterator<Item = String> + Send> {
    Box::new(BufReader::new(pipe).lines().map_while(Result::ok))
}

/// The host's end of a link, played by a test.
pub struct Peer(Messages);

impl Peer {
    /// Begins on an open link.
    pub fn on(link: AnyLink) -> Self {
        Self(Messages::new(link))
    }

    /// Says something.
    pub fn say(&mut self, message: &ToDevice) {
        self.0.send(message).unwrap();
    }

    /// Gives the link up.
    pub fn into_link(self) -> AnyLink {
        self.0.into_link()
    }

    /// The next message.
    pub fn hear(&mut self) -> FromDevice {
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "the device says nothing");
            if let Received::Message(message) = self.0.receive(Duration::from_millis(100)).expect("the link holds") {
                return message;
            }
        }
    }

    /// The next message that is not a pose.
    pub fn hear_words(&mut self) -> FromDevice {
        loop {
            let message = self.hear();
            if !matches!(message, FromDevice::Pose(_)) {
                return message;
            }
        }
    }

    /// The first pose that satisfies `wanted`, out of the next `within`; anything but poses fails.
    pub fn pose(&mut self, within: u32, wanted: impl Fn(&PoseReport) -> bool) -> PoseReport {
        let mut last = None;
        for _ in 0..within {
            match self.hear() {
                FromDevice::Pose(pose) if wanted(&pose) => return pose,
                FromDevice::Pose(pose) => last = Some(pose),
                other => panic!("{other:?} in place of a pose"),
            }
        }
        panic!("none of {within} poses is the one wanted; the last is {last:?}");
    }
}

/// The reference scene, baked into a file.
pub fn model(folder: &Path) -> String {
    let path = folder.join("ball-on-cube.model");
    let mut file = vec![0; FILE_MAX];
    let n = encode_file(&ball_on_cube(), &mut file).unwrap();
    fs::write(&path, &file[..n]).unwrap();
    path.to_str().unwrap().to_owned()
}

/// What a host said in a session.
#[derive(Debug, Default)]
pub struct Told {
    pub code: Option<i32>,
    pub summary: Option<Summary>,
    pub faults: Vec<FaultRecord>,
    pub complained: String,
}

/// The command that starts the real host as tests do.
pub fn host_command(model: &str, device: &str, args: &[&str]) -> Command {
    let mut command = Command::new(built("haptor-host"));
    command.args([model, "--device", device, "--rt", "ignore", "--status", "frames"]).args(args);
    command
}

/// Runs the real host to its end.
pub fn host(model: &str, device: &str, args: &[&str]) -> Told {
    let output = host_command(model, device, args).stdin(Stdio::null()).output().unwrap();
    let complained = String::from_utf8_lossy(&output.stderr).into_owned();
    let mut told = Told { code: output.status.code(), complained, ..Told::default() };
    let mut decoder = StreamDecoder::<{ stream_bound(FromHost::MAX_ENCODED) }>::new();
    decoder.feed(&output.stdout, |message| match message {
        FromHost::Hello(_) | FromHost::Progress(_) => {}
        FromHost::Fault(fault) => told.faults.push(fault),
        FromHost::Summary(summary) => told.summary = Some(summary),
    });
    told
}

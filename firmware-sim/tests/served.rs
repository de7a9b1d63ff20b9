//! The binary as hosts meet it: a process behind a pseudo terminal or a TCP port, with its drills.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use haptor_wire::{
    DeviceHello, FaultCause, FromDevice, HostHello, Mode, PROTOCOL_VERSION, PoseReport, SCHEMA_HASH, StreamDecoder, ToDevice,
    WrenchCommand, encode_stream,
};

/// After this a peer that says nothing is taken for hung, and the test fails.
const PATIENCE: Duration = Duration::from_secs(20);

/// Where the watchdog is not the point, a busy machine must not trip it.
const PATIENT: [&str; 2] = ["--watchdog-ms", "8000"];

/// A process that is being started holds a copy of every open port until it is fully there, so a port closed meanwhile stays open and
/// locked for that long. Starting and closing take turns.
fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The process; killed when the test ends, however it ends.
struct Sim {
    child: Child,
    place: String,
}

impl Sim {
    fn start(args: &[&str]) -> Self {
        let turn = turn();
        let mut child = Command::new(env!("CARGO_BIN_EXE_haptor-firmware-sim"))
            .args(PATIENT)
            .args(args)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        drop(turn);
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let place = line.trim().strip_prefix("serving ").unwrap().to_owned();
        Self { child, place }
    }

    fn connect(&self) -> Host {
        let (kind, at) = self.place.split_once(' ').unwrap();
        let port: Box<dyn Port> = match kind {
            "pty" => Box::new(serialport::new(at, 115_200).timeout(Duration::from_millis(50)).open_native().unwrap()),
            "tcp" => {
                let stream = TcpStream::connect(at).unwrap();
                stream.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
                Box::new(stream)
            }
            other => panic!("{other}"),
        };
        Host { port, decoder: StreamDecoder::new(), inbox: Vec::new(), seq: 0 }
    }

    fn exit_code(&mut self) -> Option<i32> {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.code();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("the process does not end");
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

trait Port: Read + Write {}
impl<T: Read + Write> Port for T {}

struct Host {
    port: Box<dyn Port>,
    decoder: StreamDecoder<64>,
    inbox: Vec<FromDevice>,
    seq: u32,
}

impl Drop for Host {
    fn drop(&mut self) {
        let _turn = turn();
        self.port = Box::new(std::io::empty());
    }
}

impl Host {
    fn say(&mut self, message: &ToDevice) {
        let mut out = [0; 64];
        let n = encode_stream(message, &mut out).unwrap();
        self.port.write_all(&out[..n]).unwrap();
    }

    /// The next message; `None` when the device has gone.
    fn hear(&mut self) -> Option<FromDevice> {
        let begin = Instant::now();
        while self.inbox.is_empty() {
            assert!(begin.elapsed() < PATIENCE, "the device says nothing");
            let mut bytes = [0; 1024];
            let n = match self.port.read(&mut bytes) {
                Ok(0) => return None,
                Ok(n) => n,
                Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => 0,
                Err(_) => return None,
            };
            let inbox = &mut self.inbox;
            self.decoder.feed(&bytes[..n], |message| inbox.push(message));
        }
        Some(self.inbox.remove(0))
    }

    fn hear_until<T>(&mut self, mut pick: impl FnMut(&FromDevice) -> Option<T>) -> T {
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "what is waited for does not come");
            let message = self.hear().expect("the device has gone");
            if let Some(found) = pick(&message) {
                return found;
            }
        }
    }

    fn pose(&mut self) -> PoseReport {
        self.hear_until(|message| match message {
            FromDevice::Pose(pose) => Some(*pose),
            _ => None,
        })
    }

    /// Reset, hello, force; and the first report in force.
    fn open(&mut self) -> DeviceHello {
        self.say(&ToDevice::SetMode(Mode::Reset));
        self.say(&ToDevice::Hello(HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 }));
        let hello = self.hear_until(|message| match message {
            FromDevice::Hello(hello) => Some(*hello),
            _ => None,
        });
        self.say(&ToDevice::SetMode(Mode::Force));
        hello
    }

    /// Answers a report with no force.
    fn answer(&mut self, pose: &PoseReport) {
        self.seq += 1;
        self.say(&ToDevice::Wrench(WrenchCommand {
            seq: self.seq,
            echo: pose.seq,
            force_un: [0; 3],
            torque_unm: [0; 3],
            hold_us: 5000,
        }));
    }

    /// Runs the loop until a report satisfies `done`.
    fn run_until(&mut self, mut done: impl FnMut(&PoseReport) -> bool) -> PoseReport {
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "what is waited for does not come");
            let pose = self.pose();
            if done(&pose) {
                return pose;
            }
            self.answer(&pose);
        }
    }
}

#[test]
fn hosts_come_and_go_over_a_pty_and_over_tcp() {
    // a terminal keeps what the host before left unread, and that may begin within a frame; a connection begins with a frame
    for (place, cut) in [("pty", 1), ("tcp:127.0.0.1:0", 0)] {
        let sim = Sim::start(&["--serve", place, "--preset", "sigma7", "--serial", "SN42"]);
        for visit in 0..3 {
            let mut host = sim.connect();
            let hello = host.open();
            assert!(hello.name_chars().eq("sigma7".chars()), "{place}");
            assert!(hello.serial_chars().eq("SN42".chars()), "{place}");
            let last = host.run_until(|pose| pose.mode == Mode::Force && pose.echo >= 200);
            assert_eq!(last.flags, 0, "{place}, visit {visit}");
            let rejected = host.decoder.counts().rejected();
            assert!(rejected <= cut, "{place}, visit {visit}: {rejected} frames rejected");
        }
    }
}

#[test]
fn the_hand_moves_once_forces_are_armed() {
    let sim = Sim::start(&["--serve", "pty"]);
    let mut host = sim.connect();
    host.open();
    assert_eq!(host.pose().position_nm, [0; 3]);
    host.run_until(|pose| pose.position_nm[2] < -4_000_000);
}

#[test]
fn a_host_that_stops_answering_trips_the_watchdog() {
    let sim = Sim::start(&["--serve", "tcp:127.0.0.1:0", "--watchdog-ms", "30"]);
    let mut host = sim.connect();
    host.open();
    let fault = host.hear_until(|message| match message {
        FromDevice::Fault(fault) => Some(*fault),
        _ => None,
    });
    assert_eq!(fault.cause, FaultCause::Watchdog);
    assert_eq!(host.pose().mode, Mode::Brake);
}

#[test]
fn a_stall_ends_in_the_brake() {
    let sim = Sim::start(&["--fault", "stall@0.1:50ms", "--watchdog-ms", "30"]);
    let mut host = sim.connect();
    host.open();
    let pose = host.run_until(|pose| pose.mode == Mode::Brake);
    assert_eq!(pose.flags, PoseReport::FLAG_WATCHDOG);
}

#[test]
fn after_garbage_both_ends_are_in_step_again() {
    let sim = Sim::start(&["--serve", "pty", "--fault", "garbage@0.1:20ms", "--seed", "7"]);
    let mut host = sim.connect();
    host.open();
    let before = host.run_until(|pose| pose.echo >= 80);
    host.run_until(|pose| pose.seq >= before.seq + 100);
    let counts = host.decoder.counts();
    assert!(counts.rejected() > 0, "{counts:?}");
    assert!(counts.accepted > 150, "{counts:?}");
}

#[test]
fn a_kick_trips_over_speed() {
    let sim = Sim::start(&["--serve", "pty", "--fault", "kick@0.1"]);
    let mut host = sim.connect();
    host.open();
    let pose = host.run_until(|pose| pose.mode == Mode::Brake);
    assert_eq!(pose.flags, PoseReport::FLAG_OVER_SPEED);
}

#[test]
fn a_restarted_device_is_silent_until_greeted_and_counts_anew() {
    let sim = Sim::start(&["--serve", "tcp:127.0.0.1:0", "--fault", "restart@0.1"]);
    let mut host = sim.connect();
    host.open();
    // the answer to a message out of turn is the first that a restarted device says
    let fault = loop {
        match host.hear().unwrap() {
            FromDevice::Pose(pose) => host.answer(&pose),
            FromDevice::Fault(fault) => break fault,
            FromDevice::Hello(hello) => panic!("{hello:?}"),
        }
    };
    assert_eq!(fault.cause, FaultCause::Protocol);
    host.open();
    assert!(host.pose().seq < 20);
}

#[test]
fn a_device_that_dies_is_gone() {
    for place in ["pty", "tcp:127.0.0.1:0"] {
        let mut sim = Sim::start(&["--serve", place, "--fault", "die@0.1"]);
        let mut host = sim.connect();
        host.open();
        while let Some(message) = host.hear() {
            let FromDevice::Pose(pose) = message else {
                continue;
            };
            host.seq += 1;
            // the write may find it gone before the read does
            let mut out = [0; 64];
            let command = ToDevice::Wrench(WrenchCommand {
                seq: host.seq,
                echo: pose.seq,
                force_un: [0; 3],
                torque_unm: [0; 3],
                hold_us: 5000,
            });
            let n = encode_stream(&command, &mut out).unwrap();
            if host.port.write_all(&out[..n]).is_err() {
                break;
            }
        }
        assert_eq!(sim.exit_code(), Some(0), "{place}");
    }
}

#[test]
fn it_ends_when_its_time_is_up_or_its_parent_has_gone() {
    let mut timed = Sim::start(&["--seconds", "0.05"]);
    assert_eq!(timed.exit_code(), Some(0));

    let mut tied = Sim::start(&["--until-stdin-closes"]);
    assert!(tied.child.try_wait().unwrap().is_none());
    drop(tied.child.stdin.take());
    assert_eq!(tied.exit_code(), Some(0));
}

#[test]
fn signals_end_it_in_order_and_ctrl_c_is_its_parent_s_when_it_has_one() {
    let send = |sim: &Sim, signal: &str| {
        let line = format!("kill -{signal} {}", sim.child.id());
        let _turn = turn();
        assert!(Command::new("sh").args(["-c", &line]).status().unwrap().success());
    };
    for signal in ["TERM", "INT", "HUP"] {
        let mut sim = Sim::start(&[]);
        send(&sim, signal);
        assert_eq!(sim.exit_code(), Some(0), "{signal}");
    }
    let mut tied = Sim::start(&["--until-stdin-closes"]);
    send(&tied, "INT");
    let mut host = tied.connect();
    host.open();
    host.run_until(|pose| pose.mode == Mode::Force);
    send(&tied, "TERM");
    assert_eq!(tied.exit_code(), Some(0));
}

#[test]
fn bad_usage_exits_2_and_says_what_is_there() {
    let table = [
        (&["--preset", "falcon"][..], "premium15"),
        (&["--script", "dance"], "press-twist-slide"),
        (&["--serve", "usb"], "tcp:"),
        (&["--fault", "flood@1"], "garbage"),
        (&["--serve", "tcp:192.0.2.1:9"], "192.0.2.1:9"),
    ];
    for (args, hint) in table {
        let _turn = turn();
        let out = Command::new(env!("CARGO_BIN_EXE_haptor-firmware-sim")).args(args).output().unwrap();
        assert_eq!(out.status.code(), Some(2), "{args:?}");
        assert_eq!(out.stdout, b"", "{args:?}");
        let said = String::from_utf8(out.stderr).unwrap();
        assert!(said.contains(hint), "{args:?}: {said}");
    }
}

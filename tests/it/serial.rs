//! The device link on a pseudo-terminal as on a bad cable: noise between frames, frames cut short, bytes that come as they like, a port
//! that goes and comes back under its name.

use std::fs;
use std::os::fd::OwnedFd;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use haptor_host::link::serial::SerialLink;
use haptor_host::link::{Messages, Port, Received};
use haptor_host::rt::flags;
use haptor_wire::recording::RecordReader;
use haptor_wire::{
    DeviceFault, FaultCause, FaultRecord, FromDevice, HostFault, Mode, PoseReport, Record, TickRecord, decode_stream,
    encode_stream, stream_bound,
};
use rustix::io::{Errno, ioctl_fionbio};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use crate::cli::built;
use crate::host_rig::length;
use crate::served::{Served, alone, host_command, model, patiently, signal};
use crate::support::noise::noise;

/// Bytes of the longest frame from a device.
const FRAME: usize = stream_bound(FromDevice::MAX_ENCODED);

/// The controlling end of a pseudo-terminal, and the host's messages on the other.
fn cable() -> (OwnedFd, Messages) {
    let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&device).unwrap();
    unlockpt(&device).unwrap();
    let path = ptsname(&device, Vec::new()).unwrap().into_string().unwrap();
    let link = SerialLink::open(&Port::from(path.as_str())).unwrap();
    (device, Messages::new(Box::new(link)))
}

/// Whole numbers that look random, below a bound, from a seed.
struct Dice(u32);

impl Dice {
    fn below(&mut self, bound: usize) -> usize {
        self.0 += 1;
        (((noise(self.0) + 1.0) * 0.5 * bound as f32) as usize).min(bound - 1)
    }

    fn bytes(&mut self, n: usize) -> Vec<u8> {
        (0..n).map(|_| self.below(256) as u8).collect()
    }
}

fn message(seq: u32) -> FromDevice {
    if seq.is_multiple_of(7) {
        return FromDevice::Fault(DeviceFault { cause: FaultCause::Hardware, seq, detail: -1 });
    }
    FromDevice::Pose(PoseReport {
        seq,
        t_us: seq.wrapping_mul(1000),
        position_nm: [0, i32::MAX, -5_400_000 + seq as i32],
        rotation_q30: [1 << 30, 0, 0, -1],
        buttons: 0,
        mode: Mode::Force,
        flags: 0,
        echo: seq,
    })
}

fn frame(seq: u32) -> Vec<u8> {
    let mut out = [0; FRAME];
    let n = encode_stream(&message(seq), &mut out).unwrap();
    out[..n].to_vec()
}

/// A stretch of line: whole frames, noise, cut frames, flipped bits, idle zeros, in an order of the dice's.
fn stretch(dice: &mut Dice, pieces: u32) -> Vec<u8> {
    let mut line = Vec::new();
    for seq in 0..pieces {
        let mut piece = frame(seq);
        match dice.below(10) {
            0 => {
                let n = dice.below(2 * FRAME);
                line.extend(dice.bytes(n));
            }
            1 => piece.truncate(dice.below(piece.len())),
            2 => {
                let at = dice.below(piece.len());
                piece[at] ^= 1 << dice.below(8);
            }
            3 => piece.insert(0, 0),
            4 => drop(piece.drain(..dice.below(4))),
            _ => {}
        }
        line.extend(piece);
    }
    line.push(0);
    line
}

/// What a stretch says, by the rule alone: between zeros is a frame, or it is not.
fn expected(line: &[u8]) -> (Vec<FromDevice>, u32) {
    let (mut said, mut rejected) = (Vec::new(), 0);
    for piece in line.split(|&byte| byte == 0).filter(|piece| !piece.is_empty()) {
        let read = (piece.len() <= FRAME).then(|| decode_stream::<FromDevice>(&mut piece.to_vec()).ok()).flatten();
        match read {
            Some(message) => said.push(message),
            None => rejected += 1,
        }
    }
    (said, rejected)
}

/// Writes in pieces of the dice's, as far as the line has room, and reads what has come in between, until all of `line` is through and silence follows.
fn through(device: &OwnedFd, messages: &mut Messages, line: &[u8], dice: &mut Dice) -> Vec<FromDevice> {
    let (mut said, mut sent) = (Vec::new(), 0);
    loop {
        if sent < line.len() {
            let end = line.len().min(sent + 1 + dice.below(300));
            sent += match rustix::io::write(device, &line[sent..end]) {
                Err(Errno::AGAIN) => 0,
                written => written.unwrap(),
            };
        }
        match messages.receive(Duration::ZERO).unwrap() {
            Received::Message(message) => said.push(message),
            Received::Nothing if sent == line.len() => return said,
            Received::Part | Received::Nothing => {}
        }
    }
}

#[test]
fn after_any_damage_the_next_whole_frame_is_read_and_all_else_is_counted() {
    for seed in 0..20 {
        let (device, mut messages) = cable();
        // one thread does both: a full line must not stop it before it has read
        ioctl_fionbio(&device, true).unwrap();
        let mut dice = Dice(seed * 100_000);
        let line = stretch(&mut dice, 400);
        let (wanted, rejected) = expected(&line);
        assert!(wanted.len() > 200 && rejected > 60, "{} read, {rejected} not", wanted.len());
        // the last bytes may still be on their way when the line looks silent
        let mut said = through(&device, &mut messages, &line, &mut dice);
        while said.len() < wanted.len() || messages.rejected() < rejected {
            match messages.receive(Duration::from_secs(20)).unwrap() {
                Received::Message(message) => said.push(message),
                Received::Part => {}
                Received::Nothing => break,
            }
        }
        assert!(said == wanted, "seed {seed}: {} of {}", said.len(), wanted.len());
        assert_eq!(messages.rejected(), rejected, "seed {seed}");
    }
}

/// Ticks and faults recorded so far.
fn recorded(path: &Path) -> (Vec<TickRecord>, Vec<FaultRecord>) {
    let (mut ticks, mut faults) = (Vec::new(), Vec::new());
    for record in RecordReader::new(&mut fs::read(path).unwrap_or_default()) {
        match record {
            Ok(Record::Tick(tick)) => ticks.push(tick),
            Ok(Record::Fault(fault)) => faults.push(fault),
            _ => {}
        }
    }
    (ticks, faults)
}

fn device() -> Served {
    let mut command = Command::new(built("haptor-firmware-sim"));
    Served::start(command.args(["--script", "press", "--watchdog-ms", "8000"]))
}

/// As /dev/serial/by-id keeps a link for a device: to whichever port it has now.
fn relink(to: &Served, link: &Path) {
    let _ = fs::remove_file(link);
    symlink(to.address().strip_prefix("serial:").unwrap(), link).unwrap();
}

#[test]
fn a_port_that_vanishes_and_comes_back_under_its_name_is_used_again() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let (link, recording) = (folder.path().join("by-id"), folder.path().join("s.rec"));
    let first = device();
    relink(&first, &link);
    let args = ["--hold", "100", "--fade", "100", "--record", recording.to_str().unwrap()];
    let mut command = host_command(&model(folder.path()), &format!("serial:{}", link.display()), &args);
    let mut host = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let presses = |tick: &TickRecord| length(tick.force) > 3.0;
    patiently("the hand presses", || recorded(&recording).0.iter().any(presses));
    drop(first);
    let lost = |fault: &FaultRecord| fault.cause == HostFault::LinkLost;
    patiently("the loss is told", || recorded(&recording).1.iter().any(lost));
    let second = device();
    relink(&second, &link);
    let again = || {
        let (ticks, _) = recorded(&recording);
        let closed = ticks.iter().rposition(|tick| tick.flags & flags::CLOSED != 0).expect("it was closed");
        ticks[closed..].iter().any(presses)
    };
    patiently("the hand presses on the second device", again);
    signal(host.id(), "TERM");
    patiently("the host ends", || host.try_wait().unwrap().is_some());
}

//! A cable with faults between two pseudo-terminals: the host on one end, the device on the other, and a ledger of every frame.
//!
//! A frame is what a zero ends. Each is passed on, dropped, damaged by one bit, repeated, or kept back until the one after it has gone; now and
//! then the whole cable stands still for a while and then delivers everything at once. What happens depends on the seed and on how many frames came
//! before. No damage makes or takes a zero, so a damaged frame is one frame, and its receiver rejects exactly one.

use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use haptor_host::rt::tracker::{Order, Tracker};
use haptor_wire::{FromDevice, ToDevice, decode_stream};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, fcntl_setfl};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use serde::de::DeserializeOwned;

/// How often a frame meets each fault [1/10000]: at 1 kHz some three faults a second each way, so that sessions break, recover and go on.
const DROP: u64 = 10;
const DAMAGE: u64 = 10;
const DOUBLE: u64 = 5;
const DELAY: u64 = 5;

/// How often a frame begins a stall [1/10000]: every ten seconds or so, counting both ways.
const STALL: u64 = 1;

/// Longest stall \[ms\]: the wrench has been held and faded by then, and the device's watchdog may have run out.
const LONGEST_STALL_MS: u64 = 80;

/// Bytes read at once.
const READ_BYTES: usize = 4096;

/// SplitMix64 (Steele, Lea & Flood 2014).
#[derive(Debug)]
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % bound
    }

    fn happens(&mut self, of_10_000: u64) -> bool {
        self.below(10_000) < of_10_000
    }
}

/// What became of the frames of one direction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ledger {
    /// Frames that came.
    pub came: u64,
    /// Frames dropped.
    pub dropped: u64,
    /// Frames with one bit turned.
    pub damaged: u64,
    /// Frames delivered twice.
    pub doubled: u64,
    /// Frames delivered after the one that followed them.
    pub delayed: u64,
    /// Frames that came when nothing was delivered any more.
    pub withheld: u64,
    /// Whole frames delivered.
    pub good: u64,
    /// Damaged frames delivered.
    pub bad: u64,
}

/// What a receiver of the delivered reports must have counted.
#[derive(Debug, Default)]
pub struct Reports {
    tracker: Tracker,
    /// Numbers left out.
    pub lost: u64,
    /// Numbers that were not news.
    pub out_of_order: u64,
    /// Times that the count began anew.
    pub restarts: u64,
}

impl Reports {
    fn delivered(&mut self, frame: &[u8]) {
        let pose = match read_frame(frame) {
            Some(FromDevice::Pose(pose)) => pose,
            Some(FromDevice::Hello(_)) => return self.tracker.forget_time(),
            Some(FromDevice::Fault(_)) | None => return,
        };
        match self.tracker.judge(pose.seq, pose.t_us) {
            Order::New { lost } => self.lost += u64::from(lost),
            Order::Stuck { lost } => {
                self.lost += u64::from(lost);
                self.out_of_order += 1;
            }
            Order::Old => self.out_of_order += 1,
            Order::Restarted => self.restarts += 1,
        }
    }
}

/// The message of a frame, whose end is a zero and whose beginning may be some.
fn read_frame<T: DeserializeOwned>(frame: &[u8]) -> Option<T> {
    decode_stream(&mut frame.split(|&byte| byte == 0).find(|piece| !piece.is_empty())?.to_vec()).ok()
}

/// How the host numbered its commands, as they came.
#[derive(Debug, Default)]
pub struct Commands {
    /// Commands that came.
    pub came: u64,
    /// The largest number.
    pub last: u64,
}

impl Commands {
    fn came(&mut self, frame: &[u8]) {
        if let Some(ToDevice::Wrench(command)) = read_frame(frame) {
            self.came += 1;
            self.last = self.last.max(command.seq.into());
        }
    }
}

/// One direction.
#[derive(Debug, Default)]
struct Direction {
    partial: Vec<u8>,
    delayed: Vec<u8>,
    out: VecDeque<u8>,
    ledger: Ledger,
}

impl Direction {
    /// Takes bytes; yields the whole frames among them.
    fn take(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut frames = Vec::new();
        for &byte in bytes {
            self.partial.push(byte);
            // a zero alone is an idle line: it goes with the frame after it
            if byte == 0 && self.partial.iter().any(|&byte| byte != 0) {
                frames.push(std::mem::take(&mut self.partial));
            }
        }
        self.ledger.came += frames.len() as u64;
        frames
    }

    /// Treats a frame; yields what is delivered of it, with whether it is whole.
    fn treat(&mut self, mut frame: Vec<u8>, dice: &mut Dice) -> Vec<(Vec<u8>, bool)> {
        let ledger = &mut self.ledger;
        if dice.happens(DROP) {
            ledger.dropped += 1;
            return Vec::new();
        }
        let damaged = dice.happens(DAMAGE) && turn_a_bit(&mut frame, dice);
        ledger.damaged += u64::from(damaged);
        if !damaged && self.delayed.is_empty() && dice.happens(DELAY) {
            ledger.delayed += 1;
            self.delayed = frame;
            return Vec::new();
        }
        let doubled = !damaged && dice.happens(DOUBLE);
        ledger.doubled += u64::from(doubled);
        let mut delivered = vec![(frame.clone(), !damaged)];
        delivered.extend(doubled.then_some((frame, true)));
        delivered.extend(self.late());
        delivered
    }

    /// The frame kept back.
    fn late(&mut self) -> Option<(Vec<u8>, bool)> {
        let late = std::mem::take(&mut self.delayed);
        (!late.is_empty()).then_some((late, true))
    }

    fn deliver(&mut self, frame: &[u8], whole: bool) {
        *if whole { &mut self.ledger.good } else { &mut self.ledger.bad } += 1;
        self.out.extend(frame);
    }

    /// Writes what is due, as far as there is room.
    fn write(&mut self, to: impl AsFd) -> io::Result<()> {
        while !self.out.is_empty() {
            match rustix::io::write(&to, self.out.as_slices().0) {
                Ok(n) => drop(self.out.drain(..n)),
                Err(Errno::AGAIN) => return Ok(()),
                Err(errno) => return Err(errno.into()),
            }
        }
        Ok(())
    }
}

/// Turns a bit of a byte that is no zero and becomes none; false when chance finds no such byte.
fn turn_a_bit(frame: &mut [u8], dice: &mut Dice) -> bool {
    let at = dice.below(frame.len() as u64) as usize;
    let turned = frame[at] ^ 1 << dice.below(8);
    if frame[at] == 0 || turned == 0 {
        return false;
    }
    frame[at] = turned;
    true
}

/// The cable.
#[derive(Debug)]
pub struct Relay {
    /// The end at which a host is, and the path by which it opens its own.
    host: OwnedFd,
    host_path: PathBuf,
    /// The host's end once more, to keep it open and see what is unread.
    held: OwnedFd,
    device: OwnedFd,
    to_host: Direction,
    to_device: Direction,
    pub reports: Reports,
    pub commands: Commands,
    dice: Dice,
    stalled_until: Option<Instant>,
    /// Faults happen.
    pub mischief: bool,
    /// Nothing goes to the host any more.
    pub silent: bool,
    pub stalls: u64,
}

impl Relay {
    /// Opens the device's end and makes one for the host.
    pub fn new(device: &Path, seed: u64) -> io::Result<Self> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let device = rustix::fs::open(device, flags, Mode::empty())?;
        let host = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&host)?;
        unlockpt(&host)?;
        fcntl_setfl(&host, OFlags::RDWR | OFlags::NONBLOCK)?;
        let host_path = PathBuf::from(ptsname(&host, Vec::new())?.into_string().map_err(io::Error::other)?);
        let held = rustix::fs::open(&host_path, flags, Mode::empty())?;
        let mut settings = tcgetattr(&held)?;
        settings.make_raw();
        tcsetattr(&held, OptionalActions::Now, &settings)?;
        Ok(Self {
            host,
            host_path,
            held,
            device,
            to_host: Direction::default(),
            to_device: Direction::default(),
            reports: Reports::default(),
            commands: Commands::default(),
            dice: Dice::new(seed),
            stalled_until: None,
            mischief: true,
            silent: false,
            stalls: 0,
        })
    }

    /// Where the host finds its end.
    pub fn host_path(&self) -> &Path {
        &self.host_path
    }

    /// The books: device to host, host to device.
    pub fn ledgers(&self) -> (Ledger, Ledger) {
        (self.to_host.ledger, self.to_device.ledger)
    }

    /// Bytes of a frame that has begun and not ended, either way, or that wait to be written.
    pub fn on_the_way(&self) -> usize {
        [&self.to_host, &self.to_device].iter().map(|way| way.partial.len() + way.delayed.len() + way.out.len()).sum()
    }

    /// Bytes delivered that the host has not read.
    pub fn unread_by_host(&self) -> io::Result<u64> {
        Ok(rustix::io::ioctl_fionread(&self.held)?)
    }

    /// Lets what was kept back go.
    pub fn release(&mut self) {
        if let Some((frame, whole)) = self.to_host.late() {
            self.reports.delivered(&frame);
            self.to_host.deliver(&frame, whole);
        }
        if let Some((frame, whole)) = self.to_device.late() {
            self.to_device.deliver(&frame, whole);
        }
    }

    /// One look at both ends, waiting up to a millisecond; how many frames came.
    pub fn turn(&mut self) -> io::Result<u64> {
        let timeout = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };
        let mut watched = [PollFd::new(&self.host, PollFlags::IN), PollFd::new(&self.device, PollFlags::IN)];
        match poll(&mut watched, Some(&timeout)) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(errno) => return Err(errno.into()),
        }
        let mut bytes = [0; READ_BYTES];
        let n = read(&self.device, &mut bytes)?;
        let from_device = self.to_host.take(&bytes[..n]);
        let n = read(&self.host, &mut bytes)?;
        let from_host = self.to_device.take(&bytes[..n]);
        let came = (from_device.len() + from_host.len()) as u64;
        from_device.into_iter().for_each(|frame| self.carry_to_host(frame));
        from_host.into_iter().for_each(|frame| self.carry_to_device(frame));
        self.write()?;
        Ok(came)
    }

    fn carry_to_host(&mut self, frame: Vec<u8>) {
        if self.silent {
            self.to_host.ledger.withheld += 1;
            return;
        }
        for (frame, whole) in self.mischief(frame, |relay| &mut relay.to_host) {
            if whole {
                self.reports.delivered(&frame);
            }
            self.to_host.deliver(&frame, whole);
        }
    }

    fn carry_to_device(&mut self, frame: Vec<u8>) {
        self.commands.came(&frame);
        for (frame, whole) in self.mischief(frame, |relay| &mut relay.to_device) {
            self.to_device.deliver(&frame, whole);
        }
    }

    fn mischief(&mut self, frame: Vec<u8>, way: fn(&mut Self) -> &mut Direction) -> Vec<(Vec<u8>, bool)> {
        if !self.mischief {
            return vec![(frame, true)];
        }
        if self.stalled_until.is_none() && self.dice.happens(STALL) {
            let length = Duration::from_millis(1 + self.dice.below(LONGEST_STALL_MS));
            self.stalled_until = Some(Instant::now() + length);
            self.stalls += 1;
        }
        let mut dice = std::mem::replace(&mut self.dice, Dice::new(0));
        let delivered = way(self).treat(frame, &mut dice);
        self.dice = dice;
        delivered
    }

    fn write(&mut self) -> io::Result<()> {
        if self.stalled_until.is_some_and(|until| Instant::now() < until) {
            return Ok(());
        }
        self.stalled_until = None;
        self.to_host.write(&self.host)?;
        self.to_device.write(&self.device)
    }
}

/// What is there; nothing when nobody has the other end open.
fn read(from: &OwnedFd, into: &mut [u8]) -> io::Result<usize> {
    match rustix::io::read(from, into) {
        Ok(n) => Ok(n),
        Err(Errno::AGAIN | Errno::INTR | Errno::IO) => Ok(0),
        Err(errno) => Err(errno.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of three bytes without a zero inside.
    fn line(frames: u8) -> Vec<u8> {
        (1..=frames).flat_map(|i| [i, 255 - i, i, 0]).collect()
    }

    #[test]
    fn frames_are_found_however_the_line_is_cut_and_idle_zeros_go_with_the_next() {
        for cut in [1, 3, 7, 400] {
            let (mut way, mut found) = (Direction::default(), Vec::new());
            let line = [vec![0], line(50), vec![0, 0], line(2), vec![9]].concat();
            line.chunks(cut).for_each(|piece| found.extend(way.take(piece)));
            assert_eq!((found.len(), way.ledger.came, way.partial.as_slice()), (52, 52, &[9][..]), "{cut}");
            assert_eq!((found[0].as_slice(), found[50].as_slice()), (&[0, 1, 254, 1, 0][..], &[0, 0, 1, 254, 1, 0][..]));
        }
    }

    #[test]
    fn the_ledger_holds_whatever_the_dice_say_and_damage_leaves_frames_frames() {
        for seed in 0..5 {
            let (mut way, mut dice) = (Direction::default(), Dice::new(seed));
            for _ in 0..400 {
                for frame in way.take(&line(100)) {
                    for (frame, whole) in way.treat(frame, &mut dice) {
                        assert_eq!(frame.iter().position(|&byte| byte == 0), Some(frame.len() - 1));
                        way.deliver(&frame, whole);
                    }
                }
            }
            if let Some((frame, whole)) = way.late() {
                way.deliver(&frame, whole);
            }
            let l = way.ledger;
            assert_eq!((l.came, l.bad, l.withheld), (40_000, l.damaged, 0));
            assert_eq!(l.came - l.dropped + l.doubled, l.good + l.bad, "{l:?}");
            assert!([l.dropped, l.damaged, l.doubled, l.delayed].iter().all(|&n| n > 5), "{l:?}");
        }
    }
}

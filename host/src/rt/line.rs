//! The link as the loop sees it: looked at once a tick, its poses put in order, replaced when it dies.
//!
//! Opening and closing a link allocates and blocks, so neither happens here: a dead link goes through a queue to the thread that
//! opens links ([`crate::reopen`]), and the new one comes back through another.

use std::time::Duration;

use haptor_wire::device::{DeviceFault, DeviceHello, FromDevice, PoseReport, ToDevice};
use rtrb::{Consumer, Producer, RingBuffer};

use super::clock::Clock;
use super::roundtrip::RoundTrips;
use super::tracker::{Order, Tracker};
use crate::link::{AnyLink, LinkError, Messages, Received};

/// Looks at the link in one tick at most: a device that floods, or a line that brings a byte a time, cannot hold the loop.
const LOOKS_MAX: u32 = 256;

/// Links on their way at once; there is only ever one.
const LINKS: usize = 2;

/// The loop's side of the exchange of links.
#[derive(Debug)]
pub struct Exchange {
    dead: Producer<AnyLink>,
    fresh: Consumer<AnyLink>,
}

/// The opening thread's side.
#[derive(Debug)]
pub struct Opener {
    /// Links to close.
    pub dead: Consumer<AnyLink>,
    /// Links opened.
    pub fresh: Producer<AnyLink>,
}

/// Both sides.
#[must_use]
pub fn exchange() -> (Exchange, Opener) {
    let (dead, to_close) = RingBuffer::new(LINKS);
    let (opened, fresh) = RingBuffer::new(LINKS);
    (Exchange { dead, fresh }, Opener { dead: to_close, fresh: opened })
}

/// What one tick's look at the link brought.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arrivals {
    /// The newest pose report that is news.
    pub pose: Option<PoseReport>,
    /// The device said who it is.
    pub hello: Option<DeviceHello>,
    /// The device reported a fault.
    pub fault: Option<DeviceFault>,
    /// The device's count began anew.
    pub restarted: bool,
    /// The link died in this tick.
    pub lost: bool,
    /// A new link came in this tick.
    pub reopened: bool,
    /// What came since the last message was not messages.
    pub nonsense: bool,
}

/// Counts over a session; they outlive links.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounts {
    /// Reports that never came, by gaps in their numbers.
    pub lost: u64,
    /// Reports older than one already used, or repeated, or with a pose that was there before.
    pub out_of_order: u64,
    /// Frames dropped on links that are no more.
    rejected_before: u64,
}

/// The link and what is known about it.
#[derive(Debug)]
pub struct Line {
    messages: Option<Messages>,
    exchange: Exchange,
    tracker: Tracker,
    counts: LineCounts,
    /// The link died since the last look.
    died: bool,
    /// Times of commands and echoes.
    pub trips: RoundTrips,
}

impl Line {
    /// Begins on an open link.
    #[must_use]
    pub fn new(link: AnyLink, exchange: Exchange) -> Self {
        Self {
            messages: Some(Messages::new(link)),
            exchange,
            tracker: Tracker::default(),
            counts: LineCounts::default(),
            died: false,
            trips: RoundTrips::new(),
        }
    }

    /// Counts so far.
    #[must_use]
    pub const fn counts(&self) -> LineCounts {
        self.counts
    }

    /// Frames dropped so far: checksum, length or contents.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.counts.rejected_before + self.messages.as_ref().map_or(0, |messages| u64::from(messages.rejected()))
    }

    /// Takes what has come; while no pose has, waits for one until `until_ns`.
    pub fn gather(&mut self, clock: &impl Clock, until_ns: u64) -> Arrivals {
        let mut got = Arrivals { reopened: self.take_fresh(), ..Arrivals::default() };
        for _ in 0..LOOKS_MAX {
            let left_ns = if got.pose.is_some() { 0 } else { until_ns.saturating_sub(clock.now_ns()) };
            let Some(messages) = &mut self.messages else {
                clock.sleep_until_ns(until_ns);
                break;
            };
            match messages.receive(Duration::from_nanos(left_ns)) {
                Ok(Received::Message(message)) => self.sort(message, clock.now_ns(), &mut got),
                Ok(Received::Part) => {}
                Ok(Received::Nothing) => break,
                Err(_) => {
                    self.drop_link();
                    break;
                }
            }
        }
        got.lost = std::mem::take(&mut self.died);
        got.nonsense = self.messages.as_ref().is_some_and(Messages::is_nonsense);
        got
    }

    fn sort(&mut self, message: FromDevice, now_ns: u64, got: &mut Arrivals) {
        match message {
            FromDevice::Hello(hello) => {
                self.tracker.forget_time();
                got.hello = Some(hello);
            }
            FromDevice::Fault(fault) => got.fault = Some(fault),
            FromDevice::Pose(pose) => match self.tracker.judge(pose.seq, pose.t_us) {
                Order::New { lost } => {
                    self.counts.lost += u64::from(lost);
                    self.trips.echoed(pose.echo, now_ns);
                    got.pose = Some(pose);
                }
                Order::Stuck { lost } => {
                    self.counts.lost += u64::from(lost);
                    self.counts.out_of_order += 1;
                }
                Order::Old => self.counts.out_of_order += 1,
                Order::Restarted => {
                    got.restarted = true;
                    got.pose = Some(pose);
                }
            },
        }
    }

    /// Sends a message; false when the link did not take it. A link that failed is given up, and the next look says so.
    pub fn send(&mut self, message: &ToDevice) -> bool {
        let Some(messages) = &mut self.messages else { return false };
        match messages.send(message) {
            Ok(()) => true,
            Err(LinkError::Full) => false,
            Err(_) => {
                self.drop_link();
                false
            }
        }
    }

    fn drop_link(&mut self) {
        self.counts.rejected_before = self.rejected();
        self.trips.forget();
        self.died = true;
        if let Some(messages) = self.messages.take() {
            // there is room: the queue holds more links than exist
            let _ = self.exchange.dead.push(messages.into_link());
        }
    }

    fn take_fresh(&mut self) -> bool {
        if self.messages.is_some() {
            return false;
        }
        let Ok(link) = self.exchange.fresh.pop() else { return false };
        self.messages = Some(Messages::new(link));
        self.tracker = Tracker::default();
        true
    }
}

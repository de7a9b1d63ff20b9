//! One viewer: what came from it, what it wants to see, what it is owed, and how long its patience and ours last.

use std::io::{ErrorKind, Read};
use std::net::Shutdown;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

use haptor_contact::Vec3;
use haptor_wire::{
    Denial, FromViewer, Refusal, RefusalCause, RestPoints, RestState, Statistics, StreamDecoder, Subscription, Summary, ToViewer,
    stream_bound,
};

use super::listen::Socket;
use super::outbox::Outbox;
use super::streams::{Download, Recording};

/// Bytes read from a viewer in one turn at most: four chunks of a model.
const READ_BYTES: usize = 16 << 10;

/// Messages that a viewer may send a second; beyond, the rest waits in its socket. Uploads come at 16 MB/s then, and hands never at that rate.
pub const MESSAGES_PER_S: f64 = 4000.0;

/// Messages that a viewer may send at once after a pause.
const BURST: f64 = 400.0;

/// Time that a viewer has for its hello: it has nothing else to do.
pub const HELLO_WITHIN: Duration = Duration::from_secs(2);

/// Time after which a viewer that says nothing is closed.
pub const IDLE: Duration = Duration::from_secs(30);

/// Time that a viewer has to read why it is closed.
const FAREWELL: Duration = Duration::from_secs(1);

/// Frames that are no messages, after which a viewer is closed: TCP damages nothing, so they come from a broken program.
const REJECTED_MAX: u32 = 8;

/// Rest points of a viewer at most: six times what a picture of 10,000 vertices needs.
pub const REST_POINTS_MAX: usize = 1 << 16;

/// How far a viewer has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// No hello yet.
    New,
    /// It looks on; its place among the viewers.
    In(usize),
    /// It has been told why, and is closed when it has heard it, or at this time.
    Closing(Instant),
    /// The connection is gone.
    Gone,
}

/// A viewer.
#[derive(Debug)]
pub struct Peer {
    /// Its number, never given again.
    pub serial: u64,
    /// How far it has come.
    pub stage: Stage,
    /// What it will get.
    pub outbox: Outbox,
    /// What it wants to see.
    pub subscription: Subscription,
    /// The last tick looked at for it.
    pub last_tick: Option<u64>,
    /// When it gets statistics next.
    pub statistics_due: Instant,
    /// The tick whose surface is being computed for it.
    pub surface_under_way: Option<u64>,
    /// Snapshots sent.
    pub sent: u64,
    /// Snapshots and surfaces left out because it reads too slowly.
    pub dropped: u64,
    /// What was computed of the surface that it watches.
    pub watched: Watched,
    /// The recording it gets.
    pub recording: Option<Recording>,
    /// The scene it gets.
    pub download: Option<Download>,
    rest: Rest,
    socket: Socket,
    decoder: StreamDecoder<{ stream_bound(FromViewer::MAX_ENCODED) }>,
    input: Vec<u8>,
    /// Bytes of the input that have been decoded.
    decoded: usize,
    came: Instant,
    heard: Instant,
    /// Messages that it may send now.
    allowance: f64,
    refilled: Instant,
    said_all: bool,
}

/// Surfaces of a viewer, in counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watched {
    /// Computed.
    pub surfaces: u64,
    /// Passes that they took.
    pub passes: u64,
    /// Points in them.
    pub points: u64,
    /// Left out because the one before was still being computed.
    pub behind: u64,
}

/// The points it wants to see the displacements of.
#[derive(Debug, Default)]
struct Rest {
    points: Vec<Vec3>,
    of: usize,
    whole: Option<Arc<[Vec3]>>,
}

impl Peer {
    /// Somebody who has just come.
    #[must_use]
    pub fn new(serial: u64, socket: Socket, now: Instant) -> Self {
        Self {
            serial,
            stage: Stage::New,
            outbox: Outbox::new(now),
            subscription: Subscription::default(),
            last_tick: None,
            statistics_due: now,
            surface_under_way: None,
            sent: 0,
            dropped: 0,
            watched: Watched::default(),
            recording: None,
            download: None,
            rest: Rest::default(),
            socket,
            decoder: StreamDecoder::new(),
            input: Vec::new(),
            decoded: 0,
            came: now,
            heard: now,
            allowance: BURST,
            refilled: now,
            said_all: false,
        }
    }

    /// Its place among the viewers, once it has been let in.
    #[must_use]
    pub const fn place(&self) -> Option<usize> {
        match self.stage {
            Stage::In(place) => Some(place),
            _ => None,
        }
    }

    /// The session so far, and what the link cost this viewer, one of so many; `missed` = looks left out for all.
    #[must_use]
    pub fn statistics(&self, session: Summary, viewers: u8, missed: u64) -> Statistics {
        let Watched { surfaces, passes, points, behind } = self.watched;
        let (sent, dropped, rejected) = (self.sent, self.dropped, self.rejected());
        Statistics { session, viewers, sent, dropped, surfaces, passes, points, behind, missed, rejected }
    }

    /// Frames that were no messages.
    #[must_use]
    pub fn rejected(&self) -> u32 {
        self.decoder.counts().rejected()
    }

    /// Whether it is worth looking at its socket.
    #[must_use]
    pub fn may_speak(&mut self, now: Instant) -> bool {
        self.allowance = (self.allowance + MESSAGES_PER_S * now.duration_since(self.refilled).as_secs_f64()).min(BURST);
        self.refilled = now;
        self.allowance >= 1.0 && self.stage != Stage::Gone
    }

    /// Takes what its socket has, once all that came before has been decoded.
    pub fn read(&mut self, now: Instant) {
        if self.decoded < self.input.len() || !self.may_speak(now) {
            return;
        }
        self.decoded = 0;
        self.input.resize(READ_BYTES, 0);
        let read = self.socket.read(&mut self.input);
        self.input.truncate(*read.as_ref().unwrap_or(&0));
        match read {
            Ok(0) => self.stage = Stage::Gone,
            Ok(_) => {}
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(_) => self.stage = Stage::Gone,
        }
    }

    /// The next message of what was read, unless it has spoken enough in this turn.
    pub fn next(&mut self, now: Instant) -> Option<FromViewer> {
        while self.allowance >= 1.0 && matches!(self.stage, Stage::New | Stage::In(_)) {
            let &byte = self.input.get(self.decoded)?;
            self.decoded += 1;
            if let Some(message) = self.decoder.push(byte) {
                self.allowance -= 1.0;
                self.heard = now;
                return Some(message);
            }
            self.judge_rejected(now);
        }
        if matches!(self.stage, Stage::Closing(_)) {
            self.decoded = self.input.len();
        }
        None
    }

    /// Whatever is not the viewer link is shown the door at its first frame: a web page that posts here must not come to its second.
    fn judge_rejected(&mut self, now: Instant) {
        let most = if self.stage == Stage::New { 0 } else { REJECTED_MAX };
        if self.rejected() > most {
            self.refuse(RefusalCause::Garbage, now);
        }
    }

    /// Tells it why it is closed.
    pub fn refuse(&mut self, why: RefusalCause, now: Instant) {
        self.outbox.put(&ToViewer::Refused(Refusal::new(why)));
        self.close(now);
    }

    /// Closes it once it has got what waits.
    pub fn close(&mut self, now: Instant) {
        self.stage = Stage::Closing(now + FAREWELL);
    }

    /// Closes it where its time is up.
    pub fn judge(&mut self, now: Instant) {
        let silent = now.duration_since(self.heard);
        match self.stage {
            Stage::New if now.duration_since(self.came) > HELLO_WITHIN => self.refuse(RefusalCause::Silent, now),
            Stage::In(_) if silent > IDLE => self.refuse(RefusalCause::Idle, now),
            Stage::In(_) if self.outbox.is_stuck(now) => self.refuse(RefusalCause::Stuck, now),
            Stage::Closing(until) if now > until => self.stage = Stage::Gone,
            _ => {}
        }
    }

    /// Sends what waits. One that is being closed is told that there is no more; its own end of the connection then ends it.
    pub fn write(&mut self, now: Instant) {
        if self.outbox.write_to(&mut self.socket, now).is_err() {
            self.stage = Stage::Gone;
        }
        if matches!(self.stage, Stage::Closing(_)) && self.outbox.is_empty() && !self.said_all {
            self.said_all = true;
            self.socket.end();
        }
    }

    /// It will send so many rest points.
    pub fn begin_rest(&mut self, count: u32) -> RestState {
        self.rest = Rest::default();
        if count as usize > REST_POINTS_MAX {
            return RestState { have: 0, of: 0, why: Some(Denial::TooLarge) };
        }
        self.rest.of = count as usize;
        RestState { have: 0, of: count, why: None }
    }

    /// Rest points, in order; each a finite number.
    pub fn add_rest(&mut self, points: &RestPoints) -> RestState {
        let Rest { points: there, of, whole } = &mut self.rest;
        let have = whole.as_ref().map_or(there.len(), |whole| whole.len());
        // both at most REST_POINTS_MAX
        let state = |have: usize, why| RestState { have: have as u32, of: *of as u32, why };
        if points.offset as usize != have || have + points.points.len() > *of {
            return state(have, Some(Denial::OutOfOrder));
        }
        if !points.points.iter().flatten().all(|x| x.is_finite()) {
            return state(have, Some(Denial::Value));
        }
        there.extend(points.points.iter().copied().map(Vec3::from_array));
        let have = have + points.points.len();
        if have == *of && whole.is_none() {
            *whole = Some(std::mem::take(there).into());
        }
        state(have, None)
    }

    /// The rest points, once all are there.
    #[must_use]
    pub fn rest(&self) -> Option<Arc<[Vec3]>> {
        self.rest.whole.clone().filter(|points| !points.is_empty())
    }
}

impl AsFd for Peer {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

impl Socket {
    /// Says that nothing more will be said.
    fn end(&self) {
        // one that is gone needs not be told
        let _ = match self {
            Self::Tcp(socket) => socket.shutdown(Shutdown::Write),
            Self::Unix(socket) => socket.shutdown(Shutdown::Write),
        };
    }
}

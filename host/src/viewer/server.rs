//! The viewers' thread. One turn is a list of calls; nothing in it waits but the first, and that for what sockets bring.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::{Duration, Instant};

use haptor_wire::{
    FromViewer, Limits, PROTOCOL_VERSION, RefusalCause, SceneNow, SessionHello, Summary, ToViewer, VIEWER_SCHEMA_HASH,
    ViewerHello, Welcome, check_viewer_version,
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::figures::SharedFigures;
use super::listen::Listener;
use super::peer::{IDLE, Peer, REST_POINTS_MAX, Stage};
use super::requests::{Requests, Running};
use super::token::Token;
use super::uploads::{MODEL_BYTES_MAX, Uploads};
use super::workshop::{Job, Made};
use crate::recorder::orders::Orders;
use crate::rt::desk::{Counter, VIEWERS_MAX};

/// Longest wait for sockets while somebody looks on: a snapshot is not seen later than that.
const TURN: Duration = Duration::from_millis(3);

/// Longest wait while nobody is there: a session that ends does not wait longer for this thread.
const TURN_ALONE: Duration = Duration::from_millis(50);

/// Connections at once, those among them that have not said who they are or are being closed.
const CONNECTIONS_MAX: usize = 3 * VIEWERS_MAX;

/// Time for the last bytes to leave when the session ends.
const LAST_BYTES: Duration = Duration::from_millis(300);

/// What a server is made of.
#[derive(Debug)]
pub struct Parts {
    /// Where viewers come in.
    pub listener: Listener,
    /// What they must know.
    pub token: Option<Token>,
    /// Ticks a second.
    pub rate_hz: u32,
    /// Digest of the scene that runs first.
    pub digest: u64,
    /// Its file.
    pub file: Arc<[u8]>,
    /// The desk's other side.
    pub counter: Counter,
    /// Of the recorder.
    pub recorder: Orders,
    /// Of the session.
    pub figures: SharedFigures,
    /// To the workshop.
    pub jobs: Sender<Job>,
    /// From the workshop.
    pub made: Receiver<Made>,
}

/// The server.
#[derive(Debug)]
pub struct Server {
    listener: Listener,
    token: Option<Token>,
    rate_hz: u32,
    pub(super) counter: Counter,
    pub(super) recorder: Orders,
    pub(super) figures: SharedFigures,
    pub(super) jobs: Sender<Job>,
    pub(super) made: Receiver<Made>,
    pub(super) peers: Vec<Box<Peer>>,
    pub(super) requests: Requests,
    pub(super) uploads: Uploads,
    pub(super) scene: Running,
    pub(super) device: Option<SessionHello>,
    /// Counts of the last look.
    pub(super) counts: [u64; 4],
    serials: u64,
}

impl Server {
    /// Nobody there yet.
    #[must_use]
    pub fn new(parts: Parts) -> Self {
        let Parts { listener, token, rate_hz, digest, file, counter, recorder, figures, jobs, made } = parts;
        let mut uploads = Uploads::default();
        uploads.keep(digest, Arc::clone(&file), Instant::now());
        Self {
            listener,
            token,
            rate_hz,
            counter,
            recorder,
            figures,
            jobs,
            made,
            peers: Vec::new(),
            requests: Requests::default(),
            uploads,
            scene: Running { number: 0, digest, file },
            device: None,
            counts: [0; 4],
            serials: 0,
        }
    }

    /// Serves until the summary comes, or nobody can send one any more.
    pub fn run(mut self, end: &Receiver<Summary>) {
        loop {
            match end.try_recv() {
                Err(TryRecvError::Empty) => self.turn(),
                Err(TryRecvError::Disconnected) => return,
                Ok(summary) => return self.part(&summary),
            }
        }
    }

    /// One turn.
    fn turn(&mut self) {
        self.wait(Instant::now());
        let now = Instant::now();
        self.accept(now);
        self.hear(now);
        self.pass_notes();
        self.pass_made();
        self.pass_looks();
        self.tell_statistics(now);
        self.pump();
        self.send(now);
    }

    /// Waits until a socket has something, or takes something that waits.
    fn wait(&mut self, now: Instant) {
        let turn = if self.peers.is_empty() { TURN_ALONE } else { TURN };
        let wants: Vec<PollFlags> = self.peers.iter_mut().map(|peer| wants(peer, now)).collect();
        let mut watched = vec![PollFd::new(&self.listener, PollFlags::IN)];
        watched.extend(self.peers.iter().zip(wants).map(|(peer, wants)| PollFd::new(&**peer, wants)));
        let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(turn.subsec_nanos()) };
        // what cuts the wait short only makes this turn an early one
        let _ = poll(&mut watched, Some(&timeout));
    }

    fn accept(&mut self, now: Instant) {
        while let Some(socket) = self.listener.accept() {
            if self.peers.len() < CONNECTIONS_MAX {
                self.serials += 1;
                self.peers.push(Box::new(Peer::new(self.serials, socket, now)));
            }
        }
    }

    /// What viewers say.
    fn hear(&mut self, now: Instant) {
        for at in 0..self.peers.len() {
            self.peers[at].read(now);
            while let Some(message) = self.peers[at].next(now) {
                self.handle(at, &message, now);
            }
        }
    }

    fn handle(&mut self, at: usize, message: &FromViewer, now: Instant) {
        let peer = &mut self.peers[at];
        match (peer.place(), message) {
            (None, FromViewer::Hello(hello)) => self.greet(at, hello, now),
            (None, _) | (_, FromViewer::Hello(_)) => peer.refuse(RefusalCause::Order, now),
            (_, FromViewer::Subscribe(subscription)) => {
                peer.subscription = *subscription;
                peer.statistics_due = now;
                if subscription.surface == 0 && peer.surface_under_way.take().is_some() {
                    let viewer = peer.serial;
                    self.job(Job::GiveUp(viewer));
                }
            }
            (_, FromViewer::UploadBegin(begin)) => {
                let state = self.uploads.begin(begin, now);
                peer.outbox.put(&ToViewer::Upload(state));
            }
            (_, FromViewer::UploadChunk(chunk)) => {
                let state = self.uploads.chunk(chunk, now);
                peer.outbox.put(&ToViewer::Upload(state));
            }
            (_, FromViewer::RestBegin(begin)) => {
                let state = peer.begin_rest(begin.count);
                peer.outbox.put(&ToViewer::Rest(state));
            }
            (_, FromViewer::RestPoints(points)) => {
                let state = peer.add_rest(points);
                peer.outbox.put(&ToViewer::Rest(state));
            }
            (_, FromViewer::Ping(nonce)) => drop(peer.outbox.offer_message(&ToViewer::Pong(*nonce))),
            (_, FromViewer::Ask(ask)) => self.ask(at, ask, now),
        }
    }

    /// Lets a viewer in, or says why not.
    fn greet(&mut self, at: usize, hello: &ViewerHello, now: Instant) {
        let taken: Vec<usize> = self.peers.iter().filter_map(|peer| peer.place()).collect();
        let free = (0..VIEWERS_MAX).find(|place| !taken.contains(place));
        let peer = &mut self.peers[at];
        if check_viewer_version(hello.version, hello.schema).is_err() {
            return peer.refuse(RefusalCause::Version, now);
        }
        if !self.token.is_none_or(|token| token.is(&hello.token)) {
            return peer.refuse(RefusalCause::Token, now);
        }
        let Some(place) = free else { return peer.refuse(RefusalCause::TooMany, now) };
        peer.stage = Stage::In(place);
        let limits = Limits {
            viewers: VIEWERS_MAX as u8,
            model_bytes: MODEL_BYTES_MAX as u32,
            rest_points: REST_POINTS_MAX as u32,
            idle_ms: IDLE.as_millis() as u32,
        };
        let welcome = Welcome { version: PROTOCOL_VERSION, schema: VIEWER_SCHEMA_HASH, rate_hz: self.rate_hz, limits };
        peer.outbox.put(&ToViewer::Welcome(welcome));
        peer.outbox.put(&ToViewer::Scene(SceneNow { digest: self.scene.digest, length: self.scene.file.len() as u32 }));
        self.device.iter().for_each(|hello| peer.outbox.put(&ToViewer::Device(*hello)));
    }

    /// Tells one viewer, if it is still there.
    pub(super) fn tell(&mut self, viewer: u64, message: &ToViewer) {
        if let Some(peer) = self.peers.iter_mut().find(|peer| peer.serial == viewer && peer.place().is_some()) {
            peer.outbox.put(message);
        }
    }

    /// Tells everybody who looks on.
    pub(super) fn tell_all(&mut self, message: &ToViewer) {
        self.peers.iter_mut().filter(|peer| peer.place().is_some()).for_each(|peer| peer.outbox.put(message));
    }

    /// Gives the workshop something to do.
    pub(super) fn job(&self, job: Job) {
        // a workshop that is gone was told to go
        let _ = self.jobs.send(job);
    }

    /// Tells the loop what is wanted, before viewers are told that it has been; sends what waits, and lets go of those who have gone.
    fn send(&mut self, now: Instant) {
        self.peers.iter_mut().for_each(|peer| peer.judge(now));
        for place in 0..VIEWERS_MAX {
            let viewer = self.peers.iter().find(|peer| peer.place() == Some(place));
            self.counter.wanted.look_every(place, viewer.map_or(0, |peer| peer.subscription.every));
        }
        self.peers.iter_mut().for_each(|peer| peer.write(now));
        for gone in self.peers.extract_if(.., |peer| peer.stage == Stage::Gone).filter(|gone| gone.surface_under_way.is_some()) {
            // a workshop that is gone was told to go
            let _ = self.jobs.send(Job::GiveUp(gone.serial));
        }
    }

    /// The session has ended: everybody gets what waits, and the summary.
    fn part(mut self, summary: &Summary) {
        let now = Instant::now();
        self.pass_notes();
        self.pass_looks();
        self.pump();
        self.tell_all(&ToViewer::End(*summary));
        self.peers.iter_mut().filter(|peer| peer.place().is_some()).for_each(|peer| peer.close(now));
        while !self.peers.is_empty() && now.elapsed() < LAST_BYTES {
            self.wait(Instant::now());
            self.hear(Instant::now());
            self.send(Instant::now());
        }
    }
}

/// What to watch a viewer's socket for.
fn wants(peer: &mut Peer, now: Instant) -> PollFlags {
    let mut wants = PollFlags::empty();
    wants.set(PollFlags::IN, peer.may_speak(now));
    wants.set(PollFlags::OUT, !peer.outbox.is_empty());
    wants
}

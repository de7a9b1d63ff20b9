//! What viewers ask: sent on to the loop or the workshop, with a note of who waits for the answer.

use std::sync::Arc;
use std::time::Instant;

use haptor_wire::viewer::words;
use haptor_wire::{Ask, Denial, Denied, ToViewer, Tuning, Wish, WorkBudget};

use super::server::Server;
use super::streams::{Download, Recording, TAP_ROOM};
use super::workshop::Job;
use crate::rt::desk::{Numbered, ORDERS_MAX, Order};

/// A request on its way.
#[derive(Clone, Debug)]
pub struct Waiting {
    /// Its number among all requests.
    number: u64,
    /// Serial number of the viewer.
    viewer: u64,
    /// Its number among the viewer's.
    request: u32,
    /// The scene that it brings.
    pub scene: Option<Running>,
}

/// A scene that runs, or will.
#[derive(Clone, Debug)]
pub struct Running {
    /// Its number: 0 is the first, and each activation has its own.
    pub number: u32,
    /// Digest of its file.
    pub digest: u64,
    /// Its file.
    pub file: Arc<[u8]>,
}

/// The requests on their way.
#[derive(Debug, Default)]
pub struct Requests {
    waiting: Vec<Waiting>,
    /// Who hit the emergency stop: viewer and request.
    stops: Vec<(u64, u32)>,
    numbers: u64,
    scenes: u32,
}

impl Requests {
    /// Notes a request; `None` when too many wait.
    fn open(&mut self, viewer: u64, request: u32) -> Option<&mut Waiting> {
        if self.waiting.len() >= ORDERS_MAX {
            return None;
        }
        self.numbers += 1;
        self.waiting.push(Waiting { number: self.numbers, viewer, request, scene: None });
        self.waiting.last_mut()
    }

    /// The request of this number, answered now.
    pub fn close(&mut self, number: u64) -> Option<Waiting> {
        let at = self.waiting.iter().position(|waiting| waiting.number == number)?;
        Some(self.waiting.remove(at))
    }

    /// The scene that a request brings.
    #[must_use]
    pub fn scene(&self, number: u64) -> Option<&Running> {
        self.waiting.iter().find(|waiting| waiting.number == number)?.scene.as_ref()
    }

    /// Whether another scene is on its way.
    fn is_scene_coming(&self) -> bool {
        self.waiting.iter().any(|waiting| waiting.scene.is_some())
    }

    /// Everybody who hit the emergency stop.
    pub fn take_stops(&mut self) -> Vec<(u64, u32)> {
        std::mem::take(&mut self.stops)
    }
}

impl Server {
    /// A request of the viewer at this place of the list.
    pub(super) fn ask(&mut self, at: usize, ask: &Ask, now: Instant) {
        let (viewer, number) = (self.peers[at].serial, ask.number);
        let done = match ask.what {
            Wish::EStop => {
                self.counter.wanted.stop();
                self.requests.stops.push((viewer, number));
                return;
            }
            Wish::Record(true) => self.begin_recording(at),
            Wish::Record(false) => return self.end_recording(at, number),
            Wish::Download => return self.begin_download(at, number),
            Wish::Activate(digest) => self.activate(viewer, number, digest, now),
            Wish::Tune(tuning) => self.tune(viewer, number, tuning),
            Wish::Freeze(on) => self.order(viewer, number, Order::Freeze(on)),
            Wish::Tare => self.order(viewer, number, Order::Tare),
            Wish::Rearm => self.order(viewer, number, Order::Rearm),
            Wish::Budget(rule) => self.limit(viewer, number, rule),
        };
        match done {
            Ok(Sent::Done) => self.peers[at].outbox.put(&ToViewer::Done(number)),
            Ok(Sent::Waits) => {}
            Err(why) => self.deny(viewer, number, why, ""),
        }
    }

    fn order(&mut self, viewer: u64, request: u32, order: Order) -> Result<Sent, Denial> {
        let number = self.requests.open(viewer, request).ok_or(Denial::Busy)?.number;
        self.give(number, order);
        Ok(Sent::Waits)
    }

    /// Gives an order to the loop.
    pub(super) fn give(&mut self, number: u64, order: Order) {
        // there is room: no more requests wait than orders fit
        let _ = self.counter.orders.push(Numbered { number, order });
    }

    fn activate(&mut self, viewer: u64, request: u32, digest: u64, now: Instant) -> Result<Sent, Denial> {
        let file = self.uploads.whole(digest, now).ok_or(Denial::NoModel)?;
        if self.requests.is_scene_coming() {
            return Err(Denial::Busy);
        }
        let scene = self.requests.scenes + 1;
        let waiting = self.requests.open(viewer, request).ok_or(Denial::Busy)?;
        waiting.scene = Some(Running { number: scene, digest, file: Arc::clone(&file) });
        let number = waiting.number;
        self.requests.scenes = scene;
        self.job(Job::Build { number, scene, digest, file });
        Ok(Sent::Waits)
    }

    fn tune(&mut self, viewer: u64, request: u32, tuning: Tuning) -> Result<Sent, Denial> {
        let number = self.requests.open(viewer, request).ok_or(Denial::Busy)?.number;
        self.job(Job::Check { number, scene: self.scene.number, tuning: Box::new(tuning) });
        Ok(Sent::Waits)
    }

    /// Not while a scene comes that was given its budget already. One that comes later follows it all the way.
    fn limit(&mut self, viewer: u64, request: u32, rule: WorkBudget) -> Result<Sent, Denial> {
        if self.requests.is_scene_coming() {
            return Err(Denial::Busy);
        }
        let number = self.requests.open(viewer, request).ok_or(Denial::Busy)?.number;
        self.job(Job::Limit { number, scene: self.scene.number, rule });
        Ok(Sent::Waits)
    }

    fn begin_recording(&mut self, at: usize) -> Result<Sent, Denial> {
        if self.peers[at].recording.is_some() {
            return Err(Denial::Recording);
        }
        self.peers[at].recording = Some(Recording::new(self.recorder.tap(TAP_ROOM)));
        Ok(Sent::Done)
    }

    /// The answer follows the last bytes.
    fn end_recording(&mut self, at: usize, number: u32) {
        let peer = &mut self.peers[at];
        let (viewer, under_way) = (peer.serial, peer.recording.as_mut().filter(|recording| !recording.is_ending()));
        match under_way {
            Some(recording) => recording.end(number),
            None => self.deny(viewer, number, Denial::NotRecording, ""),
        }
    }

    /// The answer follows the last bytes.
    fn begin_download(&mut self, at: usize, number: u32) {
        let peer = &mut self.peers[at];
        if peer.download.is_some() {
            let viewer = peer.serial;
            return self.deny(viewer, number, Denial::Busy, "");
        }
        peer.download = Some(Download::new(self.scene.digest, Arc::clone(&self.scene.file), number));
    }

    /// Tells who waits for it how a request ended.
    pub(super) fn conclude(&mut self, waiting: &Waiting, result: Result<(), (Denial, String)>) {
        match result {
            Ok(()) => self.tell(waiting.viewer, &ToViewer::Done(waiting.request)),
            Err((why, text)) => self.deny(waiting.viewer, waiting.request, why, &text),
        }
    }

    fn deny(&mut self, viewer: u64, number: u32, why: Denial, text: &str) {
        self.tell(viewer, &ToViewer::Denied(Denied { number, why, words: words(text) }));
    }
}

/// What became of a request at once.
enum Sent {
    /// It has been carried out.
    Done,
    /// Its answer will come.
    Waits,
}

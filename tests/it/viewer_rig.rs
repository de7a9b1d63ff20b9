//! A session on the rig's virtual clock, with the real server of the viewer link beside it: real threads, real sockets, real bytes.
//!
//! Ticks pass when a test lets them, so what a viewer gets is counted and not timed. Waiting for what a thread sends has a limit in real time, which only ends
//! a test that fails.

use std::path::PathBuf;
use std::sync::mpsc::{self, Sender};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use haptor_engine::Scene;
use haptor_host::recorder::origin::Origin;
use haptor_host::recorder::{Recorder, Sources};
use haptor_host::rt::blackbox::black_box;
use haptor_host::viewer::figures::SharedFigures;
use haptor_host::viewer::listen::{Listener, ViewerAddress};
use haptor_host::viewer::server::{Parts, Server};
use haptor_host::viewer::token::Token;
use haptor_host::viewer::workshop::Workshop;
use haptor_wire::{Denial, Summary, ToViewer, Wish, WorkBudget};
use rtrb::RingBuffer;

use crate::host_rig::{RATE_HZ, Rig, ball_on_cube};
use crate::viewer::{PATIENCE, TestViewer, file};

/// A session and its server.
pub struct Served {
    pub rig: Rig,
    pub address: ViewerAddress,
    ends: Vec<Sender<Summary>>,
    threads: Vec<JoinHandle<()>>,
    /// Holds the Unix socket.
    _folder: tempfile::TempDir,
}

impl Served {
    /// The hand plays `script`; viewers come in on a free port.
    pub fn new(script: &str) -> Self {
        Self::with_token(script, None)
    }

    /// The same for those who know a token.
    pub fn with_token(script: &str, token: Option<Token>) -> Self {
        Self::at(script, ViewerAddress::Tcp(([127, 0, 0, 1], 0).into()), token)
    }

    /// The same on a Unix socket, whose buffers are small and of one size.
    pub fn on_unix(script: &str) -> Self {
        Self::at(script, ViewerAddress::Unix(PathBuf::new()), None)
    }

    fn at(script: &str, address: ViewerAddress, token: Option<Token>) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let address = match address {
            ViewerAddress::Unix(_) => ViewerAddress::Unix(folder.path().join("viewers")),
            tcp @ ViewerAddress::Tcp(_) => tcp,
        };
        let mut rig = Rig::new(script, None);
        let listener = Listener::open(&address).expect("a free address");
        let address = listener.address().expect("an address");
        let origin = Origin::new(RATE_HZ, file(&ball_on_cube()).into());
        let figures = SharedFigures::default();
        let (recorder, orders) = Recorder::create(origin.clone(), None, None).expect("no file to create");
        let recorder = recorder.with_figures(figures.clone());
        let (copies, records) = RingBuffer::new(1 << 16);
        rig.copies = Some(copies);
        let sources = Sources { records, dumps: black_box(RATE_HZ).1, rest_wanted: rig.rest_wanted() };
        let ((jobs, to_do), (send_made, made)) = (mpsc::channel(), mpsc::channel());
        let workshop = Workshop::new(Scene::new(&ball_on_cube()).expect("a good scene"), WorkBudget::Scene, RATE_HZ, send_made);
        let server = Server::new(Parts {
            listener,
            token,
            rate_hz: RATE_HZ,
            digest: origin.header.scene_digest,
            file: origin.scene().clone(),
            counter: rig.counter.take().expect("nobody has it yet"),
            recorder: orders,
            figures,
            jobs,
            made,
        });
        let ((tell_recorder, recorder_end), (tell_server, server_end)) = (mpsc::channel(), mpsc::channel());
        let threads = vec![
            thread::spawn(move || drop(recorder.run(sources, &recorder_end))),
            thread::spawn(move || server.run(&server_end)),
            thread::spawn(move || workshop.run(&to_do)),
        ];
        Self { rig, address, ends: vec![tell_recorder, tell_server], threads, _folder: folder }
    }

    /// A viewer that has been let in.
    pub fn viewer(&self) -> TestViewer {
        self.stranger().enter()
    }

    /// A connection on which nothing has been said.
    pub fn stranger(&self) -> TestViewer {
        TestViewer::connect(&self.address)
    }

    /// Lets ticks pass until the hand presses and the output is open.
    pub fn press(&mut self) {
        let pressed = self
            .rig
            .until(20_000, |rig| rig.ticks.last().is_some_and(|t| t.flags == 0 && crate::host_rig::length(t.force) > 2.0));
        assert!(pressed, "the hand presses");
    }

    /// Lets ticks pass until nothing touches and the output is open.
    pub fn lift(&mut self) {
        let lifted = self.rig.until(20_000, |rig| rig.ticks.last().is_some_and(|t| t.flags == 0 && t.regions == 0));
        assert!(lifted, "the hand lifts");
    }

    /// Lets ticks pass, slowly enough for threads to keep up, until the viewer has heard what it waits for.
    pub fn tick_until<T>(&mut self, viewer: &mut TestViewer, what: &str, mut pick: impl FnMut(&ToViewer) -> Option<T>) -> T {
        let until = Instant::now() + PATIENCE;
        loop {
            self.rig.tick();
            if let Some(found) = viewer.look(&mut pick) {
                return found;
            }
            assert!(Instant::now() < until, "waited for {what}; heard {:?}", viewer.heard);
        }
    }

    /// Has the viewer ask for something, and ticks until it is answered.
    pub fn ask(&mut self, viewer: &mut TestViewer, wish: Wish) -> Result<(), Denial> {
        let number = viewer.ask(wish);
        self.tick_until(viewer, "an answer", |message| answer(message, number))
    }

    /// Ends the session; everybody ends.
    pub fn end(mut self) -> Rig {
        let summary = self.rig.summary();
        for end in &self.ends {
            end.send(summary).expect("the thread waits for it");
        }
        self.threads.into_iter().for_each(|thread| thread.join().expect("no panic"));
        self.rig.counter = None;
        self.rig
    }
}

fn answer(message: &ToViewer, number: u32) -> Option<Result<(), Denial>> {
    match message {
        ToViewer::Done(done) if *done == number => Some(Ok(())),
        ToViewer::Denied(denied) if denied.number == number => Some(Err(denied.why)),
        _ => None,
    }
}

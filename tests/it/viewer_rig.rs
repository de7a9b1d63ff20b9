//! A session on the rig's virtual clock, with the real server of the viewer link beside it: real threads, real sockets, real bytes.
//!
//! Ticks pass when a test lets them, so what a viewer gets is counted and not timed. Waiting for what a thread sends has a limit in real time, which only ends
//! a test that fails.

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::sync::mpsc::{self, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use haptor_engine::Scene;
use haptor_host::recorder::origin::Origin;
use haptor_host::recorder::{Recorder, Sources};
use haptor_host::rt::blackbox::black_box;
use haptor_host::viewer::figures::SharedFigures;
use haptor_host::viewer::listen::{Listener, ViewerAddress};
use haptor_host::viewer::server::{Parts, Server};
use haptor_host::viewer::token::Token;
use haptor_host::viewer::workshop::Workshop;
use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::viewer::NO_TOKEN;
use haptor_wire::{
    Ask, BakedScene, Denial, FromViewer, StreamDecoder, Subscription, Summary, ToViewer, UploadBegin, UploadChunk, ViewerHello,
    Wish, encode_stream, scene_file, stream_bound,
};
use rtrb::RingBuffer;

use crate::host_rig::{RATE_HZ, Rig, ball_on_cube};

/// Longest wait for something that must come.
const PATIENCE: Duration = Duration::from_secs(30);

/// A session and its server.
pub struct Served {
    pub rig: Rig,
    pub address: ViewerAddress,
    ends: Vec<Sender<Summary>>,
    threads: Vec<JoinHandle<()>>,
    /// Holds the Unix socket.
    _folder: tempfile::TempDir,
}

/// The file of a scene.
pub fn file(scene: &BakedScene) -> Vec<u8> {
    let mut file = [0; FILE_MAX];
    let n = encode_file(scene, &mut file).expect("room");
    file[..n].to_vec()
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
        let sources = Sources { records, dumps: black_box().1, rest_wanted: rig.rest_wanted() };
        let ((jobs, to_do), (send_made, made)) = (mpsc::channel(), mpsc::channel());
        let workshop = Workshop::new(Scene::new(&ball_on_cube()).expect("a good scene"), send_made);
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
        let mut viewer = self.stranger();
        viewer.say(&FromViewer::Hello(ViewerHello::new(NO_TOKEN)));
        viewer.wait_for("a welcome", |message| matches!(message, ToViewer::Welcome(_)).then_some(()));
        viewer.pinged = Some(Instant::now());
        viewer
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

/// Both kinds of socket.
trait Stream: Read + Write {}
impl<T: Read + Write> Stream for T {}

/// A viewer as a test plays it.
pub struct TestViewer {
    socket: Box<dyn Stream>,
    decoder: StreamDecoder<{ stream_bound(ToViewer::MAX_ENCODED) }>,
    /// What came and has not been asked for.
    pub heard: VecDeque<ToViewer>,
    numbers: u32,
    /// The host has closed the connection.
    pub closed: bool,
    /// When it last said that it is there.
    pinged: Option<Instant>,
}

/// Time between two pings of a viewer that has been let in; the answers are dropped with what nobody picks.
const PING_EVERY: Duration = Duration::from_secs(3);

impl TestViewer {
    fn connect(address: &ViewerAddress) -> Self {
        let moment = Some(Duration::from_micros(200));
        let socket: Box<dyn Stream> = match address {
            ViewerAddress::Tcp(address) => {
                let socket = std::net::TcpStream::connect(address).expect("the server listens");
                socket.set_nodelay(true).and_then(|()| socket.set_read_timeout(moment)).expect("a socket");
                Box::new(socket)
            }
            ViewerAddress::Unix(path) => {
                let socket = UnixStream::connect(path).expect("the server listens");
                socket.set_read_timeout(moment).expect("a socket");
                Box::new(socket)
            }
        };
        Self { socket, decoder: StreamDecoder::new(), heard: VecDeque::new(), numbers: 0, closed: false, pinged: None }
    }

    pub fn say(&mut self, message: &FromViewer) {
        let mut frame = [0; stream_bound(FromViewer::MAX_ENCODED)];
        let n = encode_stream(message, &mut frame).expect("room");
        self.say_bytes(&frame[..n]);
    }

    /// Bytes as they are; a host that has closed does not take them.
    pub fn say_bytes(&mut self, bytes: &[u8]) {
        self.closed |= self.socket.write_all(bytes).is_err();
    }

    /// Asks for something; yields its number.
    pub fn ask(&mut self, what: Wish) -> u32 {
        self.numbers += 1;
        self.say(&FromViewer::Ask(Ask { number: self.numbers, what }));
        self.numbers
    }

    pub fn subscribe(&mut self, every: u32, surface: u32, statistics_ms: u32) {
        self.say(&FromViewer::Subscribe(Subscription { every, surface, statistics_ms }));
        self.settle();
    }

    /// All that was said before has been handled.
    pub fn settle(&mut self) {
        self.numbers += 1;
        let nonce = self.numbers;
        self.say(&FromViewer::Ping(nonce));
        self.wait_for("a pong", |message| (*message == ToViewer::Pong(nonce)).then_some(()));
    }

    /// Takes what has come.
    pub fn hear(&mut self) {
        if self.pinged.is_some_and(|pinged| pinged.elapsed() > PING_EVERY) {
            self.pinged = Some(Instant::now());
            self.say(&FromViewer::Ping(0));
        }
        let mut bytes = [0; 1 << 16];
        match self.socket.read(&mut bytes) {
            Ok(0) => self.closed = true,
            Ok(n) => self.decoder.feed(&bytes[..n], |message| self.heard.push_back(message)),
            Err(error) => self.closed |= !matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut),
        }
    }

    /// What is picked of what has come; what came before it and was not picked is dropped.
    pub fn look<T>(&mut self, mut pick: impl FnMut(&ToViewer) -> Option<T>) -> Option<T> {
        self.hear();
        while let Some(message) = self.heard.pop_front() {
            if let Some(found) = pick(&message) {
                return Some(found);
            }
        }
        None
    }

    pub fn wait_for<T>(&mut self, what: &str, mut pick: impl FnMut(&ToViewer) -> Option<T>) -> T {
        let until = Instant::now() + PATIENCE;
        loop {
            if let Some(found) = self.look(&mut pick) {
                return found;
            }
            assert!(Instant::now() < until && !self.closed, "waited for {what}, closed {}", self.closed);
        }
    }

    /// Hears until the host closes; what it said last.
    pub fn until_closed(&mut self) -> Option<ToViewer> {
        let until = Instant::now() + PATIENCE;
        while !self.closed && Instant::now() < until {
            self.hear();
        }
        assert!(self.closed, "the host closes");
        self.heard.pop_back()
    }

    /// Uploads bytes of a file from where the host has them, up to `to`; yields how many the host has then.
    pub fn upload(&mut self, file: &[u8], digest: u64, to: usize) -> u32 {
        self.say(&FromViewer::UploadBegin(UploadBegin { digest, length: file.len() as u32 }));
        let mut have = self.uploaded();
        while (have as usize) < to {
            let end = to.min(have as usize + 200);
            let bytes = file[have as usize..end].iter().copied().collect();
            self.say(&FromViewer::UploadChunk(UploadChunk { digest, offset: have, bytes }));
            have = self.uploaded();
        }
        have
    }

    fn uploaded(&mut self) -> u32 {
        self.wait_for("an upload's state", |message| match message {
            ToViewer::Upload(state) => {
                assert_eq!(state.why, None);
                Some(state.have)
            }
            _ => None,
        })
    }

    /// Uploads a whole scene; yields its digest.
    pub fn upload_scene(&mut self, scene: &BakedScene) -> u64 {
        let file = file(scene);
        let digest = scene_file::digest(&file);
        assert_eq!(self.upload(&file, digest, file.len()) as usize, file.len());
        digest
    }
}

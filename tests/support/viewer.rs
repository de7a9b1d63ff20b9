//! A viewer as tests play it: frames out, frames in, on either kind of socket.

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use haptor_host::viewer::listen::ViewerAddress;
use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::viewer::NO_TOKEN;
use haptor_wire::{
    Ask, BakedScene, FromViewer, StreamDecoder, Subscription, ToViewer, UploadBegin, UploadChunk, ViewerHello, Wish,
    encode_stream, scene_file, stream_bound,
};

/// Longest wait for something that must come.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// The file of a scene.
pub fn file(scene: &BakedScene) -> Vec<u8> {
    let mut file = [0; FILE_MAX];
    let n = encode_file(scene, &mut file).expect("room");
    file[..n].to_vec()
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
    /// A connection on which nothing has been said.
    pub fn connect(address: &ViewerAddress) -> Self {
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

    /// Says hello and waits to be let in.
    pub fn enter(mut self) -> Self {
        self.say(&FromViewer::Hello(ViewerHello::new(NO_TOKEN)));
        self.wait_for("a welcome", |message| matches!(message, ToViewer::Welcome(_)).then_some(()));
        self.pinged = Some(Instant::now());
        self
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

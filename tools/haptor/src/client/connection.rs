//! A connection that has been let in: what the host says, in order, and what it is asked.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use haptor_wire::{
    Ask, FromViewer, Limits, RefusalCause, StreamDecoder, Subscription, ToViewer, ViewerHello, Welcome, Wish,
    check_viewer_version, encode_stream, stream_bound,
};

use super::address::{Address, Socket, Token};
use super::error::ClientError;

/// Longest wait for an answer: a scene with large tables is built in a few seconds.
pub const ANSWER_WITHIN: Duration = Duration::from_secs(20);

/// Longest wait for a welcome.
const WELCOME_WITHIN: Duration = Duration::from_secs(5);

/// Messages on their way from the reading thread to who looks: two seconds of snapshots at 60 a second with their surfaces.
const WAITING: usize = 8192;

/// Messages kept while an answer is waited for; beyond, the oldest go.
const KEPT: usize = 8192;

/// Time after which something is said, so that the host knows somebody is there.
const PING_EVERY: Duration = Duration::from_secs(5);

/// Bytes of the longest frame of the host.
const FRAME_MAX: usize = stream_bound(ToViewer::MAX_ENCODED);

/// A connection.
#[derive(Debug)]
pub struct Connection {
    socket: Arc<Mutex<Socket>>,
    heard: Receiver<ToViewer>,
    /// What came while something else was waited for.
    kept: VecDeque<ToViewer>,
    welcome: Welcome,
    numbers: u32,
}

impl Connection {
    /// Connects and says hello.
    ///
    /// # Errors
    /// [`ClientError`]: nobody there, or the host says why it refuses.
    pub fn open(address: &Address, token: Token) -> Result<Self, ClientError> {
        let failed = |reason| ClientError::Connect { address: address.to_string(), reason };
        let socket = address.connect().map_err(failed)?;
        let reader = socket.again().map_err(failed)?;
        let socket = Arc::new(Mutex::new(socket));
        let (send, heard) = mpsc::sync_channel(WAITING);
        let pings = Arc::clone(&socket);
        thread::Builder::new().name("viewer link".into()).spawn(move || listen(reader, &pings, &send)).map_err(failed)?;
        let limits = Limits { viewers: 0, model_bytes: 0, rest_points: 0, idle_ms: 0 };
        let unsaid = Welcome { version: 0, schema: 0, rate_hz: 0, limits };
        let mut connection = Self { socket, heard, kept: VecDeque::new(), welcome: unsaid, numbers: 0 };
        connection.say(&FromViewer::Hello(ViewerHello::new(token)))?;
        connection.welcome = connection.until(WELCOME_WITHIN, |message| match message {
            ToViewer::Welcome(welcome) => Some(*welcome),
            _ => None,
        })?;
        check_viewer_version(connection.welcome.version, connection.welcome.schema).map_err(ClientError::Version)?;
        Ok(connection)
    }

    /// What the host said of itself.
    pub const fn welcome(&self) -> &Welcome {
        &self.welcome
    }

    /// Says something.
    ///
    /// # Errors
    /// [`ClientError::Closed`] when the host is gone.
    pub fn say(&self, message: &FromViewer) -> Result<(), ClientError> {
        say(&self.socket, message)
    }

    /// Says what it wants to see.
    ///
    /// # Errors
    /// As [`Self::say`].
    pub fn subscribe(&self, subscription: Subscription) -> Result<(), ClientError> {
        self.say(&FromViewer::Subscribe(subscription))
    }

    /// Asks for something without waiting for the answer, which carries the number this yields.
    ///
    /// # Errors
    /// As [`Self::say`].
    pub fn ask(&mut self, what: Wish) -> Result<u32, ClientError> {
        self.numbers = self.numbers.wrapping_add(1);
        self.say(&FromViewer::Ask(Ask { number: self.numbers, what }))?;
        Ok(self.numbers)
    }

    /// Asks for something and waits for the answer.
    ///
    /// # Errors
    /// [`ClientError::Denied`] with the host's reason; others as for [`Self::next`].
    pub fn request(&mut self, what: Wish) -> Result<(), ClientError> {
        let number = self.ask(what)?;
        self.until(ANSWER_WITHIN, |message| answer(message, number))?
    }

    /// The next thing the host says; `None` when it says nothing within `wait`.
    ///
    /// # Errors
    /// [`ClientError::Refused`] when the host closes and says why, [`ClientError::Closed`] when it is gone.
    pub fn next(&mut self, wait: Duration) -> Result<Option<ToViewer>, ClientError> {
        if let Some(message) = self.kept.pop_front() {
            return Ok(Some(message));
        }
        self.receive(wait)
    }

    /// Waits for what `pick` picks; everything else is kept for [`Self::next`], in order.
    ///
    /// # Errors
    /// [`ClientError::Silent`] when it does not come; others as for [`Self::next`].
    pub fn until<T>(&mut self, within: Duration, mut pick: impl FnMut(&ToViewer) -> Option<T>) -> Result<T, ClientError> {
        let end = Instant::now() + within;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Some(message) = self.receive(left)? else { return Err(ClientError::Silent(within.as_secs())) };
            if let Some(found) = pick(&message) {
                return Ok(found);
            }
            if self.kept.len() == KEPT {
                self.kept.pop_front();
            }
            self.kept.push_back(message);
        }
    }

    fn receive(&self, wait: Duration) -> Result<Option<ToViewer>, ClientError> {
        match self.heard.recv_timeout(wait) {
            Ok(ToViewer::Refused(refusal)) if refusal.why == RefusalCause::Version => {
                Err(ClientError::Version(refusal.mismatch()))
            }
            Ok(ToViewer::Refused(refusal)) => Err(ClientError::Refused(refusal)),
            Ok(message) => Ok(Some(message)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(ClientError::Closed),
        }
    }
}

impl Drop for Connection {
    /// Ends the reading thread.
    fn drop(&mut self) {
        self.socket.lock().unwrap_or_else(PoisonError::into_inner).close();
    }
}

/// The answer to a request, if this is it.
pub(super) fn answer(message: &ToViewer, number: u32) -> Option<Result<(), ClientError>> {
    match message {
        ToViewer::Done(done) if *done == number => Some(Ok(())),
        ToViewer::Denied(denied) if denied.number == number => Some(Err(ClientError::Denied(Box::new(denied.clone())))),
        _ => None,
    }
}

fn say(socket: &Mutex<Socket>, message: &FromViewer) -> Result<(), ClientError> {
    let mut frame = [0; stream_bound(FromViewer::MAX_ENCODED)];
    // the buffer has the longest message's bound
    let length = encode_stream(message, &mut frame).unwrap_or(0);
    let mut socket = socket.lock().unwrap_or_else(PoisonError::into_inner);
    socket.write_all(&frame[..length]).map_err(|_| ClientError::Closed)
}

/// Reads until the connection ends or nobody listens, and pings meanwhile.
fn listen(mut socket: Socket, pings: &Mutex<Socket>, send: &SyncSender<ToViewer>) {
    let (mut decoder, mut bytes) = (StreamDecoder::<FRAME_MAX>::new(), vec![0; 1 << 16]);
    let mut pinged = Instant::now();
    loop {
        let count = match socket.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
            Err(_) => return,
        };
        for &byte in &bytes[..count] {
            match decoder.push(byte) {
                // the answers to our own pings are no news
                None | Some(ToViewer::Pong(0)) => {}
                Some(message) => {
                    if send.send(message).is_err() {
                        return;
                    }
                }
            }
        }
        if pinged.elapsed() > PING_EVERY {
            pinged = Instant::now();
            if say(pings, &FromViewer::Ping(0)).is_err() {
                return;
            }
        }
    }
}

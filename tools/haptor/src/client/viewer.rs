//! A viewer that comes back: what it wants to see is said again on every new connection.

use std::time::{Duration, Instant};

use haptor_wire::{Subscription, ToViewer, Wish};

use super::address::{Address, Token};
use super::connection::Connection;
use super::error::ClientError;

/// Time between two attempts to come back.
const RETRY: Duration = Duration::from_millis(500);

/// What a viewer hears.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "a message lives from its coming to its handling, never in a collection")]
pub enum News {
    /// The host says something.
    Message(ToViewer),
    /// Let in, for the first time or again.
    Connected,
    /// The connection was lost; it is being made anew.
    Lost(ClientError),
}

/// A viewer.
#[derive(Debug)]
pub struct Viewer {
    address: Address,
    token: Token,
    subscription: Subscription,
    points: Vec<[f32; 3]>,
    connection: Option<Connection>,
    retry: Instant,
}

impl Viewer {
    /// Connects.
    ///
    /// # Errors
    /// [`ClientError`] when that does not succeed at once.
    pub fn connect(address: Address, token: Token) -> Result<Self, ClientError> {
        let connection = Some(Connection::open(&address, token)?);
        let (subscription, points) = (Subscription::default(), Vec::new());
        Ok(Self { address, token, subscription, points, connection, retry: Instant::now() })
    }

    /// The connection, while there is one.
    pub const fn connection(&mut self) -> Option<&mut Connection> {
        self.connection.as_mut()
    }

    /// Says what it wants to see, now and on every new connection.
    pub fn subscribe(&mut self, subscription: Subscription) {
        self.subscription = subscription;
        if self.connection.as_ref().is_some_and(|connection| connection.subscribe(subscription).is_err()) {
            self.connection = None;
        }
    }

    /// Says which points are to be watched, now and on every new connection.
    ///
    /// # Errors
    /// [`ClientError::NotTaken`] when the host does not take them.
    pub fn watch_points(&mut self, points: Vec<[f32; 3]>) -> Result<(), ClientError> {
        self.points = points;
        let Some(connection) = &mut self.connection else { return Ok(()) };
        match connection.watch_points(&self.points) {
            Err(error) if error.is_lost_connection() => {
                self.connection = None;
                Ok(())
            }
            other => other,
        }
    }

    /// Asks for something; the answer comes among the news. `None` while there is no connection.
    pub fn ask(&mut self, what: Wish) -> Option<u32> {
        let asked = self.connection.as_mut()?.ask(what).ok();
        if asked.is_none() {
            self.connection = None;
        }
        asked
    }

    /// The next news; `None` when there are none within `wait`.
    ///
    /// # Errors
    /// [`ClientError`] that coming back cannot mend: another version, a wrong token.
    pub fn next(&mut self, wait: Duration) -> Result<Option<News>, ClientError> {
        let Some(connection) = &mut self.connection else { return self.come_back(wait) };
        match connection.next(wait) {
            Ok(message) => Ok(message.map(News::Message)),
            Err(error) => {
                self.connection = None;
                self.retry = Instant::now() + RETRY;
                if error.is_lost_connection() { Ok(Some(News::Lost(error))) } else { Err(error) }
            }
        }
    }

    fn come_back(&mut self, wait: Duration) -> Result<Option<News>, ClientError> {
        let now = Instant::now();
        if now < self.retry {
            std::thread::sleep(wait.min(self.retry - now));
            return Ok(None);
        }
        self.retry = now + RETRY;
        let back = Connection::open(&self.address, self.token).and_then(|mut connection| {
            connection.subscribe(self.subscription)?;
            if !self.points.is_empty() {
                connection.watch_points(&self.points)?;
            }
            Ok(connection)
        });
        match back {
            Ok(connection) => {
                self.connection = Some(connection);
                Ok(Some(News::Connected))
            }
            Err(error) if error.is_lost_connection() => Ok(None),
            Err(error) => Err(error),
        }
    }
}

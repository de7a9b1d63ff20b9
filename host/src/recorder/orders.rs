//! What other threads may ask of the recorder while the session runs.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender, SyncSender, sync_channel};

use super::tap::{Tap, TapEnd, tap};
use crate::error::HostError;

/// One thing asked.
#[derive(Debug)]
pub(super) enum Order {
    /// Begin a recording.
    Begin(PathBuf, SyncSender<Result<(), HostError>>),
    /// End it; yields whether there was one.
    End(SyncSender<bool>),
    /// Pass every frame from now on.
    Tap(TapEnd),
    /// The file of a scene that the session may go to.
    Scene(Arc<[u8]>),
}

/// The asking end. Any thread but the real-time one may hold one.
#[derive(Clone, Debug)]
pub struct Orders(Sender<Order>);

/// Both ends.
#[must_use]
pub(super) fn orders() -> (Orders, Receiver<Order>) {
    let (asked, orders) = mpsc::channel();
    (Orders(asked), orders)
}

impl Orders {
    /// Begins a recording in a new file. Its ticks can be computed again from the next `Rest` on, which the real-time thread is asked for: the first tick without
    /// contact.
    ///
    /// # Errors
    /// [`HostError::File`] when the file cannot be created, or a recording is being made; [`HostError::Panicked`] when the recorder is gone.
    pub fn begin(&self, path: PathBuf) -> Result<(), HostError> {
        self.ask(|answer| Order::Begin(path, answer))?
    }

    /// Ends the recording; yields whether there was one.
    ///
    /// # Errors
    /// [`HostError::Panicked`] when the recorder is gone.
    pub fn end(&self) -> Result<bool, HostError> {
        self.ask(Order::End)
    }

    /// A reader of every frame from now on, as a file begun now would hold them; `room` elements are kept for a slow one. Without a recorder it is closed at once.
    #[must_use]
    pub fn tap(&self, room: usize) -> Tap {
        let (end, reader) = tap(room);
        // a recorder that is gone drops its end
        let _ = self.0.send(Order::Tap(end));
        reader
    }

    /// Makes the file of a scene known, before the session goes to it.
    pub fn scene(&self, file: Arc<[u8]>) {
        let _ = self.0.send(Order::Scene(file));
    }

    fn ask<T>(&self, order: impl FnOnce(SyncSender<T>) -> Order) -> Result<T, HostError> {
        let (answer, answered) = sync_channel(1);
        let gone = || HostError::Panicked { name: "recorder" };
        self.0.send(order(answer)).map_err(|_| gone())?;
        answered.recv().map_err(|_| gone())
    }
}

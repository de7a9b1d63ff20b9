//! Readers of the recording while it is made: each gets the frames that a file begun at the same moment would hold, through a queue of its own. A reader that
//! is too slow loses frames, and is told how many by a `Lost` in their place; one that is gone is forgotten.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

use haptor_wire::Record;
use haptor_wire::frame::FrameError;

use super::origin::{Frames, append};

/// The reader's end. Every element is one or more whole frames; closed when the session ends.
pub type Tap = Receiver<Frames>;

/// The recorder's end.
#[derive(Debug)]
pub struct TapEnd {
    frames: SyncSender<Frames>,
    /// Records that found no room since the last that did.
    missing: u64,
}

/// Both ends of a queue of `room` elements.
pub fn tap(room: usize) -> (TapEnd, Tap) {
    let (frames, reader) = sync_channel(room);
    (TapEnd { frames, missing: 0 }, reader)
}

impl TapEnd {
    /// Passes frames of `records` records on; false when the reader is gone.
    pub fn pass(&mut self, frames: &Frames, records: u64) -> bool {
        if self.missing > 0 {
            let Ok(told) = lost(self.missing) else { return false };
            match self.frames.try_send(told) {
                Ok(()) => self.missing = 0,
                Err(TrySendError::Full(_)) => {
                    self.missing += records;
                    return true;
                }
                Err(TrySendError::Disconnected(_)) => return false,
            }
        }
        match self.frames.try_send(frames.clone()) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                self.missing += records;
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }
}

fn lost(count: u64) -> Result<Frames, FrameError> {
    let mut frames = Vec::new();
    append(&mut frames, &Record::Lost { count })?;
    Ok(frames.into())
}

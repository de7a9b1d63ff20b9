//! Files on their way to a viewer, as fast as it reads: a recording while it is made, and the scene that runs.

use std::collections::VecDeque;
use std::sync::Arc;

use haptor_wire::viewer::CHUNK_BYTES;
use haptor_wire::{RecordBytes, SceneBytes, ToViewer};

use super::outbox::Outbox;
use crate::recorder::origin::Frames;
use crate::recorder::tap::Tap;

/// Elements of a recording that wait for a slow viewer at most: eight seconds of ticks at the default rate. Beyond, the recording says what is missing.
pub const TAP_ROOM: usize = 8192;

/// A recording on its way.
#[derive(Debug)]
pub struct Recording {
    /// Where more comes from; `None` once it has been ended.
    tap: Option<Tap>,
    waiting: VecDeque<Frames>,
    /// Bytes of the first in `waiting` that have gone.
    gone: usize,
    offset: u64,
    /// The request that ended it.
    ended_by: Option<u32>,
}

impl Recording {
    /// Of what a tap yields.
    #[must_use]
    pub const fn new(tap: Tap) -> Self {
        Self { tap: Some(tap), waiting: VecDeque::new(), gone: 0, offset: 0, ended_by: None }
    }

    /// What has been recorded so far still goes out; then the request of this number is done.
    pub fn end(&mut self, request: u32) {
        if let Some(tap) = self.tap.take() {
            self.waiting.extend(tap.try_iter());
        }
        self.ended_by = Some(request);
    }

    /// Whether it has been ended.
    #[must_use]
    pub const fn is_ending(&self) -> bool {
        self.ended_by.is_some()
    }

    /// Moves on; false when all of it has gone.
    pub fn pump(&mut self, outbox: &mut Outbox) -> bool {
        while outbox.has_room() {
            let bytes = self.next_bytes();
            if bytes.is_empty() {
                return self.tap.is_some();
            }
            let message = RecordBytes { offset: self.offset, bytes };
            self.offset += message.bytes.len() as u64;
            outbox.put(&ToViewer::RecordBytes(message));
        }
        true
    }

    /// The request that ended it.
    #[must_use]
    pub const fn ended_by(&self) -> Option<u32> {
        self.ended_by
    }

    fn next_bytes(&mut self) -> heapless::Vec<u8, CHUNK_BYTES> {
        let mut bytes = heapless::Vec::new();
        while bytes.len() < CHUNK_BYTES {
            let Some(frames) = self.front() else { break };
            let left = frames.get(self.gone..).unwrap_or(&[]);
            let taken = left.len().min(CHUNK_BYTES - bytes.len());
            // there is room: so much was asked for
            let _ = bytes.extend_from_slice(&left[..taken]);
            self.gone += taken;
            if taken == left.len() {
                self.waiting.pop_front();
                self.gone = 0;
            }
        }
        bytes
    }

    fn front(&mut self) -> Option<Frames> {
        if self.waiting.is_empty() {
            self.waiting.extend(self.tap.as_ref().and_then(|tap| tap.try_recv().ok()));
        }
        self.waiting.front().cloned()
    }
}

/// The file of a scene on its way.
#[derive(Debug)]
pub struct Download {
    digest: u64,
    file: Arc<[u8]>,
    gone: usize,
    /// The request.
    pub number: u32,
}

impl Download {
    /// Of the whole file.
    #[must_use]
    pub const fn new(digest: u64, file: Arc<[u8]>, number: u32) -> Self {
        Self { digest, file, gone: 0, number }
    }

    /// Moves on; false when all of it has gone.
    pub fn pump(&mut self, outbox: &mut Outbox) -> bool {
        while outbox.has_room() {
            let left = self.file.get(self.gone..).unwrap_or(&[]);
            let Some(piece) = left.chunks(CHUNK_BYTES).next() else { return false };
            // lengths of files are below 4 GiB: they were uploaded, or read whole
            let (offset, of) = (self.gone as u32, self.file.len() as u32);
            let bytes = piece.iter().copied().collect();
            self.gone += piece.len();
            outbox.put(&ToViewer::SceneBytes(SceneBytes { digest: self.digest, offset, of, bytes }));
        }
        true
    }
}

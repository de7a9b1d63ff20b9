//! The last second of ticks, kept in memory that is there from the start and handed over with any fault.
//!
//! Two buffers: one records while the other is being written to a file by an ordinary thread and comes back. Handing over moves a
//! pointer. While both are away nothing is lost but the hand-over itself, and that is counted.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use haptor_wire::{FaultRecord, TickRecord};
use rtrb::{Consumer, Producer, RingBuffer};

use super::scale::ticks_at;

/// Ticks kept at the default rate ([`super::scale`]): a second, ten times the longest fault drill.
pub const BLACKBOX_TICKS: u32 = 1000;

/// Buffers going round: one recording, one with the writer.
const BUFFERS: usize = 2;

/// A full or partly full ring of ticks.
#[derive(Debug)]
pub struct Ring {
    ticks: Box<[TickRecord]>,
    recorded: usize,
}

impl Ring {
    fn new(rate_hz: u32) -> Self {
        let ticks = vec![TickRecord::default(); ticks_at(rate_hz, BLACKBOX_TICKS) as usize];
        Self { ticks: ticks.into_boxed_slice(), recorded: 0 }
    }

    fn push(&mut self, tick: &TickRecord) {
        let at = self.recorded % self.ticks.len();
        self.ticks[at] = *tick;
        self.recorded += 1;
    }

    /// The ticks, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &TickRecord> {
        let kept = self.recorded.min(self.ticks.len());
        let oldest = self.recorded - kept;
        (oldest..self.recorded).map(|i| &self.ticks[i % self.ticks.len()])
    }
}

/// What is handed over: the fault and the ticks up to it.
#[derive(Debug)]
pub struct Dump {
    /// The fault.
    pub fault: FaultRecord,
    /// The last ticks, the one in which the fault latched included.
    pub ring: Ring,
}

/// The recording end, on the real-time thread.
#[derive(Debug)]
pub struct BlackBox {
    ring: Option<Ring>,
    dumps: Producer<Dump>,
    spare: Consumer<Ring>,
    lost: Arc<AtomicU32>,
}

/// The writing end, on an ordinary thread.
#[derive(Debug)]
pub struct BlackBoxReader {
    dumps: Consumer<Dump>,
    spare: Producer<Ring>,
    lost: Arc<AtomicU32>,
}

/// Both ends for so many ticks a second, with all their memory.
#[must_use]
pub fn black_box(rate_hz: u32) -> (BlackBox, BlackBoxReader) {
    let (dumps, reader_dumps) = RingBuffer::new(BUFFERS);
    let (mut reader_spare, spare) = RingBuffer::new(BUFFERS);
    for _ in 1..BUFFERS {
        let _ = reader_spare.push(Ring::new(rate_hz));
    }
    let lost = Arc::default();
    let writer = BlackBox { ring: Some(Ring::new(rate_hz)), dumps, spare, lost: Arc::clone(&lost) };
    (writer, BlackBoxReader { dumps: reader_dumps, spare: reader_spare, lost })
}

impl BlackBox {
    /// Keeps a tick, over the oldest.
    pub fn record(&mut self, tick: &TickRecord) {
        if self.ring.is_none() {
            self.ring = self.spare.pop().ok();
        }
        if let Some(ring) = &mut self.ring {
            ring.push(tick);
        }
    }

    /// Hands the ticks so far over with `fault` and begins anew.
    pub fn hand_over(&mut self, fault: FaultRecord) {
        let Some(ring) = self.ring.take() else {
            self.lost.fetch_add(1, Ordering::Relaxed);
            return;
        };
        // as many places as buffers: there is room
        let _ = self.dumps.push(Dump { fault, ring });
    }
}

impl BlackBoxReader {
    /// The next dump, if any.
    pub fn take(&mut self) -> Option<Dump> {
        self.dumps.pop().ok()
    }

    /// Returns a buffer for the next ticks.
    pub fn give_back(&mut self, mut ring: Ring) {
        ring.recorded = 0;
        // as many places as buffers: there is room
        let _ = self.spare.push(ring);
    }

    /// Faults since the last call whose ticks could not be handed over because the writer still had both buffers.
    pub fn take_lost(&mut self) -> u32 {
        self.lost.swap(0, Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_wire::HostFault;

    const FAULT: FaultRecord = FaultRecord { cause: HostFault::Stale, tick: 0, after_ticks: 20 };

    fn record(writer: &mut BlackBox, ticks: std::ops::Range<u64>) {
        ticks.for_each(|tick| writer.record(&TickRecord { tick, ..TickRecord::default() }));
    }

    #[test]
    fn the_last_second_comes_oldest_first() {
        let (mut writer, mut reader) = black_box(1000);
        for (from, to, first) in [(0, 10, 0), (0, 1000, 0), (0, 2345, 1345)] {
            record(&mut writer, from..to);
            writer.hand_over(FAULT);
            let dump = reader.take().unwrap();
            assert!(dump.ring.iter().map(|t| t.tick).eq(first..to));
            reader.give_back(dump.ring);
        }
    }

    #[test]
    fn a_writer_that_keeps_both_buffers_costs_hand_overs_and_no_more() {
        let (mut writer, mut reader) = black_box(1000);
        for _ in 0..3 {
            record(&mut writer, 0..5);
            writer.hand_over(FAULT);
        }
        assert_eq!((reader.take_lost(), reader.take_lost()), (1, 0));
        let dump = reader.take().unwrap();
        reader.give_back(dump.ring);
        record(&mut writer, 7..9);
        writer.hand_over(FAULT);
        reader.take().unwrap();
        assert!(reader.take().unwrap().ring.iter().map(|t| t.tick).eq(7..9));
    }
}

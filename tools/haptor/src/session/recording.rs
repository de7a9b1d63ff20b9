//! A recording read back: ticks, faults, summary, and how much of the file was damaged.

use std::path::Path;

use haptor_wire::recording::RecordReader;
use haptor_wire::{FaultRecord, HostFault, Record, Summary, TickRecord};

/// What a recording holds.
#[derive(Debug, Default)]
pub struct Recording {
    /// Ticks in order.
    pub ticks: Vec<TickRecord>,
    /// Faults that latched.
    pub faults: Vec<FaultRecord>,
    /// The summary, when the session ended in order.
    pub summary: Option<Summary>,
    /// Damaged places, the cut end of an unfinished file among them.
    pub damaged: usize,
}

impl Recording {
    /// Reads a recording as far as it goes.
    ///
    /// # Errors
    /// When the file cannot be read at all.
    pub fn read(path: &Path) -> std::io::Result<Self> {
        let mut file = std::fs::read(path)?;
        let mut recording = Self::default();
        for record in RecordReader::new(&mut file) {
            match record {
                Ok(Record::Tick(tick)) => recording.ticks.push(tick),
                Ok(Record::Fault(fault)) => recording.faults.push(fault),
                Ok(Record::End(summary)) => recording.summary = Some(summary),
                Ok(_) => {}
                Err(_) => recording.damaged += 1,
            }
        }
        Ok(recording)
    }

    /// The first fault that latched, wherever it was written.
    pub fn fault(&self) -> Option<HostFault> {
        self.faults.first().map(|fault| fault.cause).or(self.summary.and_then(|summary| summary.fault))
    }
}

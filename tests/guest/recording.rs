//! A recording, whole.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use haptor_wire::recording::RecordReader;
use haptor_wire::{FaultRecord, Record, Summary, TickRecord};

/// What a file holds; a black box has no summary.
#[derive(Debug, Default)]
pub struct Recording {
    pub ticks: Vec<TickRecord>,
    pub faults: Vec<FaultRecord>,
    pub summary: Option<Summary>,
    /// Serial number that the device told.
    pub serial: String,
}

impl Recording {
    /// Reads a file; a damaged place in it is an error.
    pub fn read(path: &Path) -> Result<Self> {
        let mut bytes = fs::read(path).with_context(|| format!("{}", path.display()))?;
        let mut all = Self::default();
        let mut damaged = 0;
        for record in RecordReader::new(&mut bytes) {
            match record {
                Ok(Record::Device(device)) => {
                    let told = device.device_serial.into_iter().take_while(|&byte| byte != 0);
                    all.serial = told.map(char::from).collect();
                }
                Ok(Record::Tick(tick)) => all.ticks.push(tick),
                Ok(Record::Fault(fault)) => all.faults.push(fault),
                Ok(Record::End(summary)) => all.summary = Some(summary),
                Ok(_) => {}
                Err(_) => damaged += 1,
            }
        }
        ensure!(damaged == 0, "{}: {damaged} places are damaged", path.display());
        Ok(all)
    }
}

/// Length of a vector.
pub fn length(v: [f32; 3]) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}

/// The device gets nothing.
pub fn is_zero(tick: &TickRecord) -> bool {
    length(tick.force) == 0.0 && length(tick.torque) == 0.0
}

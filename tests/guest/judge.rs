//! What a drill's recording must show, whatever the drill was.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use haptor_host::rt::blackbox::BLACKBOX_TICKS;
use haptor_host::rt::stale::SMALL_FORCE;
use haptor_wire::{FaultRecord, flags};

use crate::programs::black_box;
use crate::recording::{Recording, is_zero, length};

/// Force at which the hand is taken to press \[N\].
const PRESSING: f32 = 3.0;

/// What a drill's fault looked like.
#[derive(Debug)]
pub struct Seen {
    /// The fault.
    pub fault: FaultRecord,
    /// Ticks from the drill to the fault.
    pub detected: u64,
    /// Ticks from the drill to the first zero wrench.
    pub zero: u64,
    /// Ticks from the drill until forces were back, if they came back.
    pub recovered: Option<u64>,
}

/// Finds the fault of the drill in tick `at` and holds it against the rules that all faults obey.
pub fn fault(recording: &Recording, at: u64) -> Result<Seen> {
    let fault = *recording.faults.first().context("no fault was latched")?;
    let ticks = &recording.ticks;
    let index = ticks.iter().position(|tick| tick.tick == fault.tick).context("the fault's tick is not recorded")?;
    ensure!(ticks[..index].iter().any(|tick| length(tick.force) > PRESSING), "the hand did not press before");
    ensure!(fault.tick >= at, "{fault:?} came before the drill in tick {at}");
    let summary = recording.summary.context("the recording has no end")?;
    ensure!(summary.fault == Some(fault.cause), "latched is {:?}, not {:?}", summary.fault, fault.cause);

    let zero = ticks.iter().find(|tick| tick.tick >= at && is_zero(tick)).context("the wrench was never zero")?;
    let closed: Vec<_> = ticks[index..].iter().take_while(|tick| tick.flags & flags::CLOSED != 0).collect();
    ensure!(!closed.is_empty(), "the output did not close");
    ensure!(closed.iter().all(|tick| is_zero(tick)), "a wrench went out while closed");
    let opened = ticks.get(index + closed.len());
    if let Some(opened) = opened {
        ensure!(length(opened.contact_force) < SMALL_FORCE, "opened at {} N", length(opened.contact_force));
    }
    let back = ticks[index + closed.len()..].iter().find(|tick| length(tick.force) > PRESSING);
    Ok(Seen {
        fault,
        detected: fault.tick - at,
        zero: zero.tick - at,
        recovered: back.and(opened).map(|opened| opened.tick - at),
    })
}

/// The black box reads, is of this fault, ends with it, and shows how the hand pressed.
pub fn black_box_of(recording: &Path, fault: &FaultRecord) -> Result<()> {
    let kept = Recording::read(&black_box(recording))?;
    ensure!(kept.faults.first() == Some(fault), "the black box is of {:?}", kept.faults);
    let until: Vec<_> = kept.ticks.iter().take_while(|tick| tick.tick <= fault.tick).collect();
    ensure!(until.last().is_some_and(|tick| tick.tick == fault.tick), "the fault's tick is not in the black box");
    ensure!(until.len() <= BLACKBOX_TICKS, "{} ticks", until.len());
    ensure!(until.iter().any(|tick| length(tick.force) > PRESSING), "the press is not in the black box");
    Ok(())
}

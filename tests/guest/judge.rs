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
    ensure!(until.len() <= BLACKBOX_TICKS as usize, "{} ticks", until.len());
    ensure!(until.iter().any(|tick| length(tick.force) > PRESSING), "the press is not in the black box");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_wire::{HostFault, Summary, TickRecord};

    /// Pressed until the fault in tick 1102, closed to 1499, open from then on, pressed anew from 1600 on.
    fn session(change: impl Fn(&mut Recording)) -> Recording {
        let fault = FaultRecord { cause: HostFault::LinkLost, tick: 1_102, after_ticks: 0 };
        let ticks = (0..2_000).map(|tick| {
            let closed = (1_102..1_500).contains(&tick);
            let force = if closed || (1_500..1_600).contains(&tick) { 0.0 } else { 5.0 };
            let (force, flags) = ([0.0, 0.0, force], if closed { flags::CLOSED } else { 0 });
            TickRecord { tick, force, flags, ..TickRecord::default() }
        });
        let summary = Summary { fault: Some(fault.cause), ..Summary::default() };
        let mut recording =
            Recording { ticks: ticks.collect(), faults: vec![fault], summary: Some(summary), ..Recording::default() };
        change(&mut recording);
        recording
    }

    #[test]
    fn a_session_that_obeys_the_rules_is_measured() {
        let seen = fault(&session(|_| {}), 1_100).unwrap();
        assert_eq!((seen.detected, seen.zero, seen.recovered), (2, 2, Some(400)));
        let never_back = session(|recording| recording.ticks.truncate(1_550));
        assert_eq!(fault(&never_back, 1_100).unwrap().recovered, None);
    }

    /// What is done to a good session.
    type Change = fn(&mut Recording);

    #[test]
    fn each_broken_rule_is_named() {
        let table: [(&str, Change); 7] = [
            ("no fault", |r| r.faults.clear()),
            ("before the drill", |r| r.faults[0].tick = 1_000),
            ("latched is", |r| r.summary = Some(Summary::default())),
            ("has no end", |r| r.summary = None),
            ("did not press", |r| r.ticks.iter_mut().for_each(|tick| tick.force = [0.0; 3])),
            ("while closed", |r| r.ticks[1_300].torque = [0.0, 0.01, 0.0]),
            ("opened at 2 N", |r| r.ticks[1_500].contact_force = [0.0, 2.0, 0.0]),
        ];
        for (part, change) in table {
            let error = fault(&session(change), 1_100).unwrap_err().to_string();
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}

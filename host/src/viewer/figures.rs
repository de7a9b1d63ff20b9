//! The session in figures while it runs, from the records that the recorder sees anyway: the real-time thread has no part in it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use haptor_wire::{Record, Summary, flags};

use crate::rt::account::length;
use crate::rt::histogram::Durations;

/// Figures that the recorder's thread writes and the viewers' thread reads.
#[derive(Clone, Debug, Default)]
pub struct SharedFigures(Arc<Mutex<Figures>>);

impl SharedFigures {
    /// Takes note of a record.
    pub fn note(&self, record: &Record<'_>) {
        self.lock().note(record);
    }

    /// The session so far.
    #[must_use]
    pub fn summary(&self) -> Summary {
        self.lock().summary()
    }

    fn lock(&self) -> MutexGuard<'_, Figures> {
        // counts are whole after every statement
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Counts and histograms of the ticks that were recorded.
#[derive(Debug, Default)]
struct Figures {
    session: Summary,
    wake: Durations,
    step: Durations,
    round_trip: Durations,
    /// Number of the tick after the last one.
    next: Option<u64>,
}

impl Figures {
    fn note(&mut self, record: &Record<'_>) {
        match record {
            Record::Device(hello) => self.session.rt = hello.rt,
            Record::Fault(fault) => self.session.fault = self.session.fault.or(Some(fault.cause)),
            Record::Lost { count } => self.session.recorder_dropped += count,
            Record::Tick(tick) => {
                let slept_through = self.next.map_or(0, |next| tick.tick.saturating_sub(next));
                self.next = Some(tick.tick + 1);
                let in_time = tick.flags & flags::LATE == 0;
                self.session.in_time += u64::from(in_time);
                self.session.late += slept_through + u64::from(!in_time);
                self.session.ticks = self.session.in_time + self.session.late;
                self.wake.record_ns(tick.wake_ns.into());
                if tick.flags & flags::NO_POSE == 0 {
                    self.step.record_ns(tick.step_ns.into());
                }
                if tick.round_trip_ns > 0 {
                    self.round_trip.record_ns(tick.round_trip_ns.into());
                }
                if tick.was_felt() {
                    self.session.peak_force = self.session.peak_force.max(length(tick.contact_force));
                    self.session.peak_torque = self.session.peak_torque.max(length(tick.contact_torque));
                }
            }
            _ => {}
        }
    }

    fn summary(&self) -> Summary {
        Summary {
            wake_ns: self.wake.quantiles(),
            step_ns: self.step.quantiles(),
            round_trip_ns: self.round_trip.quantiles(),
            ..self.session
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptor_wire::{FaultRecord, HostFault, TickRecord};

    #[test]
    fn ticks_are_counted_as_the_loop_counts_them() {
        let figures = SharedFigures::default();
        let tick = |tick, flags, force| TickRecord {
            tick,
            flags,
            contact_force: [0.0, 0.0, force],
            step_ns: 3000,
            round_trip_ns: 1000,
            ..TickRecord::default()
        };
        // the third comes after two that were slept through, the last is late, and nobody felt the second
        for record in [tick(0, 0, 1.0), tick(1, flags::CLOSED, 9.0), tick(4, 0, 2.0), tick(5, flags::LATE | flags::NO_POSE, 0.0)]
        {
            figures.note(&Record::Tick(record));
        }
        figures.note(&Record::Fault(FaultRecord { cause: HostFault::Stale, tick: 5, after_ticks: 20 }));
        let summary = figures.summary();
        assert_eq!((summary.ticks, summary.in_time, summary.late), (6, 3, 3));
        assert_eq!((summary.fault, summary.peak_force), (Some(HostFault::Stale), 2.0));
        assert_eq!((summary.step_ns.max, summary.round_trip_ns.max), (3000, 1000));
    }
}

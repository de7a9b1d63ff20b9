//! The loop. Words are in [`super`]; what each call does is in [`super::parts`] and the files it names.

use std::sync::atomic::{AtomicBool, Ordering};

use haptor_wire::{RtReport, Summary};

use super::account::Account;
use super::clock::Clock;
use super::desk::Desk;
use super::faults::Faults;
use super::handshake::Handshake;
use super::line::Line;
use super::orders::Pause;
use super::pace::Pace;
use super::parts::{Memory, Settings};
use super::stale::Output;
use haptor_engine::OwnedEngine;

/// Everything the real-time thread owns.
#[derive(Debug)]
pub struct Control<C> {
    pub(super) settings: Settings,
    pub(super) clock: C,
    pub(super) pace: Pace,
    pub(super) line: Line,
    pub(super) handshake: Handshake,
    pub(super) engine: OwnedEngine,
    pub(super) output: Output,
    pub(super) faults: Faults,
    pub(super) account: Account,
    pub(super) memory: Memory,
    pub(super) desk: Desk,
    pub(super) pause: Pause,
}

impl<C: Clock> Control<C> {
    /// A loop at rest, with all its memory; the first tick is due now.
    pub fn new(settings: Settings, clock: C, line: Line, engine: OwnedEngine, account: Account, desk: Desk) -> Self {
        Self {
            pace: Pace::new(settings.follow, settings.period_ns(), &clock),
            handshake: Handshake::new(settings.period_us()),
            output: Output::new(settings.stale),
            faults: Faults::default(),
            memory: Memory::default(),
            pause: Pause::default(),
            desk,
            settings,
            clock,
            line,
            engine,
            account,
        }
    }

    /// Runs until the session is over or `stop` is set.
    pub fn run(&mut self, stop: &AtomicBool) {
        while !stop.load(Ordering::Relaxed) && !self.is_over() {
            self.tick();
        }
        self.part();
    }

    /// One tick. Cannot fail; allocates nothing, locks nothing.
    pub fn tick(&mut self) {
        let slot = self.pace.begin(&self.clock);
        let got = self.line.gather(&self.clock, slot.receive_until_ns);
        let slot = self.pace.arrived(slot, &self.clock);
        self.obey(&got, &slot);
        self.attend(&slot);
        self.begin_session(&slot);
        let offer = self.feel(&got, &slot);
        let wrench = self.choose(&offer, &got, &slot);
        self.say(&wrench, &slot);
        self.close(&wrench, &slot);
    }

    /// Every duration of the session as a table; for after the last tick.
    #[must_use]
    pub fn times(&self) -> String {
        self.account.times(&self.line)
    }

    /// The session in figures, so far.
    #[must_use]
    pub fn summary(&self, rt: RtReport) -> Summary {
        self.account.summary(&self.line, &self.faults, rt)
    }
}

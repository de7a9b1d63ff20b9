//! What a session leaves behind: one record a tick, figures, and news for who looks on. Everything goes into bounded queues whose
//! memory is there from the start; what does not fit is dropped and counted.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use haptor_wire::{
    FaultRecord, FromHost, Place, Progress, Quantiles, Record, RtReport, SessionHello, Summary, TickRecord, Tuning,
};
use rtrb::{Consumer, Producer, RingBuffer};

use super::blackbox::BlackBox;
use super::budget::Budget;
use super::faults::Faults;
use super::histogram::Durations;
use super::line::Line;
use super::scale::ticks_at;

/// Records that the recorder may fall behind, at the default rate ([`super::scale`]): four seconds, longer than a disk stalls.
const RECORDS_WAITING: u32 = 4096;

/// News that the status thread may fall behind.
const NEWS_WAITING: usize = 64;

/// Time between two progress messages \[ns\]: a progress bar wants no more.
const PROGRESS_EVERY_NS: u64 = 100_000_000;

/// The other ends of the queues.
#[derive(Debug)]
pub struct Readers {
    /// The device, ticks and faults, for the recording.
    pub records: Consumer<Record<'static>>,
    /// Hello, progress and faults, for the status.
    pub news: Consumer<FromHost>,
    /// Set by the recorder to ask for a `Rest` in the recording.
    pub rest_wanted: Arc<AtomicBool>,
}

/// The books of a session.
#[derive(Debug)]
pub struct Account {
    budget: Budget,
    wake: Durations,
    step: Durations,
    peak_force: f32,
    peak_torque: f32,
    black_box: BlackBox,
    records: Producer<Record<'static>>,
    news: Producer<FromHost>,
    rest_wanted: Arc<AtomicBool>,
    dropped: u64,
    /// Records dropped since the last that found room.
    missing: u64,
    progress_due_ns: u64,
    /// A fault latched in the tick that is not booked yet.
    fault: Option<FaultRecord>,
}

impl Account {
    /// Empty books for so many ticks a second, and the other ends of their queues.
    #[must_use]
    pub fn new(black_box: BlackBox, rate_hz: u32) -> (Self, Readers) {
        let (records, records_out) = RingBuffer::new(ticks_at(rate_hz, RECORDS_WAITING) as usize);
        let (news, news_out) = RingBuffer::new(NEWS_WAITING);
        let account = Self {
            budget: Budget::new(rate_hz),
            wake: Durations::new(),
            step: Durations::new(),
            peak_force: 0.0,
            peak_torque: 0.0,
            black_box,
            records,
            news,
            rest_wanted: Arc::default(),
            dropped: 0,
            missing: 0,
            progress_due_ns: 0,
            fault: None,
        };
        let rest_wanted = Arc::clone(&account.rest_wanted);
        (account, Readers { records: records_out, news: news_out, rest_wanted })
    }

    /// Ticks so far.
    #[must_use]
    pub const fn budget(&self) -> &Budget {
        &self.budget
    }

    /// The session begins.
    pub fn begin(&mut self, hello: SessionHello, tuning: &Tuning, place: &Place) {
        self.tell(FromHost::Hello(hello));
        self.rest(hello, tuning, place);
    }

    /// The core is at rest: from here on a reader can compute every tick again, whatever it has missed.
    pub fn rest(&mut self, hello: SessionHello, tuning: &Tuning, place: &Place) {
        self.rest_wanted.store(false, Ordering::Relaxed);
        let settings = [Record::Device(hello), Record::Tuning(*tuning), Record::Place(*place), Record::Rest];
        settings.into_iter().for_each(|record| self.keep(record));
    }

    /// The recorder asks for a rest.
    #[must_use]
    pub fn rest_wanted(&self) -> bool {
        self.rest_wanted.load(Ordering::Relaxed)
    }

    /// Closes a tick: `stepped` = the core ran in it.
    pub fn tick(&mut self, record: &TickRecord, stepped: bool, slept_through: u64, in_time: bool) {
        self.budget.count(in_time, slept_through);
        self.wake.record_ns(record.wake_ns.into());
        if stepped {
            self.step.record_ns(record.step_ns.into());
        }
        if record.was_felt() {
            self.peak_force = self.peak_force.max(length(record.contact_force));
            self.peak_torque = self.peak_torque.max(length(record.contact_torque));
        }
        self.black_box.record(record);
        self.keep(Record::Tick(*record));
    }

    /// Tells how it goes, when it is time to.
    pub fn progress(&mut self, record: &TickRecord, faults: &Faults, now_ns: u64) {
        if now_ns < self.progress_due_ns {
            return;
        }
        self.progress_due_ns = now_ns + PROGRESS_EVERY_NS;
        self.tell(FromHost::Progress(Progress {
            tick: record.tick,
            regions: record.regions,
            force: record.contact_force,
            torque: record.contact_torque,
            step_ns: record.step_ns,
            in_time_permille: (self.budget.share() * 1000.0) as u16,
            fault: faults.cause(),
        }));
    }

    /// A fault has latched. [`Self::settle`] passes it on, once its own tick is in the black box.
    pub fn fault(&mut self, fault: FaultRecord) {
        self.fault.get_or_insert(fault);
    }

    /// Passes a fault of this tick on: it is told, recorded, and the black box handed over.
    pub fn settle(&mut self) {
        let Some(fault) = self.fault.take() else { return };
        self.tell(FromHost::Fault(fault));
        self.keep(Record::Fault(fault));
        self.black_box.hand_over(fault);
    }

    /// Records what is said, or that it could not be.
    pub fn keep(&mut self, record: Record<'static>) {
        if self.missing > 0 && self.records.push(Record::Lost { count: self.missing }).is_ok() {
            self.missing = 0;
        }
        if self.missing > 0 || self.records.push(record).is_err() {
            self.missing += 1;
            self.dropped += 1;
        }
    }

    /// Records that found no room so far.
    #[must_use]
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// News that find no room are old news to a reader that slow; the summary does not go this way.
    fn tell(&mut self, message: FromHost) {
        let _ = self.news.push(message);
    }

    /// Every duration of the session, as [`crate::config::Args::times`] wants them. Allocates: for after the last tick.
    #[must_use]
    pub fn times(&self, line: &Line) -> String {
        let all = [("wake_up", &self.wake), ("step", &self.step), ("round_trip", line.trips.durations())];
        let rows = all.iter().flat_map(|(what, durations)| durations.bins().map(move |bin| (what, bin)));
        rows.fold("what,upto_ns,count\n".to_owned(), |table, (what, (upto_ns, count))| {
            table + &format!("{what},{upto_ns},{count}\n")
        })
    }

    /// The session in figures.
    #[must_use]
    pub fn summary(&self, line: &Line, faults: &Faults, rt: RtReport) -> Summary {
        let counts = line.counts();
        let figures = |durations: &Durations| -> Quantiles { durations.quantiles() };
        Summary {
            ticks: self.budget.ticks(),
            in_time: self.budget.in_time,
            late: self.budget.late,
            lost: counts.lost,
            rejected: line.rejected(),
            out_of_order: counts.out_of_order,
            recorder_dropped: self.dropped,
            peak_force: self.peak_force,
            peak_torque: self.peak_torque,
            step_ns: figures(&self.step),
            wake_ns: figures(&self.wake),
            round_trip_ns: figures(line.trips.durations()),
            rt,
            fault: faults.cause(),
        }
    }
}

/// Length of a vector, in f64 so that no square overflows.
pub(crate) fn length(v: [f32; 3]) -> f32 {
    v.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt() as f32
}

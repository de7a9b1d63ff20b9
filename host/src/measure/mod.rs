//! What a tick costs on this machine: the ticks of a recording run again by the core, as fast as they go.
//!
//! Three ways: **timed**, under the policy of the real-time thread, every tick into a histogram; **fastest**, the least time of each tick over some rounds, for
//! whoever compares ticks and has no counter; **counted**, once and without a clock, for an instruction counter to watch: every tick is one call of
//! [`measured_tick`], and where it is asked for an update of the surface after them one of [`measured_surface`]. The recording says everything: scene, tuning, rests, poses. What goes out is a line of JSON.
//!
//! The loop allocates nothing and makes no system call but the clock's.

mod args;
mod run;
mod stream;
mod surface;
mod tell;

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use haptor_engine::Engine;

use crate::error::HostError;
use crate::rt::clock::Monotonic;
use crate::rt::policy;
pub use args::{Args, How};
pub use run::{Length, Timed, count, fastest, measured_tick, time};
pub use stream::{Op, Stream};
pub use surface::{Seen, measured_surface};

/// Name of the thread that steps.
const THREAD: &str = "measuring";

/// Stack of that thread \[bytes\]: some hundred times what a step needs, and what the policy touches in advance.
const STACK_BYTES: usize = 1 << 20;

/// Time between two lines that say how far it is.
const TELL_EVERY: Duration = Duration::from_millis(100);

/// The engine, on a boundary of a cache line wherever the heap has room: what a copy costs depends on it.
#[repr(align(64))]
struct Aligned<T>(T);

/// Does what the arguments say.
///
/// # Errors
/// What of the recording or the machine does not do.
pub fn run(args: &Args) -> Result<(), HostError> {
    let stream = Stream::load(args)?;
    let bodies = stream.bodies(&args.file)?;
    let mut engine = Box::new(Aligned(stream.engine(&args.file, &bodies)?));
    match args.how {
        How::Count { surface } => {
            let mut seen = surface.map(|points| Seen::new(points.get()));
            let counted = aside(|| {
                let works = count(&mut engine.0, &stream.ops);
                seen.iter_mut().for_each(|seen| seen.update(&engine.0));
                works
            });
            counted.map(|works| tell::counted(&works))
        }
        How::Fastest { rounds } => {
            aside(|| fastest(&mut engine.0, &stream.ops, rounds, &Monotonic)).map(|least| tell::fastest(&least))
        }
        How::Time { ticks, rt, cpu, seconds } => {
            let length = Length { ticks, most_ns: seconds.map_or(u64::MAX, |seconds| u64::from(seconds) * 1_000_000_000) };
            let obtained_and_timed = timed(&mut engine.0, &stream.ops, length, rt.into(), cpu)?;
            tell::timed(&obtained_and_timed);
            Ok(())
        }
    }
}

/// Runs `work` in a thread of its own, with a stack that begins where a page does, whatever the arguments and the environment are.
fn aside<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, HostError> {
    thread::scope(|scope| {
        let started = thread::Builder::new().name(THREAD.into()).stack_size(STACK_BYTES).spawn_scoped(scope, work);
        let running = started.map_err(|reason| HostError::Thread { name: THREAD, reason })?;
        running.join().map_err(|_| HostError::Panicked { name: THREAD })
    })
}

/// The timed loop in its thread; this one says how far it is.
fn timed(
    engine: &mut Engine<'_>,
    ops: &[Op],
    length: Length,
    rt: policy::RtPolicy,
    cpu: Option<usize>,
) -> Result<Timed, HostError> {
    let done = AtomicU64::new(0);
    let mut timed = Timed::new();
    let result = thread::scope(|scope| {
        let work = || -> Result<(), HostError> {
            let obtained = policy::apply(rt, cpu, &[])?;
            timed.rt = obtained.report;
            time(engine, ops, length, &Monotonic, &done, &mut timed);
            Ok(())
        };
        let started = thread::Builder::new().name(THREAD.into()).stack_size(STACK_BYTES).spawn_scoped(scope, work);
        let running = started.map_err(|reason| HostError::Thread { name: THREAD, reason })?;
        while !running.is_finished() {
            tell::progress(done.load(Ordering::Relaxed));
            thread::sleep(TELL_EVERY);
        }
        running.join().map_err(|_| HostError::Panicked { name: THREAD })?
    });
    result.map(|()| timed)
}

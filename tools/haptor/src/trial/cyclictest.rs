//! cyclictest of rt-tests: what everybody measures wake-up latency with (<https://wiki.linuxfoundation.org/realtime/documentation/howto/tools/cyclictest>).

use std::sync::atomic::AtomicBool;

use super::helper::{CYCLICTEST, Helper};
use super::spread::Spread;
use crate::failure::Failure;

/// Latencies told apart, in steps of 1 us: a tick and some. What is longer is counted by its largest.
const BINS: u32 = 20_000;

/// Priority under SCHED_FIFO, that of the host's real-time thread.
pub const PRIORITY: u32 = 80;

/// Measures on one CPU for so many seconds, with the rights of the host's real-time thread or without any.
///
/// # Errors
/// When it fails or prints what is no histogram.
pub fn run(cpu: usize, period_us: u32, seconds: u64, real_time: bool, stop: &AtomicBool) -> Result<Spread, Failure> {
    let mut args = vec!["-q".to_owned(), "-t1".to_owned()];
    args.extend(
        [("-a", cpu.to_string()), ("-i", period_us.to_string()), ("-D", seconds.to_string()), ("-h", BINS.to_string())]
            .map(|(option, value)| format!("{option}{value}")),
    );
    if real_time {
        args.extend([format!("-p{PRIORITY}"), "-m".to_owned()]);
    }
    let said = Helper::start(CYCLICTEST, &args)?.output(stop)?;
    let spread = Spread::of_cyclictest(&said);
    if spread.count() == 0 {
        return Err(Failure::problem("cyclictest printed no histogram; rt-tests 1.0 or later is needed"));
    }
    Ok(spread)
}

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
    let spread = parse(&said);
    if spread.count() == 0 {
        return Err(Failure::problem("cyclictest printed no histogram; rt-tests 1.0 or later is needed"));
    }
    Ok(spread)
}

/// Rows `MICROSECONDS COUNT`; behind them how many were longer and the longest.
fn parse(text: &str) -> Spread {
    let mut spread = Spread::default();
    let told = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name));
        line.and_then(|rest| rest.split_whitespace().next()).and_then(|word| word.parse::<u64>().ok()).unwrap_or(0)
    };
    for line in text.lines().filter(|line| !line.starts_with(['#', '/'])) {
        let mut fields = line.split_whitespace().map(str::parse::<u64>);
        if let (Some(Ok(us)), Some(Ok(count))) = (fields.next(), fields.next()) {
            // whole microseconds, cut off: the bin's upper edge is the next
            spread.add((us + 1) * 1000, count);
        }
    }
    spread.add((told("# Max Latencies:") + 1) * 1000, told("# Histogram Overflows:"));
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_is_read_with_what_did_not_fit() {
        let text = "# /dev/cpu_dma_latency set to 0us\n# Histogram\n000000 000000\n000003 000097\n000010 000002\n\
                    # Total: 000000099\n# Min Latencies: 00003\n# Avg Latencies: 00004\n# Max Latencies: 31234\n\
                    # Histogram Overflows: 00001\n# Histogram Overflow at cycle number:\n# Thread 0: 00050\n";
        let spread = parse(text);
        assert_eq!((spread.count(), spread.quantile_ns(0.5), spread.max_ns()), (100, 4_000, 31_235_000));
        assert_eq!(parse("error: no rights\n").count(), 0);
    }
}

//! What goes to standard output: one line of JSON for each thing there is to say, numbers and true or false only.
//!
//! | line | when |
//! |---|---|
//! | `{"done":N}` | while it runs: ticks so far |
//! | `{"ticks":N,"work":[...]}` | counted: ticks run, and the estimate of each, 0 without a work budget |
//! | `{"least_ns":[...]}` | fastest: one number a tick |
//! | `{"ticks":N,"clock_ns":..,"preempted":..,"fifo":..,"locked":..,"pinned":..,"p50":..,...,"max":..,"bins":[[upper_ns,count],...]}` | timed |

use std::fmt::Write as _;
use std::io::{self, Write};

use super::Timed;

/// A reader that has left ends the telling, not the run.
fn say(line: &str) {
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}

/// Ticks so far.
pub fn progress(done: u64) {
    say(&format!("{{\"done\":{done}}}"));
}

/// Ticks that were run for a counter, and what each was estimated at.
pub fn counted(works: &[u32]) {
    let list: Vec<_> = works.iter().map(u32::to_string).collect();
    say(&format!("{{\"ticks\":{},\"work\":[{}]}}", works.len(), list.join(",")));
}

/// The least time of each tick \[ns\].
pub fn fastest(least: &[u64]) {
    say(&format!("{{\"least_ns\":[{}]}}", listed(least.iter())));
}

/// The histogram and what belongs to it.
pub fn timed(timed: &Timed) {
    let (q, rt) = (timed.durations.quantiles(), &timed.rt);
    let mut line =
        format!("{{\"ticks\":{},\"clock_ns\":{},\"preempted\":{}", timed.durations.count(), timed.clock_ns, timed.preempted);
    // writing to a string cannot fail
    let _ = write!(
        line,
        ",\"fifo\":{},\"locked\":{},\"pinned\":{},\"dma_latency\":{}",
        rt.fifo, rt.locked, rt.pinned, rt.dma_latency
    );
    for (name, value) in [("p50", q.p50), ("p99", q.p99), ("p999", q.p999), ("p9999", q.p9999), ("max", q.max)] {
        let _ = write!(line, ",\"{name}\":{value}");
    }
    let bins = timed.durations.bins().map(|(upper, count)| format!("[{upper},{count}]"));
    let _ = write!(line, ",\"bins\":[{}]}}", listed(bins));
    say(&line);
}

fn listed(values: impl Iterator<Item = impl ToString>) -> String {
    values.map(|value| value.to_string()).collect::<Vec<_>>().join(",")
}

//! What the guest told, as tables.

use std::fmt::Write;

use super::What;

/// Lines of the guest by kind.
#[derive(Debug, Default)]
pub struct Report {
    sessions: Vec<String>,
    drills: Vec<String>,
    latencies: Vec<String>,
    calls: Option<String>,
    allocations: Option<String>,
    failed: Vec<String>,
    ended: bool,
}

const SESSIONS: &str = "\
| device | ticks | late | reports lost | round trip p50 / p99 / max \\[us\\] | wake-up | step of the core | \
instructions of the real-time thread a tick \\[1000\\] | peak force \\[N\\] |
|---|---|---|---|---|---|---|---|---|
";

const DRILLS: &str = "\
| drill | fault | detected after \\[ticks\\] | wrench zero after \\[ticks\\] | forces back |
|---|---|---|---|---|
";

const LATENCIES: &str = "\
| beside | wake-up latency of | cycles | p50 \\[us\\] | p99 | p99.9 | p99.99 | max |
|---|---|---:|---:|---:|---:|---:|---:|
";

impl Report {
    /// Takes a line of the console; the firmware of the emulated machine leaves signs before the first.
    pub fn take(&mut self, line: &str) {
        let line = line.find('@').map_or(line, |at| &line[at..]);
        match line.split_once('|') {
            Some(("@session", row)) => self.sessions.push(row.to_owned()),
            Some(("@allocations", count)) => self.allocations = Some(count.to_owned()),
            Some(("@latency", row)) => self.latencies.push(row.to_owned()),
            Some(("@calls", counts)) => self.calls = Some(counts.to_owned()),
            Some(("@drill", row)) => self.drills.push(row.to_owned()),
            Some(("@failed", what)) => self.failed.push(what.to_owned()),
            _ => self.ended |= line == "@end",
        }
    }

    /// Everything was as it should be, to the end.
    pub const fn is_good(&self) -> bool {
        self.failed.is_empty() && self.ended
    }

    /// What was not.
    pub fn failures(&self) -> String {
        let cut = if self.ended { "" } else { "\nthe guest did not reach its end" };
        format!("{} failed:\n{}{cut}", self.failed.len(), self.failed.join("\n"))
    }

    /// The tables.
    pub fn tables(&self) -> String {
        let mut text = String::new();
        for (head, rows) in [(SESSIONS, &self.sessions), (DRILLS, &self.drills), (LATENCIES, &self.latencies)] {
            if !rows.is_empty() {
                text += head;
                rows.iter().for_each(|row| _ = writeln!(text, "| {} |", row.replace('|', " | ")));
                text.push('\n');
            }
        }
        if let Some(counts) = &self.calls {
            _ = writeln!(text, "System calls of the real-time thread on USB, by strace, with their counts: {counts}.");
        }
        if let Some(count) = &self.allocations {
            _ = writeln!(text, "libusb allocates and frees in C, on the real-time thread: {count} times a tick, 56 bytes each.");
        }
        text
    }

    /// The document that is kept.
    pub fn document(&self, what: What, kernel: &str, seconds: f64) -> String {
        match what {
            What::Sessions | What::Drills => self.drilled(kernel, seconds),
            What::Latency => self.latency(kernel, seconds),
        }
    }

    fn latency(&self, kernel: &str, seconds: f64) -> String {
        format!(
            "# The loop beside cyclictest in a real-time guest\n\n\
             Written by `cargo xtask guest --latency --seconds {seconds} --accept`. Debian's kernel {kernel} in QEMU with one processor; every \
             instruction takes 2 ns, so a\ntime is a count of instructions. Both threads run under SCHED_FIFO 80 on that one processor, each due every \
             1,000 us, haptor-host with the simulated device on\nthe kernel's virtual USB, paced by the clock.\n\n\
             What this proves: the scheduling class is held (a hog of ordinary class changes nothing of note), the thread wakes by the path that \
             cyclictest's takes, and\non USB too it asks the system for nothing but clock and link: anything else fails the command. What it does not prove: any \
             absolute latency. An emulator has no\ncaches, no sleep states, no interrupts of others; and whichever of the two is due while the other runs waits for it, \
             which is in the tails of both.\n\n{}",
            self.tables().trim_end().to_owned() + "\n"
        )
    }

    fn drilled(&self, kernel: &str, seconds: f64) -> String {
        format!(
            "# Sessions and drills over USB in a real-time guest\n\n\
             Written by `cargo xtask guest --drills --seconds {seconds} --accept`. Debian's kernel {kernel} in QEMU with one \
             processor; every instruction takes 2 ns, so a\ntime is a count of instructions and says nothing of hardware. \
             The simulated device is plugged into the kernel's virtual USB, which knows no polling\nintervals: interrupt \
             and bulk endpoints cost the same there. `usb` = interrupt endpoints, `usb-bulk` = bulk ones. The round trip \
             is from a wrench to the\nreport that echoes it; the device reports once a millisecond.\n\n\
             A tick is 1 ms. Every drill begins while the hand presses, 1.1 s after forces were armed; ticks count from \
             there. For every fault the command checks:\nlatched under that name, zero within the stated ticks and until \
             the hand has come out, opened again only under 0.1 N, black box whole and ending with the\nfault, no file \
             left open, no memory kept, nothing hangs.\n\n{}",
            self.tables().trim_end().to_owned() + "\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(lines: &[&str]) -> Report {
        let mut report = Report::default();
        lines.iter().for_each(|line| report.take(line));
        report
    }

    #[test]
    fn lines_become_rows() {
        let report = told(&[
            "\u{1b}c@session|usb|3000|0",
            "vhci_hcd: noise",
            "@drill|unplugged|link lost|2|2|yes",
            "@allocations|2.00",
            "@end",
        ]);
        let tables = report.tables();
        assert!(report.is_good());
        for part in ["\n| usb | 3000 | 0 |\n", "\n| unplugged | link lost | 2 | 2 | yes |\n", ": 2.00 times a tick"] {
            assert!(tables.contains(part), "{tables}");
        }
    }

    #[test]
    fn a_failure_or_an_early_end_is_not_good() {
        let failed = told(&["@failed|halted: no fault was latched", "@end"]);
        assert!(!failed.is_good() && failed.failures().contains("halted: no fault"));
        let cut = told(&["@session|usb|3000|0"]);
        assert!(!cut.is_good() && cut.failures().contains("did not reach its end"));
    }
}

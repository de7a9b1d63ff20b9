//! What a process holds, sampled while it runs: memory, open files, threads.

use std::fs;

/// Resident memory may grow by so much over a whole run \[kB\]: the page or two that a last stack frame or a first fault's message touches.
const GROWTH_KB: f64 = 256.0;

/// Samples at the start that do not count: a second each; buffers, histograms and the first recovery are touched in them.
const WARM_UP: usize = 20;

/// One sample.
#[derive(Clone, Copy, Debug)]
struct Sample {
    second: f64,
    rss_kb: f64,
    files: usize,
    threads: usize,
}

/// A process under watch.
#[derive(Debug)]
pub struct Watch {
    name: &'static str,
    id: u32,
    samples: Vec<Sample>,
}

/// What became of it.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// What is told.
    pub told: String,
    /// Nothing grew.
    pub flat: bool,
}

impl Watch {
    pub fn new(name: &'static str, id: u32) -> Self {
        Self { name, id, samples: Vec::new() }
    }

    /// Takes a sample; one of a process that has ended is left out.
    pub fn look(&mut self, second: f64) {
        let proc = format!("/proc/{}", self.id);
        let Ok(status) = fs::read_to_string(format!("{proc}/status")) else { return };
        let number = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key))?;
            line.split_whitespace().next()?.parse::<f64>().ok()
        };
        let (Some(rss_kb), Some(threads)) = (number("VmRSS:"), number("Threads:")) else { return };
        let Ok(files) = fs::read_dir(format!("{proc}/fd")) else { return };
        self.samples.push(Sample { second, rss_kb, files: files.count(), threads: threads as usize });
    }

    /// Judges all samples after the warm-up: the slope of memory by least squares times the time, and that files and threads are as many as before.
    pub fn verdict(&self) -> Verdict {
        let kept = self.samples.get(WARM_UP..).unwrap_or_default();
        let (Some(first), Some(last)) = (kept.first(), kept.last()) else {
            return Verdict { told: format!("{}: too short a run to judge memory", self.name), flat: false };
        };
        let growth_kb = slope(kept) * (last.second - first.second);
        let files = kept.iter().map(|sample| sample.files).max().unwrap_or(0);
        let threads = kept.iter().map(|sample| sample.threads).max().unwrap_or(0);
        let told = format!(
            "{}: {:.0} kB resident, growth {growth_kb:+.0} kB in {:.0} s, {files} files, {threads} threads",
            self.name,
            last.rss_kb,
            last.second - first.second
        );
        // a link that is being opened anew is one file more for a moment; a leak is one that stays
        let flat = growth_kb < GROWTH_KB && last.files <= first.files && last.threads <= first.threads;
        Verdict { told, flat }
    }
}

/// Slope of memory over time by least squares [kB/s].
fn slope(samples: &[Sample]) -> f64 {
    let n = samples.len() as f64;
    let mean = |of: fn(&Sample) -> f64| samples.iter().map(of).sum::<f64>() / n;
    let (t, m) = (mean(|s| s.second), mean(|s| s.rss_kb));
    let spread: f64 = samples.iter().map(|s| (s.second - t).powi(2)).sum();
    if spread == 0.0 {
        return 0.0;
    }
    samples.iter().map(|s| (s.second - t) * (s.rss_kb - m)).sum::<f64>() / spread
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watched(rss_kb: impl Fn(f64) -> f64, files: impl Fn(usize) -> usize) -> Verdict {
        let sample = |i: usize| Sample { second: i as f64, rss_kb: rss_kb(i as f64), files: files(i), threads: 6 };
        Watch { name: "it", id: 0, samples: (0..120).map(sample).collect() }.verdict()
    }

    #[test]
    fn what_grows_is_told_from_what_wobbles_or_settles() {
        assert!(watched(|_| 4096.0, |_| 9).flat);
        assert!(watched(|s| 4096.0 + 40.0 * (s * 7.0).sin(), |i| 9 + usize::from(i == 60)).flat, "wobbles");
        assert!(watched(|s| 4096.0 + 2000.0 * (s / 15.0).min(1.0), |_| 9).flat, "settles while it warms up");
        assert!(!watched(|s| 4096.0 + 4.0 * s, |_| 9).flat, "4 kB a second");
        assert!(!watched(|_| 4096.0, |i| 9 + i / 50).flat, "a file left open now and then");
        assert!(!Watch::new("it", 0).verdict().flat, "no samples");
    }
}

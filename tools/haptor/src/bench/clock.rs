//! Two clocks around a piece of work: the wall's and the thread's own.

use std::hint::black_box;
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// Empty pieces of work from which the clocks' own cost is taken.
const EMPTY: usize = 1001;

/// What a piece of work took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// From its start to its end, whatever else ran meanwhile.
    pub wall: Duration,
    /// On a core, for this thread.
    pub cpu: Duration,
}

/// Both clocks, and what reading them costs.
#[derive(Clone, Copy, Debug)]
pub struct Clocks {
    own: Spent,
}

impl Clocks {
    /// Measures the clocks' own cost: the middle of many readings around nothing.
    pub fn new() -> Self {
        let bare = Self { own: Spent::default() };
        let empty: Vec<Spent> = (0..EMPTY).map(|_| bare.time(|| black_box(())).1).collect();
        let middle = |of: fn(&Spent) -> Duration| {
            let mut times: Vec<_> = empty.iter().map(of).collect();
            times.sort_unstable();
            times[EMPTY / 2]
        };
        Self { own: Spent { wall: middle(|spent| spent.wall), cpu: middle(|spent| spent.cpu) } }
    }

    /// Does a piece of work, and tells what it took.
    pub fn time<T>(&self, work: impl FnOnce() -> T) -> (T, Spent) {
        let (cpu, wall) = (thread_time(), Instant::now());
        let result = black_box(work());
        let (wall, cpu) = (wall.elapsed(), thread_time().saturating_sub(cpu));
        (result, Spent { wall: wall.saturating_sub(self.own.wall), cpu: cpu.saturating_sub(self.own.cpu) })
    }
}

/// Time that this thread has been on a core.
fn thread_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    // both are positive on a thread's clock
    Duration::new(time.tv_sec.try_into().unwrap_or(0), time.tv_nsec.try_into().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_cpu_and_sleep_takes_none() {
        let clocks = Clocks::new();
        let (_, asleep) = clocks.time(|| std::thread::sleep(Duration::from_millis(20)));
        let (sum, awake) = clocks.time(|| (0..1_000_000_u64).fold(0, |sum, n| black_box(sum + n)));
        assert!(sum > 0 && asleep.wall >= Duration::from_millis(19), "{asleep:?}");
        assert!(asleep.cpu < asleep.wall / 2 && awake.cpu > Duration::ZERO, "{asleep:?} {awake:?}");
    }
}

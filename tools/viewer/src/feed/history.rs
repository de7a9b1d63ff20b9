//! The last ticks, for the plots: a ring of stated capacity, and its minima and maxima by column of the picture.

use std::collections::VecDeque;

use glam::DVec3;

/// Samples kept: a minute at 1 kHz, 5 MB.
pub const CAPACITY: usize = 60_000;

/// One tick of the plots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time since the session began \[s\].
    pub time: f64,
    /// Contact force on the probe in world \[N\].
    pub force: DVec3,
    /// Contact torque on the probe in world \[N m\].
    pub torque: DVec3,
    /// Largest depth \[m\].
    pub depth: f64,
    /// What the step took \[us\]; NaN where there is no clock.
    pub step_us: f64,
}

impl Sample {
    fn is_finite(&self) -> bool {
        self.time.is_finite() && self.force.is_finite() && self.torque.is_finite() && self.depth.is_finite()
    }
}

/// A curve of the plots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// A component of the force, 0 to 2 \[N\].
    Force(usize),
    /// Magnitude of the force \[N\].
    ForceNorm,
    /// A component of the torque, 0 to 2 \[N m\].
    Torque(usize),
    /// Magnitude of the torque \[N m\].
    TorqueNorm,
    /// Largest depth \[m\].
    Depth,
    /// What the step took \[us\].
    Step,
}

impl Channel {
    /// The value of this curve in a sample.
    pub fn of(self, sample: &Sample) -> f64 {
        match self {
            Self::Force(axis) => sample.force[axis],
            Self::ForceNorm => sample.force.length(),
            Self::Torque(axis) => sample.torque[axis],
            Self::TorqueNorm => sample.torque.length(),
            Self::Depth => sample.depth,
            Self::Step => sample.step_us,
        }
    }
}

/// A ring of samples in the order of time.
#[derive(Clone, Debug)]
pub struct History {
    samples: VecDeque<Sample>,
    capacity: usize,
    refused: u64,
}

impl Default for History {
    fn default() -> Self {
        Self::with_capacity(CAPACITY)
    }
}

impl History {
    /// A ring of `capacity` samples, at least one.
    pub fn with_capacity(capacity: usize) -> Self {
        Self { samples: VecDeque::new(), capacity: capacity.max(1), refused: 0 }
    }

    /// Adds a sample; the oldest goes when the ring is full. One not later than the last begins the ring anew, one that is not finite is
    /// refused and counted.
    pub fn push(&mut self, sample: Sample) {
        if !sample.is_finite() {
            self.refused += 1;
            return;
        }
        if self.samples.back().is_some_and(|last| sample.time <= last.time) {
            self.samples.clear();
        }
        if self.samples.len() == self.capacity {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// The newest sample.
    pub fn last(&self) -> Option<&Sample> {
        self.samples.back()
    }

    /// Samples refused since the ring was made.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// The curve of `channel` from time `from` to `to` \[s\] as points (time, value), at most two for each of `columns`: the least and the
    /// largest value of the column in the order they came. A spike of one tick stays visible at any width. Values that are no numbers
    /// are left out.
    pub fn curve(&self, channel: Channel, from: f64, to: f64, columns: usize) -> Vec<[f64; 2]> {
        let start = self.samples.partition_point(|sample| sample.time < from);
        let end = self.samples.partition_point(|sample| sample.time <= to).max(start);
        let width = (to - from) / columns.max(1) as f64;
        let points = self.samples.range(start..end).map(|sample| [sample.time, channel.of(sample)]);
        let mut curve = Vec::with_capacity(2 * columns);
        let mut column: Option<Column> = None;
        for point in points.filter(|point| point[1].is_finite()) {
            // `as` saturates: a width of zero puts all into one column
            let index = ((point[0] - from) / width) as usize;
            match &mut column {
                Some(open) if open.index == index => open.add(point),
                _ => {
                    curve.extend(column.take().into_iter().flat_map(Column::points));
                    column = Some(Column { index, least: point, most: point });
                }
            }
        }
        curve.extend(column.into_iter().flat_map(Column::points));
        curve
    }
}

/// The extremes of one column of the picture.
struct Column {
    index: usize,
    least: [f64; 2],
    most: [f64; 2],
}

impl Column {
    fn add(&mut self, point: [f64; 2]) {
        if point[1] < self.least[1] {
            self.least = point;
        }
        if point[1] > self.most[1] {
            self.most = point;
        }
    }

    /// One or two points in the order of time.
    fn points(self) -> impl Iterator<Item = [f64; 2]> {
        let (first, second) = if self.least[0] <= self.most[0] { (self.least, self.most) } else { (self.most, self.least) };
        std::iter::once(first).chain((second != first).then_some(second))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time: f64, depth: f64) -> Sample {
        Sample { time, depth, step_us: f64::NAN, ..Sample::default() }
    }

    fn ring(capacity: usize, count: u32) -> History {
        let mut history = History::with_capacity(capacity);
        (0..count).for_each(|k| history.push(sample(f64::from(k), f64::from(k % 10))));
        history
    }

    #[test]
    fn a_full_ring_keeps_the_newest() {
        let all = ring(8, 20).curve(Channel::Depth, 0.0, 100.0, 1_000);
        let times: Vec<f64> = all.iter().map(|point| point[0]).collect();
        assert_eq!(times, (12..20).map(f64::from).collect::<Vec<_>>());
    }

    #[test]
    fn time_that_goes_back_begins_anew_and_what_is_no_number_is_counted() {
        let mut history = ring(8, 5);
        history.push(sample(f64::NAN, 0.0));
        history.push(sample(9.0, f64::INFINITY));
        assert_eq!((history.refused(), history.last().unwrap().time), (2, 4.0));
        history.push(sample(1.0, 7.0));
        assert_eq!(history.curve(Channel::Depth, 0.0, 9.0, 10), [[1.0, 7.0]]);
        assert!(history.curve(Channel::Step, 0.0, 9.0, 10).is_empty(), "NaN has no place in a curve");
    }

    #[test]
    fn a_spike_of_one_tick_stays_at_any_width() {
        let mut history = History::with_capacity(10_000);
        (0..10_000_u32).for_each(|k| history.push(sample(f64::from(k) * 1.0e-3, if k == 4_321 { 5.0 } else { 0.0 })));
        for columns in [1, 7, 300, 20_000] {
            let curve = history.curve(Channel::Depth, 0.0, 10.0, columns);
            assert!(curve.contains(&[4.321, 5.0]), "{columns} columns");
            assert!(curve.len() <= 2 * columns.min(10_000) + 2, "{columns} columns: {} points", curve.len());
            assert!(curve.is_sorted_by(|a, b| a[0] < b[0]), "{columns} columns");
        }
        assert!(history.curve(Channel::Depth, 5.0, 5.0, 10).len() <= 2);
        assert!(history.curve(Channel::Depth, 7.0, 3.0, 10).is_empty());
    }
}

//! A link that misbehaves on purpose: loses, delays, damages, repeats and invents frames, by a seed.
//!
//! For drills and tests: it sits between the host and any link and acts on what the device sends. What it does depends on the
//! seed and the bytes alone, so a drill that failed fails again. It allocates.

use std::collections::VecDeque;
use std::time::Duration;

use crate::link::{Link, LinkError};

/// How often each mischief happens, in 1/1000 of the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// The frame vanishes.
    pub drop: u16,
    /// The frame comes after the one that follows it.
    pub delay: u16,
    /// One bit of the frame is turned.
    pub corrupt: u16,
    /// The frame comes twice.
    pub duplicate: u16,
    /// Bytes that were never sent come before the frame.
    pub garbage: u16,
}

/// Bytes invented at once: about a frame and a half, so that they hit the decoder's limit as well.
const GARBAGE_BYTES: usize = 96;

/// A link whose incoming frames are treated by a [`Plan`].
#[derive(Debug)]
pub struct FaultLink<L> {
    inner: L,
    plan: Plan,
    random: u64,
    partial: Vec<u8>,
    delayed: Vec<u8>,
    ready: VecDeque<u8>,
}

impl<L: Link> FaultLink<L> {
    /// Wraps `inner`; the same seed, plan and bytes give the same faults. A seed of 0 counts as 1.
    pub fn new(inner: L, plan: Plan, seed: u64) -> Self {
        Self { inner, plan, random: seed.max(1), partial: Vec::new(), delayed: Vec::new(), ready: VecDeque::new() }
    }

    /// Changes what happens from the next frame on.
    pub fn set_plan(&mut self, plan: Plan) {
        self.plan = plan;
    }

    /// Marsaglia's xorshift64: "Xorshift RNGs", J. Statistical Software 8(14), 2003.
    fn next(&mut self) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random
    }

    fn happens(&mut self, permille: u16) -> bool {
        self.next() % 1000 < u64::from(permille)
    }

    fn treat(&mut self, mut frame: Vec<u8>) {
        let plan = self.plan;
        if self.happens(plan.garbage) {
            for _ in 0..GARBAGE_BYTES {
                let byte = self.next() as u8;
                self.ready.push_back(byte);
            }
        }
        if self.happens(plan.corrupt) {
            let at = self.next() as usize % frame.len();
            frame[at] ^= 1 << (self.next() % 8);
        }
        if self.happens(plan.drop) {
            return;
        }
        if self.delayed.is_empty() && self.happens(plan.delay) {
            self.delayed = frame;
            return;
        }
        let twice = self.happens(plan.duplicate);
        for _ in 0..=usize::from(twice) {
            self.ready.extend(&frame);
        }
        self.ready.extend(self.delayed.drain(..));
    }
}

impl<L: Link> Link for FaultLink<L> {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.inner.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        let mut raw = [0; 512];
        let n = self.inner.receive(&mut raw, wait)?;
        for &byte in &raw[..n] {
            self.partial.push(byte);
            if byte == 0 {
                let frame = std::mem::take(&mut self.partial);
                self.treat(frame);
            }
        }
        let n = into.len().min(self.ready.len());
        for (slot, byte) in into.iter_mut().zip(self.ready.drain(..n)) {
            *slot = byte;
        }
        Ok(n)
    }

    fn name(&self) -> &str {
        self.inner.name()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::mem;

    fn through(plan: Plan, seed: u64) -> Vec<u8> {
        let (mut device, host) = mem::pair(4096);
        let mut faulty = FaultLink::new(host, plan, seed);
        for i in 1..=100_u8 {
            device.send(&[i, i, 0]).unwrap();
        }
        let (mut all, mut got) = (Vec::new(), [0; 64]);
        loop {
            match faulty.receive(&mut got, Duration::ZERO).unwrap() {
                0 => return all,
                n => all.extend(&got[..n]),
            }
        }
    }

    #[test]
    fn no_plan_changes_nothing() {
        let plain: Vec<u8> = (1..=100_u8).flat_map(|i| [i, i, 0]).collect();
        assert_eq!(through(Plan::default(), 3), plain);
    }

    #[test]
    fn each_mischief_does_what_it_says() {
        let always = 1000;
        assert!(through(Plan { drop: always, ..Plan::default() }, 1).is_empty());
        assert_eq!(through(Plan { duplicate: always, ..Plan::default() }, 1).len(), 600);
        assert_eq!(through(Plan { garbage: always, ..Plan::default() }, 1).len(), 100 * (3 + GARBAGE_BYTES));
        let damaged = through(Plan { corrupt: always, ..Plan::default() }, 1);
        let turned: u32 = damaged.iter().zip((1..=100_u8).flat_map(|i| [i, i, 0])).map(|(a, b)| (a ^ b).count_ones()).sum();
        assert_eq!(turned, 100);
        assert_eq!(through(Plan { delay: always, ..Plan::default() }, 1)[..6], [2, 2, 0, 1, 1, 0]);
    }

    #[test]
    fn a_seed_repeats_itself() {
        let plan = Plan { drop: 200, corrupt: 200, duplicate: 200, garbage: 100, delay: 100 };
        assert_eq!(through(plan, 42), through(plan, 42));
        assert_ne!(through(plan, 42), through(plan, 43));
    }
}

//! What happens to messages and frames on their way out while a drill lasts.

use std::collections::VecDeque;

use haptor_wire::units::NOT_A_NUMBER;
use haptor_wire::{FromDevice, PoseReport};

use super::drill::{Noise, Orders};

/// Turns by which a delayed frame is late: within what a host bridges.
const DELAY_TURNS: u64 = 3;

/// Bytes of a frame of which one is damaged: shorter than any frame.
const DAMAGED_AMONG: u64 = 8;

/// What mischief remembers.
#[derive(Debug)]
pub struct Mischief {
    noise: Noise,
    turn: u64,
    frozen: Option<PoseReport>,
    other_version: bool,
    /// Frames on their way and the turn in which they arrive.
    late: VecDeque<(u64, Vec<u8>)>,
    /// A frame that the next one overtakes.
    overtaken: Option<Vec<u8>>,
}

impl Mischief {
    /// The same seed damages the same bits.
    pub fn new(seed: u64) -> Self {
        Self { noise: Noise::new(seed), turn: 0, frozen: None, other_version: false, late: VecDeque::new(), overtaken: None }
    }

    /// A turn begins; yields the frames that arrive in it.
    pub fn arrive(&mut self, orders: &Orders) -> Vec<Vec<u8>> {
        self.turn += 1;
        self.other_version |= orders.version;
        if !orders.freeze && !orders.stuck {
            self.frozen = None;
        }
        let due = self.late.iter().take_while(|(turn, _)| !orders.delay || *turn <= self.turn).count();
        let mut frames: Vec<_> = self.late.drain(..due).map(|(_, frame)| frame).collect();
        if !orders.reorder {
            frames.extend(self.overtaken.take());
        }
        frames
    }

    /// Random bytes in place of a frame.
    pub fn garbage(&mut self, bytes: &mut [u8]) {
        self.noise.fill(bytes);
    }

    /// What becomes of a message.
    pub fn alter(&mut self, message: FromDevice, orders: &Orders) -> FromDevice {
        match message {
            FromDevice::Hello(mut hello) => {
                hello.version += u16::from(self.other_version);
                FromDevice::Hello(hello)
            }
            FromDevice::Pose(mut pose) => {
                if orders.nan {
                    pose.position_nm[1] = NOT_A_NUMBER;
                }
                if orders.freeze || orders.stuck {
                    let frozen = *self.frozen.get_or_insert(pose);
                    let lives = PoseReport {
                        position_nm: frozen.position_nm,
                        rotation_q30: frozen.rotation_q30,
                        t_us: frozen.t_us,
                        ..pose
                    };
                    pose = if orders.freeze { frozen } else { lives };
                }
                FromDevice::Pose(pose)
            }
            FromDevice::Fault(_) => message,
        }
    }

    /// What becomes of a frame: the frames that leave in its place.
    pub fn disorder(&mut self, mut frame: Vec<u8>, orders: &Orders) -> Vec<Vec<u8>> {
        if orders.drop {
            return Vec::new();
        }
        if orders.corrupt {
            let at = self.noise.next() % DAMAGED_AMONG;
            frame[at as usize] ^= 1 << (self.noise.next() % 8);
        }
        if orders.delay {
            self.late.push_back((self.turn + DELAY_TURNS, frame));
            return Vec::new();
        }
        if orders.duplicate {
            return vec![frame.clone(), frame];
        }
        if orders.reorder {
            return match self.overtaken.take() {
                Some(older) => vec![frame, older],
                None => {
                    self.overtaken = Some(frame);
                    Vec::new()
                }
            };
        }
        vec![frame]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sends frames 1 to 6, one a turn, the drill lasting for the first four.
    fn through(orders: Orders) -> Vec<Vec<u8>> {
        let mut mischief = Mischief::new(1);
        (1..=6)
            .map(|n| {
                let orders = if n <= 4 { orders } else { Orders::default() };
                let mut arrived = mischief.arrive(&orders);
                arrived.extend(mischief.disorder(vec![n; 8], &orders));
                arrived.iter().map(|frame| frame[0]).collect()
            })
            .collect()
    }

    #[test]
    fn frames_leave_as_the_drill_says() {
        let none = Orders::default();
        assert_eq!(through(none), [[1], [2], [3], [4], [5], [6]]);
        assert_eq!(through(Orders { drop: true, ..none }), [&[][..], &[], &[], &[], &[5], &[6]]);
        assert_eq!(through(Orders { duplicate: true, ..none }), [&[1, 1][..], &[2, 2], &[3, 3], &[4, 4], &[5], &[6]]);
        assert_eq!(through(Orders { reorder: true, ..none }), [&[][..], &[2, 1], &[], &[4, 3], &[5], &[6]]);
        assert_eq!(through(Orders { delay: true, ..none }), [&[][..], &[], &[], &[1], &[2, 3, 4, 5], &[6]]);
    }

    #[test]
    fn one_bit_of_a_frame_is_damaged() {
        let mut mischief = Mischief::new(1);
        for _ in 0..50 {
            let frames = mischief.disorder(vec![0; 20], &Orders { corrupt: true, ..Orders::default() });
            assert_eq!(frames[0].iter().map(|byte| byte.count_ones()).sum::<u32>(), 1);
        }
    }

    #[test]
    fn messages_are_altered_as_the_drill_says() {
        let pose = |seq| {
            let (position_nm, rotation_q30, mode) = ([seq as i32; 3], [1 << 30, 0, 0, 0], haptor_wire::Mode::Force);
            PoseReport { seq, t_us: 1000 * seq, position_nm, rotation_q30, buttons: 0, mode, flags: 0, echo: 0 }
        };
        let mut mischief = Mischief::new(1);
        let freeze = Orders { freeze: true, ..Orders::default() };
        for (seq, orders, expected) in [(1, freeze, 1), (2, freeze, 1), (3, Orders::default(), 3), (4, freeze, 4)] {
            mischief.arrive(&orders);
            assert_eq!(mischief.alter(FromDevice::Pose(pose(seq)), &orders), FromDevice::Pose(pose(expected)));
        }
        let stuck = Orders { stuck: true, ..Orders::default() };
        mischief.arrive(&Orders::default());
        for (seq, expected) in [(5, 5), (6, 5)] {
            mischief.arrive(&stuck);
            let expected = PoseReport { seq, ..pose(expected) };
            assert_eq!(mischief.alter(FromDevice::Pose(pose(seq)), &stuck), FromDevice::Pose(expected));
        }
        let nan = Orders { nan: true, ..Orders::default() };
        let FromDevice::Pose(none) = mischief.alter(FromDevice::Pose(pose(1)), &nan) else { panic!("a pose stays one") };
        assert_eq!(none.position_nm, [1, NOT_A_NUMBER, 1]);
    }
}

//! A history: poses of the handle in world from rest, one a tick, and what is tuned on the way.

use haptor_contact::{MAX_SPEED, MAX_TURN_RATE, Pose, ProbeFrame, Quat, Vec3, World};
use haptor_wire::{Record, TickRecord, Tuning};

use crate::session::offline::begin;
use crate::trajectory::HEADER;

/// Share of the fastest motion that the core believes which a history may use: rounding must not make a jump of it.
const BELIEVED: f32 = 0.9;

/// Farthest way in a tick that the core may believe \[m\]: at the slowest rate, 100 Hz.
const FARTHEST: f32 = 0.01 * MAX_SPEED;

/// Poses from rest.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// What it is.
    pub name: String,
    /// Poses, one a tick.
    pub poses: Vec<Pose<World, ProbeFrame>>,
    /// What is tuned before which tick; before the first it is the level's.
    pub tunings: Vec<(usize, Tuning)>,
}

impl History {
    /// Poses that the core believes, and nothing else: what a trajectory file holds.
    pub fn is_plain(&self) -> bool {
        // no comparison holds for a pose that is no number
        let goes_on = |pair: &[Pose<World, ProbeFrame>]| (pair[1].position - pair[0].position).length() <= FARTHEST;
        self.tunings.is_empty() && self.poses.windows(2).all(goes_on)
    }

    /// The same up to a tick, and that tick with it.
    pub fn until(&self, tick: usize) -> Self {
        let mut shorter = self.clone();
        shorter.poses.truncate(tick + 1);
        shorter
    }

    /// Whether a tick runs at `level`: what was tuned before it, if anything, is of the same tier with as many samples.
    pub fn is_at(&self, level: &Tuning, tick: usize) -> bool {
        let holds = self.tunings.iter().rev().find(|(at, _)| *at <= tick);
        holds.is_none_or(|(_, tuning)| (tuning.tier, tuning.samples) == (level.tier, level.samples))
    }

    /// As records, the first tick numbered `first`.
    pub fn records(&self, level: &Tuning, first: u64) -> Vec<Record<'static>> {
        let mut records = Vec::from(begin(level));
        for (at, pose) in self.poses.iter().enumerate() {
            records.extend(self.tunings.iter().filter(|(tick, _)| *tick == at).map(|(_, tuning)| Record::Tuning(*tuning)));
            let q = pose.rotation;
            records.push(Record::Tick(TickRecord {
                tick: first + at as u64,
                position: pose.position.to_array(),
                rotation: [q.w, q.x, q.y, q.z],
                ..TickRecord::default()
            }));
        }
        records
    }

    /// As a trajectory file.
    pub fn csv(&self, rate_hz: u32) -> String {
        let row = |(tick, pose): (usize, &Pose<World, ProbeFrame>)| {
            let (Vec3 { x, y, z }, q) = (pose.position, pose.rotation);
            format!("{},{x},{y},{z},{},{},{},{}\n", tick as f64 / f64::from(rate_hz), q.w, q.x, q.y, q.z)
        };
        let rows = self.poses.iter().enumerate().map(row);
        std::iter::once(format!("{}\n", HEADER.join(","))).chain(rows).collect()
    }
}

/// Motion in a tick: a way \[m\], and a turn about the probe's mass centre, as a vector \[rad\], both in world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Way.
    pub way: Vec3,
    /// Turn.
    pub turn: Vec3,
}

impl Motion {
    /// At most what the core believes in a tick of `dt` seconds.
    pub fn believed(self, dt: f32) -> Self {
        Self {
            way: self.way.clamp_length_max(BELIEVED * MAX_SPEED * dt),
            turn: self.turn.clamp_length_max(BELIEVED * MAX_TURN_RATE * dt),
        }
    }
}

/// Poses from a first one and motions.
pub fn poses(first: Pose<World, ProbeFrame>, motions: &[Motion], dt: f32) -> Vec<Pose<World, ProbeFrame>> {
    let mut poses = vec![first];
    let mut now = first;
    for motion in motions {
        let Motion { way, turn } = motion.believed(dt);
        let rotation = if turn == Vec3::ZERO { now.rotation } else { (Quat::from_scaled_axis(turn) * now.rotation).normalize() };
        now = Pose::new(now.position + way, rotation);
        poses.push(now);
    }
    poses
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again_and_no_motion_is_a_jump() {
        let wild = Motion { way: Vec3::splat(10.0), turn: Vec3::new(0.0, 40.0, 3.0) };
        let first = Pose::new(Vec3::new(0.1, -0.2, 0.3), Quat::from_rotation_x(0.3));
        let history = History { name: "wild".into(), poses: poses(first, &[wild; 9], 1.0e-3), tunings: Vec::new() };
        let rows = crate::trajectory::parse(history.csv(1000).as_bytes()).unwrap();
        assert_eq!(rows.len(), 10);
        assert!(history.is_plain());
        let mut jumping = history.clone();
        jumping.poses[4].position.x += 10.0;
        assert!(!jumping.is_plain(), "a trajectory file takes no jump");
        jumping.poses[4].position.x = f32::NAN;
        assert!(!jumping.is_plain(), "nor what is no pose");
        assert_eq!(jumping.until(3).poses, history.poses[..4]);
        assert!(
            rows.iter().zip(&history.poses).all(|(row, pose)| row.position == pose.position && row.rotation == pose.rotation)
        );
    }
}

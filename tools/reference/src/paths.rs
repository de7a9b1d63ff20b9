//! The paths a probe is led along, in units of s0 and phi0.
//!
//! Two kinds. **Straight**: the shift keeps its direction (or returns along it), with or without twist. **Turning**: the
//! shift's direction changes under load, which is where local friction models lose their way. Every path is made of corner
//! poses and arcs, and cut into equal parameter steps, so that it can be refined without changing shape.

use super::led::Pose;
use std::f64::consts::TAU;

/// A path: its name and a function of progress 0..=1.
#[derive(Clone, Copy)]
pub struct Path {
    /// Name in tables.
    pub name: &'static str,
    /// Whether the shift's direction turns under load.
    pub turning: bool,
    /// Pose at progress `t`.
    pub at: fn(f64) -> Pose,
}

impl std::fmt::Debug for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Path {}", self.name)
    }
}

impl Path {
    /// The path in `steps` steps, without its starting pose, which is the origin for all of them.
    #[must_use]
    pub fn poses(&self, steps: usize) -> Vec<Pose> {
        (1..=steps).map(|i| (self.at)(i as f64 / steps as f64)).collect()
    }
}

/// Position on the polyline through `corners`, each leg taking the same progress.
pub(super) fn legs<const N: usize>(t: f64, corners: &[[f64; N]]) -> [f64; N] {
    let count = corners.len() - 1;
    let along = t * count as f64;
    let leg = (along as usize).min(count - 1);
    let part = along - leg as f64;
    std::array::from_fn(|k| corners[leg][k] + part * (corners[leg + 1][k] - corners[leg][k]))
}

/// Point on a circle about (0, 0).
fn round(radius: f64, turns: f64) -> [f64; 2] {
    [radius * (TAU * turns).cos(), radius * (TAU * turns).sin()]
}

/// Straight out along x to `radius` in the first `lead` of the progress, then `turns` turns on the circle; twist grows evenly.
fn out_and_round(t: f64, lead: f64, radius: f64, turns: f64, twist: f64) -> Pose {
    let [x, y] = if t < lead { [radius * t / lead, 0.0] } else { round(radius, turns * (t - lead) / (1.0 - lead)) };
    [x, y, twist * t]
}

/// Out along x to `radius`, half a circle to the left of diameter 1, and back.
fn u_turn(t: f64, out: f64, twist: f64) -> Pose {
    let [x, y] = if t < 0.4 {
        [out * t / 0.4, 0.0]
    } else if t < 0.6 {
        let [c, s] = round(0.5, (t - 0.4) / 0.4 - 0.25);
        [out + c, 0.5 + s]
    } else {
        [out * (1.0 - t) / 0.4, 1.0]
    };
    [x, y, twist * t]
}

/// A hand's aimless motion: two sines per direction of unrelated periods, `rate` the main cycles per path.
fn wander(t: f64, rate: [f64; 3], size: f64) -> Pose {
    let wave = |k: usize, second: f64| (TAU * rate[k] * t).sin() + 0.5 * (TAU * rate[k] * second * t).sin();
    [0.8 * size * wave(0, 1.9), 0.8 * size * wave(1, 1.6), size * wave(2, 2.3)]
}

/// Every path, straight ones first. Amplitudes reach from part slip (below 1) to full slip several times over.
pub const PATHS: &[Path] = &[
    straight("twist", |t| [0.0, 0.0, 6.0 * t]),
    straight("drag", |t| [1.3 * t, 0.0, 0.0]),
    straight("mix_q1f1", |t| [3.0 * t, 0.0, 4.0 * t]),
    straight("mix_q2f1", |t| [3.0 * t, 0.0, 2.0 * t]),
    straight("mix_q4f1", |t| [3.0 * t, 0.0, t]),
    straight("mix_q1f2", |t| [1.5 * t, 0.0, 4.0 * t]),
    straight("mix_q1f4", |t| [0.75 * t, 0.0, 4.0 * t]),
    straight("twist_then_drag", |t| legs(t, &[[0.0; 3], [0.0, 0.0, 1.5], [1.5, 0.0, 1.5]])),
    straight("drag_then_twist", |t| legs(t, &[[0.0; 3], [0.6, 0.0, 0.0], [0.6, 0.0, 4.0]])),
    straight("drag_far_then_twist", |t| legs(t, &[[0.0; 3], [1.5, 0.0, 0.0], [1.5, 0.0, 4.0]])),
    straight("twist_loop", |t| {
        legs(t, &[[0.0; 3], [0.0, 0.0, 2.0], [0.0, 0.0, 0.0], [0.0, 0.0, -2.0], [0.0; 3], [0.0, 0.0, 2.0]])
    }),
    straight("drag_loop", |t| legs(t, &[[0.0; 3], [0.8, 0.0, 0.0], [0.0; 3], [-0.8, 0.0, 0.0], [0.0; 3], [0.8, 0.0, 0.0]])),
    straight("mixed_loop", |t| legs(t, &[[0.0; 3], [1.0, 0.0, 1.5], [-1.0, 0.0, -1.5], [1.0, 0.0, 1.5]])),
    straight("spin_reverses_in_drag", |t| legs(t, &[[0.0; 3], [0.7, 0.0, 1.5], [1.4, 0.0, 0.0], [2.1, 0.0, 1.5]])),
    turning("spiral_out", |t| {
        let [x, y] = round(3.0 * t, 2.0 * t);
        [x, y, 0.0]
    }),
    turning("spiral_out_small", |t| {
        let [x, y] = round(0.9 * t, 2.0 * t);
        [x, y, 0.0]
    }),
    turning("spiral_out_twist", |t| {
        let [x, y] = round(3.0 * t, 2.0 * t);
        [x, y, 4.0 * t]
    }),
    turning("spiral_in", |t| {
        if t < 0.2 {
            [10.0 * t, 0.0, 0.0]
        } else {
            let [x, y] = round(2.5 * (1.0 - t), 2.5 * (t - 0.2));
            [x, y, 0.0]
        }
    }),
    turning("spiral_in_twist", |t| {
        if t < 0.2 {
            [10.0 * t, 0.0, 2.5 * t]
        } else {
            let [x, y] = round(2.5 * (1.0 - t), 2.5 * (t - 0.2));
            [x, y, 2.5 * t]
        }
    }),
    turning("circle_half", |t| out_and_round(t, 0.2, 0.5, 1.5, 0.0)),
    turning("circle_one", |t| out_and_round(t, 0.2, 1.0, 1.5, 0.0)),
    turning("circle_two", |t| out_and_round(t, 0.2, 2.0, 1.5, 0.0)),
    turning("circle_one_twist", |t| out_and_round(t, 0.2, 1.0, 1.5, 3.0)),
    turning("circle_one_spin", |t| out_and_round(t, 0.1, 1.0, 1.5, 12.0)),
    turning("circle_two_twist", |t| out_and_round(t, 0.2, 2.0, 1.5, 4.0)),
    turning("figure_eight", |t| [(TAU * t).sin() * 1.2, (2.0 * TAU * t).sin() * 0.8, 0.0]),
    turning("figure_eight_twist", |t| [(TAU * t).sin() * 1.2, (2.0 * TAU * t).sin() * 0.8, 1.5 * (1.5 * TAU * t).sin()]),
    turning("l_turn", |t| legs(t, &[[0.0; 3], [1.5, 0.0, 0.0], [1.5, 1.5, 0.0]])),
    turning("l_turn_small", |t| legs(t, &[[0.0; 3], [0.6, 0.0, 0.0], [0.6, 0.9, 0.0]])),
    turning("l_turn_twist", |t| legs(t, &[[0.0; 3], [1.5, 0.0, 1.0], [1.5, 1.5, 2.0]])),
    turning("u_turn", |t| u_turn(t, 1.2, 0.0)),
    turning("u_turn_twist", |t| u_turn(t, 1.2, 2.5)),
    turning("zigzag", |t| {
        legs(t, &[[0.0; 3], [0.5, 0.8, 0.0], [1.0, 0.0, 0.0], [1.5, 0.8, 0.0], [2.0, 0.0, 0.0], [2.5, 0.8, 0.0]])
    }),
    turning("zigzag_twist", |t| {
        legs(t, &[[0.0; 3], [0.5, 0.8, 0.8], [1.0, 0.0, 0.2], [1.5, 0.8, 1.0], [2.0, 0.0, 0.4], [2.5, 0.8, 1.2]])
    }),
    turning("twist_shift_turn", |t| legs(t, &[[0.0; 3], [0.0, 0.0, 1.5], [1.0, 0.0, 1.5], [1.0, 1.0, 1.5], [0.0, 1.0, 1.5]])),
    turning("shift_twist_turn", |t| legs(t, &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 2.0], [1.0, 1.0, 2.0], [1.0, 1.0, 0.0]])),
    turning("square_twist", |t| legs(t, &[[0.0; 3], [0.7, 0.0, 0.7], [0.7, 0.7, 0.0], [0.0, 0.7, 0.7], [0.0; 3]])),
    turning("wander_one", |t| wander(t, [1.3, 2.2, 1.7], 1.0)),
    turning("wander_two", |t| wander(t, [2.1, 1.4, 0.8], 2.0)),
    turning("wander_three", |t| wander(t, [1.6, 2.7, 3.3], 0.6)),
    turning("turn_back_slowly", |t| legs(t, &[[0.0; 3], [1.2, 0.0, 0.5], [0.4, 0.3, 1.5], [0.8, 0.9, 0.5], [0.0, 1.0, -1.0]])),
];

const fn straight(name: &'static str, at: fn(f64) -> Pose) -> Path {
    Path { name, turning: false, at }
}

const fn turning(name: &'static str, at: fn(f64) -> Pose) -> Path {
    Path { name, turning: true, at }
}

/// The path of that name.
#[must_use]
pub fn named(name: &str) -> Option<&'static Path> {
    PATHS.iter().find(|p| p.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_start_at_rest_and_do_not_jump() {
        for path in PATHS {
            let start = (path.at)(0.0);
            assert!(start.iter().all(|c| c.abs() < 1e-12), "{path:?} starts at {start:?}");
            let poses = path.poses(2000);
            for pair in poses.windows(2) {
                let jump = (0..3).map(|k| (pair[1][k] - pair[0][k]).abs()).fold(0.0, f64::max);
                assert!(jump < 0.03, "{path:?} jumps by {jump}");
            }
        }
    }
}

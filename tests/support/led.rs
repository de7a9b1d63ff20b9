//! Leads a pressed ball along a path told in the contact's own units, and reads the answer in them.
//!
//! Units of a contact of load P and radius a: shift s0 = 3 mu P (2 - nu)/(16 a G), angle phi0 = T_max/K_theta with
//! T_max = 3 pi/16 mu P a and K_theta = 16/3 G a^3; answers in mu P and T_max. In them every sphere on a half space answers alike, whatever
//! its radius, depth and material.

use std::f64::consts::PI;

use haptor_contact::{ObjectShape, ParamsSpec, Quat, Vec3};

use super::drive::Drive;
use super::tables::PressedPath;

/// Shift along x and y, and angle.
pub type Shift = [f64; 3];

/// The units of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// mu P \[N\].
    pub force: f64,
    /// T_max \[N m\].
    pub torque: f64,
    /// s0 \[m\].
    pub shift: f64,
    /// phi0 \[rad\].
    pub angle: f64,
}

impl Units {
    /// Units of a sphere's contact of load `load` \[N\] and radius `a` \[m\].
    pub fn new(load: f64, a: f64, mu: f64, shear_modulus: f64, nu: f64) -> Self {
        let torque = 3.0 * PI / 16.0 * mu * load * a;
        Self {
            force: mu * load,
            torque,
            shift: 3.0 * mu * load * (2.0 - nu) / (16.0 * a * shear_modulus),
            angle: torque / (16.0 / 3.0 * shear_modulus * a * a * a),
        }
    }

    /// Units of what `drive` presses now.
    pub fn of(drive: &Drive, mu: f64) -> Self {
        let material = drive.model().material();
        Self::new(drive.load(), drive.radius(), mu, f64::from(material.shear_modulus()), f64::from(material.poisson_ratio))
    }

    /// The held drag and torque in these units.
    pub fn share(&self, held: [f64; 3]) -> [f64; 3] {
        [held[0] / self.force, held[1] / self.force, held[2] / self.torque]
    }
}

/// Leads `drive` through `poses` (in `units`, counted from where it stands), `ticks` ticks each, and returns the answer after each.
pub fn lead(drive: &mut Drive, units: &Units, poses: &[Shift], ticks: usize) -> Vec<[f64; 3]> {
    let (start, upright) = (drive.position, drive.rotation);
    let mut last = [0.0; 3];
    let mut answers = Vec::with_capacity(poses.len());
    for pose in poses {
        for tick in 1..=ticks {
            let part = tick as f64 / ticks as f64;
            let at = |k: usize| last[k] + (pose[k] - last[k]) * part;
            let shift = Vec3::new((at(0) * units.shift) as f32, (at(1) * units.shift) as f32, 0.0);
            let turn = Quat::from_rotation_z((at(2) * units.angle) as f32);
            drive.tick(start + shift, (turn * upright).normalize());
        }
        last = *pose;
        answers.push(units.share(drive.held()));
    }
    answers
}

/// Largest differences of two answers: drag (as vectors), torque.
pub fn worst(found: &[[f64; 3]], expected: &[[f64; 3]]) -> (f64, f64) {
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).fold((0.0, 0.0), |(drag, torque), (f, e)| {
        let off = (f[0] - e[0]).hypot(f[1] - e[1]);
        (off.max(drag), (f[2] - e[2]).abs().max(torque))
    })
}

/// Leads a ball of small strain along `path`; `ticks` a row; answers in the units of the contact of radius 1.
pub fn follow(path: &PressedPath, params: &ParamsSpec, ticks: usize) -> Vec<[f64; 3]> {
    const RADIUS: f32 = 0.1;
    const DEEPEST: f64 = 2.0e-4;
    let units = {
        let mut full = Drive::ball(ObjectShape::HalfSpace, RADIUS, 0.5, params);
        full.press_to(RADIUS, DEEPEST as f32);
        Units::of(&full, 0.75)
    };
    let mut drive = Drive::ball(ObjectShape::HalfSpace, RADIUS, 0.5, params);
    let mut pose = |[a, x, y, angle]: [f64; 4]| {
        let height = f64::from(RADIUS) - DEEPEST * a * a;
        let at = Vec3::new((x * units.shift) as f32, (y * units.shift) as f32, height as f32);
        drive.tick(at, Quat::from_rotation_z((angle * units.angle) as f32));
        units.share(drive.held())
    };
    let mut answers = vec![pose(path.state[0])];
    for pair in path.state.windows(2) {
        for tick in 1..=ticks {
            let part = tick as f64 / ticks as f64;
            let answer = pose(std::array::from_fn(|k| pair[0][k] + part * (pair[1][k] - pair[0][k])));
            if tick == ticks {
                answers.push(answer);
            }
        }
    }
    answers
}

//! One circular patch led along a path, everything in the contact's own units: the form in which the committed tables are told.
//!
//! Units: contact radius a = 1, G = 1, friction limit mu P = 1, nu = 0.5. A shift is told in multiples of s0 = 3 mu P (2 - nu)/(16 a G),
//! where a sphere's drag reaches full slip; an angle in multiples of phi0 = T_max/K_theta, with T_max = (3 pi/16) mu P a and
//! K_theta = (16/3) G a^3. Forces come in mu P, torques in the profile's own T_max.

use std::f64::consts::PI;

use crate::contact::{Contact, Ground, Patch};
use crate::kernel::Solid;
use crate::lattice::Lattice;
use crate::profile::Profile;

/// The half space of the tables; at 0.5 normal and tangential problems do not disturb each other.
const SOLID: Solid = Solid { shear_modulus: 1.0, poisson_ratio: 0.5 };
/// s0 for a = G = mu P = 1.
const SHIFT_UNIT: f64 = 3.0 * (2.0 - SOLID.poisson_ratio) / 16.0;
/// phi0 for a = G = mu P = 1.
const ANGLE_UNIT: f64 = 9.0 * PI / 256.0;

/// Where the probe is: shift in s0, angle in phi0.
pub type Pose = [f64; 3];

/// What the patch answers, as force in mu P and torque in T_max of the profile: (Q_x, Q_y, T).
pub type Answer = [f64; 3];

/// A patch with its stick state.
#[derive(Clone, Debug)]
pub struct Led {
    contact: Contact,
    torque_limit: f64,
    pose: Pose,
}

impl Led {
    /// A patch of `across` cells over its diameter, free of traction, at the origin.
    ///
    /// # Panics
    /// If `across` is below 4.
    #[must_use]
    pub fn new(across: usize, profile: Profile) -> Self {
        let lattice = Lattice::over_disc(across, 1.0);
        let mut contact = Contact::new(SOLID, 1.0, vec![Patch::new(SOLID, lattice)], Ground::firm(1));
        contact.set_pressure(0, profile.pressures(&lattice, 1.0, 1.0));
        Self { contact, torque_limit: profile.torque_limit(), pose: [0.0; 3] }
    }

    /// Presses a sphere's contact to `radius` <= 1 of the full one; its load goes as the cube. The next step is solved under it. Cells that
    /// leave the contact lose their traction, cells that enter do so free of traction, where they are.
    pub fn press(&mut self, radius: f64) {
        let lattice = *self.contact.patches()[0].lattice();
        self.contact.set_pressure(0, Profile::Hertz.pressures(&lattice, radius, radius.powi(3)));
    }

    /// Number of cells of the full contact.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.contact.patches()[0].touching()
    }

    /// Moves the probe to `pose` in one step and returns the answer there.
    pub fn step(&mut self, pose: Pose) -> Answer {
        let by: Pose = std::array::from_fn(|k| pose[k] - self.pose[k]);
        self.contact.drag(&[[by[0] * SHIFT_UNIT, by[1] * SHIFT_UNIT, by[2] * ANGLE_UNIT]]);
        self.pose = pose;
        let [x, y, torque] = self.contact.patches()[0].grip();
        [x, y, torque / self.torque_limit]
    }

    /// Steps that did not converge.
    #[must_use]
    pub fn unconverged(&self) -> usize {
        self.contact.unconverged
    }

    /// Sweeps spent so far.
    #[must_use]
    pub fn sweeps(&self) -> usize {
        self.contact.sweeps
    }

    /// The contact itself.
    #[must_use]
    pub fn contact(&self) -> &Contact {
        &self.contact
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{cattaneo, lubkin};

    /// Cells over the diameter in these tests: 112 cells.
    const ACROSS: usize = 12;

    #[test]
    fn small_motions_meet_mindlin_and_reissner_sagoci() {
        // K_t = 8 G a/(2 - nu): one s0 of stuck shift would give 1.5 mu P. A coarse grid resolves the punch's steep rim to 3 %.
        let pulled = Led::new(ACROSS, Profile::Punch).step([0.01, 0.0, 0.0])[0];
        assert!((pulled / 0.015 - 1.0).abs() < 0.03, "{pulled}");
        // K_theta = 16/3 G a^3: one phi0 of stuck twist would give the Hertz T_max
        let twisted = Led::new(ACROSS, Profile::Punch).step([0.0, 0.0, 0.01])[2];
        let want = 0.01 * Profile::Hertz.torque_limit() / Profile::Punch.torque_limit();
        assert!((twisted / want - 1.0).abs() < 0.05, "{twisted} {want}");
    }

    #[test]
    fn drag_meets_cattaneo_and_twist_meets_lubkin() {
        let mut drag = Led::new(ACROSS, Profile::Hertz);
        let mut twist = Led::new(ACROSS, Profile::Hertz);
        for i in 1..=12 {
            let s = 0.1 * f64::from(i);
            assert!((drag.step([s, 0.0, 0.0])[0] - cattaneo(s)).abs() < 0.01, "s {s}");
            let x = 0.3 * f64::from(i);
            assert!((twist.step([0.0, 0.0, x])[2] - lubkin(x)).abs() < 0.01, "x {x}");
        }
        assert_eq!(drag.unconverged() + twist.unconverged(), 0);
        assert!(drag.contact().residual() < 1e-5 && twist.contact().residual() < 1e-5);
    }

    #[test]
    fn standing_still_changes_nothing() {
        let mut patch = Led::new(ACROSS, Profile::Hertz);
        let loaded = patch.step([0.4, 0.2, 0.5]);
        for _ in 0..5 {
            let held = patch.step([0.4, 0.2, 0.5]);
            assert!((0..3).all(|k| (held[k] - loaded[k]).abs() < 1e-4));
        }
    }
}

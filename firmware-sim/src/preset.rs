//! The devices it can pretend to be.
//!
//! Force and torque limits are those that the CHAI3D library ships for these models. The Premium's mass and
//! the encoder steps are as on the makers' sheets; other masses, inertias, dampings and speeds are round figures of the right order.
//! Verify before quoting.

use crate::logic::Limits;

/// A device model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Its name, on the command line and in the hello.
    pub name: &'static str,
    /// Largest force \[N\].
    pub max_force: f32,
    /// Largest torque \[N m\]; 0 = rotation is sensed only.
    pub max_torque: f32,
    /// Mass felt at the handle \[kg\].
    pub mass: f32,
    /// Inertia felt about any axis of the handle \[kg m^2\].
    pub inertia: f32,
    /// Damping of the mechanism \[N s/m\].
    pub damping: f32,
    /// Angular damping of the mechanism \[N m s/rad\].
    pub spin_damping: f32,
    /// Step of position as the encoders resolve it \[m\].
    pub encoder: f32,
    /// Step of rotation as the encoders resolve it \[rad\].
    pub spin_encoder: f32,
    /// Speed above which it brakes \[m/s\].
    pub over_speed: f32,
    /// Angular speed above which it brakes \[rad/s\].
    pub over_spin: f32,
    /// Ticks of 125 us without a wrench until the brake.
    pub watchdog_ticks: u16,
}

/// Every preset.
pub const PRESETS: [Preset; 4] = [PREMIUM15, SIGMA7, OMEGA6, TOUCH];

/// Usual watchdog: 30 ms, the most that one byte holds on devices with this kind of watchdog, and
/// above what a desktop system without real-time rights oversleeps on a bad day (17 ms seen).
pub const WATCHDOG_TICKS: u16 = 240;

/// PHANTOM Premium 1.5 6DOF class: a serial arm with three motors in the wrist.
pub const PREMIUM15: Preset = Preset {
    name: "premium15",
    max_force: 8.5,
    max_torque: 0.188,
    mass: 0.136,
    inertia: 1e-4,
    damping: 2.0,
    spin_damping: 0.004,
    encoder: 30e-6,
    spin_encoder: 1.4e-4,
    over_speed: 1.0,
    over_spin: 20.0,
    watchdog_ticks: WATCHDOG_TICKS,
};

/// sigma.7 class: a parallel arm with a driven wrist.
pub const SIGMA7: Preset = Preset {
    name: "sigma7",
    max_force: 12.0,
    max_torque: 0.2,
    mass: 0.3,
    inertia: 3e-4,
    damping: 4.0,
    spin_damping: 0.01,
    encoder: 1.5e-6,
    spin_encoder: 2.3e-4,
    over_speed: 1.0,
    over_spin: 20.0,
    watchdog_ticks: WATCHDOG_TICKS,
};

/// omega.6 class: a parallel arm, the wrist sensed and not driven.
pub const OMEGA6: Preset = Preset {
    name: "omega6",
    max_force: 12.0,
    max_torque: 0.0,
    mass: 0.25,
    inertia: 2e-4,
    damping: 4.0,
    spin_damping: 0.004,
    encoder: 10e-6,
    spin_encoder: 1.6e-3,
    over_speed: 1.0,
    over_spin: 20.0,
    watchdog_ticks: WATCHDOG_TICKS,
};

/// Touch class: a small serial arm, the wrist sensed and not driven.
pub const TOUCH: Preset = Preset {
    name: "touch",
    max_force: 3.3,
    max_torque: 0.0,
    mass: 0.045,
    inertia: 5e-5,
    damping: 1.0,
    spin_damping: 0.002,
    encoder: 55e-6,
    spin_encoder: 1.0e-3,
    over_speed: 1.0,
    over_spin: 20.0,
    watchdog_ticks: WATCHDOG_TICKS,
};

impl Preset {
    /// The preset of that name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        PRESETS.into_iter().find(|preset| preset.name == name)
    }

    /// The firmware's limits in the wire's units; `serial` is cut to 12 bytes.
    #[must_use]
    pub fn limits(&self, serial: &str) -> Limits {
        Limits {
            name: padded(self.name),
            serial: padded(serial),
            max_force_un: micro(self.max_force),
            max_torque_unm: micro(self.max_torque),
            watchdog_ticks: self.watchdog_ticks,
            over_speed_um_s: micro(self.over_speed),
            over_spin_urad_s: micro(self.over_spin),
        }
    }
}

fn padded(text: &str) -> [u8; 12] {
    let mut field = [0; 12];
    field.iter_mut().zip(text.bytes()).for_each(|(to, byte)| *to = byte);
    field
}

/// Millionths, rounded; a float converts saturating, so a negative one is 0.
pub(crate) fn micro(value: f32) -> u32 {
    (f64::from(value) * 1e6 + 0.5) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_fit_the_hello() {
        for (i, preset) in PRESETS.iter().enumerate() {
            assert!(preset.name.len() <= 12);
            assert_eq!(Preset::by_name(preset.name), Some(*preset));
            assert!(PRESETS[..i].iter().all(|other| other.name != preset.name));
        }
        assert_eq!(Preset::by_name("falcon"), None);
    }

    #[test]
    fn limits_are_the_preset_s_in_small_units() {
        let limits = PREMIUM15.limits("SIM-1");
        assert_eq!(&limits.name, b"premium15\0\0\0");
        assert_eq!(&limits.serial, b"SIM-1\0\0\0\0\0\0\0");
        assert_eq!(limits.max_force_un, 8_500_000);
        assert_eq!(limits.max_torque_unm, 188_000);
        assert_eq!(OMEGA6.limits("").max_torque_unm, 0);
        assert_eq!(limits.over_speed_um_s, 1_000_000);
    }
}

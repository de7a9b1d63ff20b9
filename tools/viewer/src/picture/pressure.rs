//! Pressure at a point of the surface, for colours.
//!
//! Under a region of radius a with largest pressure p_0 it is taken as Hertz' p_0 sqrt(1 - r^2/a^2) (Johnson, Contact Mechanics, eq. 4.24), r in
//! the region's plane. Where the source gives no p_0 it follows from the normal force F: 3 F / (2 pi a^2). The core's own pressure under a
//! flat punch is another; a picture that must be exact takes it from the recording.

use glam::Vec3;

use crate::feed::Region;

/// A region's pressure, ready to be asked at many points.
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    centre: Vec3,
    normal: Vec3,
    radius: f32,
    peak: f32,
}

impl Profile {
    /// The profile of a region whose values are finite.
    pub fn of(region: &Region) -> Self {
        Self {
            centre: region.centre.as_vec3(),
            normal: region.normal.as_vec3().normalize_or(Vec3::Z),
            radius: region.radius as f32,
            peak: region.peak_pressure() as f32,
        }
    }

    /// Pressure \[Pa\] at the share `r` of the radius from the centre.
    pub fn at_share(&self, r: f32) -> f32 {
        self.peak * (1.0 - r * r).max(0.0).sqrt()
    }

    /// Pressure \[Pa\] at a point of the deformed surface; zero further than a radius above or below the region's plane, where another side
    /// of a thin body may be.
    pub fn at(&self, point: Vec3) -> f32 {
        let away = point - self.centre;
        // most points are far away: no root for them
        if away.length_squared() > 2.0 * self.radius * self.radius {
            return 0.0;
        }
        let height = away.dot(self.normal);
        let r = (away - height * self.normal).length();
        if height.abs() > self.radius || r >= self.radius { 0.0 } else { self.at_share(r / self.radius) }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::feed::Pressure;

    const REGION: Region = Region {
        centre: DVec3::Z,
        normal: DVec3::Z,
        radius: 0.004,
        stick_radius: 0.0,
        force: DVec3::new(0.0, 3.0, 10.0),
        torque: DVec3::ZERO,
        pressure: None,
    };

    #[test]
    fn the_profile_carries_the_normal_force() {
        let profile = Profile::of(&REGION);
        let rings = 2_000;
        let step = 0.004 / rings as f32;
        let force: f32 = (0..rings)
            .map(|k| {
                let r = (k as f32 + 0.5) * step;
                profile.at(Vec3::new(r, 0.0, 1.0)) * std::f32::consts::TAU * r * step
            })
            .sum();
        assert!((force / 10.0 - 1.0).abs() < 1.0e-3, "{force} N");
        assert_eq!(profile.at(Vec3::new(0.004, 0.0, 1.0)), 0.0);
        assert_eq!(profile.at(Vec3::new(0.0, 0.0, 0.99)), 0.0, "the other side");
    }

    #[test]
    fn a_given_peak_counts_and_a_pull_presses_nothing() {
        let given = Region { pressure: Some(Pressure { mean: 1.0, peak: 7.0 }), ..REGION };
        assert_eq!(Profile::of(&given).at(Vec3::Z), 7.0);
        assert_eq!(Region { force: -DVec3::Z, ..REGION }.peak_pressure(), 0.0);
        assert_eq!(Region { radius: 0.0, ..REGION }.peak_pressure(), 0.0);
    }
}

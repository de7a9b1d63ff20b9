//! From world to pixels: an eye on a sphere around the point it looks at, and a pinhole.
//!
//! Azimuth 0 looks along +y, from the front; it grows as the eye goes to the right, counter-clockwise seen from above. Elevation 0 looks level,
//! 90 straight down.

use glam::{DMat3, DVec2, DVec3, Mat4};

/// Half the height of the picture at distance 1: an angle of view of 30 degrees, little distortion.
const TANGENT: f64 = 0.268;

/// Share of the picture left free around what is framed.
const MARGIN: f64 = 0.1;

/// Nearest depth drawn, as a share of the distance to the target.
const NEAR: f64 = 0.02;

/// Farthest depth drawn, likewise.
const FAR: f64 = 50.0;

/// Rounds of framing: each halves what is left to correct, more change no pixel.
const ROUNDS: u32 = 24;

/// Elevations end just short of the poles, where left and right would be lost \[degrees\].
const STEEPEST: f64 = 89.9;

/// An eye and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point looked at, in world \[m\].
    pub target: DVec3,
    /// From there to the eye \[m\].
    pub distance: f64,
    /// To the right of the front \[degrees\].
    pub azimuth: f64,
    /// Above the level \[degrees\].
    pub elevation: f64,
}

impl Orbit {
    /// Where the eye stands when nobody says otherwise \[degrees\]: before the scene, to the right, above.
    pub const AZIMUTH: f64 = 28.0;
    /// Likewise \[degrees\].
    pub const ELEVATION: f64 = 24.0;

    /// Looks from the given direction, so that `points` fill a picture of `width` x `height` pixels up to a margin.
    pub fn framing(points: &[DVec3], azimuth: f64, elevation: f64, (width, height): (u32, u32)) -> Self {
        let target = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let distance = 4.0 * points.iter().map(|p| p.distance(target)).fold(1.0e-6, f64::max) / TANGENT;
        let mut orbit = Self { target, distance, azimuth, elevation };
        for _ in 0..ROUNDS {
            let camera = orbit.camera(width, height);
            let seen = points.iter().filter_map(|&p| camera.project(p)).map(|(pixel, _)| pixel);
            let Some((low, high)) = seen.map(|p| (p, p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { break };
            let off = ((low + high) / 2.0 - camera.half) * (orbit.distance / camera.scale);
            orbit.target += camera.axes.transpose() * DVec3::new(off.x, -off.y, 0.0);
            let filled = (high - low) / (2.0 * camera.half * (1.0 - MARGIN));
            // half the step: the whole one swings where the eye is near
            orbit.distance *= filled.max_element().clamp(0.1, 10.0).sqrt();
        }
        orbit
    }

    /// Goes round by angles \[degrees\]; never over the poles.
    pub fn turn(&mut self, right: f64, up: f64) {
        self.azimuth = (self.azimuth + right) % 360.0;
        self.elevation = (self.elevation + up).clamp(-STEEPEST, STEEPEST);
    }

    /// Moves what is seen by shares of the picture's height.
    pub fn shift(&mut self, right: f64, down: f64) {
        let height = 2.0 * TANGENT * self.distance;
        self.target += self.axes().transpose() * DVec3::new(-right * height, down * height, 0.0);
    }

    /// Goes nearer (factor below 1) or farther, within `reach` \[m\].
    pub fn approach(&mut self, factor: f64, reach: std::ops::RangeInclusive<f64>) {
        self.distance = (self.distance * factor).clamp(*reach.start(), *reach.end());
    }

    /// From the target to the eye, unit vector.
    pub fn back(&self) -> DVec3 {
        let (sin, cos) = self.azimuth.to_radians().sin_cos();
        let (up, level) = self.elevation.clamp(-STEEPEST, STEEPEST).to_radians().sin_cos();
        DVec3::new(level * sin, -level * cos, up)
    }

    /// Rows: right, up, towards the viewer.
    pub fn axes(&self) -> DMat3 {
        let back = self.back();
        let right = DVec3::Z.cross(back).normalize_or(DVec3::X);
        DMat3::from_cols(right, back.cross(right), back).transpose()
    }

    /// The eye in world \[m\].
    pub fn eye(&self) -> DVec3 {
        self.target + self.distance * self.back()
    }

    /// The camera of a picture of `width` x `height` pixels.
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        let half = DVec2::new(f64::from(width), f64::from(height)) / 2.0;
        Camera { eye: self.eye(), axes: self.axes(), near: NEAR * self.distance, half, scale: half.y / TANGENT }
    }

    /// World to the eye's axes, and these to a graphics driver's clip space, for a picture `aspect` times as wide as high.
    pub fn matrices(&self, aspect: f64) -> [Mat4; 2] {
        let view = glam::DMat4::from_mat3(self.axes()) * glam::DMat4::from_translation(-self.eye());
        let (near, far) = (NEAR * self.distance, FAR * self.distance);
        // the driver's depth runs from -1 at `near` to 1 at `far`
        let frustum = glam::DMat4::from_cols_array_2d(&[
            [1.0 / (TANGENT * aspect.max(1.0e-3)), 0.0, 0.0, 0.0],
            [0.0, 1.0 / TANGENT, 0.0, 0.0],
            [0.0, 0.0, (near + far) / (near - far), -1.0],
            [0.0, 0.0, 2.0 * near * far / (near - far), 0.0],
        ]);
        [view.as_mat4(), frustum.as_mat4()]
    }
}

/// A camera.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    eye: DVec3,
    /// Rows: right, up, towards the viewer.
    axes: DMat3,
    near: f64,
    half: DVec2,
    scale: f64,
}

impl Camera {
    /// Pixel (x right, y down) and depth \[m\] of a point; `None` when it is behind the nearest depth.
    pub fn project(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let seen = self.axes * (point - self.eye);
        let depth = -seen.z;
        if depth < self.near {
            return None;
        }
        let pixel = DVec2::new(seen.x, -seen.y) * (self.scale / depth) + self.half;
        Some((pixel, depth))
    }

    /// Direction from a point to the eye.
    pub fn towards(&self, point: DVec3) -> DVec3 {
        (self.eye - point).normalize_or(DVec3::Z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [DVec3; 4] = [DVec3::ZERO, DVec3::new(0.1, 0.0, 0.0), DVec3::new(0.0, 0.1, 0.0), DVec3::new(0.0, 0.0, 0.2)];

    #[test]
    fn what_is_framed_is_seen_and_fills_the_picture() {
        for (azimuth, elevation) in [(0.0, 0.0), (28.0, 24.0), (90.0, 0.0), (0.0, 90.0), (-200.0, -30.0)] {
            let size = (300, 200);
            let camera = Orbit::framing(&POINTS, azimuth, elevation, size).camera(size.0, size.1);
            let pixels = POINTS.map(|p| camera.project(p).unwrap().0);
            let low = pixels.iter().copied().fold(pixels[0], DVec2::min);
            let high = pixels.iter().copied().fold(pixels[0], DVec2::max);
            assert!(low.min_element() >= 0.0 && high.x <= 300.0 && high.y <= 200.0, "{azimuth} {elevation}");
            let filled = ((high - low) / DVec2::new(300.0, 200.0)).max_element();
            assert!((0.85..0.95).contains(&filled), "{azimuth} {elevation}: {filled}");
        }
    }

    #[test]
    fn what_is_dragged_follows_the_hand() {
        let mut orbit = Orbit { target: DVec3::ZERO, distance: 1.0, azimuth: 30.0, elevation: 20.0 };
        let pixel = |orbit: &Orbit| orbit.camera(300, 200).project(DVec3::ZERO).unwrap().0;
        let before = pixel(&orbit);
        orbit.shift(0.1, 0.2);
        assert!((pixel(&orbit) - before).distance(DVec2::new(20.0, 40.0)) < 1.0e-6);
        orbit.turn(700.0, 700.0);
        assert_eq!((orbit.azimuth, orbit.elevation), (10.0, STEEPEST));
        orbit.approach(1.0e-9, 0.1..=2.0);
        assert_eq!(orbit.distance, 0.1);
    }

    #[test]
    fn rasteriser_and_driver_agree() {
        let orbit = Orbit { target: DVec3::new(0.01, 0.02, 0.03), distance: 0.7, azimuth: 40.0, elevation: 30.0 };
        let camera = orbit.camera(300, 200);
        let [view, frustum] = orbit.matrices(1.5);
        for point in POINTS {
            let clip = frustum * view * point.as_vec3().extend(1.0);
            let driver = DVec2::new(f64::from(clip.x / clip.w) + 1.0, 1.0 - f64::from(clip.y / clip.w)) * camera.half;
            assert!(camera.project(point).unwrap().0.distance(driver) < 0.01, "{point}");
        }
    }

    #[test]
    fn an_eye_goes_where_its_angles_say() {
        let at = |azimuth, elevation| Orbit { target: DVec3::ZERO, distance: 1.0, azimuth, elevation }.eye();
        assert!(at(0.0, 0.0).distance(-DVec3::Y) < 1.0e-9, "the front");
        assert!(at(90.0, 0.0).distance(DVec3::X) < 1.0e-9, "the right side");
        assert!(at(0.0, 90.0).distance(DVec3::Z) < 2.0e-3, "the top");
    }
}

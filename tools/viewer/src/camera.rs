//! From world to pixels: a pinhole that looks at a point.

use glam::{DMat3, DVec2, DVec3};

/// Half the height of the picture at distance 1: an angle of view of 30 degrees, little distortion.
const TANGENT: f64 = 0.268;

/// Nearest depth drawn, as a share of the distance to the target.
const NEAR: f64 = 0.02;

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
    /// Looks at `target` from the direction `from`, so that a ball of `radius` \[m\] about it fits the picture.
    pub fn fitting(target: DVec3, radius: f64, from: DVec3, width: u32, height: u32) -> Self {
        let half = DVec2::new(f64::from(width), f64::from(height)) / 2.0;
        let narrow = (half.x / half.y).min(1.0) * TANGENT;
        let distance = radius / (narrow / (1.0 + narrow * narrow).sqrt());
        let back = from.normalize_or(DVec3::Z);
        let right = DVec3::Z.cross(back).normalize_or(DVec3::X);
        let axes = DMat3::from_cols(right, back.cross(right), back).transpose();
        Self { eye: target + distance * back, axes, near: NEAR * distance, half, scale: half.y / TANGENT }
    }

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

//! From world to pixels: a pinhole that looks at a point.

use glam::{DMat3, DVec2, DVec3};

/// Half the height of the picture at distance 1: an angle of view of 30 degrees, little distortion.
const TANGENT: f64 = 0.268;

/// Share of the picture left free around what is framed.
const MARGIN: f64 = 0.1;

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
    /// Looks from the direction `from`, so that `points` fill the picture up to a margin.
    pub fn framing(points: &[DVec3], from: DVec3, width: u32, height: u32) -> Self {
        let mut target = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let mut distance = 4.0 * points.iter().map(|p| p.distance(target)).fold(1.0e-6, f64::max) / TANGENT;
        // each round halves what perspective leaves to correct; more change no pixel
        for _ in 0..12 {
            let camera = Self::new(target, distance, from, width, height);
            let seen = points.iter().filter_map(|&p| camera.project(p)).map(|(pixel, _)| pixel);
            let Some((low, high)) = seen.map(|p| (p, p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { break };
            let off = ((low + high) / 2.0 - camera.half) * (distance / camera.scale);
            target += camera.axes.transpose() * DVec3::new(off.x, -off.y, 0.0);
            let filled = (high - low) / (2.0 * camera.half * (1.0 - MARGIN));
            distance *= filled.max_element().max(0.1);
        }
        Self::new(target, distance, from, width, height)
    }

    fn new(target: DVec3, distance: f64, from: DVec3, width: u32, height: u32) -> Self {
        let half = DVec2::new(f64::from(width), f64::from(height)) / 2.0;
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

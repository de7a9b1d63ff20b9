//! Triangles to pixels: z-buffer, two lights, shadows none, smoothed by averaging a grid of samples in each pixel.

use glam::{DVec2, DVec3};

use crate::camera::Camera;
use crate::image::Image;

/// Samples along each side of a pixel.
const SAMPLES: u32 = 3;

/// A colour, linear, each part 0 to 1.
pub type Colour = DVec3;

/// How a surface looks.
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    /// Its colour in full light, where its corners have none of their own.
    pub colour: Colour,
    /// Share of what lies behind that is covered, 0 to 1.
    pub opacity: f64,
    /// Lit by the lights; otherwise its colour as it is.
    pub lit: bool,
}

impl Paint {
    /// Opaque and lit.
    pub fn solid(colour: Colour) -> Self {
        Self { colour, opacity: 1.0, lit: true }
    }

    /// As it is, without light, opaque.
    pub fn flat(colour: Colour) -> Self {
        Self { colour, opacity: 1.0, lit: false }
    }
}

/// A corner of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Position in world \[m\].
    pub position: DVec3,
    /// Unit normal in world.
    pub normal: DVec3,
    /// Colour in full light.
    pub colour: Colour,
}

/// A picture being drawn.
pub struct Canvas {
    camera: Camera,
    width: u32,
    height: u32,
    colour: Vec<[f32; 3]>,
    depth: Vec<f64>,
}

impl Canvas {
    /// A canvas of `width` x `height` pixels, filled with a shade from `top` to `bottom`.
    pub fn new(camera: impl Fn(u32, u32) -> Camera, width: u32, height: u32, top: Colour, bottom: Colour) -> Self {
        let (wide, high) = (width * SAMPLES, height * SAMPLES);
        let row = |y: u32| narrow(top.lerp(bottom, f64::from(y) / f64::from(high)));
        let colour = (0..high).flat_map(|y| std::iter::repeat_n(row(y), wide as usize)).collect();
        let depth = vec![f64::INFINITY; (wide * high) as usize];
        Self { camera: camera(wide, high), width: wide, height: high, colour, depth }
    }

    /// Draws a triangle; one that reaches behind the camera is left out.
    pub fn triangle(&mut self, corners: [Corner; 3], paint: Paint) {
        let [Some(a), Some(b), Some(c)] = corners.map(|corner| self.camera.project(corner.position)) else { return };
        let area = (b.0 - a.0).perp_dot(c.0 - a.0);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let pixels = [a.0, b.0, c.0];
        let (low, high) = (pixels.iter().copied().fold(a.0, DVec2::min), pixels.iter().copied().fold(a.0, DVec2::max));
        for y in rows(low.y, high.y, self.height) {
            for x in rows(low.x, high.x, self.width) {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let share = [(b.0, c.0), (c.0, a.0), (a.0, b.0)].map(|(p, q)| (p - at).perp_dot(q - at) / area);
                if share.iter().all(|&part| part >= 0.0) {
                    self.sample(x, y, corners, share, [a.1, b.1, c.1], paint);
                }
            }
        }
    }

    /// What is drawn from here on lies before everything drawn so far.
    pub fn forget_depth(&mut self) {
        self.depth.fill(f64::INFINITY);
    }

    /// Does a face of this normal at this point look towards the camera?
    pub fn faces(&self, point: DVec3, normal: DVec3) -> bool {
        normal.dot(self.camera.towards(point)) > 0.0
    }

    /// One sample, `share` of each corner in the picture's plane, taken back to space by the depths.
    fn sample(&mut self, x: u32, y: u32, corners: [Corner; 3], share: [f64; 3], depths: [f64; 3], paint: Paint) {
        let near = [0, 1, 2].map(|k| share[k] / depths[k]);
        let depth = 1.0 / near.iter().sum::<f64>();
        let index = (y * self.width + x) as usize;
        if depth >= self.depth[index] {
            return;
        }
        let mix = |of: fn(&Corner) -> DVec3| (0..3).map(|k| of(&corners[k]) * (near[k] * depth)).sum::<DVec3>();
        let (position, normal, colour) = (mix(|c| c.position), mix(|c| c.normal), mix(|c| c.colour));
        let colour = if paint.lit { self.lit(colour, position, normal) } else { colour };
        let behind = DVec3::from_array(self.colour[index].map(f64::from));
        self.colour[index] = narrow(behind.lerp(colour, paint.opacity));
        if paint.opacity >= 1.0 {
            self.depth[index] = depth;
        }
    }

    /// A light from the upper left, a weaker one from the viewer, a gloss.
    fn lit(&self, colour: Colour, position: DVec3, normal: DVec3) -> Colour {
        let towards = self.camera.towards(position);
        let normal = normal.normalize_or(towards);
        // the side that is seen is the side that is lit
        let normal = if normal.dot(towards) < 0.0 { -normal } else { normal };
        let light = DVec3::new(-0.5, -0.25, 0.8).normalize();
        let diffuse = 0.25 + 0.62 * normal.dot(light).max(0.0) + 0.16 * normal.dot(towards).max(0.0);
        let gloss = normal.dot((light + towards).normalize_or(normal)).max(0.0).powi(48);
        colour * diffuse + DVec3::splat(0.18 * gloss)
    }

    /// The picture, each pixel the mean of its samples.
    pub fn finish(&self) -> Image {
        let (width, height) = (self.width / SAMPLES, self.height / SAMPLES);
        let mut rgb = Vec::with_capacity((3 * width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                rgb.extend(self.mean(x, y).to_array().map(srgb));
            }
        }
        Image { width, height, rgb }
    }

    fn mean(&self, x: u32, y: u32) -> Colour {
        let samples = (0..SAMPLES * SAMPLES).map(|k| {
            let (i, j) = (x * SAMPLES + k % SAMPLES, y * SAMPLES + k / SAMPLES);
            DVec3::from_array(self.colour[(j * self.width + i) as usize].map(f64::from))
        });
        samples.sum::<DVec3>() / f64::from(SAMPLES * SAMPLES)
    }
}

/// The pixels between two coordinates, inside the picture.
fn rows(low: f64, high: f64, size: u32) -> std::ops::Range<u32> {
    // `as` saturates, so coordinates far outside fall on the edges
    (low.floor() as u32).min(size)..(high.ceil() as u32).saturating_add(1).min(size)
}

fn narrow(colour: Colour) -> [f32; 3] {
    colour.to_array().map(|part| part as f32)
}

/// Linear 0 to 1 to an sRGB byte, in correctly rounded operations only: gamma 2 (a square root) instead of the standard's power
/// keeps the bytes the same on every machine and differs from it by less than one can see.
fn srgb(linear: f64) -> u8 {
    (linear.clamp(0.0, 1.0).sqrt() * 255.0).round() as u8
}

/// A colour as in a file.
pub fn encoded(colour: Colour) -> [u8; 3] {
    colour.to_array().map(srgb)
}
